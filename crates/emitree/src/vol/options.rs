//! Options of method `vol`.

use super::{FeatureSize, Seed};
use crate::image::Image;
use crate::sums::Sum;
use crate::vol::tuning::TUNING;
use std::sync::Arc;

/// The part of the brightest pixel below which relative errors are not asked for, unless another one is
/// given: images fall to 0.
pub(crate) const DARKEST: f64 = 1e-5;

/// The error allowed in each pixel, from the pixel itself: `atol` + `rtol` · max(|pixel|, `floor` · largest
/// |pixel|).
///
/// This is the criterion of `numpy.isclose` with a floor under the pixel: without any floor, a relative
/// error could not be reached where an image falls to 0.
///
/// ```
/// use emitree::VolOptions;
/// use emitree::vol::PixelTolerance;
///
/// // 1 % of every pixel above 1e-4 of the brightest.
/// let by_pixel = PixelTolerance::relative(0.01).with_floor(1e-4);
/// assert_eq!(by_pixel.allowed(0.5, 2.0), 0.005);
/// assert_eq!(by_pixel.allowed(0.0, 2.0), 0.01 * 1e-4 * 2.0);
/// let options = VolOptions::default().with_pixel_tolerance(by_pixel);
/// assert_eq!(options.by_pixel, Some(by_pixel));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PixelTolerance {
    /// The error allowed relative to the |pixel|; from 0 to below 1, and above 0 if `atol` is 0.
    pub rtol: f64,
    /// The error allowed in every pixel, in the unit of the image; 0 or more.
    pub atol: f64,
    /// The brightness below which `rtol` is relative to this brightness, as a fraction of the largest
    /// |pixel|; from 0 to below 1.
    pub floor: f64,
}

impl PixelTolerance {
    /// An error of at most `rtol` times each |pixel|, down to pixels of 1e-5 of the largest one.
    pub fn relative(rtol: f64) -> Self {
        Self { rtol, atol: 0.0, floor: DARKEST }
    }

    /// An error of at most `atol` in each pixel, in the unit of the image.
    pub fn absolute(atol: f64) -> Self {
        Self { rtol: 0.0, atol, floor: 0.0 }
    }

    /// Sets the error allowed in every pixel, in the unit of the image.
    #[must_use]
    pub fn with_atol(self, atol: f64) -> Self {
        Self { atol, ..self }
    }

    /// Sets the brightness, as a fraction of the largest |pixel|, below which `rtol` is relative to it.
    #[must_use]
    pub fn with_floor(self, floor: f64) -> Self {
        Self { floor, ..self }
    }

    /// The error allowed in a pixel, in its unit, if the largest |pixel| is `largest`.
    pub fn allowed(&self, pixel: f64, largest: f64) -> f64 {
        self.atol + self.rtol * pixel.abs().max(self.floor * largest)
    }
}

