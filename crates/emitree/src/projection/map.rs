//! The map from the canonical cube of a camera to the world.

use super::MappedPoint;
use super::layer::{self, Layer, Region};

/// A camera: a piecewise smooth map from the canonical cube to the world.
///
/// The image's radiance is f(x, y) = ∫ g ds = ∫ G dz with G = g · ds/dz, and a pixel's value is its
/// irradiance over its solid angle, F(Ω)/Ω: the mean of f weighted with
/// [`solid_angle_density`](Self::solid_angle_density). For parallel rays the "solid angle" is the
/// area on the image plane.
pub trait Projection: Sync + core::fmt::Debug {
    /// The world point, emission direction and ds/dz at canonical coordinates `u` = (x, y, z).
    fn world_from_canonical(&self, u: [f64; 3]) -> MappedPoint;

    /// Canonical coordinates of the world point at `position`: the inverse of
    /// [`world_from_canonical`](Self::world_from_canonical), outside the cube for a point that the
    /// camera does not see; `None` if the point is on no line of sight or on all of them.
    fn canonical_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]>;

    /// Solid angle \[sr\] per unit of the canonical image plane, dΩ/(dx dy), at (x, y); 0 where there
    /// is no image.
    fn solid_angle_density(&self, xy: [f64; 2]) -> f64;

    /// Solid angle \[sr\] of the rectangle from `min` to `max` of the canonical image plane: the
    /// exact integral of the density.
    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64;

    /// Solid angle \[sr\] of each of the equal parts, as many as there are numbers, of the row from
    /// `y[0]` to `y[1]` of the canonical image plane: what [`solid_angle`](Self::solid_angle) says of
    /// them, for all pixels of a row at once.
    fn solid_angles_of_row(&self, y: [f64; 2], solid_angles: &mut [f64]) {
        let columns = solid_angles.len() as f64;
        for (column, solid_angle) in solid_angles.iter_mut().enumerate() {
            // Borders as quotients, so that neighbours share them to the last bit.
            let x = [column, column + 1].map(|c| c as f64 / columns);
            *solid_angle = self.solid_angle([x[0], y[0]], [x[1], y[1]]);
        }
    }

    /// The points at each of `depths` on the line of sight at (x, y): what
    /// [`world_from_canonical`](Self::world_from_canonical) says of them, for one line at once.
    ///
    /// # Panics
    ///
    /// May panic if there are not as many points as depths.
    fn points_of_line(&self, [x, y]: [f64; 2], depths: &[f64], points: &mut [MappedPoint]) {
        for (point, &z) in points.iter_mut().zip(depths) {
            *point = self.world_from_canonical([x, y, z]);
        }
    }

    /// Which axes of the cube are closed upon themselves (an azimuth over the full circle).
    fn periodic(&self) -> [bool; 3] {
        [false; 3]
    }

    /// What is seen at (x, y): the map is smooth where this does not change.
    fn region(&self, _xy: [f64; 2]) -> Region {
        Region::Sky
    }

    /// Whether [`region`](Self::region) may be anything but [`Region::Sky`].
    fn has_regions(&self) -> bool {
        false
    }

    /// Places on the image plane where a region may be that is smaller than a pixel.
    fn landmarks(&self) -> Vec<[f64; 2]> {
        Vec::new()
    }

    /// The layers that the image is the sum of, each smooth across the edges of regions.
    fn layers(&self) -> Vec<Box<dyn Layer + '_>> {
        vec![Box::new(layer::Whole(self))]
    }

    /// The parts of an image that is several squares, from the lowest rows up, all alike in shape;
    /// none if the image is one piece.
    fn tiles(&self) -> Vec<&dyn Projection> {
        Vec::new()
    }
}
