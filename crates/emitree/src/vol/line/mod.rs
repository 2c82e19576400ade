//! A line of sight: samples of G at nested dyadic depths, and their integral.
//!
//! Between jumps G is assumed to be smooth: each interval has the integral of the polynomial
//! through the nearest six samples that no jump separates from it. On uniformly spaced samples the
//! weights add up to the trapezoidal rule, which converges spectrally for a peak away from the ends
//! (Trefethen & Weideman 2014, doi:10.1137/130932132).

pub(crate) mod error;
mod fixed;
pub(crate) mod jumps;
pub(crate) mod memo;
pub(crate) mod neighbours;
pub(crate) mod node_lines;
pub(crate) mod profile;
pub(crate) mod tracking;

use crate::vol::dyadic::{GAUSS, STENCIL, level_of, polynomial, unit};
use crate::vol::line::memo::{Depths, Memo, depths};
use crate::vol::tuning::TUNING;
use core::ops::Range;

/// G at one depth of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// The depth, a dyadic place on the line.
    pub(crate) depth: u32,
    pub(crate) level: u8,
    /// G = g · ds/dz there.
    pub(crate) rate: f64,
    /// The effect of the detail on the integral, averaged with those of the neighbours.
    pub(crate) significance: f64,
    /// Whether both halves beside the sample have been sampled.
    pub(crate) opened: bool,
    /// The difference of the sample from its prediction.
    pub(crate) detail: Memo,
    /// ∫ G dz from this sample to the next, if there is no jump between them.
    integral: Memo,
}

/// Samples along one line of sight, in the order of their depths.
#[derive(Clone, Debug, Default)]
pub(crate) struct Line {
    pub(crate) samples: Vec<Sample>,
    /// For each interval between samples, whether it has a jump.
    pub(crate) jumps: Vec<bool>,
    /// ∫ G dz over the line.
    pub(crate) integral: f64,
    /// The estimated |error| of the integral.
    pub(crate) error: f64,
}

/// The number of samples of a polynomial at the end of a segment: extrapolation needs a lower
/// degree.
const ONE_SIDED: usize = 4;

impl Line {
    /// The index of the sample at `depth`, or that of its insertion.
    pub(crate) fn find(&self, depth: u32) -> Result<usize, usize> {
        self.samples.binary_search_by_key(&depth, |sample| sample.depth)
    }

    /// The sample at `depth`, if there is one, searched for outwards from sample `i`.
    pub(crate) fn find_near(&self, i: usize, depth: u32) -> Option<usize> {
        let is_below = |k: usize| self.samples[k].depth < depth;
        let (mut from, mut to, mut stride) = (i, i + 1, 1);
        if is_below(i) {
            while to < self.samples.len() && is_below(to) {
                (from, to, stride) = (to, to + stride, 2 * stride);
            }
        } else {
            while from > 0 && !is_below(from) {
                (from, to, stride) = (from.saturating_sub(stride), from + 1, 2 * stride);
            }
        }
        let among = &self.samples[from..(to + 1).min(self.samples.len())];
        among.binary_search_by_key(&depth, |sample| sample.depth).ok().map(|k| from + k)
    }

    pub(crate) fn has(&self, depth: u32) -> bool {
        self.find(depth).is_ok()
    }

    /// Adds samples (depth, rate) at new depths.
    pub(crate) fn add(&mut self, new: impl IntoIterator<Item = (u32, f64)>) {
        for (depth, rate) in new {
            let Err(i) = self.find(depth) else { continue };
            let level = level_of(depth);
            let (detail, integral) = (Memo::default(), Memo::default());
            let (significance, opened) = (0.0, false);
            let sample = Sample { depth, level, rate, significance, opened, detail, integral };
            self.samples.insert(i, sample);
            // Both parts of an interval with a jump count as jumps until the line is assessed
            // again.
            let divided = i.saturating_sub(1).min(self.jumps.len().saturating_sub(1));
            let jump = self.jumps.get(divided).copied().unwrap_or(false);
            if self.samples.len() > 1 {
                self.jumps.insert(divided.min(self.jumps.len()), jump);
            }
        }
    }

    /// The depth of sample `i` as a fraction of the line.
    pub(crate) fn z(&self, i: usize) -> f64 {
        unit(self.samples[i].depth)
    }

    /// Length of the interval between samples `i` and `i` + 1, as a fraction of the line.
    pub(crate) fn length(&self, i: usize) -> f64 {
        unit(self.samples[i + 1].depth - self.samples[i].depth)
    }

    /// The change of G from sample `i` to the next.
    pub(crate) fn step(&self, i: usize) -> f64 {
        self.samples[i + 1].rate - self.samples[i].rate
    }

    /// Whether one of the five intervals on either side of sample `i` has a jump.
    pub(crate) fn is_near_jump(&self, i: usize) -> bool {
        let near = i.saturating_sub(5)..(i + 5).min(self.jumps.len());
        self.jumps[near].contains(&true)
    }

