//! Paths: the part of a line of sight between the observer and any point on it, over which a medium absorbs.
//!
//! A point and its direction of emission determine the line of sight, whichever chart the point is from. Lines
//! that differ by rounding alone are one line, so that what is known of it serves all of its points.

use super::edge::Edge;
use super::span::Span;
use super::surroundings::{Observer, SightLine, Surroundings};
use super::vector::{along, difference, dot, unit};
use super::{MappedPoint, Projection};

/// Parts of the unit of length, or of the length of a unit vector, by which lines differ: 250 times the
/// rounding of such numbers, and far below the width of a pixel.
const RESOLUTION: f64 = 5.684_341_886_080_802e-14;
/// A part that is shorter than this share of the distances of its ends is left out: its places are one.
const SHORTEST: f64 = 1e-12;

/// A line of sight, as a number of each of its coordinates.
pub(crate) type LineKey = [i64; 3];

/// All lines of sight of a view.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Paths<'a> {
    /// The lines of an observer.
    Observer(&'a Surroundings),
    /// The lines of a map without surroundings, each from z = 0 to z = 1.
    Map(&'a dyn Projection),
}

/// One line of sight, in parts between the surfaces that it crosses.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    line: Line,
    /// Ascending, without gaps; none if the line is outside of the bounds.
    parts: Vec<Part>,
}

#[derive(Clone, Copy, Debug)]
enum Line {
    Sight(SightLine),
    /// Canonical (x, y).
    Place([f64; 2]),
}

/// A part of a line.
#[derive(Clone, Copy, Debug)]
struct Part {
    span: Span,
    /// Whether it is inside of an opaque body.
    is_inside_body: bool,
}

impl<'a> Paths<'a> {
    /// The lines of sight of a projection.
    pub(crate) fn of(projection: &'a dyn Projection) -> Self {
        let around = |projection: &'a dyn Projection| {
            projection.view_geometry().and_then(|geometry| geometry.surroundings())
        };
        let tiles = projection.tiles();
        let own = around(projection);
        let of_all = match tiles.first() {
            None => own,
            Some(first) => around(*first)
                .filter(|first| tiles.iter().all(|tile| around(*tile) == Some(*first))),
        };
        of_all.map_or(Self::Map(projection), Self::Observer)
    }

    /// The line of sight on which a point is that emits along `direction`, and how far along it: a
    /// distance, or z of a map. `None` if the point is on no line, or at the observer.
    pub(crate) fn locate(&self, position: [f64; 3], direction: [f64; 3]) -> Option<(LineKey, f64)> {
        match self {
            Self::Observer(surroundings) => match surroundings.observer {
                Observer::Point(origin) => {
                    let outwards = direction.map(|component| -component);
                    Some((key(outwards, 1.0), dot(difference(position, origin), outwards)))
                }
                Observer::Parallel { plane_point, direction } => {
                    let from = difference(position, plane_point);
                    let distance = dot(from, direction);
                    Some((key(along(from, -distance, direction), surroundings.scale()), distance))
                }
            },
            Self::Map(projection) => {
                let [x, y, z] = projection.canonical_from_world(position)?;
                Some((key([x, y, 0.0], 1.0), z))
            }
        }
    }

    /// A line of sight by its key.
    pub(crate) fn path(&self, key: LineKey) -> Path {
        let components = key.map(|number| number as f64 * RESOLUTION);
        match self {
            Self::Observer(surroundings) => {
                let line = match surroundings.observer {
                    // A direction is no zero vector.
                    Observer::Point(origin) => {
                        surroundings.line(origin, unit(components).unwrap_or(components))
                    }
                    Observer::Parallel { plane_point, direction } => {
                        let origin = along(plane_point, surroundings.scale(), components);
                        surroundings.line(origin, direction)
                    }
                };
                Path { line: Line::Sight(line), parts: parts(surroundings, &line) }
            }
            Self::Map(_) => {
                let part = Part { span: Span::of_unit_interval(), is_inside_body: false };
                Path { line: Line::Place([components[0], components[1]]), parts: vec![part] }
            }
        }
    }

    /// The point at `z`, from 0 to 1, of a part of a path; outside of opaque bodies.
    pub(crate) fn point(&self, path: &Path, part: usize, z: f64) -> MappedPoint {
        match (self, path.line) {
            (Self::Observer(surroundings), Line::Sight(line)) => {
                let mut point = line.point(&path.parts[part].span, z);
                point.position = surroundings.outside(point.position);
                point
            }
            (Self::Map(projection), Line::Place([x, y])) => {
                projection.world_from_canonical([x, y, z])
            }
            // Paths are those of their own view.
            _ => MappedPoint::default(),
        }
    }
}

impl Path {
    /// The number of its parts.
    pub(crate) fn parts(&self) -> usize {
        self.parts.len()
    }

    /// The part in which `at` is, the last one beyond its end, and z there.
    pub(crate) fn place(&self, at: f64) -> Option<(usize, f64)> {
        let is_before = |end: f64| at - SHORTEST * at.abs() <= end;
        let part = self.parts.iter().position(|part| is_before(part.span.ends()[1]));
        let part = part.or(self.parts.len().checked_sub(1))?;
        Some((part, self.parts[part].span.z_of(at).clamp(0.0, 1.0)))
    }

    /// Whether a part is inside of an opaque body, where nothing is evaluated.
    pub(crate) fn is_inside_body(&self, part: usize) -> bool {
        self.parts[part].is_inside_body
    }

    /// The length of a part.
    pub(crate) fn length(&self, part: usize) -> f64 {
        let [from, to] = self.parts[part].span.ends();
        to - from
    }
}

/// The components of a vector in units of `unit`, rounded.
fn key(vector: [f64; 3], unit: f64) -> LineKey {
    #[expect(clippy::cast_possible_truncation, reason = "saturates, far outside of the view")]
    vector.map(|component| (component / (unit * RESOLUTION)).round() as i64)
}

/// The parts of a line between the surfaces of bodies and edges, from its beginning to its end.
fn parts(surroundings: &Surroundings, line: &SightLine) -> Vec<Part> {
    let SightLine { origin, direction, ends: [from, to] } = *line;
    let bodies: Vec<[f64; 2]> =
        surroundings.bodies.iter().filter_map(|body| body.crossing(origin, direction)).collect();
    let mut borders = vec![from, to];
    borders.extend(bodies.iter().flatten());
    for edge in &surroundings.edges {
        match edge {
            Edge::Ellipsoid(ellipsoid) => {
                borders.extend(ellipsoid.crossing(origin, direction).into_iter().flatten());
            }
            Edge::Plane { position, normal } => {
                borders.push(dot(difference(*position, origin), *normal) / dot(direction, *normal));
            }
        }
    }
    borders.retain(|border| (from..=to).contains(border));
    borders.sort_by(f64::total_cmp);
    let is_short = |[from, to]: [f64; 2]| {
        let far = from.abs().max(to.abs());
        far.is_finite() && to - from <= SHORTEST * far
    };
    let mut parts = Vec::new();
    let mut begin = from;
    for &end in &borders {
        if end <= begin || is_short([begin, end]) {
            continue;
        }
        let span = surroundings.span(begin, end);
        let middle = span.at(0.5).0;
        let is_inside_body = bodies.iter().any(|[enter, leave]| (*enter..*leave).contains(&middle));
        parts.push(Part { span, is_inside_body });
        begin = end;
    }
    parts
}

#[cfg(test)]
mod tests;
