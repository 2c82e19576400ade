//! The map from the canonical cube of a camera to the world: what a user's own projection implements.

use super::{MappedPoint, ViewGeometry};

/// A camera: a piecewise smooth map from the canonical cube to the world.
///
/// The image's radiance is f(x, y) = ∫ g ds = ∫ G dz with G = g · ds/dz, and a pixel's value is its
/// irradiance over its solid angle, F(Ω)/Ω: the mean of f weighted with
/// [`solid_angle_density`](Self::solid_angle_density). For parallel rays the "solid angle" is the
/// area on the image plane.
///
/// A projection of your own implements four methods. If only the direction of each line of sight is
/// new, an [`ImagePlane`](super::ImagePlane) is less work: [`Camera`](super::Camera) adds depths,
/// bounds and opaque bodies.
///
/// ```
/// use emitree::projection::MappedPoint;
/// use emitree::{FromFn, Projection, RenderOptions, VolOptions, render};
///
/// /// Parallel lines of sight along +z through a rectangle of 1 × 2.
/// #[derive(Debug)]
/// struct Rectangle;
///
/// impl Projection for Rectangle {
///     fn world_from_canonical(&self, [x, y, z]: [f64; 3]) -> MappedPoint {
///         MappedPoint {
///             position: [x, 2.0 * y, z],
///             direction: [0.0, 0.0, -1.0],
///             path_per_depth: 1.0,
///         }
///     }
///
///     fn canonical_from_world(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 3]> {
///         Some([x, 0.5 * y, z])
///     }
///
///     fn solid_angle_density(&self, _xy: [f64; 2]) -> f64 {
///         2.0
///     }
///
///     fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
///         2.0 * (max[0] - min[0]) * (max[1] - min[1])
///     }
/// }
///
/// let ramp = FromFn(|[_, y, _]: [f64; 3], _direction: [f64; 3]| y);
/// let options = RenderOptions::new(VolOptions::new(0.001));
/// let rendering = render(&ramp, &Rectangle, [2, 4], &options)?;
/// assert!((rendering.values[(0, 0)] - 0.5).abs() < 0.002); // the mean of y from 0 to 1
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Projection: Sync + core::fmt::Debug {
    /// The world point, emission direction and ds/dz at canonical coordinates `u` = (x, y, z).
    fn world_from_canonical(&self, u: [f64; 3]) -> MappedPoint;

    /// Canonical coordinates of the world point at `position`: the inverse of
    /// [`world_from_canonical`](Self::world_from_canonical), outside the cube for a point that the
    /// camera does not view; `None` if the point is on no line of sight or on all of them.
    fn canonical_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]>;

    /// Solid angle \[sr\] per unit of the canonical image plane, dΩ/(dx dy), at (x, y); 0 where there
    /// is no image.
    fn solid_angle_density(&self, xy: [f64; 2]) -> f64;

    /// Solid angle \[sr\] of the rectangle from `min` to `max` of the canonical image plane: the
    /// exact integral of the density.
    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64;

    /// Which axes of the cube are closed upon themselves (an azimuth over the full circle); none by
    /// default.
    fn periodic(&self) -> [bool; 3] {
        [false; 3]
    }

    /// Edges, layers and tiles of the view, if it has any; `None` by default, for an image that is
    /// smooth and in one piece. A projection that is another one with other numbers, such as a wrapper
    /// that counts, returns that of the other.
    fn view_geometry(&self) -> Option<&dyn ViewGeometry> {
        None
    }
}
