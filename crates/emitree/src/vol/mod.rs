//! Method `vol`: an image to a tolerance, from as few evaluations as possible.
//!
//! There are three representations. If G has a low-rank approximation along the axes of the view,
//! samples on a few crosses determine the image. If it jumps, the surfaces at which it does are found,
//! and G is a polynomial in each box beside them. Otherwise G is integrated line by line, and the
//! lines are the nodes of an image tree: the image may be smooth where g is not, and the tolerance
//! is for the image.
//!
//! The modules, each of which uses only those before it:
//!
//! * `dyadic`: places on the unit interval and on the image plane, predictions and polynomials;
//! * `lattice`, `ascent`: scattered samples, the size of the structure that they detect, and
//!   ascents from them; `orthonormal`, `least_squares`: local fits to scattered values;
//! * `error_weights`: the error allowed in each pixel, as weights of errors;
//! * `image`: the tree of the image plane: values and details of its nodes, the remaining error
//!   around them, the error of each pixel, the nodes to be refined, means over pixels;
//! * `sampling`: samples of G in batches;
//! * `line`: samples along one line, its integral and error; the lines of all nodes, their jumps,
//!   and depths taken from neighbouring lines;
//! * `seeds`: nodes and depths at structures that the options name;
//! * `rule`: a few depths that integrate all lines of a block; the radiances of new nodes;
//! * `spectrum`: spectra at single points, and the energies selected from them;
//! * `view`: the parts of a view, each with a [chart](crate::projection::Chart); edges of the emission
//!   around bodies; the quadrature of pixels in charts; a sheet, the image tree of one part at one
//!   energy; lines and samples that verify a sheet;
//! * `featureless`: the number of scattered samples of a view without structure in any of them;
//! * `engine`: the loop over all sheets, and the final verification;
//! * `lowrank`: the low-rank approximation of each part, with forecasts of its cost and that of the tree;
//! * `surfaces`: surfaces at which G jumps, and the image from them and from polynomials beside them;
//! * `pixel_lines`: lines of sight on a lattice of pixels, where time is to be minimized and g is cheap;
//! * `choose`: the low-rank approximation first, then surfaces if G jumps, then the tree;
//! * `sums`: sums over regions, their errors, and images refined for them.
//!
//! The constants are in `tuning`. [`VolOptions::tolerance`] states what is not guaranteed.

mod ascent;
mod choose;
mod dyadic;
mod engine;
mod error_weights;
mod featureless;
mod image;
pub(crate) mod lattice;
mod least_squares;
mod line;
mod lowrank;
pub(crate) mod options;
mod orthonormal;
mod pixel_lines;
mod rule;
mod sampling;
mod seeds;
mod spectrum;
mod sums;
mod surfaces;
#[cfg(not(feature = "ablate"))]
mod tuning;
// For measurements alone.
#[cfg(feature = "ablate")]
#[doc(hidden)]
pub mod tuning;
mod view;

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

pub(crate) use options::VolOptions;
pub use options::{Minimize, PixelTolerance};
pub use seeds::Seed;
pub(crate) use sums::render;

/// The size of a small feature: the standard deviation of a Gaussian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FeatureSize {
    /// A fraction of the edge of the view's cube, above 0 and at most 1. Along each axis of the
    /// view it is that fraction of the image's width, of its height and of the depth.
    Fraction(f64),
    /// A length in the scene's length unit, above 0. It corresponds to its fraction of the edge of
    /// a cube with the volume of the view, whose depth has to be finite.
    Length(f64),
}

/// The contrast of the smallest feature that is covered: its peak in the image, in units of the
/// error allowed.
pub const FEATURE_CONTRAST: f64 = 20.0;

/// The possible base levels.
pub const BASE_LEVELS: core::ops::RangeInclusive<u8> = 2..=7;

/// The memory of one evaluation in bytes: its sample, with its share of the nodes and of the
/// temporary data of a round.
pub(crate) const BYTES_PER_EVALUATION: u64 = 640;
/// The numbers for each pixel in addition to the image and its error: the copy for the choice of
/// nodes, the scale, and the columns of one axis.
pub(crate) const MAPS: u64 = 4;