    /// Whether sample `i` is beside a jump whose interval is resolved: such samples are ends of
    /// smooth segments.
    pub(crate) fn is_beside_jump(&self, i: usize) -> bool {
        let beside = i.saturating_sub(1)..(i + 1).min(self.jumps.len());
        beside.into_iter().any(|k| self.jumps[k] && self.length(k) <= TUNING.line.resolved_interval)
    }

    /// Whether there is a jump in an interval of at most `length` steps.
    pub(crate) fn has_jump_within(&self, length: u32) -> bool {
        let intervals = self.samples.windows(2).zip(&self.jumps);
        intervals.into_iter().any(|(ends, &jump)| jump && ends[1].depth - ends[0].depth <= length)
    }

    /// The samples around sample `i` that no jump separates from it, at most [`STENCIL`] on each
    /// side.
    fn smooth_around(&self, i: usize) -> Range<usize> {
        let (mut from, mut to) = (i, i);
        while from > 0 && i - from < STENCIL && !self.jumps[from - 1] {
            from -= 1;
        }
        while to + 1 < self.samples.len() && to - i < STENCIL && !self.jumps[to] {
            to += 1;
        }
        from..to + 1
    }

    /// The samples of the polynomial that represents G between samples `i` and `i` + 1.
    fn stencil(&self, i: usize) -> Range<usize> {
        let smooth = self.smooth_around(i);
        let at_end = i == smooth.start || i + 2 == smooth.end;
        let count = smooth.len().min(if at_end { ONE_SIDED } else { STENCIL });
        let first = (i + 1).saturating_sub(count / 2).clamp(smooth.start, smooth.end - count);
        first..first + count
    }

    /// At most [`STENCIL`] samples as points (z, G).
    pub(crate) fn points(&self, of: impl Iterator<Item = usize>) -> Points {
        let mut points = Points { all: [(0.0, 0.0); STENCIL], count: 0 };
        of.for_each(|k| {
            points.all[points.count] = (self.z(k), self.samples[k].rate);
            points.count += 1;
        });
        points
    }

    /// The depths of at most [`STENCIL`] samples.
    pub(crate) fn depths(&self, of: impl Iterator<Item = usize>) -> Depths {
        depths(of.map(|k| self.samples[k].depth))
    }

    /// G at any depth of the line, sampled or interpolated.
    pub(crate) fn rate(&self, depth: u32) -> f64 {
        match self.find(depth) {
            Ok(i) => self.samples[i].rate,
            Err(0) => self.samples.first().map_or(0.0, |sample| sample.rate),
            Err(after) if after == self.samples.len() => self.samples[after - 1].rate,
            Err(after) => {
                let i = after - 1;
                if self.jumps[i] {
                    return 0.5 * (self.samples[i].rate + self.samples[after].rate);
                }
                polynomial(self.points(self.stencil(i)).as_slice(), unit(depth))
            }
        }
    }

    /// ∫ |G| dz by the trapezoidal rule.
    pub(crate) fn brightness(&self) -> f64 {
        let of_interval = |i: usize| {
            0.5 * self.length(i) * (self.samples[i].rate.abs() + self.samples[i + 1].rate.abs())
        };
        (0..self.samples.len().saturating_sub(1)).map(of_interval).sum()
    }

    /// Computes ∫ G dz from the samples, with the trapezoidal rule on intervals with a jump.
    pub(crate) fn integrate(&mut self) {
        let intervals = self.samples.len().saturating_sub(1);
        for i in 0..intervals {
            if self.jumps[i] {
                continue;
            }
            let stencil = self.stencil(i);
            let mut memo = self.samples[i].integral;
            memo.update(self.depths(stencil.clone()), || self.integral_of(i, stencil));
            self.samples[i].integral = memo;
        }
        let of_interval = |i: usize| match self.jumps[i] {
            true => self.trapezoid(i),
            false => self.samples[i].integral.value,
        };
        self.integral = (0..intervals).map(of_interval).sum();
    }

    /// The weights of the samples in ∫ G dz, in the order of their depths: those of the polynomials and
    /// trapezoids of [`integrate`](Self::integrate).
    pub(crate) fn weights(&self) -> Vec<f64> {
        let mut weights = vec![0.0; self.samples.len()];
        for i in 0..self.samples.len().saturating_sub(1) {
            let length = self.length(i);
            let stencil = (!self.jumps[i]).then(|| self.stencil(i));
            let is_used = |of: &Range<usize>| self.polynomial_integral(i, of.clone()).is_some();
            let Some(stencil) = stencil.filter(is_used) else {
                weights[i] += 0.5 * length;
                weights[i + 1] += 0.5 * length;
                continue;
            };
            let z: Vec<f64> = stencil.clone().map(|k| self.z(k)).collect();
            for (own, k) in stencil.enumerate() {
                let cardinal = |j: usize| (z[j], f64::from(u8::from(j == own)));
                let cardinal: Vec<(f64, f64)> = (0..z.len()).map(cardinal).collect();
                let at = |t: f64| polynomial(&cardinal, self.z(i) + t * length);
                weights[k] += GAUSS.iter().map(|&(t, gauss)| gauss * at(t)).sum::<f64>() * length;
            }
        }
        weights
    }

