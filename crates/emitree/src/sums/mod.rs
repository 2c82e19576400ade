//! Sums over named regions of an image, each to a tolerance of its own.
//!
//! A region is a weight for each pixel ([`Region`] makes those of circles and boxes); a [`Sum`] says what is
//! asked of it and how well, and a [`RegionSum`] is the answer, with its error.

pub(crate) mod found;
pub(crate) mod region;

use crate::image::Image;
use std::sync::Arc;

pub use found::RegionSum;
pub use region::Region;

/// What is asked of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SumKind {
    /// Σ w · pixel, in the unit of the image.
    Sum,
    /// Σ w · pixel / Σ w, in the unit of the image.
    Mean,
    /// Σ w · pixel · solid angle: the integral of the radiance over the region, in the unit of the image
    /// times sr.
    Flux,
}

/// A named sum over a region of an image, with the error allowed in it.
///
/// Of a cube it is the sum over all energies, ∫ dE, and each band has a sum too.
///
/// ```
/// use emitree::sums::{Region, Sum, SumKind};
/// use emitree::VolOptions;
///
/// let shape = [48, 64];
/// let disc = Region::circle([32.0, 24.0], 10.0).weights(shape);
/// let on = Sum::new("on", disc).with_tolerance(1e-3);
/// let around = Region::circle([32.0, 24.0], 20.0).weights(shape);
/// let mean = Sum::new("around", around).with_kind(SumKind::Mean);
/// let options = VolOptions::new(0.01).with_sums([on, mean]);
/// assert_eq!(options.sums[0].name, "on");
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sum {
    /// The name, which no other sum of a rendering has.
    pub name: String,
    /// A weight for each pixel, in the [order of images](crate::Image#axis-order-and-orientation): 1 in the
    /// region, 0 outside, the share of the pixel on its border. Weights may be negative, as those of a
    /// difference of two regions.
    pub weights: Arc<Image>,
    /// What is asked.
    pub kind: SumKind,
    /// The error allowed relative to the |value|: 0 or more, and below 1.
    pub rtol: f64,
    /// The error allowed in addition, in the unit of the value; 0 or more.
    pub atol: f64,
}

impl Sum {
    /// The sum of the pixels times `weights`, to 1 %.
    pub fn new(name: impl Into<String>, weights: Image) -> Self {
        let (name, weights) = (name.into(), Arc::new(weights));
        Self { name, weights, kind: SumKind::Sum, rtol: 0.01, atol: 0.0 }
    }

    /// Sets what is asked.
    #[must_use]
    pub fn with_kind(self, kind: SumKind) -> Self {
        Self { kind, ..self }
    }

    /// Sets the error allowed relative to the |value|, 0 or more and below 1.
    #[must_use]
    pub fn with_tolerance(self, rtol: f64) -> Self {
        Self { rtol, ..self }
    }

    /// Sets the error allowed in addition, in the unit of the value.
    #[must_use]
    pub fn with_atol(self, atol: f64) -> Self {
        Self { atol, ..self }
    }

    /// The error allowed in a value.
    pub(crate) fn allowed(&self, value: f64) -> f64 {
        self.atol + self.rtol * value.abs()
    }
}
