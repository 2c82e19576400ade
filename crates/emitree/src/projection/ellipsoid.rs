//! Ellipsoids: opaque bodies, and shapes that bound the emission.

use super::frame::GeometryError;
use super::vector::{along, cross, difference, dot, norm, unit, unit_across};

/// An ellipsoid in world coordinates; a sphere is one.
///
/// ```
/// use emitree::projection::Ellipsoid;
///
/// let earth = Ellipsoid::sphere([0.0; 3], 6371.0)?;
/// let saturn = Ellipsoid::new([0.0; 3], [60_268.0, 60_268.0, 54_364.0])?
///     .oriented([0.0, 0.45, 0.89], [1.0, 0.0, 0.0])?;
/// # Ok::<(), emitree::projection::GeometryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    centre: [f64; 3],
    semi_axes: [f64; 3],
    /// Unit vectors along the semi-axes.
    axes: [[f64; 3]; 3],
    /// The same, each divided by its semi-axis: lines of sight are scaled often.
    scales: [[f64; 3]; 3],
}

/// How far outside of a body a point on its surface is moved: more than rounding, less than any
/// model resolves. A model that emits only outside must not have the point inside.
const ABOVE_SURFACE: f64 = 1e-12;

impl Ellipsoid {
    /// The sphere of this `radius` around `centre`, both in the length unit of the scene.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the centre is not finite or the radius not above 0.
    pub fn sphere(centre: [f64; 3], radius: f64) -> Result<Self, GeometryError> {
        if radius > 0.0 && radius.is_finite() {
            return Self::new(centre, [radius; 3]);
        }
        let expected = "a finite length above 0";
        Err(GeometryError::OutOfRange { name: "radius", value: radius, expected })
    }

