//! Image planes: which line of sight belongs to which point of the image.
//!
//! A plane defines directions and solid angles; a [`Camera`](super::Camera) adds the observer's
//! position, depths and bodies. Vectors are in camera components (right, up, forward).

mod disc;
mod equirectangular;
#[cfg(feature = "healpix")]
mod face;
mod parallel;
mod perspective;
mod polar;
mod solid_angle;

pub use disc::{DiscMapping, DiscPlane};
pub use equirectangular::EquirectangularPlane;
#[cfg(feature = "healpix")]
pub use face::FacePlane;
pub use parallel::ParallelPlane;
pub use perspective::TangentPlane;
pub use polar::PolarPlane;

use super::frame::GeometryError;

/// One line of sight, in camera components (right, up, forward).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Where it begins, relative to the observer, in the length unit of the scene.
    pub origin: [f64; 3],
    /// The unit vector along it, away from the observer.
    pub direction: [f64; 3],
}

impl Sight {
    /// The line of sight of a point observer, along a unit vector.
    pub(crate) fn from_point_observer(direction: [f64; 3]) -> Self {
        Self { origin: [0.0; 3], direction }
    }
}

/// An image plane: from canonical (x, y) ∈ [0, 1]² to lines of sight. Implement it for a custom
/// projection; [`Camera`](super::Camera) adds the viewpoint and depths.
///
/// The map has to be smooth on the whole square, also where it [contains](Self::contains) no part of
/// the image.
pub trait ImagePlane: Sync + core::fmt::Debug {
    /// The line of sight at (x, y).
    fn sight(&self, xy: [f64; 2]) -> Sight;

    /// The canonical (x, y) at which a point is seen, given relative to the observer; beyond the
    /// square if it is not in the view, none if it is on no line of sight or on all of them.
    fn xy_of(&self, point: [f64; 3]) -> Option<[f64; 2]>;

    /// dΩ/(dx dy) \[sr\] at (x, y), or an area for parallel lines; continued smoothly where the plane
    /// does not contain (x, y).
    fn solid_angle_density(&self, xy: [f64; 2]) -> f64;

    /// The solid angle \[sr\], or area, of the part of the rectangle from `min` to `max` that the
    /// plane contains.
    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64;

    /// Whether (x, y) belongs to the image; a disc leaves the corners of its square out.
    fn contains(&self, _xy: [f64; 2]) -> bool {
        true
    }

    /// Whether [`contains`](Self::contains) is true on all of the square.
    fn is_whole(&self) -> bool {
        true
    }

    /// Whether x is an angle over the full circle.
    fn is_closed(&self) -> bool {
        false
    }

    /// Whether all lines of sight are parallel, without a point observer.
    fn is_parallel(&self) -> bool {
        false
    }
}

/// The error for a field of view \[rad\] that a plane can't have, stated in degrees.
fn field_of_view(value_rad: f64, expected: &'static str) -> GeometryError {
    let value = value_rad.to_degrees();
    GeometryError::OutOfRange { name: "field_of_view", value, expected }
}
