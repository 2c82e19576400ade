//! Where the observer stands and which way is up: shared by all cameras with a pointing.

/// The observer's position, the point looked at, and which way is up, in world coordinates.
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
    /// The observer stands at the point it looks at.
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
    /// A number outside what the camera can do.
    #[error("`{name}` is {value}: expected {expected}")]
    OutOfRange {
        /// The parameter, as scenes name it.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
}

/// A right-handed orthonormal frame at the observer: right × up = −forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) origin: [f64; 3],
    pub(crate) right: [f64; 3],
    pub(crate) up: [f64; 3],
    pub(crate) forward: [f64; 3],
}

impl Frame {
    pub(crate) fn new(viewpoint: &Viewpoint) -> Result<Self, GeometryError> {
        let Viewpoint { position, target, up } = *viewpoint;
        let towards = core::array::from_fn(|i| target[i] - position[i]);
        let forward = unit(towards).ok_or(GeometryError::TargetIsPosition(position))?;
        let along = dot(up, forward);
        let across = core::array::from_fn(|i| up[i] - along * forward[i]);
        let tilted = GeometryError::UpAlongPointing { up, pointing: forward };
        // Less than about 1e-10 rad between the two leaves no significant digit of the rotation.
        if norm(across) <= 1e-10 * norm(up) {
            return Err(tilted);
        }
        let up = unit(across).ok_or(tilted)?;
        Ok(Self { origin: position, right: cross(forward, up), up, forward })
    }

    /// Camera components (right, up, forward) of the vector from the observer to `position`.
    pub(crate) fn camera_from_world(&self, position: [f64; 3]) -> [f64; 3] {
        let towards = core::array::from_fn(|i| position[i] - self.origin[i]);
        [self.right, self.up, self.forward].map(|axis| dot(axis, towards))
    }

    /// World vector of the camera components (right, up, forward).
    pub(crate) fn world_from_camera(&self, [r, u, f]: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| r * self.right[i] + u * self.up[i] + f * self.forward[i])
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(a);
    (length > 0.0 && length.is_finite()).then(|| a.map(|component| component / length))
}
