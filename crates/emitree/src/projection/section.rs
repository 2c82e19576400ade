//! The layers of a camera: parts of its depth between opaque bodies.
//!
//! Each body has a *parting*, a distance that is smooth in (x, y), lies inside the body where the
//! line of sight meets it, and at the limb where it touches it. Between partings the layers go on
//! through bodies as if they were not there; inside a body g is taken for what it is at the surface
//! above, so that it is never asked where there is nothing. A line that ends at a body sees the
//! layers before its parting, less the piece from its surface to the parting: that is the layer
//! *hidden* in the body, whose length, known from geometry, is its share. So no layer jumps at a limb
//! or has its square root, and the edges cost no evaluations.

use super::MappedPoint;
use super::camera::{Camera, Line};
use super::layer::{Layer, Region};
use super::plane::ImagePlane;

/// Which part of the depth a layer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Piece {
    /// From the parting of the body before this number to that of the body of this number; the first
    /// begins where the line does, the last ends there.
    Between(usize),
    /// From the surface of the body of this number to its parting.
    Hidden(usize),
}

/// One layer of a camera.
#[derive(Debug)]
pub(super) struct Section<'a, P> {
    camera: &'a Camera<P>,
    piece: Piece,
}

impl<'a, P: ImagePlane> Section<'a, P> {
    pub(super) fn new(camera: &'a Camera<P>, piece: Piece) -> Self {
        Self { camera, piece }
    }

    /// The distance at which the layers on both sides of the first `number` bodies meet.
    fn parting(&self, line: &Line, number: usize) -> f64 {
        let [from, to] = line.ends;
        let bodies = self.camera.bodies();
        if number > bodies.len() {
            return to;
        }
        let farther = |at: f64, body| at.max(self.camera.parting(line, body));
        bodies[..number].iter().fold(from, farther).min(to)
    }

    /// From where to where the layer reaches along a line.
    fn ends(&self, line: &Line) -> [f64; 2] {
        match self.piece {
            Piece::Between(number) => [self.parting(line, number), self.parting(line, number + 1)],
            Piece::Hidden(number) => {
                let to = self.parting(line, number + 1);
                let body = &self.camera.bodies()[number];
                let surface = body.crossing(line.origin, line.direction);
                [surface.map_or(to, |[enter, _]| enter.max(line.ends[0]).min(to)), to]
            }
        }
    }

    /// The unit of length of a hidden layer, which has its mean rate times this for a radiance.
    fn hidden_length(&self, number: usize) -> f64 {
        self.camera.bodies()[number].longest()
    }
}

impl<P: ImagePlane> Layer for Section<'_, P> {
    fn world_from_canonical(&self, [x, y, z]: [f64; 3]) -> MappedPoint {
        let line = self.camera.line([x, y]);
        let [from, to] = self.ends(&line);
        let mut point = line.point(&self.camera.span(from, to), z);
        match self.piece {
            Piece::Between(_) => {
                for body in self.camera.bodies() {
                    point.position = body.outside(point.position);
                }
            }
            Piece::Hidden(number) => {
                point.position = self.camera.bodies()[number].on_surface(point.position);
                point.path_per_depth = self.hidden_length(number);
            }
        }
        point
    }

    fn canonical_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let ([x, y], line, distance) = self.camera.line_to(position)?;
        let [from, to] = self.ends(&line);
        Some([x, y, self.camera.span(from, to).z_of(distance)])
    }

    fn solid_angle_density(&self, xy: [f64; 2]) -> f64 {
        self.camera.plane().solid_angle_density(xy)
    }

    fn share(&self, xy: [f64; 2], region: Region) -> f64 {
        match (self.piece, region) {
            (_, Region::Outside) | (Piece::Hidden(_), Region::Sky) => 0.0,
            (Piece::Between(_), Region::Sky) => 1.0,
            (Piece::Between(number), Region::Body(body)) => f64::from(u8::from(number <= body)),
            (Piece::Hidden(number), Region::Body(body)) if number == body => {
                let [from, to] = self.ends(&self.camera.line(xy));
                (from - to) / self.hidden_length(number)
            }
            (Piece::Hidden(_), Region::Body(_)) => 0.0,
        }
    }
}
