//! Method `vol`: an image to a tolerance, from as few evaluations as possible.
//!
//! There are two representations. If G has a low-rank approximation along the axes of the view,
//! samples on a few crosses determine the image. Otherwise G is integrated line by line, and the
//! lines are the nodes of an image tree: the image may be smooth where g is not, and the tolerance
//! is for the image.
//!
//! The modules, each of which uses only those before it:
//!
//! * `dyadic`: places on the unit interval and on the image plane, predictions and polynomials;
//! * `lattice`, `ascent`: scattered samples, the size of the structure that they detect, and
//!   ascents from them; `least_squares`: local fits to scattered values;
//! * `image`: the tree of the image plane: values and details of its nodes, the remaining error
//!   around them, the error of each pixel, the nodes to be refined, means over pixels;
//! * `sampling`: samples of G in batches;
//! * `line`: samples along one line, its integral and error; the lines of all nodes, their jumps,
//!   and depths taken from neighbouring lines;
//! * `seeds`: nodes and depths at structures that the options name;
//! * `rule`: a few depths that integrate all lines of a block; the radiances of new nodes;
//! * `spectrum`: spectra at single points, and the energies selected from them;
//! * `view`: the [layers](crate::Layer) of a view and their coverage fractions; a sheet, the image
//!   tree of one layer at one energy; lines and samples that verify a sheet;
//! * `engine`: the loop over all sheets, and the final verification;
//! * `lowrank`: the low-rank approximation, with forecasts of its cost and that of the tree;
//! * `choose`: the low-rank approximation first, then the tree.
//!
//! The constants are in `tuning`. [`VolOptions::tolerance`] states what is not guaranteed.

mod ascent;
mod choose;
mod dyadic;
mod engine;
mod image;
mod lattice;
mod least_squares;
mod line;
mod lowrank;
mod rule;
mod sampling;
mod seeds;
mod spectrum;
#[cfg(not(feature = "ablate"))]
mod tuning;
#[cfg(feature = "ablate")]
pub mod tuning;
mod view;

#[cfg(test)]
mod tests;

pub(crate) use choose::render;
pub use seeds::Seed;

/// Options of method `vol`.
#[derive(Clone, Debug, PartialEq)]
pub struct VolOptions {
    /// The largest error of a pixel that is allowed, relative to the largest |pixel|; above 0 and
    /// below 1.
    ///
    /// It is met for the structure that the samples detect. A structure between all samples, the
    /// lines and depths of the base lattice and a thousand scattered points, is not detected: for
    /// such structure there are [`Seed`]s at known places and finer base lattices.
    pub tolerance: f64,
    /// The base lattice has 2^`base_level` intervals along each axis of the image and in depth; one
    /// of [`BASE_LEVELS`]. With a finer level than the default there are at least as many scattered
    /// points as base samples.
    pub base_level: u8,
    /// The size of the smallest feature to be detected with a probability of 99 %. By default it is
    /// the size that the scattered samples of every rendering cover. See [`FeatureSize`] and
    /// [`FEATURE_CONTRAST`].
    pub smallest_feature: Option<FeatureSize>,
    /// Small structures at known places.
    pub seeds: Vec<Seed>,
    /// Energies of emission lines, in the unit of the [energy axis](crate::EnergyAxis), at which
    /// all spectra are sampled. Without them a line that is much narrower than its bin may be
    /// missed. Only for cubes.
    pub line_energies: Vec<f64>,
}

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

impl Default for VolOptions {
    /// 1 % of the largest pixel, with a base lattice of 9 × 9 lines with 9 depths each.
    fn default() -> Self {
        Self {
            tolerance: 0.01,
            base_level: 3,
            smallest_feature: None,
            seeds: Vec::new(),
            line_energies: Vec::new(),
        }
    }
}

/// The memory of one evaluation in bytes: its sample, with its share of the nodes and of the
/// temporary data of a round.
pub(crate) const BYTES_PER_EVALUATION: u64 = 640;
/// The numbers for each pixel in addition to the image and its error: the copy for the choice of
/// nodes, the scale, and the columns of one axis.
pub(crate) const MAPS: u64 = 4;
