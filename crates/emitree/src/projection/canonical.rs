//! The canonical projection: the unit cube itself, seen along +z by parallel rays.

use super::{MappedPoint, Projection};

/// The unit cube seen along +z: world coordinates are canonical coordinates.
///
/// Emission goes towards the observer at z → −∞, so its direction is (0, 0, −1). The image is
/// f(x, y) = ∫₀¹ g(x, y, z) dz, eq. (5) of the paper.
///
/// ```
/// use emitree::{Canonical, Projection};
///
/// let point = Canonical.world_from_canonical([0.1, 0.2, 0.3]);
/// assert_eq!(point.position, [0.1, 0.2, 0.3]);
/// assert_eq!(point.direction, [0.0, 0.0, -1.0]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Canonical;

impl Projection for Canonical {
    fn world_from_canonical(&self, u: [f64; 3]) -> MappedPoint {
        MappedPoint { position: u, direction: [0.0, 0.0, -1.0], path_per_depth: 1.0 }
    }

    fn canonical_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        Some(position)
    }

    fn solid_angle_density(&self, _xy: [f64; 2]) -> f64 {
        1.0
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        (max[0] - min[0]) * (max[1] - min[1])
    }
}
