//! Emissions from gridded data: a cube of values at the nodes of three axes.
//!
//! **The order of the axes**, here and in all that uses a [`Grid`]: positions are (x, y, z), shapes
//! are [nx, ny, nz], and x varies fastest in memory, then y, then z. That is the order of a FITS
//! image with NAXIS1 = x, and of a C array that is indexed `[z, y, x]`.
//!
//! * `axis.rs`: the nodes of one axis, and the cell that a coordinate lies in;
//! * `cubic.rs`: monotone cubic interpolation in one dimension;
//! * `cube.rs`: [`Grid`], the tensor product of three axes, and its evaluation.

mod axis;
mod cube;
mod cubic;
mod error;

pub use axis::uniform_nodes;
pub use cube::{Grid, Interpolation, Outside};
pub use error::{GridError, OutsideGrid};

#[cfg(test)]
mod tests;
