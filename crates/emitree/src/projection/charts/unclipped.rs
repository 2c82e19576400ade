//! A chart that bounds do not clip: all of its lines of sight begin at one distance, and end at another one.
//!
//! The distances at which lines of sight enter and leave bounds have kinks at the edges of a box, and change like a
//! square root at the limb of an ellipsoid. In coordinates that begin and end there, a plane or a sphere has the same kinks.
//! Here it has none, and where g is constant, so is G.

use super::chart::Chart;
use crate::projection::surroundings::{SightLine, Surroundings};
use crate::projection::vector::{difference, dot};
use crate::projection::{MappedPoint, Region};

/// Lines of sight along each axis of a chart from which its ends follow.
const LINES: usize = 33;
/// The least mean share of a line of sight inside the bounds. A thin layer is better resolved by coordinates that begin
/// and end at it.
const LEAST_SHARE: f64 = 0.015;
/// Ends that differ by less than this share of their distance are the same.
const SAME: f64 = 1e-6;

/// The ends of all lines of a chart that is not clipped.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CommonEnds {
    /// The distances at which all lines begin and end.
    ends: [f64; 2],
    /// The mean share of a line inside the bounds, of those that are inside of them somewhere.
    pub(crate) share: f64,
}

impl CommonEnds {
    /// The distances at which the first line of a chart enters the bounds, and the last one leaves them; `None` without
    /// bounds, if all lines begin and end at these distances or the limb of an ellipsoid is not in view, and if only a small
    /// share of lines is inside the bounds.
    pub(crate) fn of(chart: &dyn Chart, surroundings: &Surroundings) -> Option<Self> {
        let [mut from, mut to] = surroundings.distances_inside_bounds()?;
        let place = |k: usize| k as f64 / (LINES - 1) as f64;
        let ends_of_line = |k: usize| {
            let line = chart.line([place(k % LINES), place(k / LINES)])?;
            let [enter, leave] = line.ends;
            (enter < leave).then_some([enter, leave])
        };
        let inside: Vec<[f64; 2]> = (0..LINES * LINES).filter_map(ends_of_line).collect();
        let are_all_inside = inside.len() == LINES * LINES;
        if are_all_inside {
            // The ends of lines change smoothly but for the limb.
            if surroundings.is_within_ellipsoid() {
                return None;
            }
            let [first, last] = reach(&inside);
            [from, to] = [from.max(first), to.min(last)];
        }
        let is_end =
            |[enter, leave]: &[f64; 2]| (enter - from).max(to - leave) < SAME * (to - from);
        if are_all_inside && inside.iter().all(is_end) {
            return None;
        }
        let sum: f64 = inside.iter().map(|[enter, leave]| leave - enter).sum();
        let share = sum / ((to - from) * inside.len() as f64);
        (share > LEAST_SHARE).then_some(Self { ends: [from, to], share })
    }
}

/// The ends of the first and of the last one of lines on a lattice, and of the lines between these: there an end differs
/// from those of the lattice by no more than neighbours do.
fn reach(lattice: &[[f64; 2]]) -> [f64; 2] {
    let change = |end: usize| {
        let between = |k: usize, step: usize| (lattice[k][end] - lattice[k - step][end]).abs();
        let in_rows = (0..lattice.len()).filter(|k| k % LINES > 0).map(|k| between(k, 1));
        let in_columns = (LINES..lattice.len()).map(|k| between(k, LINES));
        in_rows.chain(in_columns).fold(0.0, f64::max)
    };
    let first = lattice.iter().map(|of| of[0]).fold(f64::INFINITY, f64::min);
    let last = lattice.iter().map(|of| of[1]).fold(f64::NEG_INFINITY, f64::max);
    [first - change(0), last + change(1)]
}

/// The lines of a chart without gaps, from one distance to another one.
#[derive(Debug)]
pub(crate) struct Unclipped<'a> {
    chart: Box<dyn Chart + 'a>,
    surroundings: &'a Surroundings,
    ends: [f64; 2],
}