    fn trapezoid(&self, i: usize) -> f64 {
        self.length(i) * 0.5 * (self.samples[i].rate + self.samples[i + 1].rate)
    }

    /// ∫ G dz from sample `i` to the next, by the polynomial through the samples of `stencil` if possible.
    fn integral_of(&self, i: usize, stencil: Range<usize>) -> f64 {
        self.polynomial_integral(i, stencil).unwrap_or_else(|| self.trapezoid(i))
    }

    /// ∫ dz of the polynomial through the samples of `stencil` from sample `i` to the next; `None` if the
    /// trapezoid replaces it.
    fn polynomial_integral(&self, i: usize, stencil: Range<usize>) -> Option<f64> {
        let (length, trapezoid) = (self.length(i), self.trapezoid(i));
        let points = self.points(stencil);
        let points = points.as_slice();
        let at = |t: f64| polynomial(points, self.z(i) + t * length);
        let integral = GAUSS.iter().map(|&(t, weight)| weight * at(t)).sum::<f64>() * length;
        // On uneven samples the polynomial may oscillate: its deviation from the trapezoid is
        // limited by the range of the samples.
        let rates = || points.iter().map(|point| point.1);
        let range =
            rates().fold(f64::NEG_INFINITY, f64::max) - rates().fold(f64::INFINITY, f64::min);
        // NaN, of rates beyond all numbers, is kept.
        let deviates = (integral - trapezoid).abs() > length * range;
        (!deviates).then_some(integral)
    }
}

/// A few points (z, G) of a line.
pub(crate) struct Points {
    all: [(f64, f64); STENCIL],
    count: usize,
}

impl Points {
    pub(crate) fn as_slice(&self) -> &[(f64, f64)] {
        &self.all[..self.count]
    }
}

#[cfg(test)]
mod tests_of_nodes;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::dyadic::{STEPS, spacing};
    use proptest::prelude::*;

    fn rate(depth: u32) -> f64 {
        let z = unit(depth);
        (7.0 * z).sin() + if z < 0.4 { 0.0 } else { 2.0 }
    }

    proptest! {
        #[test]
        fn a_line_is_the_same_whether_it_was_assessed_on_the_way_or_not(
            depths in prop::collection::vec(0..=STEPS >> 12, 1..120),
            parts in 1..12_usize,
        ) {
            let base = (0..=8).map(|k| k * spacing(3));
            let depths: Vec<u32> = base.chain(depths.into_iter().map(|k| k << 12)).collect();
            let samples = |of: &[u32]| of.iter().map(|&d| (d, rate(d))).collect::<Vec<_>>();
            let (mut on_the_way, mut at_once) = (Line::default(), Line::default());
            for part in depths.chunks(depths.len().div_ceil(parts)) {
                on_the_way.add(samples(part));
                on_the_way.assess(1e-3, 3);
            }
            at_once.add(samples(&depths));
            prop_assert_eq!(at_once.assess(1e-4, 3), on_the_way.assess(1e-4, 3));
            prop_assert_eq!(at_once.integral.to_bits(), on_the_way.integral.to_bits());
            prop_assert_eq!(at_once.error.to_bits(), on_the_way.error.to_bits());
            let weighted = at_once.weights().into_iter().zip(&at_once.samples);
            let terms: Vec<f64> = weighted.map(|(weight, sample)| weight * sample.rate).collect();
            let sum: f64 = terms.iter().sum();
            // Samples 500 times closer to each other than to the next ones have large weights of both signs.
            let rounding = 1e-12 * terms.iter().map(|term| term.abs()).sum::<f64>().max(1.0);
            prop_assert!((sum - at_once.integral).abs() < rounding, "{sum} {}", at_once.integral);
            for (i, sample) in at_once.samples.iter().enumerate() {
                let other = &on_the_way.samples[i];
                prop_assert_eq!(sample.significance.to_bits(), other.significance.to_bits());
            }
        }

        #[test]
        fn a_sample_is_found_from_any_other(
            depths in prop::collection::vec(0..300_u32, 1..60),
            depth in 0..300_u32,
        ) {
            let mut line = Line::default();
            line.add(depths.iter().map(|&depth| (depth, 0.0)));
            for i in 0..line.samples.len() {
                prop_assert_eq!(line.find_near(i, depth), line.find(depth).ok());
            }
        }
    }
}
