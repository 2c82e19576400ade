//! What lines of sight meet: their depths, the bounds of the emission, opaque bodies and edges.
//!
//! Cameras with the same observer share it, whatever their image planes are.

use super::MappedPoint;
use super::bounds::Bounds;
use super::edge::Edge;
use super::ellipsoid::Ellipsoid;
pub(super) use super::observer::Observer;
use super::region::Region;
use super::singularity::Singularity;
use super::span::{Depth, Span};
use super::vector::{along, difference, dot, unit};

/// Lines are clipped this part of their length inside of the bounds: a model that ends there is
/// evaluated inside, whatever rounding does.
const INSIDE_BOUNDS: f64 = 1e-9;

/// The distances of the points beside a body that continue g through it, in lengths of the gap, if
/// there is room. With 0.2 and 0.33 two scenes of a planet with a moon took 1.2 and 1.4 times as many
/// evaluations at 0.1 %.
const GAP_STEP: f64 = 0.1;
/// The least distance of these points, in lengths of the gap. The sum of the absolute weights is 97
/// if the points are 0.1 apart on both sides, 2,000 if they are 0.04 apart on one side, and 3e9 with
/// hardly any room there: rounding would be noise that lines resolve with 1e5 samples.
const LEAST_GAP_STEP: f64 = 0.04;
/// How far from a body points beside it are at least, in lengths of the gap.
const BESIDE_BODY: f64 = 1e-9;
/// The number of points beside a body, half of them on each side.
pub(super) const POINTS_OF_GAP: usize = 10;

/// What the lines of sight of a camera meet. Returned by
/// [`ViewGeometry::surroundings`](super::ViewGeometry::surroundings) for the charts of a view.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    pub(super) observer: Observer,
    depth: Depth,
    pub(super) bounds: Option<Bounds>,
    pub(super) bodies: Vec<Ellipsoid>,
    /// Surfaces on which the emission jumps or has a kink.
    pub(super) edges: Vec<Edge>,
    /// Points and axes at which the emission is singular.
    pub(super) singularities: Vec<Singularity>,
}

impl Surroundings {
    pub(super) fn new(observer: Observer, depth: Depth) -> Self {
        let (bodies, edges, singularities) = (Vec::new(), Vec::new(), Vec::new());
        Self { observer, depth, bounds: None, bodies, edges, singularities }
    }

    /// Whether all lines of sight begin at one point.
    pub(crate) fn is_seen_from_point(&self) -> bool {
        matches!(self.observer, Observer::Point(_))
    }

    /// The line of sight from `origin` along a unit vector.
    pub(super) fn line(&self, origin: [f64; 3], direction: [f64; 3]) -> SightLine {
        let [near, far] = self.depth.ends();
        let ends = match self.bounds.map(|bounds| bounds.crossing(origin, direction)) {
            None => [near, far],
            Some(None) => [near.max(0.0); 2],
            Some(Some([enter, leave])) => {
                let inside = INSIDE_BOUNDS * (leave - enter);
                let from = near.max(enter + inside);
                [from, far.min(leave - inside).max(from)]
            }
        };
        SightLine { origin, direction, ends }
    }

    /// The region of a line, and the distance at which it ends.
    pub(super) fn end_of(&self, line: &SightLine) -> (Region, f64) {
        let [from, to] = line.ends;
        let mut seen = (Region::Sky, to);
        for (number, body) in self.bodies.iter().enumerate() {
            if let Some([enter, leave]) = body.crossing(line.origin, line.direction)
                && leave > from
                && enter < seen.1
            {
                seen = (Region::Body(number), enter.max(from));
            }
        }
        seen
    }

    /// The gap in which a distance of a line is, inside of a body other than number `own`: a
    /// polynomial through points on both sides continues g, as far as the line is between two distances. So the
    /// radiance of lines that a body hides continues that of the lines beside its limb.
    pub(super) fn gap(
        &self,
        line: &SightLine,
        [from, to]: [f64; 2],
        distance: f64,
        own: Option<usize>,
    ) -> Option<Gap> {
        let others = self.bodies.iter().enumerate().filter(|(number, _)| Some(*number) != own);
        let crossings = others
            .filter_map(|(_, body)| body.crossing(line.origin, line.direction))
            .filter(|&[enter, leave]| enter < to && leave > from);
        let [enter, leave] = gap_around(distance, &|| crossings.clone())?;
        // Rounding does not move points into the body.
        let beside = BESIDE_BODY * (leave - enter);
        let [enter, leave] = [enter - beside, leave + beside];
        let step = |room: f64| {
            (GAP_STEP * (leave - enter)).min(0.8 * room / (POINTS_OF_GAP / 2 - 1) as f64)
        };
        let [before, behind] = [step(enter - from), step(to - leave)];
        let least = LEAST_GAP_STEP * (leave - enter);
        if !(before > least && behind > least) {
            return None;
        }
        let half = POINTS_OF_GAP / 2;
        let distances = core::array::from_fn(|k| match k.checked_sub(half) {
            None => enter - (half - 1 - k) as f64 * before,
            Some(k) => leave + k as f64 * behind,
        });
        let weights = core::array::from_fn(|k| {
            let others = distances.iter().enumerate().filter(|(other, _)| *other != k);
            let own = distances[k];
            others.map(|(_, other): (usize, &f64)| (distance - other) / (own - other)).product()
        });
        Some(Gap { distances, weights })
    }

