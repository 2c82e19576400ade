//! Parallel lines of sight: an orthographic view. FITS: linear axes.

use super::{ImagePlane, Sight};
use crate::projection::frame::GeometryError;

/// Lines of sight parallel to the pointing, from a rectangle around the observer.
///
/// The "solid angle" of a pixel is its area; a pixel's radiance is its mean over that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelPlane {
    /// Lower left corner and size, along right and up.
    corner: [f64; 2],
    extent: [f64; 2],
}

impl ParallelPlane {
    /// A rectangle of `extent` = \[width, height\] in the length unit, the observer in its middle.
    pub(crate) fn new(extent: [f64; 2]) -> Result<Self, GeometryError> {
        match extent.iter().find(|&&length| !(length > 0.0 && length.is_finite())) {
            None => Ok(Self { corner: extent.map(|length| -0.5 * length), extent }),
            Some(&value) => {
                let expected = "a finite width and height above 0";
                Err(GeometryError::OutOfRange { name: "extent", value, expected })
            }
        }
    }

    /// The unit square, the observer at its lower left corner.
    pub(crate) fn unit_square() -> Self {
        Self { corner: [0.0; 2], extent: [1.0; 2] }
    }
}

impl ImagePlane for ParallelPlane {
    fn sight(&self, xy: [f64; 2]) -> Sight {
        let [right, up] = core::array::from_fn(|i| self.corner[i] + xy[i] * self.extent[i]);
        Sight { origin: [right, up, 0.0], direction: [0.0, 0.0, 1.0] }
    }

    fn xy_of(&self, point: [f64; 3]) -> Option<[f64; 2]> {
        Some(core::array::from_fn(|i| (point[i] - self.corner[i]) / self.extent[i]))
    }

    fn solid_angle_density(&self, _xy: [f64; 2]) -> f64 {
        self.extent[0] * self.extent[1]
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        (max[0] - min[0]) * (max[1] - min[1]) * self.extent[0] * self.extent[1]
    }

    fn is_parallel(&self) -> bool {
        true
    }
}
