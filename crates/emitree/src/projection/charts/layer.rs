//! Layers: the parts of a chart on each side of planes on which g jumps or has a kink.
//!
//! A plane that is not seen edge-on crosses each line of sight at one depth. The planes divide space into
//! convex regions, so that the part of a line in each of them is an interval, and g is smooth along it up to its
//! ends. A *layer* is the part of a chart in one region. Its depth is quadratic near a plane, so that a square
//! root of the distance from the plane is smooth, too.

use super::chart::Chart;
use crate::projection::ViewGeometry;
use crate::projection::edge::Edge;
use crate::projection::surroundings::{Observer, SightLine, Surroundings};
use crate::projection::vector::{difference, dot, norm};

/// Planes that divide a view, at most: so many make 8 layers. Others have no effect.
const MOST_PLANES: usize = 3;
/// An observer is on a plane if its distance, in units of the size of the view, is smaller, and lines of sight are
/// parallel to a plane if the cosine of the angle between them and its normal is.
const EDGE_ON: f64 = 1e-9;

/// One side of a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
struct HalfSpace {
    position: [f64; 3],
    /// The unit normal, which points to the inside.
    normal: [f64; 3],
}

/// A region between planes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layer {
    sides: Vec<HalfSpace>,
}

/// All regions between the planes declared; none if lines of sight of the view are in one region only, or around an
/// opaque body: on its surface all regions would end within the image. Planes count whose normal has at least the
/// cosine `least_cosine` with the line of sight in the middle.
pub(crate) fn layers(geometry: &dyn ViewGeometry, least_cosine: f64) -> Vec<Layer> {
    let layers = regions(geometry, least_cosine);
    let in_view = layers.iter().filter(|layer| layer.is_in_view(geometry));
    if in_view.count() > 1 { layers } else { Vec::new() }
}

/// All regions between the planes, whatever is in view.
fn regions(geometry: &dyn ViewGeometry, least_cosine: f64) -> Vec<Layer> {
    let (Some(surroundings), Some(middle)) = (geometry.surroundings(), geometry.line([0.5; 2]))
    else {
        return Vec::new();
    };
    if !surroundings.bodies.is_empty() {
        return Vec::new();
    }
    let planes: Vec<HalfSpace> = surroundings
        .edges
        .iter()
        .filter_map(|edge| match *edge {
            Edge::Plane { position, normal } => Some(HalfSpace { position, normal }),
            Edge::Ellipsoid(_) => None,
        })
        .filter(|plane| plane.divides(surroundings, &middle, least_cosine))
        .take(MOST_PLANES)
        .collect();
    let region = |number: usize| {
        let side = |(k, plane): (usize, &HalfSpace)| match number >> k & 1 {
            0 => *plane,
            _ => HalfSpace { normal: plane.normal.map(|along| -along), ..*plane },
        };
        Layer { sides: planes.iter().enumerate().map(side).collect() }
    };
    (0..1 << planes.len()).map(region).collect()
}

impl HalfSpace {
    /// Whether the two sides of the plane are divided by depth.
    fn divides(&self, surroundings: &Surroundings, middle: &SightLine, least_cosine: f64) -> bool {
        if let Observer::Point(observer) = surroundings.observer {
            let size = surroundings.scale().max(1e-3 * norm(observer));
            let height = dot(difference(observer, self.position), self.normal);
            if height.abs() < EDGE_ON * size {
                return false;
            }
        }
        dot(middle.direction, self.normal).abs() >= least_cosine.max(EDGE_ON)
    }

    /// The distance at which a line crosses the plane, and whether it is inside beyond.
    fn crossing(&self, line: &SightLine) -> (f64, bool) {
        let height = dot(difference(line.origin, self.position), self.normal);
        let slope = dot(line.direction, self.normal);
        if slope == 0.0 {
            // Inside or outside everywhere.
            return (if height < 0.0 { f64::INFINITY } else { f64::NEG_INFINITY }, true);
        }
        (-height / slope, slope > 0.0)
    }
}

/// The part of a line in a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PartOfLine {
    /// The distances of its ends; it is empty if the second is not larger.
    ends: [f64; 2],
    /// Whether each end is at a plane as soon as the plane crosses the line there.
    is_at_plane: [bool; 2],
}

