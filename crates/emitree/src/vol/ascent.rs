//! Ascents: from the samples that differ most from what is expected, points nearby that differ more.
//!
//! A scattered sample may have but the foot of something small. All ascents take their steps side by side,
//! so that each step is one batch, and no point is asked for twice.

use super::exam::dyadic;
use rustc_hash::FxHashSet;

/// One ascent for so many scattered samples…
const SAMPLES_PER_ASCENT: usize = 128;
/// …in so many steps, each along all three axes…
const STEPS: usize = 4;
/// …the first of which have this share of the distance of the samples.
const FIRST_STEP: f64 = 0.4;

/// A point, and what has been found there.
pub(crate) type Found<T> = ([f64; 3], T);

/// The number of ascents that so many scattered samples are followed by.
pub(crate) fn number(samples: usize) -> usize {
    samples.div_ceil(SAMPLES_PER_ASCENT)
}

/// The points of larger `size` near those of `starts`, some of `samples` scattered ones: `find` looks at
/// points, of which those that are not `open` are left out.
pub(crate) fn ascend<T, E>(
    starts: Vec<Found<T>>,
    samples: usize,
    is_open: impl Fn(&[f64; 3]) -> bool,
    size: impl Fn(&T) -> f64,
    mut find: impl FnMut(&[[f64; 3]]) -> Result<Vec<T>, E>,
) -> Result<Vec<Found<T>>, E> {
    let mut best = starts;
    let mut steps = vec![FIRST_STEP / (samples as f64).cbrt(); best.len()];
    let mut known: FxHashSet<[u32; 3]> = best.iter().map(|(at, _)| at.map(dyadic)).collect();
    for _ in 0..STEPS {
        let mut tried: Vec<(usize, [f64; 3])> = Vec::new();
        for (number, ((at, _), step)) in best.iter().zip(&steps).enumerate() {
            let around = beside(*at, *step).into_iter().filter(&is_open);
            let new = around.filter(|at| known.insert(at.map(dyadic)));
            tried.extend(new.map(|at| (number, at)));
        }
        let points: Vec<[f64; 3]> = tried.iter().map(|(_, at)| *at).collect();
        let found = find(&points)?;
        let before: Vec<f64> = best.iter().map(|(_, of)| size(of)).collect();
        for ((number, at), of) in tried.into_iter().zip(found) {
            if size(&of) > size(&best[number].1) {
                best[number] = (at, of);
            }
        }
        for ((step, before), (_, of)) in steps.iter_mut().zip(before).zip(&best) {
            if size(of) <= before {
                *step *= 0.5;
            }
        }
    }
    Ok(best)
}

/// The points `step` away from a point along each axis, within the cube.
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
    use core::convert::Infallible;

    #[test]
    fn an_ascent_gets_nearer_to_a_peak_and_asks_for_no_point_twice() {
        let peak = [0.52, 0.47, 0.55];
        let height = |at: &[f64; 3]| {
            let square: f64 = (0..3).map(|k| (at[k] - peak[k]).powi(2)).sum();
            (-square / 0.002).exp()
        };
        let start = [0.5, 0.5, 0.5];
        let mut asked: Vec<[u64; 3]> = Vec::new();
        let find = |points: &[[f64; 3]]| -> Result<Vec<f64>, Infallible> {
            asked.extend(points.iter().map(|at| at.map(f64::to_bits)));
            Ok(points.iter().map(height).collect())
        };
        let starts = vec![(start, height(&start))];
        let found = ascend(starts, 1000, |_| true, |height| *height, find).unwrap();
        assert!(found[0].1 > 1.5 * height(&start), "{found:?}");
        let number = asked.len();
        asked.sort_unstable();
        asked.dedup();
        assert_eq!(asked.len(), number);
        assert!(number <= 6 * STEPS);
    }

    #[test]
    fn what_is_closed_is_not_asked_for() {
        let starts = vec![([0.5; 3], 0.0)];
        let find = |points: &[[f64; 3]]| -> Result<Vec<f64>, Infallible> {
            assert!(points.iter().all(|at| at[0] <= 0.5));
            Ok(points.iter().map(|at| at[0]).collect())
        };
        ascend(starts, 64, |at| at[0] <= 0.5, |height| *height, find).unwrap();
    }
}