    /// The line of sight through a position; `None` if it is that of the observer.
    pub(super) fn line_to(&self, position: [f64; 3]) -> Option<SightLine> {
        match self.observer {
            Observer::Point(origin) => Some(self.line(origin, unit(difference(position, origin))?)),
            Observer::Parallel { plane_point, direction } => {
                let back = dot(difference(plane_point, position), direction);
                Some(self.line(along(position, back, direction), direction))
            }
        }
    }

    /// The distances from which to which lines of sight reach.
    pub(super) fn depths(&self) -> [f64; 2] {
        self.depth.ends()
    }

    /// The distances between which all lines of sight are inside the bounds, as far as they are; `None` without bounds,
    /// or if these are not between the depths.
    pub(crate) fn distances_inside_bounds(&self) -> Option<[f64; 2]> {
        let [near, far] = self.depth.ends();
        let [from, to] = self.bounds?.distances(&self.observer);
        let [from, to] = [from.max(near), to.min(far)];
        (from < to && from.is_finite() && to.is_finite()).then_some([from, to])
    }

    /// Whether the bounds are an ellipsoid.
    pub(crate) fn is_within_ellipsoid(&self) -> bool {
        matches!(self.bounds, Some(Bounds::Ellipsoid(_)))
    }

    /// Whether there are bodies, edges, singularities or bounds that are an ellipsoid, for which views have charts.
    pub(crate) fn has_surfaces(&self) -> bool {
        !(self.bodies.is_empty() && self.edges.is_empty() && self.singularities.is_empty())
            || self.is_within_ellipsoid()
    }

    /// The distance of the target, a length of the size of the view.
    pub(super) fn scale(&self) -> f64 {
        self.depth.scale()
    }

    pub(super) fn span(&self, from: f64, to: f64) -> Span {
        self.depth.span(from, to)
    }

    /// The nearest position outside of all bodies, a rounding above the surface if it is inside.
    pub(super) fn outside(&self, position: [f64; 3]) -> [f64; 3] {
        self.bodies.iter().fold(position, |position, body| body.outside(position))
    }
}

/// The part of a line around a distance that is inside of bodies, given where it enters and leaves
/// them. Bodies between which there is no room for the points beside them are one, and so is what is
/// between them.
fn gap_around<C: Iterator<Item = [f64; 2]>>(
    distance: f64,
    crossings: &dyn Fn() -> C,
) -> Option<[f64; 2]> {
    let with_near = |mut gap: [f64; 2]| loop {
        let [enter, leave] = gap;
        let room = GAP_STEP * (leave - enter) * (POINTS_OF_GAP / 2) as f64;
        let near = crossings().filter(|other| other[0] < leave + room && other[1] > enter - room);
        let whole = near.fold(gap, |all, other| [all[0].min(other[0]), all[1].max(other[1])]);
        if whole[0] >= enter && whole[1] <= leave {
            break gap;
        }
        gap = whole;
    };
    // A large body has a small one near it, for which the large one is far.
    let gaps = crossings().map(with_near);
    let around = gaps.filter(|&[enter, leave]| enter < distance && distance < leave);
    around.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
}

/// Points of a line on both sides of a body, and their weights in the value of a
/// polynomial.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gap {
    pub(super) distances: [f64; POINTS_OF_GAP],
    pub(super) weights: [f64; POINTS_OF_GAP],
}

/// A line of sight in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SightLine {
    pub(super) origin: [f64; 3],
    pub(super) direction: [f64; 3],
    /// The distances between which the emission may be above 0.
    pub(super) ends: [f64; 2],
}

impl SightLine {
    /// The unit vector along it, away from the observer.
    pub(crate) fn direction(&self) -> [f64; 3] {
        self.direction
    }

    /// The position at a distance from the origin.
    pub(super) fn at(&self, distance: f64) -> [f64; 3] {
        along(self.origin, distance, self.direction)
    }

    /// The point at `z` of a part of the line.
    pub(super) fn point(&self, span: &Span, z: f64) -> MappedPoint {
        let (distance, path_per_depth) = span.at(z);
        self.sample(distance, path_per_depth)
    }

    /// The point at a distance, with its ds/dz.
    pub(super) fn sample(&self, distance: f64, path_per_depth: f64) -> MappedPoint {
        MappedPoint {
            position: self.at(distance),
            direction: self.direction.map(|component| -component),
            path_per_depth,
        }
    }
}

#[cfg(test)]
mod tests;