impl Layer {
    /// The depths of the layer in a chart, on the line at (u, v); `None` without lines of sight.
    pub(super) fn depths(&self, chart: &dyn Chart, uv: [f64; 2]) -> Option<Depths> {
        let line = chart.line(uv)?;
        let PartOfLine { ends: [from, to], is_at_plane } = self.part_of(&line, line.ends);
        let [start, end] = line.ends;
        let from = if from > start { chart.depth_of(&line, from) } else { 0.0 };
        let to = if to < end { chart.depth_of(&line, to) } else { 1.0 };
        Some(Depths { from, length: (to - from).max(0.0), is_at_plane })
    }

    /// The part of a piece of a line.
    fn part_of(&self, line: &SightLine, [mut from, mut to]: [f64; 2]) -> PartOfLine {
        let mut is_at_plane = [false; 2];
        for side in &self.sides {
            let (distance, is_inside_beyond) = side.crossing(line);
            if is_inside_beyond {
                from = from.max(distance);
            } else {
                to = to.min(distance);
            }
            is_at_plane[usize::from(!is_inside_beyond)] = true;
        }
        PartOfLine { ends: [from, to], is_at_plane }
    }

    /// Whether a piece of a line has a part in the layer.
    pub(super) fn has_part_of(&self, line: &SightLine, ends: [f64; 2]) -> bool {
        let [from, to] = self.part_of(line, ends).ends;
        to > from
    }

    /// The distances at which a line crosses the planes.
    pub(super) fn crossings(&self, line: &SightLine) -> impl Iterator<Item = f64> {
        self.sides.iter().map(|side| side.crossing(line).0)
    }

    /// Whether some lines of a lattice have a part in the layer.
    fn is_in_view(&self, geometry: &dyn ViewGeometry) -> bool {
        const PLACES: usize = 9;
        let place = |k: usize| k as f64 / (PLACES - 1) as f64;
        (0..PLACES * PLACES).any(|k| {
            let line = geometry.line([place(k % PLACES), place(k / PLACES)]);
            line.is_some_and(|line| self.has_part_of(&line, line.ends))
        })
    }
}

/// The depths of a layer in its chart, on one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Depths {
    from: f64,
    length: f64,
    is_at_plane: [bool; 2],
}

impl Depths {
    /// The depth in the chart at the depth `w` of the layer, and its derivative.
    pub(super) fn at(&self, w: f64) -> (f64, f64) {
        let (part, slope) = match self.is_at_plane {
            [false, false] => (w, 1.0),
            [true, false] => (w * w, 2.0 * w),
            [false, true] => (w * (2.0 - w), 2.0 * (1.0 - w)),
            [true, true] => (w * w * (3.0 - 2.0 * w), 6.0 * w * (1.0 - w)),
        };
        (self.from + part * self.length, slope * self.length)
    }

