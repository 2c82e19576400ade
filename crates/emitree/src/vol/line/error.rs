//! The error of a line of sight, and the depths to be sampled next: one step of its refinement.
//!
//! The detail d of a sample of level l is its difference from the polynomial through coarser
//! samples; its effect on the integral is d · 2^−l. The error that remains around a sample is its
//! significance, a mean of the effects nearby, times the decay observed between levels. Jumps are
//! bisected, the largest first. The segments between jumps end at samples of any level, and nothing
//! is extrapolated beyond them.

use crate::vol::dyadic::{
    DEEPEST_LEVEL, beside, coarsest_between, level_of, polynomial, spacing, unit,
};
use crate::vol::line::Line;
use crate::vol::line::memo::Memo;
use crate::vol::tuning::TUNING;

/// A change below this share of the largest |rate| is rounding and no jump, at any length of the
/// interval.
const NO_STEP: f64 = 1e-7;
/// The smallest tolerance of a line, relative to its ∫ |G| dz. A line that is far brighter than the
/// image was thought to be would otherwise be refined down to rounding.
const ROUNDING: f64 = 1e-12;
/// The level of the finest samples: no deeper ones are added.
const FINEST_LEVEL: u8 = DEEPEST_LEVEL - 2;

impl Line {
    /// Integrates, estimates the error, and returns the depths to be sampled for an error of
    /// `tolerance`, in ascending order; none if it is met.
    ///
    /// The line has all depths of `base_level`. An interval longer than half of their spacing may
    /// be steep without a jump.
    pub(crate) fn assess(&mut self, tolerance: f64, base_level: u8) -> Vec<u32> {
        self.find_jumps(tolerance, base_level);
        self.integrate();
        let tolerance = tolerance.max(ROUNDING * self.brightness());
        self.find_significances();
        let mut remaining = self.remaining(base_level);
        let total: f64 = remaining.iter().map(|of| of.error).sum();
        let out_of_reach = self.out_of_reach();
        let mut wanted = self.inside_short_segments(tolerance);
        if !wanted.is_empty() {
            // The integral of each of these segments is assumed to be at most that of the line.
            self.error = total + out_of_reach + self.brightness();
            return wanted;
        }
        let mut error = total;
        while error > tolerance && wanted.is_empty() {
            let largest = remaining.iter().map(|of| of.error).fold(0.0, f64::max);
            if largest <= 0.0 {
                break;
            }
            let least = (TUNING.line.batch_share * largest).min(TUNING.line.negligible * tolerance);
            let mut expected = error;
            for of in &mut remaining {
                if let Place::Sample(_) = of.place
                    && of.error > least
                {
                    error -= of.error;
                    expected -= of.error;
                    of.error = 0.0;
                    self.add_missing_depths(of.place, &mut wanted);
                }
            }
            let is_jump = |of: &&mut Remaining| matches!(of.place, Place::Interval(_));
            let mut jumps: Vec<&mut Remaining> = remaining.iter_mut().filter(is_jump).collect();
            jumps.sort_by(|a, b| b.error.total_cmp(&a.error));
            for of in jumps {
                if expected <= TUNING.line.bisection_goal * tolerance || of.error <= 0.0 {
                    break;
                }
                error -= of.error;
                expected -= TUNING.line.bisection_gain * of.error;
                of.error = 0.0;
                self.add_missing_depths(of.place, &mut wanted);
            }
        }
        // The error includes what these depths would reduce: the budget may end before they are
        // sampled.
        self.error = total + out_of_reach;
        wanted.sort_unstable();
        wanted.dedup();
        wanted
    }

    /// The error that remains between samples of the finest level. It is large where G has no
    /// finite integral.
    fn out_of_reach(&self) -> f64 {
        let finest = self.samples.iter().filter(|sample| sample.level >= FINEST_LEVEL);
        finest.map(|sample| sample.significance).sum()
    }

