//! Sample points before their evaluation: where they are, and on which line of sight.

use crate::projection::MappedPoint;
use core::ops::Range;

/// A map from the canonical cube of a part of the image, with the weight of g in place of ds/dz.
#[derive(Clone, Copy)]
pub(crate) struct Mapping<'a> {
    pub(crate) map: &'a (dyn Fn([f64; 3]) -> MappedPoint + Sync),
    /// Which of the tiles of the image it is, and of how many.
    pub(crate) tile: (usize, usize),
    /// The energy of all points, if there is an energy axis.
    pub(crate) energy: Option<f64>,
}

/// One sample point of a batch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Site {
    /// Canonical (x, y): the line of sight that it is on.
    pub(crate) xy: [f64; 2],
    /// Where it is in the world, with the weight of g in place of ds/dz.
    pub(crate) point: MappedPoint,
    /// Its energy, if there is an energy axis; all sites of a batch have one, or none has.
    pub(crate) energy: Option<f64>,
    /// Which of the tiles of the image it is on, and of how many.
    pub(crate) tile: (usize, usize),
}

/// Sample points that follow each other on one line of sight, at one energy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch<'a> {
    /// As those of a [`Site`], each.
    pub(crate) xy: [f64; 2],
    pub(crate) points: &'a [MappedPoint],
    pub(crate) energy: Option<f64>,
    pub(crate) tile: (usize, usize),
}

/// The sample points of a batch, computed when they are used.
pub(crate) type Sites<'a> = dyn Fn(usize) -> Site + Sync + 'a;

/// What makes the sample points of a batch: a function of a point's number, or something that makes
/// neighbours at less cost.
pub(crate) trait SiteSource: Sync {
    /// Hands over the sites of these numbers, in their order.
    fn visit(&self, numbers: Range<usize>, take: impl FnMut(&Stretch<'_>));
}

impl<F: Fn(usize) -> Site + Sync + ?Sized> SiteSource for F {
    fn visit(&self, numbers: Range<usize>, mut take: impl FnMut(&Stretch<'_>)) {
        for number in numbers {
            let Site { xy, point, energy, tile } = self(number);
            take(&Stretch { xy, points: &[point], energy, tile });
        }
    }
}
