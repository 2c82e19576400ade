//! Prediction: the averages of a cell's children from the averages around the cell.
//!
//! Conservative (average-interpolating) subdivision after Donoho 1993 (*Smooth wavelet
//! decompositions with blocky coefficient kernels*): along one axis, the polynomial of degree
//! p − 1 whose means over p neighbouring cells are the given averages is averaged over each half of
//! a cell. More axes: one after the other. The mean of the predicted children is the parent's
//! average, which is what makes the projection along an axis exact.
//!
//! p is the order: 1, 3, 5, 7, … A polynomial of degree p − 1 is predicted exactly.

use crate::cell::{power, to_u32};

/// The highest order: the weights of 9 averages still lose few digits.
pub const MAX_ORDER: usize = 9;

/// Where the stencil of one cell lies along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stencil {
    /// Position of the first cell of the stencil; the others follow, modulo the axis if periodic.
    pub(crate) start: u32,
    /// The number of cells, and the order of the prediction.
    pub(crate) order: usize,
    /// Which of the cells is the one to be predicted in.
    pub(crate) offset: usize,
}

impl Stencil {
    /// The stencil of at most `order` cells around `position` on an axis of 2^`level` cells: centred
    /// where it fits or the axis is periodic, else the closest one.
    pub(crate) fn around(position: u32, level: u8, order: usize, periodic: bool) -> Self {
        let cells = 1_usize << level;
        // The largest odd order with no cell counted twice.
        let order =
            if order <= cells { order } else { cells - usize::from(cells.is_multiple_of(2)) };
        let (radius, cells) = (to_u32(order / 2), to_u32(cells));
        if periodic {
            let start = (position + cells - radius) % cells;
            return Self { start, order, offset: order / 2 };
        }
        let start = position.saturating_sub(radius).min(cells - to_u32(order));
        Self { start, order, offset: (position - start) as usize }
    }
}

/// Weights for averages over parts of a cell, from the averages of a stencil of cells.
///
/// ```
/// use emitree::prediction::part_weights;
///
/// // The left half of the middle one of three cells, order 3.
/// assert_eq!(part_weights(3, 1, 0.0, 0.5), [0.125, 1.0, -0.125]);
/// ```
///
/// Returns the `order` weights w with which Σ w\[k\]·average\[k\] is the **mean** over the part
/// \[`from`, `to`\] (fractions of the cell's edge, `from` < `to`) of cell `offset` of the stencil.
pub fn part_weights(order: usize, offset: usize, from: f64, to: f64) -> Vec<f64> {
    // The primitive of the polynomial takes the running sums of the averages at the cell borders
    // 0, 1, …, order: interpolate those, and take the difference at the ends of the part.
    let (low, high) = (lagrange(order, offset as f64 + from), lagrange(order, offset as f64 + to));
    let length = to - from;
    // Average k is in the running sum of every border after it.
    let mut weights = vec![0.0; order];
    let mut tail = 0.0;
    for k in (0..order).rev() {
        tail += high[k + 1] - low[k + 1];
        weights[k] = tail / length;
    }
    weights
}

/// The values at `t` of the Lagrange polynomials on the nodes 0, 1, …, `degree`.
fn lagrange(degree: usize, t: f64) -> Vec<f64> {
    let basis = |k: usize| {
        let others = (0..=degree).filter(|&j| j != k).map(|j| j as f64);
        others.map(|j| (t - j) / (k as f64 - j)).product()
    };
    (0..=degree).map(basis).collect()
}

/// The prediction of one order, as a table of weights.
///
/// ```
/// use emitree::prediction::Predictor;
///
/// let quadratic = Predictor::new(3)?;
/// assert_eq!(quadratic.order(), 3);
/// // Cells of edge 1 with the averages of x²: 1/3, 7/3, 19/3; the halves of the middle one.
/// let halves = quadratic.split(&[1.0 / 3.0, 7.0 / 3.0, 19.0 / 3.0], 1);
/// assert!((halves[0] - 19.0 / 12.0).abs() < 1e-15 && (halves[1] - 37.0 / 12.0).abs() < 1e-15);
/// # Ok::<(), emitree::prediction::OrderError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Predictor {
    order: usize,
    /// Weights of the lower half, for each smaller odd order too, at `[order / 2][offset]`.
    lower_half: Vec<Vec<Vec<f64>>>,
}

/// An order that prediction does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`order` is {0}: expected an odd number from 1 to {MAX_ORDER}")]
pub struct OrderError(pub usize);

impl Predictor {
    /// The prediction of `order` p: exact for polynomials of degree p − 1.
    ///
    /// # Errors
    ///
    /// [`OrderError`] if the order is even or above [`MAX_ORDER`].
    pub fn new(order: usize) -> Result<Self, OrderError> {
        if order.is_multiple_of(2) || order > MAX_ORDER {
            return Err(OrderError(order));
        }
        let of_order = |p| (0..p).map(|offset| part_weights(p, offset, 0.0, 0.5)).collect();
        let lower_half = (1..=order).step_by(2).map(of_order).collect();
        Ok(Self { order, lower_half })
    }

    /// The order p.
    pub fn order(&self) -> usize {
        self.order
    }

    /// The averages of the lower and the upper half of cell `offset` of a stencil.
    ///
    /// # Panics
    ///
    /// If there are more averages than the order, an even number of them, or `offset` is not one of
    /// them.
    pub fn split(&self, averages: &[f64], offset: usize) -> [f64; 2] {
        let weights = &self.lower_half[averages.len() / 2][offset];
        let lower = weights.iter().zip(averages).map(|(w, a)| w * a).sum();
        // The mean of the two is the cell's average: conservation to the last bit but one.
        [lower, 2.0 * averages[offset] - lower]
    }

    /// The weights of the lower half of the cell that a stencil is around.
    pub(crate) fn lower_half(&self, stencil: Stencil) -> &[f64] {
        &self.lower_half[stencil.order / 2][stencil.offset]
    }

    /// Predicts a family: `block` holds the averages of `order`^D cells, axis 0 fastest; `offsets`
    /// says which of them is the parent. The 2^D children are left at the start of `block`.
    /// `scratch` has the length of `block`.
    pub(crate) fn predict_family<const D: usize>(
        &self,
        order: usize,
        offsets: [usize; D],
        block: &mut [f64],
        scratch: &mut [f64],
    ) {
        // Axis by axis, the fastest first, `order` averages become 2 halves; the halves of the axes
        // done are kept slowest, so that each pass reads and writes in rows. After D passes the
        // axes are in their first order again.
        let mut remaining = power(order, D);
        let mut done = 1;
        for offset in offsets {
            let weights = &self.lower_half[order / 2][offset][..order];
            remaining /= order;
            for half_block in 0..done {
                let from = &block[half_block * remaining * order..][..remaining * order];
                for (row, averages) in from.chunks_exact(order).enumerate() {
                    let lower: f64 = weights.iter().zip(averages).map(|(w, a)| w * a).sum();
                    scratch[half_block * remaining + row] = lower;
                    scratch[(done + half_block) * remaining + row] = 2.0 * averages[offset] - lower;
                }
            }
            done *= 2;
            block[..done * remaining].copy_from_slice(&scratch[..done * remaining]);
        }
    }
}

#[cfg(test)]
mod tests;