    /// A depth inside each segment of two samples whose integral may matter.
    fn inside_short_segments(&self, tolerance: f64) -> Vec<u32> {
        let is_short = |&i: &usize| {
            let between_jumps = i > 0 && i + 1 < self.jumps.len();
            between_jumps && self.jumps[i - 1] && !self.jumps[i] && self.jumps[i + 1]
        };
        let depth = |i: usize| {
            let (below, above) = (&self.samples[i], &self.samples[i + 1]);
            let length = above.depth - below.depth;
            let most = self.length(i) * below.rate.abs().max(above.rate.abs());
            let matters =
                length >= TUNING.line.least_length && most > TUNING.line.short_segment * tolerance;
            matters.then(|| coarsest_between(below.depth + length / 4, above.depth - length / 4))
        };
        (0..self.jumps.len()).filter(is_short).filter_map(depth).collect()
    }

    fn find_jumps(&mut self, tolerance: f64, base_level: u8) {
        let longest = spacing(base_level + 1);
        let largest = self.samples.iter().map(|sample| sample.rate.abs()).fold(0.0, f64::max);
        let intervals = self.samples.len().saturating_sub(1);
        let slope = |k: usize| self.step(k).abs() / self.length(k);
        let slopes: Vec<f64> = (0..intervals).map(slope).collect();
        let is_jump = |i: usize| {
            let (length, step) = (self.length(i), self.step(i).abs());
            let steps = self.samples[i + 1].depth - self.samples[i].depth;
            let is_negligible = step * length < TUNING.line.least_jump * tolerance
                && length >= TUNING.line.always_tested_length;
            if steps > longest || step < NO_STEP * largest || is_negligible {
                return false;
            }
            let below = if i > 0 { slopes[i - 1] } else { 0.0 };
            let above = if i + 1 < intervals { slopes[i + 1] } else { 0.0 };
            step > TUNING.line.jump_steepness * length * (below + above)
        };
        self.jumps = (0..intervals).map(is_jump).collect();
    }

    /// Updates the detail of sample `i`: its difference from the polynomial through coarser samples
    /// around it.
    fn update_detail(&mut self, i: usize) {
        let ([below, above], [from_below, from_above]) = self.predictors(i);
        let chosen = || below[..from_below].iter().chain(&above[..from_above]).copied();
        let detail = || {
            let points = self.points(chosen());
            self.samples[i].rate - polynomial(points.as_slice(), self.z(i))
        };
        let mut memo = self.samples[i].detail;
        if from_below + from_above == 0 {
            memo = Memo::default();
        } else {
            memo.update(self.depths(chosen()), detail);
        }
        self.samples[i].detail = memo;
    }

    /// The coarser samples that may predict sample `i`, below it and above it, the nearest first,
    /// and how many of each are used.
    fn predictors(&self, i: usize) -> ([[usize; 4]; 2], [usize; 2]) {
        let level = self.samples[i].level;
        let coarser = |k: &usize| self.samples[*k].level < level || self.is_beside_jump(*k);
        // Up to four on each side: the fourth replaces one that the other side lacks.
        let below = (0..i).rev().take_while(|&k| !self.jumps[k]).filter(coarser);
        let above = (i + 1..self.samples.len()).take_while(|&k| !self.jumps[k - 1]);
        let ((below, b), (above, a)) = (first_four(below), first_four(above.filter(coarser)));
        let chosen = match (b, a) {
            (b, a) if b >= TUNING.line.predictors && a >= TUNING.line.predictors => {
                [TUNING.line.predictors, TUNING.line.predictors]
            }
            (b, a) if b + a < 4 => [b, a],
            (b, a) if b < TUNING.line.predictors && b <= a => [b, 4 - b],
            (_, a) => [4 - a, a],
        };
        ([below, above], chosen)
    }

    /// The length over which the detail of sample `i` changes the integral.
    fn reach(&self, i: usize) -> f64 {
        let usual = unit(spacing(self.samples[i].level));
        let at_end = self.is_beside_jump(i - 1) || self.is_beside_jump(i + 1);
        if !at_end {
            return usual;
        }
        let smooth = |k: usize| if self.jumps[k] { 0.0 } else { self.length(k) };
        usual.min(TUNING.line.effect_at_end * (smooth(i - 1) + smooth(i)))
    }

