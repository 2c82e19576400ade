//! Uniform steps along lines: how many suffice, and the error that they leave.
//!
//! Midpoints of n steps contain those of n/3, so that each line has two integrals. Scattered lines that are
//! integrated in far more steps show how many suffice, and how the error of a line follows from the difference of its two
//! integrals.

use crate::exchange::MethodError;
use crate::los::fixed::{PlaceOfLine, march};
use crate::meter::Meter;
use crate::tile::Tile;
use crate::vol::lattice;
use std::time::Instant;

/// The numbers of steps that lines may have: three times as many each contain those of the number two places before.
const STEPS: [usize; 8] = [9, 15, 27, 45, 81, 135, 243, 405];
/// The evaluations on one scattered line.
const OF_A_CHECK: usize = 405 + 243 + 45 + 27 + 15 + 9;
/// The fewest and the most scattered lines, and the pixels for one of them in between.
const CHECKS: [usize; 2] = [64, 256];
const PIXELS_OF_A_CHECK: usize = 256;
/// The share of the error allowed that steps may leave on a scattered line; and what may be unknown of it.
const OF_STEPS: f64 = 0.15;
const OF_CHECK: f64 = 0.1;
/// The share of the error allowed that any line may have: one with more has three times as many steps.
const OF_LINE: f64 = 0.3;
/// The most steps of a line.
const MOST_STEPS: usize = 6561;
/// The error of a line is its difference times the largest ratio of both on a scattered line, times this.
const CAUTION: f64 = 2.0;
/// The least such factor, and the share of the error allowed below which differences are as good as none.
const LEAST_FACTOR: f64 = 0.05;
const SMALL_DIFFERENCE: f64 = 0.02;
/// The lines of the first look at the cost of an evaluation.
const FIRST_LINES: usize = 64;

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
    /// evaluations take so long that lines through all pixels took longer than `most_seconds`.
    pub(super) async fn find(
        meter: &Meter,
        tile: &Tile<'_>,
        tolerance: f64,
        most_seconds: f64,
    ) -> Result<Option<Self>, MethodError> {
        let pixels = tile.shape[0] * tile.shape[1];
        let [fewest, most] = CHECKS;
        let count = (pixels / PIXELS_OF_A_CHECK).clamp(fewest, most);
        let needed = (FIRST_LINES * STEPS[0] + count * OF_A_CHECK + pixels * STEPS[0]) as u64;
        if needed > meter.evaluations_left() {
            return Ok(None);
        }
        let place = |line: usize| {
            let [x, y, _] = lattice::point(line);
            [x, y]
        };
        let started = Instant::now();
        integrals(meter, tile, &place, FIRST_LINES, STEPS[0]).await?;
        let each = started.elapsed().as_secs_f64() / (FIRST_LINES * STEPS[0]) as f64;
        // A first batch is far from the speed of large ones.
        if each * (pixels * STEPS[2]) as f64 > 4.0 * most_seconds {
            return Ok(None);
        }
        let started = Instant::now();
        let mut of_steps = vec![Vec::new(); STEPS.len()];
        let mut thirds = [Vec::new(), Vec::new()];
        for of in [7, 6, 3, 2, 1, 0] {
            let found = integrals(meter, tile, &place, count, STEPS[of]).await?;
            of_steps[of] = found.iter().map(|two| two.all).collect();
            let third = found.iter().map(|two| two.third).collect();
            match of {
                6 | 7 => of_steps[of - 2] = third,
                0 | 1 => thirds[of] = third,
                _ => {}
            }
        }
        let seconds = started.elapsed().as_secs_f64() / (count * OF_A_CHECK) as f64;
        let exact = &of_steps[7];
        let differ = |a: &[f64], b: &[f64]| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| (a - b).abs()).collect()
        };
        let worst = |of: &[f64]| of.iter().copied().fold(0.0, f64::max);
        let largest = exact.iter().map(|radiance| radiance.abs()).fold(0.0, f64::max);
        let allowed = tolerance * largest;
        if largest.is_nan() || largest <= 0.0 || worst(&differ(exact, &of_steps[5])) > OF_CHECK * allowed {
            return Ok(None);
        }
        let suffices = |of: &usize| worst(&differ(&of_steps[*of], exact)) <= OF_STEPS * allowed;
        let Some(chosen) = (0..STEPS.len() - 1).find(suffices) else { return Ok(None) };
        let number = STEPS[chosen];
        if seconds * (pixels * number) as f64 > most_seconds {
            return Ok(None);
        }
        let third = if chosen < 2 { &thirds[chosen] } else { &of_steps[chosen - 2] };
        let differences = differ(&of_steps[chosen], third);
        let errors = differ(&of_steps[chosen], exact);
        let ratio = |(error, difference): (&f64, &f64)| {
            error / difference.max(SMALL_DIFFERENCE * allowed)
        };
        let factor = CAUTION * errors.iter().zip(&differences).map(ratio).fold(0.0, f64::max);
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

    /// The radiances of `count` lines in `finer` times as many steps as usual, and in three times as many again where the
    /// error is too large; `None` if the budget does not suffice.
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
