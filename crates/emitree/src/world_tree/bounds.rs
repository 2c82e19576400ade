//! The box of a tree in the world.

/// A box in world coordinates, its edges along the axes.
///
/// ```
/// use emitree::world_tree::WorldBox;
///
/// let bounds = WorldBox::new([-10.0, -20.0, -20.0], [30.0, 20.0, 20.0])?;
/// assert_eq!(bounds.max(), [30.0, 20.0, 20.0]);
/// # Ok::<(), emitree::world_tree::BoxError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldBox {
    min: [f64; 3],
    max: [f64; 3],
}

/// Two corners that span no box.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the box reaches from {min} to {max} along {axis}: expected finite numbers, the first below the second"
)]
pub struct BoxError {
    /// The axis: x, y or z.
    pub axis: char,
    /// The lower end given.
    pub min: f64,
    /// The upper end given.
    pub max: f64,
}

impl WorldBox {
    /// The box from the corner `min` to the corner `max`, in the length unit of the scene.
    ///
    /// # Errors
    ///
    /// [`BoxError`] names the axis along which the box has no finite extent above 0.
    pub fn new(min: [f64; 3], max: [f64; 3]) -> Result<Self, BoxError> {
        for (axis, (min, max)) in ['x', 'y', 'z'].into_iter().zip(min.into_iter().zip(max)) {
            // The extent of a box between finite corners may still be infinite in 64-bit floats.
            if !(min < max && (max - min).is_finite() && min.is_finite()) {
                return Err(BoxError { axis, min, max });
            }
        }
        Ok(Self { min, max })
    }

    /// The lowest corner.
    pub fn min(&self) -> [f64; 3] {
        self.min
    }

    /// The highest corner.
    pub fn max(&self) -> [f64; 3] {
        self.max
    }

    /// The unit cube's coordinates of a position; `None` outside the box.
    pub(super) fn unit_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let inside = (0..3).all(|a| self.min[a] <= position[a] && position[a] <= self.max[a]);
        let unit = |a: usize| (position[a] - self.min[a]) / (self.max[a] - self.min[a]);
        inside.then(|| core::array::from_fn(unit))
    }

    pub(super) fn world_from_unit(&self, u: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|a| self.min[a] + (self.max[a] - self.min[a]) * u[a])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_that_span_no_box_are_refused() {
        let message = |min, max| WorldBox::new(min, max).unwrap_err().to_string();
        let expected = "expected finite numbers, the first below the second";
        assert_eq!(
            message([0.0, 2.0, 0.0], [1.0, 2.0, 1.0]),
            format!("the box reaches from 2 to 2 along y: {expected}")
        );
        assert_eq!(
            message([0.0; 3], [1.0, 1.0, f64::NAN]),
            format!("the box reaches from 0 to NaN along z: {expected}")
        );
        assert!(message([-f64::MAX; 3], [f64::MAX; 3]).contains("along x"));
        assert!(message([f64::NEG_INFINITY; 3], [1.0; 3]).contains("from -inf to 1"));
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "corners map exactly")]
    fn the_corners_are_inside_and_nothing_beyond() {
        let bounds = WorldBox::new([-1.0, 0.0, 2.0], [3.0, 5.0, 8.0]).unwrap();
        assert_eq!(bounds.unit_from_world(bounds.min()), Some([0.0; 3]));
        assert_eq!(bounds.unit_from_world(bounds.max()), Some([1.0; 3]));
        assert_eq!(bounds.unit_from_world([1.0, 2.5, 5.0]), Some([0.5; 3]));
        assert_eq!(bounds.world_from_unit([0.5; 3]), [1.0, 2.5, 5.0]);
        for outside in [[-1.1, 1.0, 3.0], [0.0, 5.1, 3.0], [0.0, 1.0, f64::NAN]] {
            assert_eq!(bounds.unit_from_world(outside), None);
        }
    }
}
