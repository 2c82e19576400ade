//! The value of a sum over a region, with its error.

use super::SumKind;

/// The sum over a region of a rendered image or cube.
///
/// The error is that of the sum, and not the sum of the errors of its pixels, most of which cancel:
/// it is estimated from points or lines of sight that took no part in the image. Where so many of them would cost
/// more than they are worth, it is that limit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RegionSum {
    /// The name.
    pub name: String,
    /// What was asked.
    pub kind: SumKind,
    /// The sum; of a cube that of all bands times their widths.
    pub value: f64,
    /// The estimated |error| of the value.
    pub error: f64,
    /// The error that was allowed.
    pub allowed: f64,
    /// The number of points or lines of sight that the error is estimated from; 0 if it is the sum of those
    /// of the pixels.
    pub samples: usize,
    /// Of a cube: the value and the |error| of each band, without its width. These errors are the sums of
    /// those of the voxels, an upper limit.
    pub bands: Vec<[f64; 2]>,
}

impl RegionSum {
    /// Whether the error is within what was allowed.
    pub fn is_within_tolerance(&self) -> bool {
        self.error <= self.allowed
    }
}
