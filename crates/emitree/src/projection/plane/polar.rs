//! The paper's polar view: azimuth along the columns, the angle from the pointing along the rows.
//! FITS: linear axes.

use super::{ImagePlane, Sight, field_of_view};
use crate::projection::frame::GeometryError;
use core::f64::consts::TAU;

/// A cone about the pointing, unrolled: x is the azimuth over the full circle, from the image's
/// right by way of up, and y the angle from the pointing, 0 to half of the cone's angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarPlane {
    /// The largest angle from the pointing.
    reach_rad: f64,
}

impl PolarPlane {
    /// A cone of the full angle `fov_rad` \[rad\], above 0 and at most 2π, which is the whole sky.
    pub(crate) fn new(fov_rad: f64) -> Result<Self, GeometryError> {
        if fov_rad > 0.0 && fov_rad <= TAU {
            Ok(Self { reach_rad: 0.5 * fov_rad })
        } else {
            Err(field_of_view(fov_rad, "a full angle of the cone in (0, 360] degrees"))
        }
    }
}

impl ImagePlane for PolarPlane {
    fn sight(&self, [x, y]: [f64; 2]) -> Sight {
        let (sin_azimuth, cos_azimuth) = (TAU * x).sin_cos();
        let (sin_angle, cos_angle) = (self.reach_rad * y).sin_cos();
        Sight::from_point_observer([sin_angle * cos_azimuth, sin_angle * sin_azimuth, cos_angle])
    }

    fn xy_of(&self, [right, up, forward]: [f64; 3]) -> Option<[f64; 2]> {
        let across = right.hypot(up);
        let azimuth = up.atan2(right) / TAU;
        let xy = [azimuth.rem_euclid(1.0), across.atan2(forward) / self.reach_rad];
        (across > 0.0 || forward != 0.0).then_some(xy)
    }

    fn solid_angle_density(&self, [_, y]: [f64; 2]) -> f64 {
        TAU * self.reach_rad * (self.reach_rad * y).sin()
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        // cos a − cos b = 2 sin((a + b)/2) sin((b − a)/2) keeps its digits for small pixels.
        let [low, high] = [min[1], max[1]].map(|y| 0.5 * self.reach_rad * y);
        TAU * (max[0] - min[0]) * 2.0 * (low + high).sin() * (high - low).sin()
    }

    fn is_closed(&self) -> bool {
        true
    }
}
