//! The halves of a cell along one axis, of many cells side by side.
//!
//! The same sums in the same order as where families are predicted one by one, of a length that is known
//! when they are compiled.

use super::points::PointPredictor;
use crate::prediction::{Predictor, Stencil};

/// Numbers of a cell's halves from those of the N cells of its stencil.
pub(super) trait Halves<const N: usize> {
    /// Writes `side_by_side` numbers of the lower half, then as many of the upper one; `from` has as
    /// many of each cell.
    fn split(&self, from: &[f64], side_by_side: usize, to: &mut [f64]);
}

/// Means over halves, as [`Predictor::predict_family`](crate::prediction::Predictor) makes them.
pub(super) struct Means<const N: usize> {
    lower: [f64; N],
    offset: usize,
}

impl<const N: usize> Means<N> {
    pub(super) fn new(predictor: &Predictor, stencil: Stencil) -> Self {
        let weights = predictor.lower_half(stencil);
        Self { lower: core::array::from_fn(|k| weights[k]), offset: stencil.offset }
    }
}

impl<const N: usize> Halves<N> for Means<N> {
    fn split(&self, from: &[f64], side_by_side: usize, to: &mut [f64]) {
        let rows = rows_of::<N>(from, side_by_side);
        let own = rows[self.offset];
        let (lower, upper) = to.split_at_mut(side_by_side);
        for (i, ((lower, upper), own)) in lower.iter_mut().zip(upper).zip(own).enumerate() {
            *lower = weighted(&self.lower, &rows, i);
            *upper = 2.0 * own - *lower;
        }
    }
}

/// Values at the centres of halves, as [`PointPredictor::predict_family`] makes them.
pub(super) struct Values<const N: usize> {
    lower: [f64; N],
    upper: [f64; N],
}

impl<const N: usize> Values<N> {
    pub(super) fn new(points: &PointPredictor, stencil: Stencil) -> Self {
        let [lower, upper] = points.halves(stencil);
        let of = |weights: &[f64]| core::array::from_fn(|k| weights[k]);
        Self { lower: of(lower), upper: of(upper) }
    }
}

impl<const N: usize> Halves<N> for Values<N> {
    fn split(&self, from: &[f64], side_by_side: usize, to: &mut [f64]) {
        let rows = rows_of::<N>(from, side_by_side);
        let (lower, upper) = to.split_at_mut(side_by_side);
        for (i, (lower, upper)) in lower.iter_mut().zip(upper).enumerate() {
            *lower = weighted(&self.lower, &rows, i);
            *upper = weighted(&self.upper, &rows, i);
        }
    }
}

/// What is side by side, of each cell.
#[inline(always)]
fn rows_of<const N: usize>(from: &[f64], side_by_side: usize) -> [&[f64]; N] {
    core::array::from_fn(|k| &from[k * side_by_side..][..side_by_side])
}

/// The weighted sum of number `i` of all rows, the first product first.
#[inline(always)]
fn weighted<const N: usize>(weights: &[f64; N], rows: &[&[f64]; N], i: usize) -> f64 {
    let mut sum = weights[0] * rows[0][i];
    for k in 1..N {
        sum += weights[k] * rows[k][i];
    }
    sum
}
