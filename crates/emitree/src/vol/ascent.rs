//! Ascents to larger residuals: searches beside the scattered samples with the largest residuals.
//!
//! A scattered sample may lie on the slope of a narrow structure. All ascents take their steps
//! together, so that each step is one batch, and no point is sampled twice.

use crate::vol::dyadic::from_unit;
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashSet;

/// A point with the quantity that was evaluated there.
pub(crate) type Found<T> = ([f64; 3], T);

/// The number of ascents that begin from a number of scattered samples.
pub(crate) fn number(samples: usize) -> usize {
    samples.div_ceil(TUNING.verification.samples_per_ascent)
}

/// Several ascents with simultaneous steps.
pub(crate) struct Ascents<T> {
    best: Vec<Found<T>>,
    /// The length of the next step of each ascent.
    lengths: Vec<f64>,
    /// All points that have been evaluated.
    visited: FxHashSet<[u32; 3]>,
    /// The points of the current step, each with the number of its ascent.
    tried: Vec<(usize, [f64; 3])>,
    steps: usize,
}

impl<T> Ascents<T> {
    /// Ascents from `starts`, which are some of `samples` scattered points.
    pub(crate) fn new(starts: Vec<Found<T>>, samples: usize) -> Self {
        let lengths =
            vec![TUNING.verification.sample_ascent_step / (samples as f64).cbrt(); starts.len()];
        let visited = starts.iter().map(|(at, _)| at.map(from_unit)).collect();
        Self { best: starts, lengths, visited, tried: Vec::new(), steps: 0 }
    }

    /// The points of the next step that are `open`; `None` after the last step.
    pub(crate) fn next(&mut self) -> Option<Vec<[f64; 3]>> {
        if self.steps == TUNING.verification.sample_ascent_steps {
            return None;
        }
        self.steps += 1;
        let Self { best, lengths, visited, tried, .. } = self;
        tried.clear();
        for (number, ((at, _), length)) in best.iter().zip(lengths).enumerate() {
            let around = beside(*at, *length).into_iter();
            let new = around.filter(|at| visited.insert(at.map(from_unit)));
            tried.extend(new.map(|at| (number, at)));
        }
        Some(tried.iter().map(|(_, at)| *at).collect())
    }

    /// Stores the quantities `found` at the points of the current step, if they are larger in
    /// `size`. Steps of ascents without an improvement are halved.
    pub(crate) fn update(&mut self, found: Vec<T>, size: impl Fn(&T) -> f64) {
        let before: Vec<f64> = self.best.iter().map(|(_, of)| size(of)).collect();
        for ((number, at), of) in self.tried.drain(..).zip(found) {
            if size(&of) > size(&self.best[number].1) {
                self.best[number] = (at, of);
            }
        }
        for ((length, before), (_, of)) in self.lengths.iter_mut().zip(before).zip(&self.best) {
            if size(of) <= before {
                *length *= 0.5;
            }
        }
    }

    /// The point of each ascent with the largest quantity.
    pub(crate) fn best(self) -> Vec<Found<T>> {
        self.best
    }
}

/// The points at the distance `step` along each axis, clamped to the cube.
fn beside(point: [f64; 3], step: f64) -> [[f64; 3]; 6] {
    core::array::from_fn(|k| {
        let by = if k % 2 == 0 { -step } else { step };
        let mut moved = point;
        moved[k / 2] = (moved[k / 2] + by).clamp(0.0, 1.0);
        moved
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ascent_approaches_a_peak_and_samples_no_point_twice() {
        let peak = [0.52, 0.47, 0.55];
        let height = |at: &[f64; 3]| {
            let square: f64 = (0..3).map(|k| (at[k] - peak[k]).powi(2)).sum();
            (-square / 0.002).exp()
        };
        let start = [0.5, 0.5, 0.5];
        let mut requested: Vec<[u64; 3]> = Vec::new();
        let mut ascents = Ascents::new(vec![(start, height(&start))], 1000);
        while let Some(points) = ascents.next() {
            requested.extend(points.iter().map(|at| at.map(f64::to_bits)));
            ascents.update(points.iter().map(height).collect(), |height| *height);
        }
        let found = ascents.best();
        assert!(found[0].1 > 1.5 * height(&start), "{found:?}");
        let number = requested.len();
        requested.sort_unstable();
        requested.dedup();
        assert_eq!(requested.len(), number);
        assert!(number <= 6 * TUNING.verification.sample_ascent_steps);
    }
}
