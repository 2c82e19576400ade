//! Options of method `vol`.

use super::{FeatureSize, Seed};

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
    /// of [`BASE_LEVELS`](super::BASE_LEVELS). If it is finer than the default, there are no fewer scattered points.
    pub base_level: u8,
    /// The smallest feature to be seen with a probability of 99 %; by default what the scattered
    /// samples that every rendering makes cover. See [`FeatureSize`] and [`FEATURE_CONTRAST`](super::FEATURE_CONTRAST).
    pub smallest_feature: Option<FeatureSize>,
    /// Small structures at known places.
    pub seeds: Vec<Seed>,
    /// Energies of spectral lines, in the unit of the [energy axis](crate::EnergyAxis), at which
    /// spectra are sampled: a line much narrower than its bin may be missed else. Only for cubes.
    pub line_energies: Vec<f64>,
}

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
