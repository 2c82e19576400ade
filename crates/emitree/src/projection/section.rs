//! The layers of a camera with opaque bodies.
//!
//! Lines of sight that meet no body are one layer, and those that end at a body are two, since their
//! radiance has a square root at the limb: each body has a *split distance* that is smooth in (x, y),
//! inside the body where the line meets it, and at the limb where the line touches it. The *front*
//! reaches to the split distance, through the surface; inside a body g is replaced by its value at the
//! surface before it, as seen from the far end of the body, so that it is never evaluated inside. The
//! piece from the surface to the split distance, *hidden* in the body, is subtracted: its length, known
//! from geometry, is its coverage fraction. So no layer has a jump or a square root at a limb, however g
//! is continued.

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
    /// From its beginning to the split distance of the body of this number, for lines that end there.
    Front(usize),
    /// From the surface of the body of this number to its split distance, to be subtracted.
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

    /// The split distance of a body, within the line.
    fn split_distance(&self, line: &Line, number: usize) -> f64 {
        let [from, to] = line.ends;
        self.camera.split_distance(line, &self.camera.bodies()[number]).max(from).min(to)
    }

    /// From where to where the layer reaches along a line.
    fn ends(&self, line: &Line) -> [f64; 2] {
        match self.piece {
            Piece::Sky => line.ends,
            Piece::Front(number) => [line.ends[0], self.split_distance(line, number)],
            Piece::Hidden(number) => {
                let to = self.split_distance(line, number);
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
        // The same for all layers: where bodies overlap, the subtracted part equals the added one.
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
