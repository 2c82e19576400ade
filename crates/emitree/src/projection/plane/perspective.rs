//! The tangent plane: a pinhole camera. FITS: TAN.

use super::solid_angle::{integral, integral_of_small};
use super::{ImagePlane, Sight, field_of_view};
use crate::projection::frame::GeometryError;

/// Lines of sight from a point observer through a flat screen at right angles to the pointing.
///
/// On the plane at distance 1 the image is 2 tan(w/2) wide, the gnomonic projection of Calabretta & Greisen
/// 2002 (doi:10.1051/0004-6361:20021327), section 5.1.3. The pointing is at the principal point, usually in the
/// middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentPlane {
    /// tan of half the field of view, along right and up.
    half: [f64; 2],
    /// The canonical (x, y) of the pointing.
    principal_point: [f64; 2],
}

/// The widest field of view \[deg\]. Half of the sky that it shows is on a share 1 / (2 tan(w/2)) of the
/// screen's width: 1/115 here, 1/1146 at 179.9 degrees. Measured on an even glow, a Gaussian around the
/// observer, one beside and a ball around, at 10 to 0.1 % on 24 × 24 pixels: up to 178 degrees every image
/// met its tolerance; from 179 degrees on some did not, whatever was spent, and at 179.9 pixels were a
/// third too low.
const WIDEST_DEG: f64 = 178.0;
const EXPECTED: &str = "a width and a height above 0 and at most 178 degrees, since a flat screen is \
                        too wide beyond (for more of the sky: `fisheye` or `equirectangular`)";
const EXPECTED_POINT: &str = "the place of the pointing as fractions of the width and the height of the \
                              image, (0.5, 0.5) in the middle, with all of the image within 89 degrees of it \
                              along each axis";
/// A pixel at least this large on the plane has its solid angle from the closed form, whose digits
/// cancel on smaller ones.
const LARGE_PIXEL: f64 = 1e-4;
/// A pixel whose sides are below this on the plane needs two nodes along each: their error is its
/// fourth power, over a hundred.
const SMALL_PIXEL: f64 = 5e-4;

impl TangentPlane {
    /// A screen of fields of view `fov_rad` = \[width, height\] \[rad\], each above 0 and at most
    /// 178 degrees.
    pub(crate) fn new(fov_rad: [f64; 2]) -> Result<Self, GeometryError> {
        let widest = WIDEST_DEG.to_radians();
        match fov_rad.iter().find(|&&angle| !(angle > 0.0 && angle <= widest)) {
            None => {
                let half = fov_rad.map(|angle| (0.5 * angle).tan());
                Ok(Self { half, principal_point: [0.5; 2] })
            }
            Some(&angle) => Err(field_of_view(angle, EXPECTED)),
        }
    }

    /// The same screen with the pointing at the canonical (x, y), which may be beside the image.
    pub(crate) fn with_principal_point(
        self,
        principal_point: [f64; 2],
    ) -> Result<Self, GeometryError> {
        let screen = Self { principal_point, ..self };
        let widest = (0.5 * WIDEST_DEG).to_radians().tan() * (1.0 + 1e-12);
        for corner in [[0.0; 2], [1.0; 2]] {
            for (along, value) in screen.on_plane(corner).into_iter().zip(principal_point) {
                if along.is_nan() || along.abs() > widest {
                    let (name, expected) = ("principal_point", EXPECTED_POINT);
                    return Err(GeometryError::OutOfRange { name, value, expected });
                }
            }
        }
        Ok(screen)
    }

    fn on_plane(&self, xy: [f64; 2]) -> [f64; 2] {
        core::array::from_fn(|i| self.half[i] * (2.0 * (xy[i] - self.principal_point[i])))
    }
}

impl ImagePlane for TangentPlane {
    fn sight(&self, xy: [f64; 2]) -> Sight {
        let [right, up] = self.on_plane(xy);
        let length = right.hypot(up).hypot(1.0);
        Sight::from_point_observer([right / length, up / length, 1.0 / length])
    }

    fn xy_of(&self, [right, up, forward]: [f64; 3]) -> Option<[f64; 2]> {
        let plane = [right / forward, up / forward];
        (forward > 0.0).then(|| {
            core::array::from_fn(|i| self.principal_point[i] + 0.5 * plane[i] / self.half[i])
        })
    }

    fn solid_angle_density(&self, xy: [f64; 2]) -> f64 {
        let [right, up] = self.on_plane(xy);
        // The power −3/2, of which a general power takes most of the time of images of many pixels.
        let square = 1.0 + right * right + up * up;
        4.0 * self.half[0] * self.half[1] / (square * square.sqrt())
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        let ([x0, y0], [x1, y1]) = (self.on_plane(min), self.on_plane(max));
        if (x1 - x0).max(y1 - y0) < SMALL_PIXEL {
            let row = |y| integral_of_small(min[0], max[0], |x| self.solid_angle_density([x, y]));
            return integral_of_small(min[1], max[1], row);
        }
        if (x1 - x0) * (y1 - y0) < LARGE_PIXEL {
            let row = |y| integral(min[0], max[0], |x| self.solid_angle_density([x, y]));
            return integral(min[1], max[1], row);
        }
        let corner = |x: f64, y: f64| (x * y / (1.0 + x * x + y * y).sqrt()).atan();
        corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
    }
}