    /// The depth of the layer at the depth `z` of the chart; outside [0, 1] if it is not in the layer.
    pub(super) fn of(&self, z: f64) -> f64 {
        if self.length <= 0.0 {
            return if z < self.from { -1.0 } else { 2.0 };
        }
        let part = (z - self.from) / self.length;
        if !(0.0..=1.0).contains(&part) {
            return part;
        }
        match self.is_at_plane {
            [false, false] => part,
            [true, false] => part.sqrt(),
            [false, true] => 1.0 - (1.0 - part).sqrt(),
            // The root of 3 w² − 2 w³ = part between 0 and 1.
            [true, true] => 0.5 - ((1.0 - 2.0 * part).asin() / 3.0).sin(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::remapped::{Remap, Remapped};
    use super::*;
    use crate::projection::Projection;
    use crate::projection::bounds::Bounds;
    use crate::projection::camera::Orthographic;
    use crate::projection::ellipsoid::Ellipsoid;
    use crate::projection::frame::Viewpoint;

    const WALLS: [([f64; 3], [f64; 3]); 2] =
        [([0.3, 0.1, 0.0], [1.0, 0.4, -0.2]), ([-0.5, 0.0, 0.2], [-0.6, 0.3, 0.7])];

    fn camera(bounds: Option<Bounds>, edges: Vec<Edge>) -> Orthographic {
        let viewpoint =
            Viewpoint { position: [-6.0, 0.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
        let camera = Orthographic::new(viewpoint, [2.0, 2.0], [0.0, 12.0]).unwrap();
        let camera = camera.with_edges(edges);
        match bounds {
            Some(bounds) => camera.with_bounds(bounds),
            None => camera,
        }
    }

    fn walls() -> Vec<Edge> {
        WALLS.map(|(position, normal)| Edge::plane(position, normal).unwrap()).to_vec()
    }

    fn geometry(camera: &Orthographic) -> &dyn ViewGeometry {
        camera.view_geometry().unwrap()
    }

    #[test]
    fn layers_divide_each_line_without_a_gap() {
        let ball = Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], 3.0).unwrap());
        for bounds in [None, Some(ball)] {
            let camera = camera(bounds, walls());
            let layers = layers(geometry(&camera), 0.0);
            assert_eq!(layers.len(), 4);
            for uv in [[0.5, 0.5], [0.1, 0.8], [0.93, 0.2]] {
                let whole = geometry(&camera).chart(0);
                let length = |chart: &dyn Chart| {
                    let steps = 2000;
                    let step = |k: usize| (k as f64 + 0.5) / steps as f64;
                    let at = |k: usize| chart.world_from_chart([uv[0], uv[1], step(k)]);
                    (0..steps).map(|k| at(k).path_per_depth).sum::<f64>() / steps as f64
                };
                let of_layer = |layer: &Layer| {
                    let chart = geometry(&camera).chart(0);
                    length(&Remapped { chart, remap: Remap::Layer(layer.clone()) })
                };
                let sum: f64 = layers.iter().map(of_layer).sum();
                let expected = length(&*whole);
                assert!((sum / expected - 1.0).abs() < 1e-6, "{sum} {expected}");
            }
        }
    }

    #[test]
    fn points_are_on_the_sides_of_their_layer_and_inverted() {
        let camera = camera(None, walls());
        for layer in layers(geometry(&camera), 0.0) {
            let sides = layer.sides.clone();
            let chart = geometry(&camera).chart(0);
            let chart = Remapped { chart, remap: Remap::Layer(layer) };
            for k in 1..200 {
                let at = |step: f64| (f64::from(k) * step).fract();
                let uvw = [at(0.754_877), at(0.569_840), at(0.438_579)];
                let point = chart.world_from_chart(uvw);
                if point.path_per_depth == 0.0 {
                    continue;
                }
                for side in &sides {
                    let height = dot(difference(point.position, side.position), side.normal);
                    assert!(height > -1e-12, "{height:e}");
                }
                let again = chart.chart_from_world(point.position).unwrap();
                assert!((0..3).all(|i| (again[i] - uvw[i]).abs() < 1e-7), "{uvw:?} {again:?}");
            }
        }
    }

    #[test]
    fn planes_that_divide_no_depth_make_no_layers() {
        let count = |position, normal, least_cosine| {
            let camera = camera(None, vec![Edge::plane(position, normal).unwrap()]);
            layers(geometry(&camera), least_cosine).len()
        };
        assert_eq!(count([0.0; 3], [1.0, 1.0, 0.0], 0.0), 2);
        assert_eq!(count([0.0; 3], [0.0, 1.0, 0.0], 0.0), 0, "edge-on");
        assert_eq!(count([40.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0), 0, "out of view");
        assert_eq!(count([0.0; 3], [1.0, 2.0, 0.0], 0.5), 0, "at a grazing angle");
        let more = (0..5).map(|k| Edge::plane([f64::from(k), 0.0, 0.0], [1.0, 0.0, 0.0]).unwrap());
        let camera = camera(None, more.collect());
        assert_eq!(layers(geometry(&camera), 0.0).len(), 8, "three planes at the most");
    }

    #[test]
    fn bodies_have_no_layers() {
        let body = Ellipsoid::sphere([0.0; 3], 0.5).unwrap();
        let camera = camera(None, walls()).with_occulters(vec![body]).unwrap();
        assert!(layers(geometry(&camera), 0.0).is_empty());
    }
}
