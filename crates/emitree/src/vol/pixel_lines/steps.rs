//! Uniform steps along lines: how many suffice, and the error that they leave.
//!
//! Midpoints of n steps contain those of n/3, so that each line has two integrals; jumps between steps are bisected
//! (`jumps`). Scattered lines that are integrated in far more steps show how many suffice, and how the error of a line
//! follows from the difference of its two integrals.

use crate::exchange::MethodError;
use crate::los::fixed::PlaceOfLine;
use crate::vol::lattice;
use crate::vol::pixel_lines::jumps::{Allowed, Medium, Two};
use std::time::Instant;

/// The numbers of steps that lines may have.
const NUMBERS: [usize; 10] = [9, 15, 21, 27, 45, 63, 81, 135, 189, 243];
/// The steps of scattered lines with which those in fewer steps are compared.
const FINEST: usize = 405;
/// The evaluations on one scattered line if 45 steps suffice.
const OF_A_CHECK: usize = FINEST + 9 + 15 + 21 + 27 + 45;
/// The fewest and the most scattered lines, and the pixels for one of them in between.
const CHECKS: [usize; 2] = [64, 256];
const PIXELS_OF_A_CHECK: usize = 256;
/// The share of the error allowed that steps may leave on a scattered line; and what may be unknown of it.
const OF_STEPS: f64 = 0.25;
const OF_CHECK: f64 = 0.1;
/// The share of the error allowed by which a piece of a line between two steps may change it where g jumps: all lines of a
/// pixel may miss it.
const OF_MISSED: f64 = 1.0;
/// The share of the error allowed that any line may have: one with more has three times as many steps.
const OF_LINE: f64 = 0.5;
/// The most steps of a line, and of a scattered one.
const MOST_STEPS: usize = 6561;
const MOST_STEPS_OF_A_CHECK: usize = FINEST * 9;
/// The share of the scattered lines that may have more steps than the others.
const FEW_OPEN: f64 = 0.25;
/// The share of the scattered lines on which steps may leave larger errors where g jumps.
const FEW: f64 = 1.0 / 64.0;
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

/// The time of an evaluation on a few lines \[s\].
async fn seconds_of_first_lines(
    medium: Medium<'_>,
    place: &PlaceOfLine<'_>,
) -> Result<f64, MethodError> {
    // Of several times the shortest: other programs on the machine only lengthen them.
    let mut each = f64::INFINITY;
    for first in 0..FIRST_BATCHES {
        let place = |line| place(first * FIRST_LINES + line);
        let started = Instant::now();
        // A jump is not looked for on lines of so few steps.
        let any = Allowed::Absolute(f64::INFINITY);
        medium.integrals(&place, FIRST_LINES, NUMBERS[0], any).await?;
        let evaluations = (FIRST_LINES * NUMBERS[0]) as f64;
        each = each.min(started.elapsed().as_secs_f64() / evaluations);
    }
    Ok(each)
}

/// The radiances of scattered lines whose integrals in 405 steps are `found`: in more steps where these leave a larger
/// error than a given one. `None` if there are too many such lines, or too many steps.
async fn exact_radiances(
    medium: Medium<'_>,
    place: &PlaceOfLine<'_>,
    found: &[Two],
    error: f64,
    allowed: Allowed,
) -> Result<Option<Vec<f64>>, MethodError> {
    let mut integrals = found.to_vec();
    let mut steps = FINEST;
    loop {
        let is_open = |&line: &usize| (integrals[line].all - integrals[line].third).abs() > error;
        let open: Vec<usize> = (0..found.len()).filter(is_open).collect();
        if open.is_empty() {
            return Ok(Some(integrals.iter().map(|two| two.all).collect()));
        }
        steps *= 3;
        // Uniform steps converge slowly, or not at all.
        if open.len() as f64 > FEW_OPEN * found.len() as f64 || steps > MOST_STEPS_OF_A_CHECK {
            return Ok(None);
        }
        let of_open = |line: usize| place(open[line]);
        let finer = medium.integrals(&of_open, open.len(), steps, allowed).await?;
        let Some((finer, _)) = finer else { return Ok(None) };
        open.into_iter().zip(finer).for_each(|(line, two)| integrals[line] = two);
    }
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
    /// The same for the bisection of jumps; infinite where there are none.
    allowed_at_jumps: Allowed,
    pub(super) has_jumps: bool,
    /// The change of a line by a piece that lies between two steps.
    pub(super) missed: f64,
    pub(super) checks: Vec<CheckLine>,
    /// The largest |radiance| of a scattered line.
    pub(super) largest: f64,
    /// The time of an evaluation, all threads together \[s\].
    pub(super) seconds: f64,
}

