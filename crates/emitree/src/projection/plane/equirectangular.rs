//! Equal angles about the pointing: FITS code CAR, and what the SMILE SXI scripts use.

use super::{ImagePlane, Sight, field_of_view};
use crate::projection::frame::GeometryError;
use core::f64::consts::{PI, TAU};

/// Columns and rows are uniform in longitude and latitude about the pointing.
///
/// With the pointing as the origin of longitude λ and latitude φ, the line of sight at canonical
/// (x, y) is λ = (x − ½) · width and φ = (y − ½) · height, the plate carrée of Calabretta & Greisen
/// 2002 (doi:10.1051/0004-6361:20021327), section 5.2.3, with λ to the right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquirectangularPlane {
    fov_rad: [f64; 2],
}

impl EquirectangularPlane {
    /// Fields of view `fov_rad` = \[width, height\] \[rad\], at most 2π and π.
    pub(crate) fn new(fov_rad: [f64; 2]) -> Result<Self, GeometryError> {
        let [width, height] = fov_rad;
        if !(width > 0.0 && width <= TAU) {
            Err(field_of_view(width, "a width in (0, 360] degrees"))
        } else if !(height > 0.0 && height <= PI) {
            Err(field_of_view(height, "a height in (0, 180] degrees"))
        } else {
            Ok(Self { fov_rad })
        }
    }

    fn latitude_rad(&self, y: f64) -> f64 {
        (y - 0.5) * self.fov_rad[1]
    }
}

impl ImagePlane for EquirectangularPlane {
    fn sight(&self, [x, y]: [f64; 2]) -> Sight {
        let (sin_lon, cos_lon) = ((x - 0.5) * self.fov_rad[0]).sin_cos();
        let (sin_lat, cos_lat) = self.latitude_rad(y).sin_cos();
        Sight::from_point_observer([cos_lat * sin_lon, sin_lat, cos_lat * cos_lon])
    }

    fn xy_of(&self, [right, up, forward]: [f64; 3]) -> Option<[f64; 2]> {
        let distance = right.hypot(up).hypot(forward);
        let (longitude_rad, latitude_rad) = (right.atan2(forward), (up / distance).asin());
        let xy = [longitude_rad / self.fov_rad[0], latitude_rad / self.fov_rad[1]];
        (distance > 0.0).then(|| xy.map(|from_middle| 0.5 + from_middle))
    }

    fn solid_angle_density(&self, xy: [f64; 2]) -> f64 {
        self.latitude_rad(xy[1]).cos() * self.fov_rad[0] * self.fov_rad[1]
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        // sin b − sin a = 2 cos((a + b)/2) sin((b − a)/2) keeps its digits for small pixels.
        let (low, high) = (self.latitude_rad(min[1]), self.latitude_rad(max[1]));
        let sines = 2.0 * (0.5 * (low + high)).cos() * (0.5 * (high - low)).sin();
        (max[0] - min[0]) * self.fov_rad[0] * sines
    }

    fn is_closed(&self) -> bool {
        #[expect(clippy::float_cmp, reason = "only the exactly full circle closes upon itself")]
        let full_circle = self.fov_rad[0] == TAU;
        full_circle
    }
}
