//! Method `vol`: the image within a tolerance, from as few evaluations as possible.
//!
//! There are two representations. If G has a low-rank approximation along the axes of the view, samples
//! on a few crosses determine the image. Otherwise G is integrated line by line, and the lines are the
//! nodes of a tree in the image plane: the image may be smooth where g is not, and its error is what the
//! tolerance limits.
//!
//! The modules, each of which uses those before it only:
//!
//! * `dyadic`: places on the unit interval and on the image plane, predictions and polynomials;
//! * `lattice`, `ascent`: scattered samples, the size of the structure that they detect, and ascents
//!   from them; `least_squares`: local fits to scattered values;
//! * `image`: the tree of the image plane: values and details of its nodes, the remaining error around
//!   them, the error of each pixel, the nodes to be refined, means over pixels;
//! * `sampling`: samples of G in batches;
//! * `line`: samples along one line, its integral and error; the lines of all nodes, their jumps and
//!   what neighbours take from each other;
//! * `seeds`: nodes and depths at structures that the caller names;
//! * `rule`: a few depths that integrate all lines of a block; the radiances of new nodes;
//! * `spectrum`: spectra at single points, and the energies that explain them;
//! * `view`: the [layers](crate::Layer) of a view and their coverage fractions; a sheet, the image
//!   tree of one layer at one energy; lines and samples that verify a sheet;
//! * `engine`: the loop over all sheets, and the final verification;
//! * `lowrank`: the low-rank approximation, with a forecast of its cost and of the tree's;
//! * `choose`: the low-rank approximation first, then the tree.
//!
//! [`VolOptions::tolerance`] says what is guaranteed, and what is not.

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
mod testing;
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
    /// It is kept for what the samples have seen. A structure that falls between them can't be promised,
    /// be it the lines and depths of the base lattice or a thousand scattered points: name it with a
    /// [`Seed`], or choose a finer base.
    pub tolerance: f64,
    /// The base lattice has 2^`base_level` intervals along each axis, of the image and in depth; one
    /// of [`BASE_LEVELS`]. If it is finer than the default, there are no fewer scattered points.
    pub base_level: u8,
    /// The smallest feature to be seen with a probability of 99 %; by default what the scattered
    /// samples that every rendering makes cover. See [`FeatureSize`] and [`FEATURE_CONTRAST`].
    pub smallest_feature: Option<FeatureSize>,
    /// Small structures at known places.
    pub seeds: Vec<Seed>,
    /// Energies of spectral lines, in the unit of the [energy axis](crate::EnergyAxis), at which
    /// spectra are sampled: a line much narrower than its bin may be missed else. Only for cubes.
    pub line_energies: Vec<f64>,
}

/// The size of a small feature: the standard deviation of a Gaussian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FeatureSize {
    /// As a fraction of the edge of the view's cube, above 0 and at most 1. Along each axis of the view
    /// it is that fraction of the image's width, of its height and of the depth.
    Fraction(f64),
    /// As a length in the scene's length unit, above 0: that fraction of the edge of a cube with the
    /// volume of the view, whose depth has to be finite.
    Length(f64),
}

/// The contrast of the smallest feature that is covered: the peak of the feature in the image, in units
/// of the error allowed.
pub const FEATURE_CONTRAST: f64 = 20.0;

/// The base levels that there are.
pub const BASE_LEVELS: core::ops::RangeInclusive<u8> = 2..=7;

impl Default for VolOptions {
    /// 1 % of the largest pixel, from a base lattice of 9 × 9 lines with 9 depths each.
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

/// Memory that one evaluation takes: its sample, and its share of the nodes and of what a round
/// makes of them.
pub(crate) const BYTES_PER_EVALUATION: u64 = 640;
/// Numbers for each pixel beside the image and its error: the copy that the choice is made on, the
/// scale, and the columns of one axis.
pub(crate) const MAPS: u64 = 4;
