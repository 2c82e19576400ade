//! Uniform steps along lines: how many suffice, and the error that they leave.
//!
//! Midpoints of n steps contain those of n/3, so that each line has two integrals. Scattered lines that are
//! integrated in far more steps show how many suffice, and how the error of a line follows from the difference of its
//! two integrals.

use crate::exchange::MethodError;
use crate::los::fixed::{PlaceOfLine, march};
use crate::meter::Meter;
use crate::tile::Tile;
use crate::vol::lattice;
use std::time::Instant;

/// The numbers of steps that lines may have.
const NUMBERS: [usize; 10] = [9, 15, 21, 27, 45, 63, 81, 135, 189, 243];
/// The numbers of steps in which scattered lines are integrated, the finest first: with their thirds they are all
/// `NUMBERS` and the thirds of these.
const INTEGRATED: [usize; 8] = [405, 243, 189, 45, 27, 21, 15, 9];
/// The evaluations on one scattered line.
const OF_A_CHECK: usize = 405 + 243 + 189 + 45 + 27 + 21 + 15 + 9;
/// The fewest and the most scattered lines, and the pixels for one of them in between.
const CHECKS: [usize; 2] = [64, 256];
const PIXELS_OF_A_CHECK: usize = 256;
/// The share of the error allowed that steps may leave on a scattered line; and what may be unknown of it.
const OF_STEPS: f64 = 0.25;
const OF_CHECK: f64 = 0.1;
/// The share of the error allowed that any line may have: one with more has three times as many steps.
const OF_LINE: f64 = 0.5;
/// The most steps of a line.
const MOST_STEPS: usize = 6561;
/// The error of a line is its difference times the largest ratio of both on a scattered line, times this.
const CAUTION: f64 = 2.0;
/// The least such factor, and the share of the error allowed below which differences are as good as none.
const LEAST_FACTOR: f64 = 0.05;
const SMALL_DIFFERENCE: f64 = 0.02;
/// The pixels for one line where these are few: an image of large blocks.
const PIXELS_OF_A_LINE: usize = 16;
/// The batches that are timed first and the lines in each.
const FIRST_BATCHES: usize = 3;
const FIRST_LINES: usize = 24;

/// The radiance of a line and its estimated error.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LineValue {
    pub(super) radiance: f64,
    pub(super) error: f64,
}

/// A line whose radiance is known better than those of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct CheckLine {
    pub(super) place: [f64; 2],
    pub(super) radiance: f64,
}

/// The integrals of a line by all steps and by a third of them.
#[derive(Clone, Copy, Debug, Default)]
struct Two {
    all: f64,
    third: f64,
}

/// The integrals of `count` lines in so many steps, a multiple of 3.
async fn integrals(
    meter: &Meter,
    tile: &Tile<'_>,
    place: &PlaceOfLine<'_>,
    count: usize,
    steps: usize,
) -> Result<Vec<Two>, MethodError> {
    let mut found = vec![Two::default(); count];
    let width = 1.0 / steps as f64;
    let add = |of: &mut Two, first: usize, rates: &[f64]| {
        let third = rates.iter().zip(first..).filter(|(_, step)| step % 3 == 1);
        of.all += width * rates.iter().sum::<f64>();
        of.third += 3.0 * width * third.map(|(rate, _)| rate).sum::<f64>();
    };
    march(meter, tile, place, steps, None, &mut found, add).await?;
    Ok(found)
}

/// The radiances of lines in so many steps, among those that have been `found`.
fn radiances_in(found: &[Vec<Two>], steps: usize) -> Vec<f64> {
    let numbered = INTEGRATED.iter().zip(found);
    let all = numbered.clone().find(|(of, _)| **of == steps).map(|(_, found)| found);
    let third = numbered.into_iter().find(|(of, _)| **of == 3 * steps).map(|(_, found)| found);
    match (all, third) {
        (Some(found), _) => found.iter().map(|two| two.all).collect(),
        (None, Some(found)) => found.iter().map(|two| two.third).collect(),
        (None, None) => Vec::new(),
    }
}

fn differences(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).collect()
}

fn largest_of(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |largest: f64, number| largest.max(number.abs()))
}

/// How lines are integrated.
#[derive(Debug)]
pub(super) struct Steps {
    /// Uniform steps of most lines.
    pub(super) number: usize,
    /// The error of a line over the difference of its two integrals.
    factor: f64,
    /// The error allowed in a line.
    allowed: f64,
    pub(super) checks: Vec<CheckLine>,
    /// The largest |radiance| of a scattered line.
    pub(super) largest: f64,
    /// The time of an evaluation, all threads together \[s\].
    pub(super) seconds: f64,
}