impl Steps {
    /// The fewest steps for a tolerance; `None` if there are none, if all scattered lines are dark, or if
    /// evaluations take so long that the scattered lines took longer than products, or few lines longer than surfaces
    /// and image trees \[s\].
    pub(super) async fn find(
        medium: Medium<'_>,
        tolerance: f64,
        [of_products, of_others]: [f64; 2],
    ) -> Result<Option<Self>, MethodError> {
        let pixels = medium.tile.shape[0] * medium.tile.shape[1];
        let [fewest, most] = CHECKS;
        let count = (pixels / PIXELS_OF_A_CHECK).clamp(fewest, most);
        let [first_steps, _, _, usual_steps, ..] = NUMBERS;
        let lines = pixels / PIXELS_OF_A_LINE;
        let needed =
            FIRST_BATCHES * FIRST_LINES * first_steps + count * OF_A_CHECK + lines * first_steps;
        if !medium.affords(needed) {
            return Ok(None);
        }
        let place = |line: usize| {
            let [x, y, _] = lattice::point(line);
            [x, y]
        };
        let each = seconds_of_first_lines(medium, &place).await?;
        // The scattered lines are most of it. Small batches are slower than large ones, which is on the safe side.
        if each * (count * OF_A_CHECK + lines * usual_steps) as f64 > of_products {
            return Ok(None);
        }
        let mut seconds = f64::INFINITY;
        let mut timed = async |steps: usize, allowed: Allowed| {
            let started = Instant::now();
            let found = medium.integrals(&place, count, steps, allowed).await?;
            seconds = seconds.min(started.elapsed().as_secs_f64() / (count * steps) as f64);
            Ok::<_, MethodError>(found)
        };
        let Some((finest, jumps)) = timed(FINEST, Allowed::OfLargest(OF_LINE * tolerance)).await?
        else {
            return Ok(None);
        };
        let largest = finest.iter().map(|two| two.all.abs()).fold(0.0, f64::max);
        let allowed = tolerance * largest;
        if largest <= 0.0 || !finest.iter().all(|two| two.all.is_finite() && two.third.is_finite())
        {
            return Ok(None);
        }
        let has_jumps = jumps.lines > 0;
        // On lines of few steps, smooth peaks look like jumps.
        let allowed_at_jumps =
            Allowed::Absolute(if has_jumps { OF_LINE * allowed } else { f64::INFINITY });
        let exact =
            exact_radiances(medium, &place, &finest, OF_CHECK * allowed, allowed_at_jumps).await?;
        let Some(exact) = exact else { return Ok(None) };
        // Lines with larger errors have more steps.
        let few = if has_jumps { crate::cell::whole(FEW * count as f64) } else { 0 };
        let mut sufficient = None;
        for number in NUMBERS {
            let Some((found, _)) = timed(number, allowed_at_jumps).await? else { return Ok(None) };
            let error = |(two, exact): (&Two, &f64)| (two.all - exact).abs();
            let errors: Vec<f64> = found.iter().zip(&exact).map(error).collect();
            if errors.iter().filter(|error| **error > OF_STEPS * allowed).count() <= few {
                sufficient = Some((number, found, errors));
                break;
            }
        }
        let Some((number, found, errors)) = sufficient else { return Ok(None) };
        // As many as that a piece of a line beyond a surface that lies between two steps changes it by no more than what
        // is allowed.
        let between_steps = (jumps.largest / (OF_MISSED * allowed)).min(MOST_STEPS as f64);
        let enough = crate::cell::whole(between_steps).div_ceil(3) * 3;
        if seconds * (lines * number.max(enough)) as f64 > of_others {
            return Ok(None);
        }
        let ratio = |(error, two): (&f64, &Two)| {
            error / (two.all - two.third).abs().max(SMALL_DIFFERENCE * allowed)
        };
        let factor = CAUTION * errors.iter().zip(&found).map(ratio).fold(0.0, f64::max);
        let check = |(line, &radiance): (usize, &f64)| CheckLine { place: place(line), radiance };
        Ok(Some(Self {
            number: number.max(enough),
            factor: factor.clamp(LEAST_FACTOR, 1.0),
            allowed: OF_LINE * allowed,
            allowed_at_jumps,
            has_jumps,
            missed: jumps.largest / number.max(enough) as f64,
            checks: exact.iter().enumerate().map(check).collect(),
            largest,
            seconds,
        }))
    }

    /// The radiances of `count` lines in `finer` times as many steps as usual, and in three times as many again where
    /// the error is too large; `None` if the budget does not suffice.
    pub(super) async fn radiances(
        &self,
        medium: Medium<'_>,
        place: &PlaceOfLine<'_>,
        count: usize,
        finer: usize,
    ) -> Result<Option<Vec<LineValue>>, MethodError> {
        let mut values = vec![LineValue::default(); count];
        let mut open: Vec<usize> = (0..count).collect();
        let mut steps = finer * self.number;
        while !open.is_empty() {
            let of_open = |line: usize| place(open[line]);
            let allowed = self.allowed_at_jumps;
            let found = medium.integrals(&of_open, open.len(), steps, allowed).await?;
            let Some((found, _)) = found else { return Ok(None) };
            for (&line, two) in open.iter().zip(&found) {
                let error = self.factor * (two.all - two.third).abs() + two.at_jumps;
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
