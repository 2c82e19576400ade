//! The layers of a camera with opaque bodies.
//!
//! Lines of sight that meet no body are one layer, and those that end at a body are two, since what
//! they see has the square root of the limb in it: each body has a *parting*, a distance that is
//! smooth in (x, y), lies inside the body where the line meets it, and at the limb where it touches
//! it. The *front* reaches to the parting, through the surface; inside a body g is taken for what it is
//! at the surface before it, seen from the far end of the body, so that it is never asked where there is
//! nothing. The piece from the
//! surface to the parting, *hidden* in the body, is taken off again: its length, known from geometry,
//! is its share. So no layer jumps at a limb or has its square root, whatever g is continued to.

use super::MappedPoint;
use super::ViewGeometry;
use super::camera::{Camera, Line};
use super::layer::{Layer, Region};
use super::plane::ImagePlane;

/// Which part of the depth a layer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Piece {
    /// All of it, for lines that meet no body.
    Sky,
    /// From its beginning to the parting of the body of this number, for lines that end there.
    Front(usize),
    /// From the surface of the body of this number to its parting, to be taken off again.
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

    /// The distance of a body's parting, within the line.
    fn parting(&self, line: &Line, number: usize) -> f64 {
        let [from, to] = line.ends;
        self.camera.parting(line, &self.camera.bodies()[number]).max(from).min(to)
    }

    /// From where to where the layer reaches along a line.
    fn ends(&self, line: &Line) -> [f64; 2] {
        match self.piece {
            Piece::Sky => line.ends,
            Piece::Front(number) => [line.ends[0], self.parting(line, number)],
            Piece::Hidden(number) => {
                let to = self.parting(line, number);
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
        let bodies = self.camera.bodies();
        if let Piece::Hidden(number) = self.piece {
            point.path_per_depth = self.hidden_length(number);
            if !bodies.iter().any(|body| body.contains(point.position)) {
                point.position =
                    self.camera.on_near_surface(&bodies[number], &line, point.position);
            }
        }
        // The same for all layers: where bodies overlap, what is taken off is what was there.
        for body in bodies {
            if body.contains(point.position) {
                point.position = self.camera.on_near_surface(body, &line, point.position);
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
            (Piece::Sky, Region::Sky) => 1.0,
            (Piece::Front(number), Region::Body(body)) if number == body => 1.0,
            (Piece::Hidden(number), Region::Body(body)) if number == body => {
                let [from, to] = self.ends(&self.camera.line(xy));
                (from - to) / self.hidden_length(number)
            }
            _ => 0.0,
        }
    }

    fn is_open(&self, xy: [f64; 2]) -> bool {
        let seen = self.camera.region(xy);
        match self.piece {
            // The sky goes on beyond the rim of a disc.
            Piece::Sky => !matches!(seen, Region::Body(_)),
            Piece::Front(number) | Piece::Hidden(number) => seen == Region::Body(number),
        }
    }
}
