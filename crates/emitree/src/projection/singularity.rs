//! Points and axes at which the emission is singular, or has a peak far smaller than a pixel.

use super::frame::GeometryError;
use super::vector::unit;

/// The exponent of a singularity for which none is given: that of a cusp squared, or of free outflow.
const USUAL_EXPONENT: f64 = 2.0;

/// A point or an axis near which the emission rate g grows as a power of the distance, or has a peak
/// far smaller than a pixel.
///
/// A singularity describes g and does not change it. Method `vol` has coordinates about it in which the
/// image is smooth: the logarithm of the distance of a line of sight from it, and along each line the distance
/// from the nearest point in units of that distance. g is evaluated close to it, but never at it.
///
/// ```
/// use emitree::projection::Singularity;
///
/// let cusp = Singularity::point([8.5, 0.0, 0.0])?.with_exponent(2.0)?;
/// let jet = Singularity::axis([0.0; 3], [0.0, 0.0, 1.0])?;
/// let error = cusp.with_exponent(3.0).unwrap_err().to_string();
/// assert_eq!(error, "`exponent` is 3: expected a number from 0 to below 3, so that the integral is finite");
/// # let _ = jet;
/// # Ok::<(), emitree::projection::GeometryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singularity {
    pub(crate) position: [f64; 3],
    /// The unit vector along an axis; `None` for a point.
    pub(crate) axis: Option<[f64; 3]>,
    /// g grows as the distance to the power of minus this.
    pub(crate) exponent: f64,
}

impl Singularity {
    /// A point, in the length unit of the scene.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Vector`] if the position is not finite.
    pub fn point(position: [f64; 3]) -> Result<Self, GeometryError> {
        if !position.iter().all(|x| x.is_finite()) {
            let expected = "three finite coordinates";
            return Err(GeometryError::Vector { name: "position", value: position, expected });
        }
        Ok(Self { position, axis: None, exponent: USUAL_EXPONENT })
    }

    /// The line through `position`, in the length unit of the scene, along `direction`, a vector of any
    /// length.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Vector`] if the position is not finite, or the direction not finite or zero.
    pub fn axis(position: [f64; 3], direction: [f64; 3]) -> Result<Self, GeometryError> {
        // Over the largest component, so that the squares neither overflow nor underflow.
        let largest = direction.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let axis = unit(direction.map(|component| component / largest));
        let expected = "a finite vector that is not zero";
        let axis =
            axis.ok_or(GeometryError::Vector { name: "direction", value: direction, expected })?;
        let exponent = 0.5 * USUAL_EXPONENT;
        Ok(Self { axis: Some(axis), exponent, ..Self::point(position)? })
    }

    /// The same with a known exponent: g grows as the distance to the power of −`exponent`. Otherwise it is 2
    /// for a point and 1 for an axis. It decides how close to the singularity g is evaluated. 0 is a peak of finite
    /// height, far smaller than a pixel, and wider than 10⁻⁵ of one.
    ///
    /// # Errors
    ///
    /// [`GeometryError::OutOfRange`] unless 0 ≤ `exponent` < 3 for a point, and < 2 for an axis.
    pub fn with_exponent(self, exponent: f64) -> Result<Self, GeometryError> {
        let (most, expected) = match self.axis {
            None => (3.0, "a number from 0 to below 3, so that the integral is finite"),
            Some(_) => (2.0, "a number from 0 to below 2, so that the integral is finite"),
        };
        if (0.0..most).contains(&exponent) {
            Ok(Self { exponent, ..self })
        } else {
            Err(GeometryError::OutOfRange { name: "exponent", value: exponent, expected })
        }
    }

    /// Where it is: the point, or a point of the axis, in the length unit of the scene.
    #[must_use]
    pub fn position(&self) -> [f64; 3] {
        self.position
    }

    /// The unit vector along an axis; none of a point.
    pub fn direction(&self) -> Option<[f64; 3]> {
        self.axis
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_singularity_is_refused() {
        let point = |position| Singularity::point(position).unwrap_err().to_string();
        let expected = "`position` is [0.0, NaN, 1.0]: expected three finite coordinates";
        assert_eq!(point([0.0, f64::NAN, 1.0]), expected);
        let axis = |direction| Singularity::axis([0.0; 3], direction).unwrap_err().to_string();
        let expected = "expected a finite vector that is not zero";
        assert_eq!(axis([0.0; 3]), format!("`direction` is [0.0, 0.0, 0.0]: {expected}"));
        let infinite = [f64::INFINITY, 0.0, 0.0];
        assert_eq!(axis(infinite), format!("`direction` is [inf, 0.0, 0.0]: {expected}"));
        let line = Singularity::axis([0.0; 3], [0.0, 0.0, -1e-300]).unwrap();
        assert_eq!(line.axis, Some([0.0, 0.0, -1.0]));
        let error = line.with_exponent(2.0).unwrap_err().to_string();
        let expected = "a number from 0 to below 2, so that the integral is finite";
        assert_eq!(error, format!("`exponent` is 2: expected {expected}"));
        assert!(line.with_exponent(-0.1).is_err() && line.with_exponent(f64::NAN).is_err());
        let point = Singularity::point([1.0; 3]).unwrap();
        assert!(point.with_exponent(2.9).is_ok());
    }
}
