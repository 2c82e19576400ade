//! Whether the emission reaches the faces of bounds that are a box, so that the view is divided by them.
//!
//! Lines of sight begin and end at the faces. Where these change the path has a kink in the image, which
//! matters if there is emission near the ends of lines.

use crate::meter::Meter;
use crate::site::Site;
use crate::tile::Tile;
use crate::vol::lattice;
use crate::vol::sampling::{Stop, evaluate};
use crate::vol::tuning::TUNING;

/// Whether rates at depths z along lines, scattered over a view, are large enough near the ends of lines to matter
/// at a tolerance.
pub(crate) fn reaches_faces(samples: impl Iterator<Item = (f64, f64)>, tolerance: f64) -> bool {
    let depth = TUNING.faces.depth;
    let [mut of_faces, mut all] = [0.0, 0.0];
    for (z, rate) in samples {
        all += rate.abs();
        if z < depth || z > 1.0 - depth {
            of_faces += rate.abs();
        }
    }
    of_faces > TUNING.faces.least_share * tolerance * all
}

/// Whether the emission reaches the faces at some of these energies, by a few samples.
pub(crate) async fn reaches_faces_at(
    meter: &Meter,
    tile: &Tile<'_>,
    energies: &[Option<f64>],
    tolerance: f64,
) -> Result<bool, Stop> {
    let chart = tile.projection.chart(0);
    let samples = TUNING.faces.samples;
    let place = |i: usize| lattice::point(i % samples);
    let site = |i: usize| {
        let u @ [x, y, _] = place(i);
        let point = chart.world_from_chart(u);
        Site { xy: [x, y], point, energy: energies[i / samples], tile: (0, 1) }
    };
    let rates = evaluate(meter, samples * energies.len(), &site).await?;
    let at = |(i, rate): (usize, &f64)| (place(i)[2], *rate);
    let of_energy = |rates: &[f64]| reaches_faces(rates.iter().enumerate().map(at), tolerance);
    Ok(rates.chunks(samples).any(of_energy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn emission_at_one_end_of_lines_reaches_the_faces() {
        let depths = || (0..128).map(|i| (f64::from(i) + 0.5) / 128.0);
        let hat = |at: f64| depths().map(move |z| (z, (1.0 - (z - at).abs() / 0.2).max(0.0)));
        assert!(!reaches_faces(hat(0.5), 1e-2));
        assert!(reaches_faces(hat(0.9), 1e-2) && reaches_faces(hat(0.1), 1e-2));
        // Small rates matter at small tolerances.
        let weak = || hat(0.5).map(|(z, rate)| (z, rate + 1e-4));
        assert!(!reaches_faces(weak(), 1e-2) && reaches_faces(weak(), 1e-4));
        assert!(!reaches_faces(depths().map(|z| (z, 0.0)), 1e-4));
    }
}
