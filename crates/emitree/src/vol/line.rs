//! A line of sight: samples of G at nested dyadic depths, and the integral that they give.
//!
//! Between jumps G is taken for smooth: each interval integrates the polynomial through the nearest
//! six samples that no jump parts from it. Where samples are equally spaced the weights add up to
//! the trapezoid rule, which converges spectrally for a peak away from the ends (Trefethen &
//! Weideman 2014, doi:10.1137/130932132).

use super::dyadic::{GAUSS, STENCIL, level_of, polynomial, unit};
use core::ops::Range;

/// G at one depth of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// The dyadic place along the line.
    pub(crate) depth: u32,
    pub(crate) level: u8,
    /// G = g · ds/dz there.
    pub(crate) rate: f64,
    /// What the sample changes in the integral, as far as it was not expected.
    pub(crate) significance: f64,
    /// Both halves beside it have been sampled.
    pub(crate) opened: bool,
}

/// Samples along one line of sight, by depth.
#[derive(Clone, Debug, Default)]
pub(crate) struct Line {
    pub(crate) samples: Vec<Sample>,
    /// For each interval between samples, whether G jumps in it.
    pub(crate) jumps: Vec<bool>,
    /// ∫ G dz over the line.
    pub(crate) integral: f64,
    /// The estimated |error| of the integral.
    pub(crate) error: f64,
}

/// A jump in a longer interval may turn out to be a steep slope, and its ends are no ends then.
const CLOSED_IN: f64 = 0.03;
/// Points of a polynomial at the end of a segment: extrapolation wants a lower degree.
const ONE_SIDED: usize = 4;

impl Line {
    /// Where a sample at `depth` is, or would be put.
    pub(crate) fn find(&self, depth: u32) -> Result<usize, usize> {
        self.samples.binary_search_by_key(&depth, |sample| sample.depth)
    }

    pub(crate) fn has(&self, depth: u32) -> bool {
        self.find(depth).is_ok()
    }

    /// Adds samples (depth, rate); those that are there already stay.
    pub(crate) fn add(&mut self, new: impl IntoIterator<Item = (u32, f64)>) {
        for (depth, rate) in new {
            let Err(i) = self.find(depth) else { continue };
            let level = level_of(depth);
            let sample = Sample { depth, level, rate, significance: 0.0, opened: false };
            self.samples.insert(i, sample);
            // Both parts of an interval with a jump have one until the line is looked at again.
            let parted = i.saturating_sub(1).min(self.jumps.len().saturating_sub(1));
            let jump = self.jumps.get(parted).copied().unwrap_or(false);
            if self.samples.len() > 1 {
                self.jumps.insert(parted.min(self.jumps.len()), jump);
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

    /// What G changes by from sample `i` to the next.
    pub(crate) fn step(&self, i: usize) -> f64 {
        self.samples[i + 1].rate - self.samples[i].rate
    }

    /// Whether one of the five intervals on either side of sample `i` has a jump.
    pub(crate) fn is_near_jump(&self, i: usize) -> bool {
        let near = i.saturating_sub(5)..(i + 5).min(self.jumps.len());
        self.jumps[near].contains(&true)
    }

    /// Whether sample `i` is beside a jump that has been closed in on: the end of a segment on which
    /// G is taken for smooth.
    pub(crate) fn is_beside_jump(&self, i: usize) -> bool {
        let beside = i.saturating_sub(1)..(i + 1).min(self.jumps.len());
        beside.into_iter().any(|k| self.jumps[k] && self.length(k) <= CLOSED_IN)
    }

    /// Whether G jumps within an interval no longer than `length` steps.
    pub(crate) fn has_jump_within(&self, length: u32) -> bool {
        let intervals = self.samples.windows(2).zip(&self.jumps);
        intervals.into_iter().any(|(ends, &jump)| jump && ends[1].depth - ends[0].depth <= length)
    }

    /// The samples around sample `i` that no jump parts from it, at most [`STENCIL`] on each side.
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

    /// The polynomial that stands for G between samples `i` and `i` + 1, as its points (z, G).
    fn points_of(&self, i: usize) -> ([(f64, f64); STENCIL], usize) {
        let smooth = self.smooth_around(i);
        let at_end = i == smooth.start || i + 2 == smooth.end;
        let count = smooth.len().min(if at_end { ONE_SIDED } else { STENCIL });
        let first = (i + 1).saturating_sub(count / 2).clamp(smooth.start, smooth.end - count);
        let point = |k: usize| {
            let k = (first + k).min(self.samples.len() - 1);
            (self.z(k), self.samples[k].rate)
        };
        (core::array::from_fn(point), count)
    }

    /// G at any depth of the line: sampled, or interpolated between samples.
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
                let (points, count) = self.points_of(i);
                polynomial(&points[..count], unit(depth))
            }
        }
    }

    /// ∫ |G| dz, by trapezoids.
    pub(crate) fn brightness(&self) -> f64 {
        let of_interval = |i: usize| {
            0.5 * self.length(i) * (self.samples[i].rate.abs() + self.samples[i + 1].rate.abs())
        };
        (0..self.samples.len().saturating_sub(1)).map(of_interval).sum()
    }

    /// ∫ G dz from the samples; an interval with a jump gives its trapezoid.
    pub(crate) fn integrate(&mut self) {
        let of_interval = |i: usize| {
            let length = self.length(i);
            let trapezoid = length * 0.5 * (self.samples[i].rate + self.samples[i + 1].rate);
            if self.jumps[i] {
                return trapezoid;
            }
            let (points, count) = self.points_of(i);
            let points = &points[..count];
            let at = |t: f64| polynomial(points, self.z(i) + t * length);
            let integral = GAUSS.iter().map(|&(t, weight)| weight * at(t)).sum::<f64>() * length;
            // Where samples lie unevenly the polynomial may swing out: not beyond their range.
            let rates = || points.iter().map(|point| point.1);
            let range =
                rates().fold(f64::NEG_INFINITY, f64::max) - rates().fold(f64::INFINITY, f64::min);
            if (integral - trapezoid).abs() > length * range { trapezoid } else { integral }
        };
        self.integral = (0..self.samples.len().saturating_sub(1)).map(of_interval).sum();
    }
}