    /// The ellipsoid with these `semi_axes` along x, y and z.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the centre is not finite or a semi-axis not above 0.
    pub fn new(centre: [f64; 3], semi_axes: [f64; 3]) -> Result<Self, GeometryError> {
        let refuse = |name, value, expected| Err(GeometryError::Vector { name, value, expected });
        if !centre.iter().all(|x| x.is_finite()) {
            return refuse("center", centre, "three finite coordinates");
        }
        if !semi_axes.iter().all(|&length| length > 0.0 && length.is_finite()) {
            return refuse("semi_axes", semi_axes, "three finite lengths above 0");
        }
        Ok(Self::with_axes(centre, semi_axes, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    }

    fn with_axes(centre: [f64; 3], semi_axes: [f64; 3], axes: [[f64; 3]; 3]) -> Self {
        let scales = core::array::from_fn(|i| axes[i].map(|along| along / semi_axes[i]));
        Self { centre, semi_axes, axes, scales }
    }

    /// The same body turned: its third semi-axis along `pole`, the first in the plane of `pole` and
    /// `meridian`.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Vector`] if the pole is no direction or the meridian along it.
    pub fn oriented(self, pole: [f64; 3], meridian: [f64; 3]) -> Result<Self, GeometryError> {
        let error = |name, value, expected| GeometryError::Vector { name, value, expected };
        let third = unit(pole).ok_or(error("pole", pole, "a finite vector that is not zero"))?;
        let first = unit_across(meridian, third);
        let first = first.ok_or(error("meridian", meridian, "a direction across `pole`"))?;
        Ok(Self::with_axes(self.centre, self.semi_axes, [first, cross(third, first), third]))
    }

    /// The centre, in world coordinates.
    pub fn centre(&self) -> [f64; 3] {
        self.centre
    }

    /// The vectors from the centre to the ends of the semi-axes.
    pub fn semi_axis_vectors(&self) -> [[f64; 3]; 3] {
        core::array::from_fn(|i| self.axes[i].map(|along| along * self.semi_axes[i]))
    }

    /// The longest semi-axis.
    pub(crate) fn longest(&self) -> f64 {
        self.semi_axes.iter().copied().fold(0.0, f64::max)
    }

    /// The shortest semi-axis.
    pub(crate) fn shortest(&self) -> f64 {
        self.semi_axes.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The components of a vector along the axes, in units of the semi-axes: the body becomes the
    /// unit sphere.
    pub(super) fn scaled(&self, vector: [f64; 3]) -> [f64; 3] {
        self.scales.map(|scale| dot(scale, vector))
    }

    /// The scaled vector from the centre to a point.
    pub(super) fn scaled_point(&self, position: [f64; 3]) -> [f64; 3] {
        self.scaled(difference(position, self.centre))
    }

    /// The world's components of a scaled vector.
    pub(super) fn unscaled(&self, vector: [f64; 3]) -> [f64; 3] {
        let along_axes: [f64; 3] = core::array::from_fn(|i| vector[i] * self.semi_axes[i]);
        core::array::from_fn(|k| (0..3).map(|i| along_axes[i] * self.axes[i][k]).sum())
    }

    /// The size of this ellipsoid in units of another one with the same centre and shape; `None` if
    /// those differ.
    pub(super) fn size_relative_to(&self, other: &Self) -> Option<f64> {
        const ROUNDING: f64 = 1e-12;
        let size =
            self.semi_axes[0].max(self.semi_axes[1]).max(self.semi_axes[2]) / other.longest();
        let apart = norm(difference(self.centre, other.centre));
        // The semi-axes as vectors of the other's scaled coordinates have to be of one length and
        // across each other.
        let columns: [[f64; 3]; 3] =
            core::array::from_fn(|i| other.scaled(self.axes[i].map(|c| c * self.semi_axes[i])));
        let is_alike = (0..3).all(|i| {
            (0..3).all(|j| {
                let expected = if i == j { size * size } else { 0.0 };
                (dot(columns[i], columns[j]) - expected).abs() <= ROUNDING.sqrt() * size * size
            })
        });
        (is_alike && apart <= ROUNDING * self.longest()).then_some(size)
    }

    /// Whether a point is inside, or on the surface.
    pub(crate) fn contains(&self, position: [f64; 3]) -> bool {
        norm(self.scaled_point(position)) <= 1.0
    }

    /// The distances at which the line of `origin` and `direction` enters and leaves the body.
    pub(crate) fn crossing(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<[f64; 2]> {
        let (o, d) = (self.scaled_point(origin), self.scaled(direction));
        let squared = dot(d, d);
        let closest = -dot(o, d) / squared;
        // The closest point itself, and not a difference of squares: digits are kept from afar.
        let miss = along(o, closest, d);
        let within = 1.0 - dot(miss, miss);
        let half = (within > 0.0).then(|| (within / squared).sqrt())?;
        Some([closest - half, closest + half])
    }

    /// The point of the surface on the way from the centre to `position`, a rounding above it.
    pub(crate) fn on_surface(&self, position: [f64; 3]) -> [f64; 3] {
        let away = norm(self.scaled_point(position));
        let factor = (1.0 + ABOVE_SURFACE) / away.max(f64::MIN_POSITIVE);
        if away == 0.0 {
            return along(self.centre, self.semi_axes[2] * (1.0 + ABOVE_SURFACE), self.axes[2]);
        }
        along(self.centre, factor, difference(position, self.centre))
    }

    /// `position`, or the point of the surface above it if it is inside, or so near to the surface
    /// that a model whose rounding differs may have it inside.
    pub(crate) fn outside(&self, position: [f64; 3]) -> [f64; 3] {
        let is_clear = norm(self.scaled_point(position)) > 1.0 + 0.5 * ABOVE_SURFACE;
        if is_clear { position } else { self.on_surface(position) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn turned() -> impl Strategy<Value = Ellipsoid> {
        let vector = || prop::array::uniform3(-1.0..1.0f64);
        (vector(), prop::array::uniform3(0.3..2.0f64), vector(), vector()).prop_filter_map(
            "a pole and a meridian",
            |(centre, semi_axes, pole, meridian)| {
                Ellipsoid::new(centre, semi_axes).ok()?.oriented(pole, meridian).ok()
            },
        )
    }

    proptest! {
        #[test]
        fn crossings_are_on_the_surface(
            body in turned(),
            towards in prop::array::uniform3(-1.0..1.0f64),
            aim in prop::array::uniform3(-0.5..0.5f64),
        ) {
            let origin = along(body.centre, 20.0, towards);
            let away = unit(difference(body.centre, origin));
            prop_assume!(away.is_some() && !body.contains(origin));
            let target = core::array::from_fn(|i| body.centre[i] + aim[i]);
            let direction = unit(difference(target, origin));
            prop_assume!(direction.is_some());
            let direction = direction.unwrap_or_default();
            if let Some([enter, leave]) = body.crossing(origin, direction) {
                for s in [enter, leave] {
                    let distance = norm(body.scaled_point(along(origin, s, direction)));
                    prop_assert!((distance - 1.0).abs() < 1e-12);
                }
            }
            let above = body.on_surface(target);
            prop_assert!((norm(body.scaled_point(above)) - 1.0).abs() < 1e-11);
            prop_assert!(!body.contains(above));
        }
    }

    #[test]
    fn what_is_no_ellipsoid_is_refused() {
        let message = Ellipsoid::sphere([0.0; 3], -1.0).unwrap_err().to_string();
        assert_eq!(message, "`radius` is -1: expected a finite length above 0");
        let message = Ellipsoid::new([0.0; 3], [1.0, 0.0, 1.0]).unwrap_err().to_string();
        assert_eq!(
            message,
            "`semi_axes` is [1.0, 0.0, 1.0]: expected three finite lengths above 0"
        );
        let sphere = Ellipsoid::sphere([0.0; 3], 1.0).unwrap();
        let message = sphere.oriented([0.0; 3], [1.0, 0.0, 0.0]).unwrap_err().to_string();
        assert!(message.starts_with("`pole` is [0.0, 0.0, 0.0]: expected"), "{message}");
        let message = sphere.oriented([0.0, 0.0, 2.0], [0.0, 0.0, 1.0]).unwrap_err().to_string();
        assert!(message.ends_with("a direction across `pole`"), "{message}");
        assert!(Ellipsoid::sphere([f64::NAN, 0.0, 0.0], 1.0).is_err());
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "what is outside stays where it is")]
    fn the_centre_has_a_point_above_it_too() {
        let body = Ellipsoid::new([1.0, 2.0, 3.0], [1.0, 2.0, 4.0]).unwrap();
        assert!((body.outside([1.0, 2.0, 3.0])[2] - 7.0).abs() < 1e-10);
        assert_eq!(body.outside([9.0, 2.0, 3.0]), [9.0, 2.0, 3.0]);
    }
}
