//! Emission problems with exact images, for tests, benches, examples and reproductions.
//!
//! Each module has the emission rate g of one problem on the unit cube and its exact image: the mean
//! of ∫ g dz over each pixel, from a closed form or from quadrature with a known error.
//! [`catalogue`] lists them as one type, and [`family`] makes any number of further ones. [`cubes`] are
//! problems with an energy axis and their exact spectral cubes, [`views`] have cameras with opaque
//! bodies and bounds. [`mutation`] makes files and scenes with something wrong in them.
//!
//! ```
//! use emitree::tree::BuildOptions;
//! use emitree::{Canonical, FromFn, RenderOptions, render};
//! use emitree_problems::{equation8, relative_error};
//!
//! let emission = FromFn(|position, _| equation8::rate(position, 100.0));
//! let options = RenderOptions::new(BuildOptions::default());
//! let rendering = render(&emission, &Canonical, [64, 64], &options)?;
//! let exact = equation8::exact_image(100.0, [64, 64]);
//! assert!(relative_error(&rendering.values, &exact) < 0.01);
//! # Ok::<(), emitree::RenderError<std::convert::Infallible>>(())
//! ```

pub mod absorbing;
pub mod ball;
pub mod beta_model;
#[cfg(test)]
mod brute;
pub mod catalogue;
pub mod corona;
pub mod cubes;
pub mod cusps;
pub mod deep;
pub mod divided;
pub mod equation8;
pub mod family;
mod gauss;
pub mod gaussian;
pub mod gaussians;
pub mod jumps;
pub mod knots;
pub mod mutation;
pub mod nebula;
mod panels;
pub mod planets;
pub mod recorded;
pub mod shapes;
pub mod shell;
pub mod shock;
pub mod smile;
pub mod solids;
pub mod tails;
pub mod tube;
pub mod views;
mod weighted_gaussians;
pub mod wires;
pub mod zodiacal;

use emitree::Image;
pub use emitree_models::means;

/// The largest |error| of a pixel over the largest |pixel| of the exact image: how errors are
/// measured everywhere here.
///
/// # Panics
///
/// If the shapes differ.
pub fn relative_error(image: &Image, exact: &Image) -> f64 {
    let largest = exact.pixels().iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    image.max_difference(exact) / largest
}
