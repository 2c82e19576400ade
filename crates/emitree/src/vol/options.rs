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

impl VolOptions {
    /// Errors of at most `tolerance` times the largest |pixel|, above 0 and below 1; all else as by
    /// [default](Self::default).
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, ..Self::default() }
    }

    /// The same with a base lattice of 2^`base_level` intervals along each axis, one of
    /// [`BASE_LEVELS`](super::BASE_LEVELS).
    #[must_use]
    pub fn with_base_level(mut self, base_level: u8) -> Self {
        self.base_level = base_level;
        self
    }

    /// The same with the size of the smallest feature that must not be missed.
    #[must_use]
    pub fn with_smallest_feature(mut self, size: impl Into<Option<FeatureSize>>) -> Self {
        self.smallest_feature = size.into();
        self
    }

    /// The same with small structures at known places, in place of those before.
    #[must_use]
    pub fn with_seeds(mut self, seeds: impl Into<Vec<Seed>>) -> Self {
        self.seeds = seeds.into();
        self
    }

    /// The same with the energies of spectral lines, in the unit of the energy axis, in place of those
    /// before.
    #[must_use]
    pub fn with_line_energies(mut self, energies: impl Into<Vec<f64>>) -> Self {
        self.line_energies = energies.into();
        self
    }
}
