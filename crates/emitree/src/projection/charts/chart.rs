//! Charts: coordinates of a part of a view in which its radiance is smooth.

use crate::projection::charts::depth::{Depth, Weights};
use crate::projection::charts::piece::{Piece, Side};
use crate::projection::charts::shells::Shells;
use crate::projection::surroundings::{POINTS_OF_GAP, SightLine, Surroundings};
use crate::projection::vector::{difference, dot};
use crate::projection::{MappedPoint, Projection, ViewGeometry};
use core::f64::consts::TAU;

/// A map from the unit cube to a part of the world, along whose third axis the emission of one
/// piece of the lines of sight is integrated. The first two axes are the image plane, or angles at
/// a body.
pub trait Chart: Send + Sync + core::fmt::Debug {
    /// The world point, emission direction and ds/dz at the coordinates `u`; near a singularity ds/dz times a
    /// density, by which the weights of pixels are divided.
    fn world_from_chart(&self, u: [f64; 3]) -> MappedPoint;

    /// The coordinates of a world point: the inverse of
    /// [`world_from_chart`](Self::world_from_chart), outside the cube for a point that is not on
    /// the piece of a line in view; `None` if the point is on no line of sight or on all of them.
    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]>;

    /// The weight of the radiance at (u, v): dΩ/(dx dy) \[sr\] on the image plane, continued
    /// smoothly where there is no image, and 1 in angles at a body.
    fn density(&self, uv: [f64; 2]) -> f64;

    /// The line of sight at (u, v); `None` without lines of sight that planes may divide.
    fn line(&self, _uv: [f64; 2]) -> Option<SightLine> {
        None
    }

    /// The depth at a distance along a [line](Self::line), 0 or 1 beyond the ends.
    fn depth_of(&self, line: &SightLine, distance: f64) -> f64 {
        let place = self.chart_from_world(line.at(distance));
        place.map_or(0.0, |[_, _, z]| z.clamp(0.0, 1.0))
    }

    /// How much each coordinate of depth changes with z, if there are several.
    fn depth_shares(&self, _u: [f64; 3]) -> Option<Weights> {
        None
    }

    /// The number of the opaque body at which the line of sight at (u, v) ends, and the depth there;
    /// `None` if it meets none, or if the chart ends there itself.
    fn visible_end(&self, _uv: [f64; 2]) -> Option<(usize, f64)> {
        None
    }

    /// The depths between which the line of sight at (u, v) is inside the bounds, if the chart continues beyond
    /// them; the first one is above the second one on a line that is outside of them.
    fn ends_inside_bounds(&self, _uv: [f64; 2]) -> [f64; 2] {
        [0.0, 1.0]
    }

    /// The depths between which the line of sight at (u, v) is seen; none if the first one is above the second one.
    fn visible_ends(&self, uv: [f64; 2]) -> [f64; 2] {
        let [from, to] = self.ends_inside_bounds(uv);
        [from, self.visible_end(uv).map_or(to, |(_, end)| end.min(to))]
    }

    /// Whether some points of the chart are inside an opaque body, where g has no value.
    fn has_gaps(&self) -> bool {
        false
    }

    /// For a point inside an opaque body, points around the body on the same line of sight and their
    /// weights in a sum that continues G smoothly through the body; `None` for all other points.
    fn across_gap(&self, _u: [f64; 3]) -> Option<AcrossGap> {
        None
    }

    /// The number of the tile of the image, and the place on it, at which the line at (u, v) is
    /// seen; a place near it for a line that is not in view.
    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]);
}

/// Points on both sides of a body, at any of which ds/dz is 1, and the weights of their rates.
#[derive(Clone, Copy, Debug)]
pub struct AcrossGap {
    pub(crate) around: [MappedPoint; POINTS_OF_GAP],
    pub(crate) weights: [f64; POINTS_OF_GAP],
}

impl AcrossGap {
    /// The value of the sum, from g at the points.
    pub(crate) fn value(&self, rates: &[f64]) -> f64 {
        self.weights.iter().zip(rates).map(|(weight, rate)| weight * rate).sum()
    }
}

/// A whole projection as its only chart.
#[derive(Debug)]
pub(crate) struct Whole<'a, P: ?Sized> {
    pub(crate) projection: &'a P,
    pub(crate) tile: usize,
}

impl<P: Projection + ?Sized> Chart for Whole<'_, P> {
    fn world_from_chart(&self, u: [f64; 3]) -> MappedPoint {
        self.projection.world_from_canonical(u)
    }

    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        self.projection.canonical_from_world(position)
    }

    fn density(&self, uv: [f64; 2]) -> f64 {
        self.projection.solid_angle_density(uv)
    }

    fn line(&self, uv: [f64; 2]) -> Option<SightLine> {
        self.projection.view_geometry()?.line(uv)
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        (self.tile, uv)
    }
}

/// The part of the coordinates (c, φ) of a piece that is in view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    /// The ends of c.
    pub(crate) c: [f64; 2],
    /// The beginning and the width of φ.
    pub(crate) azimuth_rad: [f64; 2],
}

impl Window {
    /// Whether the azimuth is the full circle.
    pub(crate) fn is_closed(&self) -> bool {
        self.azimuth_rad[1] >= TAU
    }

