//! The weights of the coordinates of depth in a chart, fitted to samples.
//!
//! The depth of a chart is a weighted mean of several coordinates. If r are the changes of the
//! coordinates with the present depth, other weights w turn a sample G into G / (w · r), and it then
//! stands for w · r times its present part of the depth. The mean square of G is therefore
//! proportional to Σ G² / (w · r), a convex function of the weights. It is small if most of the depth
//! is where the emission is. An image plane has one coordinate of depth, which is stretched on the same
//! condition.

use crate::projection::charts::depth::{COORDINATES, Weights};
use crate::projection::charts::stretch::Stretch;
use crate::vol::tuning::TUNING;

/// The number of steps: the weights need not be accurate.
const STEPS: usize = 60;

/// The number of widths of stretches, each smaller by √2. Few samples of a peak do not show a width
/// below the spacing of samples along the depth.
const WIDTHS: u32 = 10;
/// The number of intervals between the centres of stretches: a centre that is off by half of an interval
/// of the finest width changes the mean square by a few per cent.
const CENTRES: u32 = 128;

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

/// The stretch of the depth z of an image plane that nearly minimizes the mean square of samples, from
/// their squares and their z; `None` if that without a stretch is not much larger.
///
/// A stretch turns a sample G into G dz/dt, and 1/(dz/dt) as many samples are there, so that the mean
/// square is proportional to Σ G² dz/dt.
pub(crate) fn fitted_stretch(samples: &[(f64, f64)]) -> Option<Stretch> {
    let before: f64 = samples.iter().map(|(square, _)| square).sum();
    if !(before > 0.0 && before.is_finite()) {
        return None;
    }
    let mean_square = |stretch: &Stretch| {
        samples.iter().map(|(square, z)| square * stretch.slope_at(*z)).sum::<f64>()
    };
    let widths = (1..=WIDTHS).map(|k| 0.5_f64.powf(0.5 * f64::from(k)));
    let centres = || (0..=CENTRES).map(|i| f64::from(i) / f64::from(CENTRES));
    let uniform = TUNING.view.uniform_places;
    let all = widths.flat_map(|w| centres().map(move |at| Stretch::about(at, w, uniform)));
    let (least, best) =
        all.map(|stretch| (mean_square(&stretch), stretch)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    (TUNING.view.least_stretch_gain * least < before).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRESENT: Weights = [0.7, 0.2, 0.1, 0.0, 0.0, 0.0];

    /// Changes of the coordinates with the present depth, given those of all but the own one.
    fn shares(plain: f64, of_centre: f64) -> Weights {
        let own = (1.0 - PRESENT[1] * plain - PRESENT[2] * of_centre) / PRESENT[0];
        [own, plain, of_centre, 3.0, 0.0, 0.0]
    }

    /// Emission where the plain coordinate changes most, and little elsewhere.
    fn samples() -> Vec<(f64, Weights)> {
        let mut samples = vec![(1e-3, shares(0.1, 0.1)); 20];
        samples.extend([(4.0, shares(4.2, 0.2)), (2.0, shares(4.5, 0.6)), (1.0, shares(3.0, 0.1))]);
        samples
    }

    fn mean_square(weights: &Weights) -> f64 {
        let of = |(square, shares): &(f64, Weights)| {
            square / weights.iter().zip(shares).map(|(w, share)| w * share).sum::<f64>()
        };
        samples().iter().map(of).sum()
    }

    #[test]
    fn the_coordinate_that_changes_where_samples_are_large_has_most_weight() {
        let found = fitted(&PRESENT, &samples()).unwrap();
        assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{found:?}");
        assert!(found[1] > 0.75, "{found:?}");
        for (found, present) in found.iter().zip(PRESENT) {
            assert!(*found >= TUNING.view.kept_weight * present, "{found} {present}");
        }
        // What has no weight is no coordinate of the chart.
        assert!(found[3..].iter().all(|weight| *weight <= 0.0), "{found:?}");
    }

    #[test]
    fn no_weights_above_the_floors_are_much_better() {
        let kept = TUNING.view.kept_weight;
        let least = mean_square(&fitted(&PRESENT, &samples()).unwrap());
        assert!(TUNING.view.least_gain * least < mean_square(&PRESENT));
        for i in 0..=50 {
            for j in 0..=50 - i {
                let [own, plain] = [i, j].map(|k| f64::from(k) / 50.0);
                let free = [own, plain, 1.0 - own - plain, 0.0, 0.0, 0.0];
                let other = core::array::from_fn(|k| kept * PRESENT[k] + (1.0 - kept) * free[k]);
                assert!(least < 1.005 * mean_square(&other), "{other:?}");
            }
        }
    }

    #[test]
    fn weights_stay_if_there_is_nothing_to_gain() {
        // Alike in all coordinates, along them all, dark, and without samples.
        let alike = vec![(2.0, shares(1.0, 1.0)); 9];
        assert_eq!(fitted(&PRESENT, &alike), None);
        let everywhere =
            [(1.0, shares(2.0, 0.0)), (1.0, shares(0.5, 2.0)), (1.0, shares(0.8, 1.0))];
        assert_eq!(fitted(&PRESENT, &everywhere), None);
        let dark: Vec<(f64, Weights)> =
            samples().iter().map(|(_, shares)| (0.0, *shares)).collect();
        assert_eq!(fitted(&PRESENT, &dark), None);
        assert_eq!(fitted(&PRESENT, &[]), None);
        assert_eq!(fitted(&PRESENT, &[(f64::INFINITY, shares(2.0, 1.0))]), None);
    }

    #[test]
    fn a_depth_is_stretched_about_the_emission() {
        // Samples at equal distances of an emission between 0.63 and 0.67.
        let z = |i: usize| (i as f64 + 0.5) / 128.0;
        let square = |z: f64| (1.0 - (z - 0.65).abs() / 0.02).max(0.0);
        let samples: Vec<(f64, f64)> = (0..128).map(|i| (square(z(i)), z(i))).collect();
        let stretch = fitted_stretch(&samples).unwrap();
        let inside = (0..1000).map(|i| stretch.at(f64::from(i) / 1000.0).0);
        let share = inside.filter(|z| (0.63..0.67).contains(z)).count();
        assert!((200..220).contains(&share), "{share}");
        // The same everywhere, dark, and without samples.
        let uniform: Vec<(f64, f64)> = samples.iter().map(|(_, z)| (1.0, *z)).collect();
        let dark: Vec<(f64, f64)> = samples.iter().map(|(_, z)| (0.0, *z)).collect();
        for samples in [&uniform[..], &dark, &[]] {
            assert_eq!(fitted_stretch(samples), None);
        }
    }
}
