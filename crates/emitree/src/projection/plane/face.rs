//! One face of the `HEALPix` sphere.

use super::{ImagePlane, Sight};
use crate::projection::healpix::{FACES, face_of_direction, sight_of_face};
use core::f64::consts::PI;

/// A twelfth of the sky, in the coordinates of [`sight_of_face`]: all its pixels have one solid angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FacePlane {
    face: u8,
}

impl FacePlane {
    /// The faces in their order.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        (0..FACES).map(|face| Self { face })
    }
}

impl ImagePlane for FacePlane {
    fn sight(&self, xy: [f64; 2]) -> Sight {
        Sight::from_point_observer(sight_of_face(self.face, xy))
    }

    /// None for points on other faces.
    fn xy_of(&self, point: [f64; 3]) -> Option<[f64; 2]> {
        let (face, xy) = face_of_direction(point);
        let is_somewhere = point.iter().any(|along| *along != 0.0);
        (face == self.face && is_somewhere).then_some(xy)
    }

    fn solid_angle_density(&self, _xy: [f64; 2]) -> f64 {
        PI / 3.0
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        PI / 3.0 * (max[0] - min[0]) * (max[1] - min[1])
    }
}
