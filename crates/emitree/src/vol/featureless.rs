//! The number of scattered samples of a view: more of a wide one, and of one without structure in any of them.

use crate::tile::Tile;
use crate::vol::lattice::points_to_detect;
use crate::vol::tuning::TUNING;

/// For tolerances from the first number on, the standard deviation of the Gaussians, in edges of
/// the cube, that the samples have to detect before an image is accepted.
const SMALLEST: [(f64, f64); 3] = [(0.2, 0.045), (0.03, 0.034), (0.0, 0.025)];

/// The number of samples of a narrow view at a tolerance; `least_feature` is that of its part.
pub(crate) fn points_of_view(tolerance: f64, least_feature: f64) -> usize {
    let of_tolerance = SMALLEST.iter().find(|(from, _)| tolerance >= *from);
    let detected = TUNING.lowrank.probe_detection_share;
    of_tolerance.map_or(0, |(_, size)| points_to_detect(least_feature * size, detected))
}

/// The solid angle of a view from a point in units of that of a usual one, a power of 2: as many samples detect less in
/// a wider view. 1 for parallel lines.
pub(crate) fn sky_factor(tiles: &[Tile<'_>]) -> usize {
    let from_point = |tile: &Tile<'_>| {
        let geometry = tile.projection.view_geometry()?;
        geometry
            .surroundings()?
            .is_seen_from_point()
            .then(|| geometry.solid_angle([0.0; 2], [1.0; 2]))
    };
    let solid_angle: Option<f64> = tiles.iter().map(from_point).sum();
    let ratio = solid_angle.unwrap_or(0.0) / TUNING.lowrank.usual_solid_angle_sr;
    1 << crate::cell::whole(ratio.max(1.0).log2().floor()).min(3)
}
