//! Lines of sight across the view, and rates of the emission at points of their surroundings.

use crate::scene::Scene;
use emitree::{Emission, Samples};

/// Lines of sight along each side of the image.
pub(super) const LINES: usize = 8;

/// A line of sight.
pub(super) struct Line {
    /// Where it begins, nearest to the observer.
    pub(super) near: [f64; 3],
    /// Where it ends.
    pub(super) far: [f64; 3],
    /// The direction in which g is needed there.
    pub(super) direction: [f64; 3],
    pub(super) length: f64,
}

/// The lines through an even raster of the image that are of finite length.
pub(super) fn lines(scene: &Scene) -> Vec<Line> {
    let camera = scene.camera.projection();
    let middle = |k: usize| (k as f64 + 0.5) / LINES as f64;
    let places = (0..LINES).flat_map(|j| (0..LINES).map(move |i| [middle(i), middle(j)]));
    let line = |[x, y]: [f64; 2]| {
        let [near, far] = [0.0, 1.0].map(|z| camera.world_from_canonical([x, y, z]));
        let length = length(minus(far.position, near.position));
        let is_line = far.path_per_depth > 0.0 && length.is_finite() && length > 0.0;
        let (near, direction) = (near.position, far.direction);
        is_line.then_some(Line { near, far: far.position, direction, length })
    };
    places.filter_map(line).collect()
}

/// The rates at points, in the middle of the energies; none if the emission can't be evaluated at all of them, as data
/// and models may end.
pub(super) fn rates(
    scene: &Scene,
    points: &[[f64; 3]],
    directions: &[[f64; 3]],
) -> Option<Vec<f64>> {
    let energies: Vec<f64> =
        scene.axis().iter().flat_map(|axis| vec![axis.energy(0.5); points.len()]).collect();
    let samples = Samples::new(points, directions).at_energies(&energies);
    let mut rates = vec![0.0; points.len()];
    scene.emission.emission_rates(&samples, &mut rates).ok()?;
    Some(rates)
}

pub(super) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

pub(super) fn length(a: [f64; 3]) -> f64 {
    a.iter().map(|component| component * component).sum::<f64>().sqrt()
}
