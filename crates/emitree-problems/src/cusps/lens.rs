//! Lines of sight near a point, by geometry of its own: exact however close to the point they are.

use super::cusp::{Line, Vector, advanced, dot};
use emitree::projection::{Bounds, GeometryError, Singularity};
use emitree::{Equirectangular, Orthographic, Perspective, Projection, Viewpoint};

/// The kind of a camera, and with it what coordinates of its image plane are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Lengths; all lines are parallel.
    Parallel,
    /// Tangents of angles from the pointing.
    Tangent,
    /// Longitude and latitude \[rad\].
    Angles,
}

/// A camera at a position, that looks along +y, with +x to the right and +z up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lens {
    pub(super) kind: Kind,
    pub(super) position: Vector,
    /// Half of the width and of the height of the image on its plane.
    pub(super) half: [f64; 2],
    /// Distances from which to which lines reach.
    pub(super) depth: [f64; 2],
}

/// A point as a camera has it: its place on the image plane, and its distance, along the pointing for
/// tangents, and itself for angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    pub(super) place: [f64; 2],
    pub(super) distance: f64,
}

impl Lens {
    /// The camera of the library.
    pub(super) fn camera(
        &self,
        bounds: Option<Bounds>,
        singularities: Vec<Singularity>,
    ) -> Result<Box<dyn Projection>, GeometryError> {
        let target = advanced(self.position, 1.0, [0.0, 1.0, 0.0]);
        let viewpoint = Viewpoint { position: self.position, target, up: [0.0, 0.0, 1.0] };
        let full = self.half.map(|half| 2.0 * half);
        macro_rules! bounded {
            ($camera:expr) => {{
                let camera = $camera.with_singularities(singularities);
                match bounds {
                    Some(bounds) => Box::new(camera.with_bounds(bounds)),
                    None => Box::new(camera),
                }
            }};
        }
        Ok(match self.kind {
            Kind::Parallel => bounded!(Orthographic::new(viewpoint, full, self.depth)?),
            Kind::Tangent => {
                let fov = self.half.map(|half| 2.0 * libm::atan(half));
                bounded!(Perspective::new(viewpoint, fov, self.depth)?)
            }
            Kind::Angles => bounded!(Equirectangular::new(viewpoint, full, self.depth)?),
        })
    }

    /// A point in front of the camera.
    pub(super) fn seen(&self, position: Vector) -> Seen {
        let [right, forward, up] = advanced(position, -1.0, self.position);
        match self.kind {
            Kind::Parallel => Seen { place: [right, up], distance: forward },
            Kind::Tangent => Seen { place: [right / forward, up / forward], distance: forward },
            Kind::Angles => {
                let distance = right.hypot(up).hypot(forward);
                let place = [libm::atan2(right, forward), libm::asin(up / distance)];
                Seen { place, distance }
            }
        }
    }

    /// The point that is seen at a place.
    pub(super) fn point(&self, seen: Seen) -> Vector {
        let Seen { place: [x, y], distance } = seen;
        let offset = match self.kind {
            Kind::Parallel => [x, distance, y],
            Kind::Tangent => [x * distance, distance, y * distance],
            Kind::Angles => direction_of_angles([x, y]).map(|component| distance * component),
        };
        advanced(self.position, 1.0, offset)
    }

    /// Of solid angle, or of area for parallel lines, at a place on the image plane.
    pub(super) fn density(&self, [x, y]: [f64; 2]) -> f64 {
        match self.kind {
            Kind::Parallel => 1.0,
            Kind::Tangent => libm::pow(1.0 + x * x + y * y, -1.5),
            Kind::Angles => libm::cos(y),
        }
    }

    /// The line at an `offset` on the image plane from the place of a point.
    pub(super) fn line(&self, seen: &Seen, offset: [f64; 2]) -> Line {
        let [x, y] = [0, 1].map(|i| seen.place[i] + offset[i]);
        let distance = seen.distance;
        let [near, far] = self.depth;
        let (direction, across, along) = match self.kind {
            Kind::Parallel => {
                let across = [offset[0], 0.0, offset[1]];
                return Line {
                    offset: across,
                    direction: [0.0, 1.0, 0.0],
                    ends: [near - distance, far - distance],
                };
            }
            Kind::Tangent => {
                let length = (1.0 + x * x + y * y).sqrt();
                let direction = [x / length, 1.0 / length, y / length];
                let to_point = [distance * seen.place[0], distance, distance * seen.place[1]];
                (direction, [offset[0], 0.0, offset[1]], dot(to_point, direction))
            }
            Kind::Angles => {
                let direction = direction_of_angles([x, y]);
                let to_point = direction_of_angles(seen.place);
                (
                    direction,
                    change_of_angles(seen.place, offset),
                    distance * dot(to_point, direction),
                )
            }
        };
        // The line is the point's own, turned: what is across it is the distance from the point.
        let aside = advanced(across, -dot(across, direction), direction);
        Line {
            offset: aside.map(|component| distance * component),
            direction,
            ends: [near - along, far - along],
        }
    }

    /// A line as its origin and its direction.
    pub(super) fn origin_and_direction(&self, [x, y]: [f64; 2]) -> (Vector, Vector) {
        match self.kind {
            Kind::Parallel => (advanced(self.position, 1.0, [x, 0.0, y]), [0.0, 1.0, 0.0]),
            Kind::Tangent => {
                let length = (1.0 + x * x + y * y).sqrt();
                (self.position, [x / length, 1.0 / length, y / length])
            }
            Kind::Angles => (self.position, direction_of_angles([x, y])),
        }
    }
}

fn direction_of_angles([longitude, latitude]: [f64; 2]) -> Vector {
    let (cos, sin) = (libm::cos(latitude), libm::sin(latitude));
    [cos * libm::sin(longitude), cos * libm::cos(longitude), sin]
}

/// How the direction changes from a place to one at an offset, without differences of nearly equal
/// numbers: sin b − sin a = 2 cos((a + b)/2) sin((b − a)/2).
fn change_of_angles([longitude, latitude]: [f64; 2], [east, north]: [f64; 2]) -> Vector {
    let half = |angle: f64, step: f64| (angle + 0.5 * step, libm::sin(0.5 * step));
    let ((mean_lon, half_east), (mean_lat, half_north)) =
        (half(longitude, east), half(latitude, north));
    let cos_latitude_change = -2.0 * libm::sin(mean_lat) * half_north;
    let sin_latitude_change = 2.0 * libm::cos(mean_lat) * half_north;
    let sin_longitude_change = 2.0 * libm::cos(mean_lon) * half_east;
    let cos_longitude_change = -2.0 * libm::sin(mean_lon) * half_east;
    let cos_latitude = libm::cos(latitude);
    let moved = longitude + east;
    [
        cos_latitude_change * libm::sin(moved) + cos_latitude * sin_longitude_change,
        cos_latitude_change * libm::cos(moved) + cos_latitude * cos_longitude_change,
        sin_latitude_change,
    ]
}
