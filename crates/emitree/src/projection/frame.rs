//! The observer's position and orientation: shared by all cameras with a pointing.

use super::vector::{cross, difference, dot, unit, unit_across};

/// The observer's position, the target, and the direction of up, in world coordinates.
///
/// ```
/// use emitree::Viewpoint;
///
/// let viewpoint = Viewpoint {
///     position: [10.0, -30.0, 0.0],
///     target: [6.0, 0.0, 0.0],
///     up: [0.0, 0.0, 1.0],
/// };
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// The observer, in the length unit of the scene.
    pub position: [f64; 3],
    /// The point in the middle of the image, in the length unit of the scene.
    pub target: [f64; 3],
    /// A vector whose component across the pointing is the image's +y; any length.
    pub up: [f64; 3],
}

/// A camera that can't be built from its numbers.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// The observer and the target are at the same point.
    #[error("`target` is `position` ({0:?}): expected two different points")]
    TargetIsPosition([f64; 3]),
    /// Up is zero or along the pointing, so that the image's rotation is undefined.
    #[error("`up` {up:?} is along the pointing {pointing:?}: expected another direction")]
    UpAlongPointing {
        /// The vector given.
        up: [f64; 3],
        /// The unit vector from the observer to the target.
        pointing: [f64; 3],
    },
    /// A number outside the camera's range.
    #[error("`{name}` is {value}: expected {expected}")]
    OutOfRange {
        /// The parameter, as scenes name it.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What was expected.
        expected: &'static str,
    },
    /// A vector or point that a body or a bounding shape can't have.
    #[error("`{name}` is {value:?}: expected {expected}")]
    Vector {
        /// The parameter, as scenes name it.
        name: &'static str,
        /// The value given.
        value: [f64; 3],
        /// What was expected.
        expected: &'static str,
    },
    /// The observer is inside an opaque body.
    #[error(
        "the observer at {position:?} is inside occulter {number}, or on its surface: expected a \
         position outside of all opaque bodies"
    )]
    InsideOcculter {
        /// The body, counted from 1 in the order given.
        number: usize,
        /// The observer.
        position: [f64; 3],
    },
}

/// An orthonormal frame at the observer: what cameras call right, up and forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) origin: [f64; 3],
    pub(crate) right: [f64; 3],
    pub(crate) up: [f64; 3],
    pub(crate) forward: [f64; 3],
}

impl Frame {
    /// The frame of a viewpoint, right × up = −forward.
    pub(crate) fn new(viewpoint: &Viewpoint) -> Result<Self, GeometryError> {
        let Viewpoint { position, target, up } = *viewpoint;
        let forward =
            unit(difference(target, position)).ok_or(GeometryError::TargetIsPosition(position))?;
        let tilted = GeometryError::UpAlongPointing { up, pointing: forward };
        let up = unit_across(up, forward).ok_or(tilted)?;
        Ok(Self { origin: position, right: cross(forward, up), up, forward })
    }

    /// The axes of the world: right is x, up is y and forward is z.
    pub(crate) fn of_world(origin: [f64; 3]) -> Self {
        Self { origin, right: [1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0], forward: [0.0, 0.0, 1.0] }
    }

    /// Camera components (right, up, forward) of the vector from the observer to `position`.
    pub(crate) fn camera_from_world(&self, position: [f64; 3]) -> [f64; 3] {
        let towards = difference(position, self.origin);
        [self.right, self.up, self.forward].map(|axis| dot(axis, towards))
    }

    /// World vector of the camera components (right, up, forward).
    pub(crate) fn world_from_camera(&self, [r, u, f]: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| r * self.right[i] + u * self.up[i] + f * self.forward[i])
    }
}
