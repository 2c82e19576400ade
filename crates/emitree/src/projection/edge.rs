//! Edges of the emission: surfaces on which g jumps or has a kink.

use super::ellipsoid::Ellipsoid;
use super::frame::GeometryError;
use super::vector::unit;

/// A surface on which the emission rate g jumps, or has a kink.
///
/// An edge describes g and does not change it: the image is the same integral with and without it. It may
/// lie anywhere, also around the observer, behind an opaque body or outside of the bounds.
///
/// ```
/// use emitree::projection::{Edge, Ellipsoid};
///
/// let shock = Edge::Ellipsoid(Ellipsoid::sphere([0.0; 3], 2.5)?);
/// let wall = Edge::plane([0.0, 0.0, 1.0], [0.0, 0.0, 2.0])?;
/// assert_eq!(wall, Edge::plane([0.0, 0.0, 1.0], [0.0, 0.0, 1.0])?);
/// # Ok::<(), emitree::projection::GeometryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Edge {
    /// The surface of a sphere or of another ellipsoid.
    Ellipsoid(Ellipsoid),
    /// A plane without an end; made by [`plane`](Self::plane).
    ///
    /// In views without opaque bodies, up to three planes that are not seen edge-on divide lines of sight where g
    /// jumps, and where it has a kink if the normal is within 60° of the line of sight in the middle: both sides
    /// of a plane are then smooth.
    ///
    /// A plane that is seen edge-on saves evaluations in views with an opaque body, an ellipsoidal edge or
    /// ellipsoidal bounds, if it contains their centre and the observer, or with parallel lines of sight the centre and
    /// their direction, to 1e-9 of the radius. The image is then computed on its two sides separately. Other
    /// planes have no effect.
    #[non_exhaustive]
    Plane {
        /// A point of the plane, in the length unit of the scene.
        position: [f64; 3],
        /// The unit vector perpendicular to the plane.
        normal: [f64; 3],
    },
}

impl Edge {
    /// The plane through `position`, in the length unit of the scene, perpendicular to `normal`, a vector of
    /// any length.
    ///
    /// ```
    /// use emitree::projection::Edge;
    ///
    /// let error = Edge::plane([0.0; 3], [0.0; 3]).unwrap_err().to_string();
    /// assert_eq!(error, "`normal` is [0.0, 0.0, 0.0]: expected a finite vector that is not zero");
    /// ```
    ///
    /// # Errors
    ///
    /// [`GeometryError::Vector`] if the position is not finite, or the normal not finite or zero.
    pub fn plane(position: [f64; 3], normal: [f64; 3]) -> Result<Self, GeometryError> {
        let refuse = |name, value, expected| GeometryError::Vector { name, value, expected };
        if !position.iter().all(|x| x.is_finite()) {
            return Err(refuse("position", position, "three finite coordinates"));
        }
        // Over the largest component, so that the squares neither overflow nor underflow.
        let largest = normal.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let direction = unit(normal.map(|component| component / largest));
        let expected = "a finite vector that is not zero";
        let normal = direction.ok_or(refuse("normal", normal, expected))?;
        Ok(Self::Plane { position, normal })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::vector::{dot, norm};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn normals_of_any_length_are_unit_vectors(
            position in prop::array::uniform3(-9.0..9.0f64),
            normal in prop::array::uniform3(-1.0..1.0f64),
            exponent in -300..300i32,
        ) {
            prop_assume!(norm(normal) > 1e-3);
            let scaled = normal.map(|component| component * 10.0_f64.powi(exponent));
            let Edge::Plane { position: kept, normal: found } = Edge::plane(position, scaled).unwrap()
            else { panic!("a plane") };
            prop_assert!((0..3).all(|i| kept[i].to_bits() == position[i].to_bits()));
            prop_assert!((norm(found) - 1.0).abs() < 1e-14);
            prop_assert!((dot(found, normal) - norm(normal)).abs() < 1e-14);
        }
    }

    #[test]
    fn what_is_no_plane_is_refused() {
        let message = |position, normal| Edge::plane(position, normal).unwrap_err().to_string();
        let expected = "expected three finite coordinates";
        let infinite = [0.0, f64::INFINITY, 0.0];
        let nan = [0.0, f64::NAN, 1.0];
        assert_eq!(
            message(infinite, [1.0; 3]),
            format!("`position` is [0.0, inf, 0.0]: {expected}")
        );
        assert_eq!(message(nan, [0.0; 3]), format!("`position` is [0.0, NaN, 1.0]: {expected}"));
        let expected = "expected a finite vector that is not zero";
        assert_eq!(message([0.0; 3], [0.0; 3]), format!("`normal` is [0.0, 0.0, 0.0]: {expected}"));
        assert_eq!(message([0.0; 3], infinite), format!("`normal` is [0.0, inf, 0.0]: {expected}"));
        assert_eq!(message([0.0; 3], nan), format!("`normal` is [0.0, NaN, 1.0]: {expected}"));
    }

    #[test]
    fn the_least_numbers_are_a_direction() {
        let plane = Edge::plane([0.0; 3], [0.0, -5e-324, 0.0]).unwrap();
        assert_eq!(plane, Edge::plane([0.0; 3], [0.0, -f64::MAX, 0.0]).unwrap());
    }
}
