//! Equal angles about the pointing: FITS code CAR, and what the SMILE SXI scripts use.

use super::frame::{Frame, GeometryError, Viewpoint};
use super::{MappedPoint, Projection};
use core::f64::consts::{FRAC_PI_2, TAU};

/// A camera whose columns and rows are equal steps of longitude and latitude about the pointing.
///
/// With the pointing as the origin of longitude λ and latitude φ, the line of sight at canonical
/// (x, y) is λ = (x − ½) · width and φ = (y − ½) · height, the plate carrée of Calabretta & Greisen
/// 2002 (doi:10.1051/0004-6361:20021327), section 5.2.3, with λ to the right. Depth is linear
/// between `near` and `far`.
///
/// ```
/// use emitree::{Equirectangular, Projection, Viewpoint};
///
/// let viewpoint =
///     Viewpoint { position: [0.0; 3], target: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0] };
/// let camera = Equirectangular::new(viewpoint, [0.2, 0.1], [0.0, 10.0])?;
/// let centre = camera.world_from_canonical([0.5, 0.5, 0.5]);
/// assert_eq!(centre.position, [5.0, 0.0, 0.0]);
/// assert_eq!(centre.path_per_depth, 10.0);
/// # Ok::<(), emitree::GeometryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equirectangular {
    frame: Frame,
    fov_rad: [f64; 2],
    depth: [f64; 2],
}

impl Equirectangular {
    /// A camera at `viewpoint` with fields of view `fov_rad` = \[width, height\] \[rad\] and depths
    /// \[near, far\] along each line of sight, in the length unit of the scene.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the viewpoint has no rotation, the width is not in (0, 2π], the height
    /// is not in (0, π], or not 0 ≤ near < far < ∞.
    pub fn new(
        viewpoint: Viewpoint,
        fov_rad: [f64; 2],
        depth: [f64; 2],
    ) -> Result<Self, GeometryError> {
        let out_of_range =
            |name, value, expected| Err(GeometryError::OutOfRange { name, value, expected });
        let [width, height] = fov_rad;
        if !(width > 0.0 && width <= TAU) {
            return out_of_range(
                "field_of_view",
                width.to_degrees(),
                "a width in (0, 360] degrees",
            );
        }
        if !(height > 0.0 && height <= 2.0 * FRAC_PI_2) {
            let height = height.to_degrees();
            return out_of_range("field_of_view", height, "a height in (0, 180] degrees");
        }
        let [near, far] = depth;
        if !(near >= 0.0 && near.is_finite()) {
            return out_of_range("near", near, "a finite depth of 0 or more");
        }
        if !(far > near && far.is_finite()) {
            return out_of_range("far", far, "a finite depth beyond `near`");
        }
        Ok(Self { frame: Frame::new(&viewpoint)?, fov_rad, depth })
    }

    fn latitude_rad(&self, y: f64) -> f64 {
        (y - 0.5) * self.fov_rad[1]
    }
}

impl Projection for Equirectangular {
    fn world_from_canonical(&self, [x, y, z]: [f64; 3]) -> MappedPoint {
        let (sin_lon, cos_lon) = ((x - 0.5) * self.fov_rad[0]).sin_cos();
        let (sin_lat, cos_lat) = self.latitude_rad(y).sin_cos();
        let sight = self.frame.world_from_camera([cos_lat * sin_lon, sin_lat, cos_lat * cos_lon]);
        let [near, far] = self.depth;
        let distance = near + z * (far - near);
        MappedPoint {
            position: core::array::from_fn(|i| self.frame.origin[i] + distance * sight[i]),
            direction: sight.map(|component| -component),
            path_per_depth: far - near,
        }
    }

    fn canonical_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let [right, up, forward] = self.frame.camera_from_world(position);
        let distance = right.hypot(up).hypot(forward);
        if distance == 0.0 {
            return None;
        }
        let (longitude_rad, latitude_rad) = (right.atan2(forward), (up / distance).asin());
        let [near, far] = self.depth;
        Some([
            0.5 + longitude_rad / self.fov_rad[0],
            0.5 + latitude_rad / self.fov_rad[1],
            (distance - near) / (far - near),
        ])
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

    fn periodic(&self) -> [bool; 3] {
        #[expect(clippy::float_cmp, reason = "only the exactly full circle closes upon itself")]
        let full_circle = self.fov_rad[0] == TAU;
        [full_circle, false, false]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_finds_each_point_again() {
        let viewpoint = Viewpoint {
            position: [10.0, -30.0, 3.0],
            target: [6.0, 0.0, 0.0],
            up: [0.0, 0.1, 1.0],
        };
        let camera = Equirectangular::new(viewpoint, [6.0, 3.0], [1.0, 80.0]).unwrap();
        for u in [[0.5, 0.5, 0.5], [0.01, 0.02, 0.0], [0.99, 0.7, 0.9], [0.3, 0.98, 1.2]] {
            let position = camera.world_from_canonical(u).position;
            let found = camera.canonical_from_world(position).unwrap();
            for axis in 0..3 {
                assert!((found[axis] - u[axis]).abs() < 1e-12, "{found:?} for {u:?}");
            }
        }
        assert_eq!(camera.canonical_from_world(viewpoint.position), None);
    }
}
