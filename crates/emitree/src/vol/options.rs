//! Options of method `vol`.

use super::{FeatureSize, Seed};

/// Options of method [`Vol`](crate::Method::Vol).
///
/// ```
/// use emitree::VolOptions;
/// use emitree::vol::{FeatureSize, Seed};
///
/// let knot = Seed { position: [0.2, 0.4, 0.9], radius: 0.01 };
/// let options = VolOptions::new(0.001)
///     .with_seeds([knot])
///     .with_smallest_feature(FeatureSize::Fraction(0.05));
/// assert_eq!((options.tolerance, options.base_level), (0.001, 3));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct VolOptions {
    /// The largest error of a pixel that is allowed, relative to the largest |pixel|; above 0 and
    /// below 1.
    ///
    /// It is met for the structure that the samples detect. A structure between all samples, the
    /// lines and depths of the base lattice and a thousand scattered points, is not detected: for
    /// such structure there are [`Seed`]s at known places and finer base lattices.
    pub tolerance: f64,
    /// The base lattice has 2^`base_level` intervals along each axis of the image and in depth; one
    /// of [`BASE_LEVELS`](super::BASE_LEVELS). With a finer level than the default there are at
    /// least as many scattered points as base samples.
    pub base_level: u8,
    /// The size of the smallest feature to be detected with a probability of 99 %. By default it is
    /// the size that the scattered samples of every rendering cover. See [`FeatureSize`] and
    /// [`FEATURE_CONTRAST`](super::FEATURE_CONTRAST).
    pub smallest_feature: Option<FeatureSize>,
    /// Small structures at known places.
    pub seeds: Vec<Seed>,
    /// Energies of emission lines, in the unit of the [energy axis](crate::EnergyAxis), at which
    /// all spectra are sampled. Without them a line that is much narrower than its bin may be
    /// missed. Only for cubes.
    pub line_energies: Vec<f64>,
}

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

impl VolOptions {
    /// Options for errors of at most `tolerance` times the largest |pixel|, above 0 and below 1,
    /// with the [defaults](Self::default) of all others.
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, ..Self::default() }
    }

    /// Sets the level of the base lattice, which has 2^`base_level` intervals along each axis; one
    /// of [`BASE_LEVELS`](super::BASE_LEVELS).
    #[must_use]
    pub fn with_base_level(mut self, base_level: u8) -> Self {
        self.base_level = base_level;
        self
    }

    /// Sets the size of the smallest feature to be detected.
    #[must_use]
    pub fn with_smallest_feature(mut self, size: impl Into<Option<FeatureSize>>) -> Self {
        self.smallest_feature = size.into();
        self
    }

    /// Sets the small structures at known places, which replace those set before.
    #[must_use]
    pub fn with_seeds(mut self, seeds: impl Into<Vec<Seed>>) -> Self {
        self.seeds = seeds.into();
        self
    }

    /// Sets the energies of emission lines, in the unit of the energy axis, which replace those set
    /// before.
    #[must_use]
    pub fn with_line_energies(mut self, energies: impl Into<Vec<f64>>) -> Self {
        self.line_energies = energies.into();
        self
    }
}
