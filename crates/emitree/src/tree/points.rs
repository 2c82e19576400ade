//! Prediction of values at the centres of cells, where a tree holds those in place of averages.
//!
//! The polynomial of degree p − 1 through the values at the centres of p neighbouring cells, along
//! one axis after the other, gives the values at the centres of a cell's children: Deslauriers and
//! Dubuc 1989 (doi:10.1007/BF01889598), for centres. The midpoint rule makes the same number g at the
//! centre and an average to second order only; taken for what it is, it keeps the order p.

use crate::cell::power;
use crate::prediction::Stencil;

/// Tables of weights for the values at the centres of a cell's halves.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PointPredictor {
    /// Weights of the lower and the upper half, for each odd order up to the tree's, at
    /// `[order / 2][offset]`.
    halves: Vec<Vec<[Vec<f64>; 2]>>,
}

impl PointPredictor {
    /// Tables for the odd `order` and the odd ones below it.
    pub(super) fn new(order: usize) -> Self {
        let of_stencil = |order: usize, offset: usize| {
            [-0.25, 0.25].map(|half| lagrange(order, offset as f64 + half))
        };
        let of_order = |order: usize| (0..order).map(|offset| of_stencil(order, offset)).collect();
        Self { halves: (1..=order).step_by(2).map(of_order).collect() }
    }

    /// The weights of both halves of the cell that a stencil is around.
    pub(super) fn halves(&self, stencil: Stencil) -> [&[f64]; 2] {
        let [lower, upper] = &self.halves[stencil.order / 2][stencil.offset];
        [lower, upper]
    }

    /// Predicts a family, as [`Predictor::predict_family`](crate::prediction::Predictor) does with averages:
    /// `block` holds the values of `order`^D cells, axis 0 fastest; the 2^D children are left at its
    /// start.
    pub(super) fn predict_family<const D: usize>(
        &self,
        order: usize,
        offsets: [usize; D],
        block: &mut [f64],
        scratch: &mut [f64],
    ) {
        let mut remaining = power(order, D);
        let mut done = 1;
        for offset in offsets {
            let [lower, upper] = &self.halves[order / 2][offset];
            remaining /= order;
            for half_block in 0..done {
                let from = &block[half_block * remaining * order..][..remaining * order];
                for (row, values) in from.chunks_exact(order).enumerate() {
                    let half =
                        |weights: &[f64]| weights.iter().zip(values).map(|(w, v)| w * v).sum();
                    scratch[half_block * remaining + row] = half(lower);
                    scratch[(done + half_block) * remaining + row] = half(upper);
                }
            }
            done *= 2;
            block[..done * remaining].copy_from_slice(&scratch[..done * remaining]);
        }
    }
}

/// The values at `t` of the Lagrange polynomials on the nodes 0, 1, …, `nodes` − 1.
fn lagrange(nodes: usize, t: f64) -> Vec<f64> {
    let basis = |k: usize| {
        let others = (0..nodes).filter(|&j| j != k).map(|j| j as f64);
        others.map(|j| (t - j) / (k as f64 - j)).product()
    };
    (0..nodes).map(basis).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights of the parabola through −1, 0 and 1 at −1/4, and of the one-sided parabola at 1/4.
    #[test]
    fn weights_of_order_3() {
        let predictor = PointPredictor::new(3);
        let close = |weights: &[f64], expected: [f64; 3]| {
            assert!(
                weights.iter().zip(expected).all(|(w, e)| (w - e).abs() < 1e-15),
                "{weights:?}"
            );
        };
        close(&predictor.halves[1][1][0], [5.0 / 32.0, 30.0 / 32.0, -3.0 / 32.0]);
        close(&predictor.halves[1][0][1], [21.0 / 32.0, 14.0 / 32.0, -3.0 / 32.0]);
    }

    #[test]
    fn a_polynomial_is_predicted_at_the_centres_of_children() {
        let g = |x: f64, y: f64| 1.0 + x.powi(4) * y - 2.0 * y.powi(3) * x;
        let mut block: Vec<f64> =
            (0..25).map(|i| g(f64::from(i % 5) + 0.5, f64::from(i / 5) + 0.5)).collect();
        let mut scratch = block.clone();
        PointPredictor::new(5).predict_family::<2>(5, [1, 3], &mut block, &mut scratch);
        for (child, value) in block[..4].iter().enumerate() {
            let (x, y) = (1.25 + 0.5 * (child & 1) as f64, 3.25 + 0.5 * (child >> 1) as f64);
            assert!((value - g(x, y)).abs() < 1e-11, "{value} {}", g(x, y));
        }
    }
}
