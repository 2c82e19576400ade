//! Emissions from gridded data: values at the nodes of three axes.
//!
//! **The order of the axes**, here and in all that uses a [`Grid`]: positions are (x, y, z), shapes
//! are [nx, ny, nz], and x varies fastest in memory, then y, then z. That is the order of a FITS
//! image with NAXIS1 = x, and of a C array that is indexed `[z, y, x]`. Of other [`Coordinates`] the order
//! is that of their names: (ρ, φ, z) and (r, θ, φ), ρ and r varying fastest.
//!
//! * `coordinates.rs`: what the axes are, and the coordinates of a position;
//! * `search.rs`: how the cell of a coordinate is found;
//! * `axis.rs`: the nodes of one axis, and the cell that a coordinate lies in;
//! * `arrange.rs`: descending axes, full turns of φ, and poles;
//! * `axes.rs`: [`GridAxes`], the three axes;
//! * `cubic.rs`: monotone cubic interpolation in one dimension;
//! * `interpolation.rs`: the value in a cell, from those around it;
//! * `locations.rs`: the cells of many positions at once;
//! * `cube.rs`: [`Grid`], values on axes, and its evaluation.

mod arrange;
mod axes;
pub(crate) mod axis;
mod coordinates;
mod cube;
mod cubic;
mod error;
mod interpolation;
mod locations;
mod search;

pub use axes::GridAxes;
pub use axis::{check_nodes, logarithmic_nodes, uniform_nodes};
pub use coordinates::Coordinates;
pub use cube::{Grid, Outside};
pub use error::{GridError, OutsideGrid};
pub use interpolation::Interpolation;
pub(crate) use locations::Locations;

#[cfg(test)]
mod curved_tests;
#[cfg(test)]
mod tests;
