//! Where lines enter and leave ellipsoids and boxes: geometry of its own, for a reference that does not
//! depend on the library's.

use emitree::projection::{Bounds, Ellipsoid, GeometryError};

pub(super) type Vector = [f64; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// a + t b.
pub(super) fn advanced(a: Vector, t: f64, b: Vector) -> Vector {
    core::array::from_fn(|i| a[i] + t * b[i])
}

/// a − b.
pub(super) fn less(a: Vector, b: Vector) -> Vector {
    advanced(a, -1.0, b)
}

/// An ellipsoid with semi-axes along any orthonormal vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ball {
    pub(super) centre: Vector,
    pub(super) semi_axes: Vector,
    pub(super) axes: [Vector; 3],
}

impl Ball {
    /// A sphere.
    pub(super) fn sphere(centre: Vector, radius: f64) -> Self {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Self { centre, semi_axes: [radius; 3], axes }
    }

    /// A vector in units of the semi-axes, along them.
    fn scaled(&self, vector: Vector) -> Vector {
        core::array::from_fn(|i| dot(self.axes[i], vector) / self.semi_axes[i])
    }

    /// The distance from the centre over that of the surface in the same direction.
    pub(super) fn depth_of(&self, position: Vector) -> f64 {
        norm(self.scaled(less(position, self.centre)))
    }

    /// The roots of |o + t d|² = 1: where a line of `origin` and `direction` enters and leaves.
    pub(super) fn crossing(&self, origin: Vector, direction: Vector) -> Option<[f64; 2]> {
        let (o, d) = (self.scaled(less(origin, self.centre)), self.scaled(direction));
        // About the closest point: the discriminant is then a difference of numbers near 1.
        let middle = -dot(o, d) / dot(d, d);
        let closest = advanced(o, middle, d);
        let rest = 1.0 - dot(closest, closest);
        (rest > 0.0).then(|| {
            let half = (rest / dot(d, d)).sqrt();
            [middle - half, middle + half]
        })
    }

    /// The library's.
    pub(super) fn ellipsoid(&self) -> Result<Ellipsoid, GeometryError> {
        Ellipsoid::new(self.centre, self.semi_axes)?.oriented(self.axes[2], self.axes[0])
    }
}

/// The shape that contains all emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Room {
    Everywhere,
    Ball(Ball),
    Cuboid([Vector; 2]),
}

impl Room {
    /// Where a line enters and leaves, and which faces it does so by, as one number.
    pub(super) fn crossing(&self, origin: Vector, direction: Vector) -> Option<([f64; 2], u8)> {
        match self {
            Self::Everywhere => Some(([f64::NEG_INFINITY, f64::INFINITY], 0)),
            Self::Ball(ball) => ball.crossing(origin, direction).map(|ends| (ends, 0)),
            Self::Cuboid(corners) => cuboid_crossing(*corners, origin, direction),
        }
    }

    /// The library's.
    pub(super) fn bounds(&self) -> Result<Option<Bounds>, GeometryError> {
        Ok(match self {
            Self::Everywhere => None,
            Self::Ball(ball) => Some(Bounds::Ellipsoid(ball.ellipsoid()?)),
            Self::Cuboid([min, max]) => Some(Bounds::cuboid(*min, *max)?),
        })
    }
}

/// The slabs between the faces, one axis after the other.
fn cuboid_crossing(
    [min, max]: [Vector; 2],
    origin: Vector,
    direction: Vector,
) -> Option<([f64; 2], u8)> {
    let (mut ends, mut faces) = ([f64::NEG_INFINITY, f64::INFINITY], [3_u8; 2]);
    for axis in 0..3 {
        let [first, last] =
            [min[axis], max[axis]].map(|face| (face - origin[axis]) / direction[axis]);
        let (enter, leave) = (first.min(last), first.max(last));
        if direction[axis] == 0.0 {
            if !(min[axis]..=max[axis]).contains(&origin[axis]) {
                return None;
            }
            continue;
        }
        let number = [0, 1, 2][axis];
        if enter > ends[0] {
            (ends[0], faces[0]) = (enter, number);
        }
        if leave < ends[1] {
            (ends[1], faces[1]) = (leave, number);
        }
    }
    (ends[0] < ends[1]).then_some((ends, faces[0] * 4 + faces[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_a_cube_has_the_length_of_its_diagonal() {
        let room = Room::Cuboid([[-1.0; 3], [1.0; 3]]);
        let along = [1.0 / 3.0_f64.sqrt(); 3];
        let ([enter, leave], _) = room.crossing([-5.0; 3], along).unwrap_or_default();
        assert!((leave - enter - 2.0 * 3.0_f64.sqrt()).abs() < 1e-12, "{enter} {leave}");
        assert!(room.crossing([0.0, 3.0, 0.0], [1.0, 0.0, 0.0]).is_none());
    }

    #[test]
    fn a_line_through_an_ellipsoid_ends_on_its_surface() {
        let axes = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];
        let ball = Ball { centre: [1.0, 2.0, 3.0], semi_axes: [0.5, 1.0, 2.0], axes };
        let (origin, direction) = ([5.0, 2.3, 3.4], [-1.0, 0.0, 0.0]);
        let ends = ball.crossing(origin, direction).unwrap_or_default();
        assert!(ends[0] < ends[1]);
        for t in ends {
            assert!((ball.depth_of(advanced(origin, t, direction)) - 1.0).abs() < 1e-12);
        }
    }
}
