//! Bounding shapes: the emission is 0 outside of them, and is not evaluated there.

use super::ellipsoid::Ellipsoid;
use super::frame::GeometryError;
use super::observer::Observer;
use super::vector::{difference, dot, norm};

/// A shape that contains all emission: lines of sight are cut to it.
///
/// ```
/// use emitree::projection::{Bounds, Ellipsoid};
///
/// let halo = Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], 12.0)?);
/// let room = Bounds::cuboid([-1.0; 3], [1.0, 1.0, 2.0])?;
/// # Ok::<(), emitree::projection::GeometryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Bounds {
    /// A sphere or another ellipsoid.
    Ellipsoid(Ellipsoid),
    /// A box along the axes of the world; made by [`cuboid`](Self::cuboid).
    Cuboid(Cuboid),
}

/// A box along the axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    min: [f64; 3],
    max: [f64; 3],
}

impl Bounds {
    /// The box between two opposite corners, in the length unit of the scene.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Vector`] if a corner is not finite, or `max` not above `min` along each axis.
    pub fn cuboid(min: [f64; 3], max: [f64; 3]) -> Result<Self, GeometryError> {
        let finite = |corner: [f64; 3]| corner.iter().all(|x| x.is_finite());
        let (name, value, expected) = if !finite(min) {
            ("min", min, "three finite coordinates")
        } else if !(finite(max) && (0..3).all(|i| max[i] > min[i])) {
            ("max", max, "three finite coordinates, each above that of `min`")
        } else {
            return Ok(Self::Cuboid(Cuboid { min, max }));
        };
        Err(GeometryError::Vector { name, value, expected })
    }

    /// The distances at which the line of `origin` and `direction` enters and leaves the shape.
    pub(crate) fn crossing(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<[f64; 2]> {
        match self {
            Self::Ellipsoid(ellipsoid) => ellipsoid.crossing(origin, direction),
            Self::Cuboid(cuboid) => cuboid.crossing(origin, direction),
        }
    }

    /// Two distances between which all lines of sight of an observer are inside the shape, as far as they are: the least
    /// ones, but for those of an observer near an ellipsoid that is no sphere.
    pub(super) fn distances(&self, observer: &Observer) -> [f64; 2] {
        match (self, observer) {
            (Self::Ellipsoid(ellipsoid), Observer::Point(origin)) => {
                let distance = norm(difference(ellipsoid.centre(), *origin));
                [-1.0, 1.0].map(|side| (distance + side * ellipsoid.longest()).max(0.0))
            }
            (Self::Ellipsoid(ellipsoid), Observer::Parallel { plane_point, direction }) => {
                let distance = dot(difference(ellipsoid.centre(), *plane_point), *direction);
                let reach = norm(ellipsoid.semi_axis_vectors().map(|axis| dot(axis, *direction)));
                [distance - reach, distance + reach]
            }
            (Self::Cuboid(cuboid), Observer::Point(origin)) => {
                let beside = [0, 1, 2].map(|i| {
                    let [below, above] = [cuboid.min[i] - origin[i], cuboid.max[i] - origin[i]];
                    [below.max(-above).max(0.0), below.abs().max(above.abs())]
                });
                [0, 1].map(|end| norm(beside.map(|of_axis| of_axis[end])))
            }
            (Self::Cuboid(cuboid), Observer::Parallel { plane_point, direction }) => {
                let middle = dot(difference(cuboid.at([0.5; 3]), *plane_point), *direction);
                let reach: f64 = (0..3).map(|i| 0.5 * (cuboid.edge(i) * direction[i]).abs()).sum();
                [middle - reach, middle + reach]
            }
        }
    }
}

impl Cuboid {
    /// The coordinate of a face along its axis.
    pub(crate) fn plane(&self, axis: usize, is_max: bool) -> f64 {
        if is_max { self.max[axis] } else { self.min[axis] }
    }

    /// The length of the edges along an axis.
    pub(crate) fn edge(&self, axis: usize) -> f64 {
        self.max[axis] - self.min[axis]
    }

    /// The position at a place in units of the edges, from 0 to 1.
    pub(crate) fn at(&self, place: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| {
            if place[i] >= 1.0 { self.max[i] } else { self.min[i] + place[i] * self.edge(i) }
        })
    }

    /// The place of a position in units of the edges.
    pub(crate) fn place_of(&self, position: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| (position[i] - self.min[i]) / self.edge(i))
    }

    fn crossing(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<[f64; 2]> {
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if !(self.min[axis]..=self.max[axis]).contains(&origin[axis]) {
                    return None;
                }
                continue;
            }
            let [a, b] = [self.min, self.max].map(|c| (c[axis] - origin[axis]) / direction[axis]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter < leave).then_some([enter, leave])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_cross_a_box_where_they_should() {
        let room = Bounds::cuboid([-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]).unwrap();
        let crossing = |origin, direction| room.crossing(origin, direction);
        assert_eq!(crossing([-5.0, 0.0, 0.0], [1.0, 0.0, 0.0]), Some([4.0, 6.0]));
        assert_eq!(crossing([0.0, 0.0, 0.0], [0.0, 0.0, -1.0]), Some([-3.0, 3.0]));
        assert_eq!(crossing([-5.0, 2.5, 0.0], [1.0, 0.0, 0.0]), None);
        let diagonal = crossing([-2.0, -2.0, 0.0], [0.6, 0.8, 0.0]).unwrap();
        assert!((diagonal[0] - 1.0 / 0.6).abs() < 1e-15 && (diagonal[1] - 5.0).abs() < 1e-15);
        assert_eq!(crossing([-9.0, 0.0, 0.0], [0.6, 0.8, 0.0]), None);
    }

    #[test]
    fn a_box_inside_out_is_refused() {
        let message = Bounds::cuboid([0.0; 3], [1.0, -1.0, 1.0]).unwrap_err().to_string();
        let expected = "three finite coordinates, each above that of `min`";
        assert_eq!(message, format!("`max` is [1.0, -1.0, 1.0]: expected {expected}"));
        assert!(Bounds::cuboid([f64::NAN; 3], [1.0; 3]).is_err());
    }
}