    fn find_significances(&mut self) {
        for i in 0..self.samples.len() {
            if self.samples[i].level > 0 {
                self.update_detail(i);
            }
        }
        let effect = |i: usize| match self.samples[i].level {
            0 => 0.0,
            _ => self.samples[i].detail.value * self.reach(i),
        };
        let effects: Vec<f64> = (0..self.samples.len()).map(effect).collect();
        for i in 0..self.samples.len() {
            let (depth, level) = (self.samples[i].depth, self.samples[i].level);
            if level == 0 {
                continue;
            }
            // Neighbours of the same level are two of its spacings away; beyond an end their effect
            // is mirrored.
            let of_neighbour = |up: bool| match beside(depth, 2 * spacing(level), up) {
                Some(neighbour) if level_of(neighbour) == level => {
                    self.find_near(i, neighbour).map_or(0.0, |k| effects[k])
                }
                _ => effects[i],
            };
            let neighbours = [of_neighbour(false), of_neighbour(true)];
            let sum = 0.5 * effects[i] + 0.25 * (neighbours[0] + neighbours[1]);
            let sizes = 0.5 * effects[i].abs() + 0.25 * (neighbours[0].abs() + neighbours[1].abs());
            self.samples[i].significance = sum.abs() + TUNING.line.cancellation_guard * sizes;
        }
    }

    /// The remaining errors around samples and in intervals with jumps. Marks the samples with both
    /// halves sampled.
    fn remaining(&mut self, base_level: u8) -> Vec<Remaining> {
        let mut remaining = Vec::new();
        for i in 0..self.samples.len() {
            if self.jumps.get(i).copied().unwrap_or(false) {
                let error = TUNING.line.jump_error * self.length(i) * self.step(i).abs();
                remaining.push(Remaining { place: Place::Interval(i), error });
            }
            let sample = self.samples[i];
            if sample.level < base_level.max(1) || sample.level >= FINEST_LEVEL {
                continue;
            }
            let [below, above] = self.missing_halves(i);
            self.samples[i].opened = below.is_none() && above.is_none();
            if below.is_none() && above.is_none() {
                continue;
            }
            let error = sample.significance * self.decay(i, base_level);
            remaining.push(Remaining { place: Place::Sample(i), error });
        }
        remaining
    }

    /// The middles of the halves beside sample `i` (not an end of the line) that have not been
    /// sampled and are on its segment.
    fn missing_halves(&self, i: usize) -> [Option<u32>; 2] {
        if self.is_beside_jump(i) {
            return [None; 2];
        }
        let depth = self.samples[i].depth;
        let half = spacing(self.samples[i].level + 1);
        let missing = |up, neighbour: usize| {
            let beyond_end = self.is_beside_jump(neighbour)
                && self.samples[neighbour].depth.abs_diff(depth) <= half;
            beside(depth, half, up).filter(|&d| !beyond_end && self.find_near(i, d).is_none())
        };
        [missing(false, i - 1), missing(true, i + 1)]
    }

    /// The share of the significance of sample `i` that is expected to remain.
    fn decay(&self, i: usize, base_level: u8) -> f64 {
        let sample = self.samples[i];
        if sample.level <= base_level {
            return 1.0;
        }
        let of_parent = |up| {
            let parent = beside(sample.depth, spacing(sample.level), up)?;
            let is_parent = level_of(parent) + 1 == sample.level;
            let k = self.find_near(i, parent).filter(|_| is_parent)?;
            Some(self.samples[k].significance)
        };
        let coarser = [false, true].into_iter().filter_map(of_parent).fold(0.0, f64::max);
        (TUNING.line.decay_margin * sample.significance / (coarser + f64::MIN_POSITIVE))
            .clamp(TUNING.line.least_decay, 1.0)
    }

