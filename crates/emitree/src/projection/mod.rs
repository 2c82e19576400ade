//! Projections: the map between the world and the canonical cube of a camera.
//!
//! The canonical cube is [0, 1]³: x and y on the image plane (see [the orientation](crate::Image)),
//! z along the line of sight, 0 at the observer's side. Only projections contain
//! the geometry: the trees and the renderers work on functions on the unit cube.
//!
//! A [`Camera`] is an [image plane](ImagePlane) (which line of sight belongs to which pixel) at a
//! [`Viewpoint`](crate::Viewpoint), with a range of depths, [`Bounds`], [`Edge`]s and
//! [singularities](Singularity) of the emission, and opaque bodies.

#[cfg(feature = "healpix")]
pub(crate) mod all_sky;
mod bounds;
pub(crate) mod camera;
pub(crate) mod canonical;
pub(crate) mod disc_chart;
mod edge;
mod ellipsoid;
pub(crate) mod frame;
#[cfg(feature = "healpix")]
pub mod healpix;
pub(crate) mod charts;
mod region;
mod singularity;
mod surroundings;
pub(crate) mod map;
mod observer;
pub(crate) mod path;
mod plane;
pub(crate) mod rows;
mod span;
pub(crate) mod vector;
mod view_geometry;

pub use bounds::{Bounds, Cuboid};
pub use camera::Camera;
pub(crate) use canonical::Canonical;
pub use charts::chart::Chart;
pub use edge::Edge;
pub use ellipsoid::Ellipsoid;
pub use frame::GeometryError;
pub(crate) use map::Projection;
#[cfg(feature = "healpix")]
pub use plane::FacePlane;
pub use plane::{
    DiscMapping, DiscPlane, EquirectangularPlane, ImagePlane, ParallelPlane, PolarPlane, Sight,
    TangentPlane,
};
pub use region::Region;
pub use singularity::Singularity;
pub use surroundings::{SightLine, Surroundings};
pub use view_geometry::ViewGeometry;

/// The world point of a point of the canonical cube.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MappedPoint {
    /// World position, in the length unit of the scene.
    pub position: [f64; 3],
    /// Unit vector of emission: from the point to the observer.
    pub direction: [f64; 3],
    /// ds/dz: the path length along the line of sight, in the length unit, per unit of depth z.
    /// Where it is 0 the line of sight is not in the view, and g is not evaluated.
    pub path_per_depth: f64,
}
