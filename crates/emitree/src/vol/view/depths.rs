//! The weights of the coordinates of depth in a chart, fitted to samples.
//!
//! The depth of a chart is a weighted mean of several coordinates. If r are the changes of the
//! coordinates with the present depth, other weights w turn a sample G into G / (w · r), and it then
//! stands for w · r times its present part of the depth. The mean square of G is therefore
//! proportional to Σ G² / (w · r), a convex function of the weights. It is small if most of the depth
//! is where the emission is.

use crate::projection::charts::depth::{COORDINATES, Weights};
use crate::vol::tuning::TUNING;

/// The number of steps: the weights need not be accurate.
const STEPS: usize = 60;

/// The weights that nearly minimize the mean square of samples, from their squares and the changes of
/// coordinates at them; `None` if that of the present weights is hardly larger.
pub(crate) fn fitted(present: &Weights, samples: &[(f64, Weights)]) -> Option<Weights> {
    let dot = |w: &Weights, r: &Weights| w.iter().zip(r).map(|(w, r)| w * r).sum::<f64>();
    let mean_square =
        |w: &Weights| samples.iter().map(|(square, r)| square / dot(w, r)).sum::<f64>();
    let before = mean_square(present);
    if !(before > 0.0 && before.is_finite()) {
        return None;
    }
    // Each coordinate keeps a part of its weight: samples show a part of the emission only.
    let mut free = *present;
    let weights = |free: &Weights| -> Weights {
        core::array::from_fn(|k| {
            TUNING.view.kept_weight * present[k] + (1.0 - TUNING.view.kept_weight) * free[k]
        })
    };
    for _ in 0..STEPS {
        let w = weights(&free);
        let mut pull = [0.0; COORDINATES];
        for (square, r) in samples {
            let whole = dot(&w, r);
            pull.iter_mut().zip(r).for_each(|(pull, r)| *pull += square * r / (whole * whole));
        }
        let mut next: Weights = core::array::from_fn(|k| free[k] * pull[k].sqrt());
        let sum: f64 = next.iter().sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return None;
        }
        next.iter_mut().for_each(|next| *next /= sum);
        free = next;
    }
    let found = weights(&free);
    (TUNING.view.least_gain * mean_square(&found) < before).then_some(found)
}