    /// Adds the depths that reduce the remaining error at a place.
    fn add_missing_depths(&self, place: Place, wanted: &mut Vec<u32>) {
        match place {
            Place::Interval(i) => {
                let (from, to) = (self.samples[i].depth, self.samples[i + 1].depth);
                if to - from >= 4 {
                    wanted.push(from + (to - from) / 2);
                }
            }
            Place::Sample(i) => {
                let [below, above] = self.missing_halves(i);
                wanted.extend(below.into_iter().chain(above));
            }
        }
    }
}

/// The first four of some numbers, and how many there are.
fn first_four(numbers: impl Iterator<Item = usize>) -> ([usize; 4], usize) {
    let (mut first, mut count) = ([0; 4], 0);
    for (entry, number) in first.iter_mut().zip(numbers) {
        *entry = number;
        count += 1;
    }
    (first, count)
}

/// A place on a line where an error may remain.
#[derive(Clone, Copy, Debug)]
enum Place {
    Sample(usize),
    /// The interval from this sample to the next, which has a jump.
    Interval(usize),
}

#[derive(Clone, Copy, Debug)]
struct Remaining {
    place: Place,
    error: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::dyadic::unit;

    const BASE_LEVEL: u8 = 3;

    /// Refines a line with the rate `rate` to `tolerance`.
    fn refined(rate: impl Fn(f64) -> f64, tolerance: f64) -> Line {
        let mut line = Line::default();
        let mut wanted: Vec<u32> = (0..=8).map(|k| k * spacing(BASE_LEVEL)).collect();
        while !wanted.is_empty() {
            line.add(wanted.iter().map(|&depth| (depth, rate(unit(depth)))));
            wanted = line.assess(tolerance, BASE_LEVEL);
        }
        line
    }

    #[test]
    fn a_peak_costs_few_samples_and_its_error_is_covered() {
        let width = 0.05;
        let peak = |z: f64| (-((z - 0.4) / width).powi(2)).exp();
        let exact = width * core::f64::consts::PI.sqrt();
        let cost = [1e-2, 1e-4, 1e-6, 1e-8].map(|tolerance| {
            let line = refined(peak, tolerance * exact);
            assert!((line.integral - exact).abs() <= line.error, "{tolerance}: {}", line.integral);
            assert!(line.error <= tolerance * exact);
            line.samples.len()
        });
        assert_eq!(cost, [39, 67, 125, 263]);
    }

    #[test]
    fn a_jump_costs_one_sample_for_each_factor_of_two() {
        let step = |z: f64| if z < 0.3 { 1.0 } else { 0.25 };
        let exact = 0.3 + 0.7 * 0.25;
        let cost = [1e-3, 1e-4, 1e-5].map(|tolerance| {
            let line = refined(step, tolerance);
            assert!((line.integral - exact).abs() <= tolerance, "{}", line.integral);
            line.samples.len()
        });
        assert_eq!(cost, [23, 26, 30]);
    }

    #[test]
    fn a_quadratic_is_integrated_exactly_by_the_base_depths() {
        let line = refined(|z| z * z, 1e-9);
        assert_eq!(line.samples.len(), 9);
        assert!((line.integral - 1.0 / 3.0).abs() < 1e-15);
        assert!(line.error < 1e-15);
    }

    #[test]
    fn an_integral_that_is_infinite_has_no_small_error() {
        for power in [1, 2, 3] {
            let line = refined(|z| if z < 1.0 { (1.0 - z).powi(-power) } else { 0.0 }, 1e-3);
            assert!(line.error > 0.02 * line.integral, "{power}: {} {}", line.error, line.integral);
        }
    }

    #[test]
    fn a_single_deviating_sample_is_resolved() {
        // One base depth is 0.002 away from the middle of a knot of width 0.004.
        let knot = |z: f64| 1.0 + 50.0 * (-((z - 0.377) / 0.004).powi(2)).exp();
        let exact = 1.0 + 50.0 * 0.004 * core::f64::consts::PI.sqrt();
        let line = refined(knot, 1e-3);
        assert!((line.integral - exact).abs() < 1e-3, "{}", line.integral);
    }
}
