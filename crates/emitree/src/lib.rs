//! Images of optically thin volume emissions, with as few evaluations of the emission as possible.
//!
//! A model gives the directional volume emission rate g(r, d), and is expensive to evaluate. Each
//! pixel of a camera is the line-of-sight integral of g averaged over the pixel. [`render()`] returns
//! the image, its estimated error and the number of evaluations:
//!
//! ```
//! use emitree::{Equirectangular, FromFn, RenderOptions, Viewpoint, VolOptions, render};
//!
//! // A corona that fades with the distance r from the origin, seen from 10 away.
//! let corona = FromFn(|[x, y, z]: [f64; 3], _direction: [f64; 3]| {
//!     (-(x * x + y * y + z * z).sqrt()).exp()
//! });
//! let viewpoint = Viewpoint { position: [10.0, 0.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
//! let camera = Equirectangular::new(viewpoint, [0.8, 0.6], [0.0, 20.0])?;
//! let options = RenderOptions::new(VolOptions::new(0.01));
//!
//! let rendering = render(&corona, &camera, [60, 80], &options)?;
//! assert!(rendering.converged() && rendering.estimated_error() < Some(0.01));
//! let centre = rendering.values[(30, 40)];
//! assert!((centre - 2.0).abs() < 0.1); // ∫ exp(−|s|) ds = 2 through the middle
//! println!("{} evaluations", rendering.stats.evaluations);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The names that these examples need are at the root; all others are in the modules, in the order in
//! which data pass through them:
//!
//! * [`projection`]: a camera maps the world to the canonical cube, z along the line of sight: image
//!   planes of seven kinds, depths finite or not, bounds, opaque bodies, the sky in `HEALPix` faces;
//! * [`vol`]: the engine: a low-rank approximation or, where there is none, a tree of the image plane whose
//!   nodes are lines of sight, refined until the tolerance is met; charts, in which views with opaque
//!   bodies are smooth up to limbs;
//! * [`cell`], [`quadrature`], [`prediction`], [`refinement`]: dyadic cells, their averages, the
//!   prediction of a cell's children, and which cells are split;
//! * [`tree`]: the paper's sparse tree of cell averages: built, projected along z by one sum for each
//!   coefficient, sampled to pixels;
//! * [`world_tree`]: a tree of g itself in a box of the world, an emission for any camera;
//! * [`los`]: lines of sight pixel by pixel, the baseline;
//! * [`radiance`]: irradiances of pixels, and images of trees;
//! * [`energy`]: the energy axis, with which there is an image for each of its bins ([`render_cube()`]);
//! * [`progress`]: callbacks while a rendering is made;
//! * [`result`]: the parts of a [`Rendering`];
//! * [`large`]: images and cubes larger than the memory, row by row;
//! * [`mesh`]: the frozen quadrature of a [`Session`];
//! * [`sweep`]: the images of one model for many values of its parameters;
//! * [`error`]: [`RenderError`], and the options that it names.
//!
//! The crate starts from M. Holmström, *Fast Visualization of Volume Emissions using Conservative
//! Subdivision* ("the paper").
//!
//! # Features
//!
//! * `rayon` (default): work is divided among threads. Without it everything is done in the thread that
//!   calls, with the same bits.
//! * `healpix` (default): `Healpix` and `projection::healpix`, the sky in pixels of equal area.
//! * `ablate`: for `cargo xtask ablate` alone, which replaces constants of the engine at run time.

mod parallel;
mod emission;
mod erased;
mod known;
mod line_values;
mod polling;
mod exchange;
mod ahead;
mod calls;
mod absorption;
mod meter;
mod site;
mod tally;
pub mod projection;
pub mod cell;
pub mod quadrature;
pub mod prediction;
pub mod refinement;
pub mod tree;
pub mod world_tree;
pub mod vol;
pub mod los;
mod image;
pub mod sums;
pub mod energy;
mod cube;
mod memory;
mod values;
pub mod mesh;
pub mod radiance;
mod tile;
mod found_surfaces;
mod output;
mod method;
mod paper;
pub mod progress;
mod options;
mod checks;
mod session;
mod rendering;
pub mod result;
mod render;
pub mod large;
pub mod sweep;
pub mod error;

pub use cube::Cube;
pub use emission::{Absorbing, Emission, FromFn, FromSpectralFn, Samples};
pub use energy::axis::{EnergyAxis, EnergyScale};
pub use error::render::RenderError;
pub use image::Image;
pub use options::{Method, RenderOptions};
#[cfg(feature = "healpix")]
pub use projection::all_sky::Healpix;
pub use projection::camera::{Equirectangular, Fisheye, Orthographic, Perspective, Polar};
pub use projection::canonical::Canonical;
pub use projection::frame::Viewpoint;
pub use projection::map::Projection;
pub use render::{render, render_cube};
pub use rendering::Rendering;
pub use session::Session;
pub use tree::build::StopReason;
pub use vol::options::VolOptions;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