    /// (u, v) of (c, φ), in \[0, 1\]² inside the window.
    pub(crate) fn unit(&self, [c, azimuth]: [f64; 2]) -> [f64; 2] {
        let u = (c - self.c[0]) / (self.c[1] - self.c[0]);
        let [begin, width] = self.azimuth_rad;
        let beyond = (azimuth - begin).rem_euclid(TAU);
        // An azimuth below the beginning by no more than one above the end is not a turn away.
        let is_below = beyond > width && TAU - beyond < beyond - width;
        [u, (if is_below { beyond - TAU } else { beyond }) / width]
    }

    pub(super) fn natural(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let c = self.c[0] + u * (self.c[1] - self.c[0]);
        // Both ends of the full circle are the same lines, bit for bit.
        let v = if self.is_closed() && v >= 1.0 { 0.0 } else { v };
        [if u >= 1.0 { self.c[1] } else { c }, self.azimuth_rad[0] + v * self.azimuth_rad[1]]
    }
}

/// The chart of one side of a piece of the lines around a body.
#[derive(Debug)]
pub(crate) struct PieceChart<'a> {
    pub(super) surroundings: &'a Surroundings,
    pub(super) shells: &'a Shells,
    pub(super) piece: Piece,
    pub(super) side: Side,
    pub(super) weights: Weights,
    pub(super) window: Window,
    /// The image planes of all tiles.
    pub(super) tiles: Vec<&'a dyn ViewGeometry>,
}

impl PieceChart<'_> {
    fn line_at(&self, uv: [f64; 2]) -> SightLine {
        let [c, azimuth] = self.window.natural(uv);
        self.shells.line(self.surroundings, self.shells.angle(self.piece, c), azimuth)
    }

    /// The factor of the path, which is below 1 where a pixel is larger than the distance from a singularity: the
    /// errors of all lines of sight then have the same effect on pixels.
    fn density_at_singularity(&self, u: f64) -> f64 {
        self.shells.density(self.piece, self.window.natural([u, 0.0])[0])
    }

    fn range(&self, line: &SightLine) -> [f64; 2] {
        self.shells.range(self.piece, self.side, line, &self.shells.aim(line))
    }

    fn depth(&self, line: &SightLine) -> Depth {
        self.shells.depth(self.surroundings, (self.piece, self.side), self.weights, line)
    }
}

impl Chart for PieceChart<'_> {
    fn world_from_chart(&self, [u, v, z]: [f64; 3]) -> MappedPoint {
        let line = self.line_at([u, v]);
        let of = (self.piece, self.side);
        let mut point = self.shells.point(self.surroundings, of, self.weights, &line, z);
        point.path_per_depth *= self.density_at_singularity(u);
        point
    }

    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let line = self.surroundings.line_to(position)?;
        let aim = self.shells.aim(&line);
        let ends_at_body = self.shells.ends(self.surroundings, &line);
        if !self.shells.has(self.shells.zone(&aim), self.piece, ends_at_body) {
            return None;
        }
        let [u, v] = self.window.unit([self.shells.coordinate(self.piece, &aim), aim.azimuth()]);
        let distance = dot(difference(position, line.origin), line.direction);
        Some([u, v, self.depth(&line).z_of(distance)])
    }

    fn density(&self, _uv: [f64; 2]) -> f64 {
        1.0
    }

    fn line(&self, uv: [f64; 2]) -> Option<SightLine> {
        Some(self.line_at(uv))
    }

    fn depth_of(&self, line: &SightLine, distance: f64) -> f64 {
        let [from, to] = self.range(line);
        if distance <= from {
            0.0
        } else if distance >= to {
            1.0
        } else {
            self.depth(line).z_of(distance)
        }
    }

    fn depth_shares(&self, [u, v, z]: [f64; 3]) -> Option<Weights> {
        self.depth(&self.line_at([u, v])).shares(z)
    }

    fn has_gaps(&self) -> bool {
        self.surroundings.bodies.len() > usize::from(self.shells.body.is_some())
    }

    fn across_gap(&self, [u, v, z]: [f64; 3]) -> Option<AcrossGap> {
        let line = self.line_at([u, v]);
        let range = self.range(&line);
        // The point that `outside` has not moved.
        let (distance, path) = self.depth(&line).at(z)?;
        let path = path * self.density_at_singularity(u);
        let gap = self.surroundings.gap(&line, range, distance, self.shells.body)?;
        let around = gap.distances.map(|distance| {
            let mut beside = line.sample(distance, 1.0);
            beside.position = self.surroundings.outside(beside.position);
            beside
        });
        Some(AcrossGap { around, weights: gap.weights.map(|weight| weight * path) })
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        image_place(&self.tiles, &self.line_at(uv))
    }
}

/// The number of the tile, and the place on it, at which a line is seen; a place near it for a line that
/// is not in view.
pub(crate) fn image_place(tiles: &[&dyn ViewGeometry], line: &SightLine) -> (usize, [f64; 2]) {
    let place = |tile: &&dyn ViewGeometry| tile.place_of_line(line);
    let is_inside = |xy: &[f64; 2]| xy.iter().all(|along| (0.0..=1.0).contains(along));
    let mut places = tiles.iter().map(place).enumerate();
    let first = tiles.first().and_then(place);
    let found = places.find_map(|(tile, xy)| Some((tile, xy.filter(is_inside)?)));
    found.unwrap_or((0, first.unwrap_or([0.5; 2]).map(|along| along.clamp(0.0, 1.0))))
}