impl Steps {
    /// The fewest steps for a tolerance; `None` if there are none, if all scattered lines are dark, or if
    /// evaluations take so long that even few lines took longer than `most_seconds`.
    pub(super) async fn find(
        meter: &Meter,
        tile: &Tile<'_>,
        tolerance: f64,
        most_seconds: f64,
    ) -> Result<Option<Self>, MethodError> {
        let pixels = tile.shape[0] * tile.shape[1];
        let [fewest, most] = CHECKS;
        let count = (pixels / PIXELS_OF_A_CHECK).clamp(fewest, most);
        let [first_steps, _, _, usual_steps, ..] = NUMBERS;
        let lines = pixels / PIXELS_OF_A_LINE;
        let needed =
            FIRST_BATCHES * FIRST_LINES * first_steps + count * OF_A_CHECK + lines * first_steps;
        if needed as u64 > meter.evaluations_left() {
            return Ok(None);
        }
        let place = |line: usize| {
            let [x, y, _] = lattice::point(line);
            [x, y]
        };
        // Of several times the shortest: other programs on the machine only lengthen them.
        let mut each = f64::INFINITY;
        for first in 0..FIRST_BATCHES {
            let place = |line| place(first * FIRST_LINES + line);
            let started = Instant::now();
            integrals(meter, tile, &place, FIRST_LINES, first_steps).await?;
            let evaluations = (FIRST_LINES * first_steps) as f64;
            each = each.min(started.elapsed().as_secs_f64() / evaluations);
        }
        // The scattered lines are most of it. Small batches are slower than large ones, which is on the safe side.
        if each * (count * OF_A_CHECK + lines * usual_steps) as f64 > most_seconds {
            return Ok(None);
        }
        let mut seconds = f64::INFINITY;
        let mut found = Vec::with_capacity(INTEGRATED.len());
        for steps in INTEGRATED {
            let started = Instant::now();
            found.push(integrals(meter, tile, &place, count, steps).await?);
            seconds = seconds.min(started.elapsed().as_secs_f64() / (count * steps) as f64);
        }
        let exact: Vec<f64> = found[0].iter().map(|two| two.all).collect();
        let largest = largest_of(&exact);
        let allowed = tolerance * largest;
        let of_third = differences(&exact, &radiances_in(&found, INTEGRATED[0] / 3));
        if largest.is_nan() || largest <= 0.0 || largest_of(&of_third) > OF_CHECK * allowed {
            return Ok(None);
        }
        let suffices = |steps: &usize| {
            largest_of(&differences(&radiances_in(&found, *steps), &exact)) <= OF_STEPS * allowed
        };
        let Some(number) = NUMBERS.into_iter().find(suffices) else { return Ok(None) };
        if seconds * (lines * number) as f64 > most_seconds {
            return Ok(None);
        }
        let radiances = radiances_in(&found, number);
        let errors = differences(&radiances, &exact);
        let of_thirds = differences(&radiances, &radiances_in(&found, number / 3));
        let ratio =
            |(error, difference): (&f64, &f64)| error / difference.max(SMALL_DIFFERENCE * allowed);
        let factor = CAUTION * errors.iter().zip(&of_thirds).map(ratio).fold(0.0, f64::max);
        let check = |(line, &radiance): (usize, &f64)| CheckLine { place: place(line), radiance };
        Ok(Some(Self {
            number,
            factor: factor.clamp(LEAST_FACTOR, 1.0),
            allowed: OF_LINE * allowed,
            checks: exact.iter().enumerate().map(check).collect(),
            largest,
            seconds,
        }))
    }

    /// The radiances of `count` lines in `finer` times as many steps as usual, and in three times as many again where
    /// the error is too large; `None` if the budget does not suffice.
    pub(super) async fn radiances(
        &self,
        meter: &Meter,
        tile: &Tile<'_>,
        place: &PlaceOfLine<'_>,
        count: usize,
        finer: usize,
    ) -> Result<Option<Vec<LineValue>>, MethodError> {
        let mut values = vec![LineValue::default(); count];
        let mut open: Vec<usize> = (0..count).collect();
        let mut steps = finer * self.number;
        while !open.is_empty() {
            if (open.len() * steps) as u64 > meter.evaluations_left() {
                return Ok(None);
            }
            let of_open = |line: usize| place(open[line]);
            let found = integrals(meter, tile, &of_open, open.len(), steps).await?;
            for (&line, two) in open.iter().zip(&found) {
                let error = self.factor * (two.all - two.third).abs();
                values[line] = LineValue { radiance: two.all, error };
            }
            steps *= 3;
            if steps > MOST_STEPS {
                break;
            }
            open.retain(|line| values[*line].error > self.allowed);
        }
        Ok(Some(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_numbers_of_steps_and_their_thirds_follow_from_the_integrated_ones() {
        let found: Vec<Vec<Two>> = INTEGRATED
            .iter()
            .map(|&steps| vec![Two { all: steps as f64, third: (steps / 3) as f64 }])
            .collect();
        for steps in NUMBERS.into_iter().flat_map(|steps| [steps, steps / 3]) {
            assert_eq!(radiances_in(&found, steps), [steps as f64], "{steps}");
        }
        assert_eq!(OF_A_CHECK, INTEGRATED.iter().sum::<usize>());
    }
}