impl<'a> Unclipped<'a> {
    /// The lines of a chart in these surroundings between the ends of all.
    pub(crate) fn new(
        chart: Box<dyn Chart + 'a>,
        surroundings: &'a Surroundings,
        of: CommonEnds,
    ) -> Self {
        Self { chart, surroundings, ends: of.ends }
    }

    fn z_of(&self, distance: f64) -> f64 {
        let [from, to] = self.ends;
        (distance - from) / (to - from)
    }
}

impl Chart for Unclipped<'_> {
    fn world_from_chart(&self, [u, v, z]: [f64; 3]) -> MappedPoint {
        let [from, to] = self.ends;
        let Some(line) = self.chart.line([u, v]) else { return MappedPoint::default() };
        let mut point = line.sample(from + z * (to - from), to - from);
        point.position = self.surroundings.outside(point.position);
        point
    }

    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let [u, v, _] = self.chart.chart_from_world(position)?;
        let line = self.chart.line([u, v])?;
        Some([u, v, self.z_of(dot(difference(position, line.origin), line.direction))])
    }

    fn density(&self, uv: [f64; 2]) -> f64 {
        self.chart.density(uv)
    }

    fn line(&self, uv: [f64; 2]) -> Option<SightLine> {
        self.chart.line(uv)
    }

    fn depth_of(&self, _line: &SightLine, distance: f64) -> f64 {
        self.z_of(distance).clamp(0.0, 1.0)
    }

    fn visible_end(&self, uv: [f64; 2]) -> Option<(usize, f64)> {
        let (Region::Body(body), end) = self.surroundings.end_of(&self.chart.line(uv)?) else {
            return None;
        };
        Some((body, self.z_of(end)))
    }

    fn ends_inside_bounds(&self, uv: [f64; 2]) -> [f64; 2] {
        let line = self.chart.line(uv).filter(|line| line.ends[0] < line.ends[1]);
        line.map_or([1.0, 0.0], |line| line.ends.map(|end| self.z_of(end)))
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        self.chart.image_place(uv)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::{Bounds, Ellipsoid, Projection, ViewGeometry};
    use crate::{Orthographic, Perspective, Viewpoint};

    const INFINITE: f64 = f64::INFINITY;

    fn bounds() -> [Bounds; 3] {
        let tilted = Ellipsoid::new([0.2, 0.1, 0.0], [1.0, 0.5, 0.7]).unwrap();
        let tilted = tilted.oriented([1.0, 2.0, 2.0], [1.0, 0.0, 0.0]).unwrap();
        let sphere = Ellipsoid::sphere([0.1, -0.1, 0.2], 0.9).unwrap();
        let room = Bounds::cuboid([-0.7, -0.6, -0.8], [0.8, 0.7, 0.9]).unwrap();
        [Bounds::Ellipsoid(tilted), Bounds::Ellipsoid(sphere), room]
    }

    /// Views from outside of all of the bounds and, of a box, from inside and of a part.
    fn views(bounds: Bounds) -> Vec<Box<dyn Projection>> {
        let from =
            |position: [f64; 3]| Viewpoint { position, target: [0.0; 3], up: [0.0, 0.0, 1.0] };
        let perspective = |position, fov_rad: f64| {
            let camera = Perspective::new(from(position), [fov_rad; 2], [0.0, INFINITE]).unwrap();
            Box::new(camera.with_bounds(bounds)) as Box<dyn Projection>
        };
        let parallel = |extent: f64| {
            let viewpoint = from([1.0, 2.0, 3.0]);
            let depth = [-INFINITE, INFINITE];
            let camera = Orthographic::new(viewpoint, [extent; 2], depth).unwrap();
            Box::new(camera.with_bounds(bounds)) as Box<dyn Projection>
        };
        let mut views = vec![perspective([3.0, -5.0, 2.0], 0.5), parallel(3.0)];
        if matches!(bounds, Bounds::Cuboid(_)) {
            views.push(perspective([3.0, -5.0, 2.0], 0.05));
            views.push(perspective([0.3, -0.2, 0.1], 1.5));
            views.push(parallel(0.3));
        }
        views
    }

    fn unclipped(geometry: &dyn ViewGeometry) -> Option<Unclipped<'_>> {
        let chart = geometry.chart(0);
        let around = geometry.surroundings()?;
        let ends = CommonEnds::of(&*chart, around)?;
        Some(Unclipped::new(chart, around, ends))
    }

    #[test]
    fn all_that_is_inside_the_bounds_is_between_the_ends_of_all_lines() {
        for bounds in bounds() {
            for view in views(bounds) {
                let geometry = view.view_geometry().unwrap();
                let chart = unclipped(geometry).unwrap();
                let mut seen = 0;
                for k in 0..400 {
                    let [x, y, share] = crate::vol::lattice::point(k);
                    let line = geometry.line([x, y]).unwrap();
                    let [from, to] = chart.ends_inside_bounds([x, y]);
                    if line.ends[0] >= line.ends[1] {
                        assert!(from > to);
                        continue;
                    }
                    seen += 1;
                    assert!(
                        from >= -1e-12 && from < to && to <= 1.0 + 1e-12,
                        "{view:?}: {from} {to}"
                    );
                    let z = from + share * (to - from);
                    let point = chart.world_from_chart([x, y, z]);
                    let [enter, leave] = line.ends;
                    let distance = enter + share * (leave - enter);
                    let expected = line.at(distance);
                    let back = chart.chart_from_world(expected).unwrap();
                    for k in 0..3 {
                        assert!((point.position[k] - expected[k]).abs() < 1e-12);
                        assert!((back[k] - [x, y, z][k]).abs() < 1e-9);
                    }
                    assert!((chart.depth_of(&line, distance) - z).abs() < 1e-12);
                }
                assert!(seen > 50);
            }
        }
    }

    #[test]
    fn the_length_of_a_depth_is_that_of_all_lines() {
        let view = &views(bounds()[2])[0];
        let chart = unclipped(view.view_geometry().unwrap()).unwrap();
        let lengths =
            [[0.1, 0.2, 0.3], [0.8, 0.4, 0.7]].map(|u| chart.world_from_chart(u).path_per_depth);
        assert!((lengths[0] - lengths[1]).abs() < 1e-12 * lengths[0]);
    }

    #[test]
    fn views_without_kinks_and_thin_layers_keep_their_coordinates() {
        let viewpoint =
            Viewpoint { position: [0.0, 0.0, 5.0], target: [0.0; 3], up: [0.0, 1.0, 0.0] };
        let camera = Orthographic::new(viewpoint, [1.9; 2], [-INFINITE, INFINITE]).unwrap();
        assert!(unclipped(&camera).is_none());
        let room = Bounds::cuboid([-1.0; 3], [1.0; 3]).unwrap();
        assert!(unclipped(&camera.clone().with_bounds(room)).is_none());
        for bounds in bounds().into_iter().take(2) {
            assert!(unclipped(&camera.clone().with_bounds(bounds)).is_some());
            let within = Orthographic::new(viewpoint, [0.2; 2], [-INFINITE, INFINITE]).unwrap();
            assert!(unclipped(&within.with_bounds(bounds)).is_none());
        }
        let layer = Bounds::cuboid([-9.0, -9.0, -0.01], [9.0, 9.0, 0.01]).unwrap();
        let oblique =
            Viewpoint { position: [0.0, 5.0, 5.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
        let camera = Orthographic::new(oblique, [4.0; 2], [-INFINITE, INFINITE]).unwrap();
        assert!(unclipped(&camera.with_bounds(layer)).is_none());
    }
}