/// What a rendering is to need as little of as possible.
///
/// ```
/// use emitree::VolOptions;
/// use emitree::vol::Minimize;
///
/// let options = VolOptions::new(0.01).with_minimize(Minimize::Time);
/// assert_eq!(options.minimize, Minimize::Time);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Minimize {
    /// Evaluations of g. The same input gives the same bits.
    #[default]
    Evaluations,
    /// Wall-clock time. If g turns out to take nanoseconds, the image is made of lines of sight on a lattice of
    /// pixels where that is faster, to the same tolerance; g is evaluated up to millions of times then, which
    /// [`RenderStats::line_steps`](crate::result::RenderStats::line_steps) says. The choice depends on measured
    /// time, so that the same input may give one of two images, each within the tolerance. Sessions, renderings
    /// with `rounds`, cubes, several tiles, discs, singular emissions, errors by pixel, sums, seeds and meshes have
    /// fewest evaluations all the same.
    Time,
}

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
    /// below 1. With [`by_pixel`](Self::by_pixel) it is not used.
    ///
    /// It is met for the structure that the samples detect. A structure between all samples, the
    /// lines and depths of the base lattice and a thousand scattered points, is not detected: for
    /// such structure there are [`Seed`]s at known places and finer base lattices.
    pub tolerance: f64,
    /// The error allowed in each pixel from the pixel itself, instead of `tolerance`.
    pub by_pixel: Option<PixelTolerance>,
    /// A weight for each pixel of the image: the error allowed there is divided by it. A pixel with the
    /// weight 0 does not matter: its error is not limited, and it is not among those whose largest one
    /// is meant. In the [order of images](crate::Image#axis-order-and-orientation), of the same shape.
    pub weights: Option<Arc<Image>>,
    /// For cubes: each band to the largest |voxel| of its own, instead of that of the cube; bands that are
    /// darker than 1e-5 of the brightest one to that brightness.
    pub per_band: bool,
    /// Sums over regions, each with a tolerance of its own that the rendering meets too. Beside sums,
    /// `tolerance` may be 1: the pixels matter for the sums alone, and have 5 % of the largest one.
    pub sums: Vec<Sum>,
    /// Places on the image plane, x and y from 0 to 1 over the image, whose lines of sight have radiances of their own in
    /// the result. They do not change the image. Beside found surfaces, lines with errors beyond the tolerance are
    /// sampled where their region is not certain.
    pub lines: Option<Arc<[[f64; 2]]>>,
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
    /// Whether evaluations of g are to be few, or time short.
    pub minimize: Minimize,
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
            by_pixel: None,
            weights: None,
            per_band: false,
            sums: Vec::new(),
            lines: None,
            base_level: 3,
            smallest_feature: None,
            seeds: Vec::new(),
            minimize: Minimize::Evaluations,
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

    /// Sets the error allowed in each pixel from the pixel itself.
    #[must_use]
    pub fn with_pixel_tolerance(mut self, by_pixel: impl Into<Option<PixelTolerance>>) -> Self {
        self.by_pixel = by_pixel.into();
        self
    }

    /// Sets the weight of each pixel, in an image of the shape of that to be rendered.
    #[must_use]
    pub fn with_weights(mut self, weights: Image) -> Self {
        self.weights = Some(Arc::new(weights));
        self
    }

    /// Sets whether each band of a cube is rendered to the largest |voxel| of its own.
    #[must_use]
    pub fn with_per_band(mut self, per_band: bool) -> Self {
        self.per_band = per_band;
        self
    }

    /// Sets the sums over regions, which replace those set before.
    #[must_use]
    pub fn with_sums(mut self, sums: impl Into<Vec<Sum>>) -> Self {
        self.sums = sums.into();
        self
    }

    /// Sets places on the image plane, x and y from 0 to 1 over the image, whose lines of sight have
    /// [radiances](crate::result::LineValues) in the result.
    #[must_use]
    pub fn with_lines(mut self, places: impl Into<Arc<[[f64; 2]]>>) -> Self {
        self.lines = Some(places.into());
        self
    }

    /// Whether the same error is allowed in all pixels.
    pub(crate) fn is_uniform(&self) -> bool {
        self.by_pixel.is_none() && self.weights.is_none() && !self.per_band
    }

    /// The tolerance of the largest pixel: the number that weighted errors are compared with.
    pub(crate) fn of_largest(&self) -> f64 {
        if self.is_uniform() {
            return self.tolerance;
        }
        let relative = self.by_pixel.map(|of| of.rtol).filter(|rtol| *rtol > 0.0);
        relative.unwrap_or(self.tolerance).min(TUNING.engine.loosest_tolerance)
    }

    /// The error allowed in the darkest pixel in terms of that in the largest one, which is `largest`: at
    /// most 1, and no less than what rounding allows.
    pub(crate) fn share_of_darkest(&self, largest: f64) -> f64 {
        let Some(by_pixel) = self.by_pixel.filter(|_| largest > 0.0) else { return 1.0 };
        (by_pixel.allowed(0.0, largest) / (self.tolerance * largest)).clamp(1e-10, 1.0)
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

    /// Sets whether evaluations of g are to be few, or time short.
    #[must_use]
    pub fn with_minimize(mut self, minimize: Minimize) -> Self {
        self.minimize = minimize;
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
