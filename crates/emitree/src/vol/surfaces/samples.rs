//! Samples of G with the regions that they belong to, decided by the values of samples nearby.

use crate::vol::surfaces::buckets::PlacedPoints;
use crate::vol::surfaces::columns::Columns;
use crate::vol::surfaces::octree::{HIDDEN, Label};
use crate::vol::tuning::TUNING;
use std::collections::BTreeMap;

/// One sample, or a point whose region is known otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) at: [f64; 3],
    /// G there; what its region predicts if G was not evaluated.
    pub(super) rate: f64,
    label: Label,
    is_measured: bool,
}

/// What the samples of a region predict at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Predicted {
    label: Label,
    rate: f64,
    error: f64,
    /// The largest difference of the samples from their mean.
    spread: f64,
    /// The number of samples.
    count: usize,
}

/// The fewest equal values of a region that is constant.
const FOR_CONSTANT: usize = 4;

/// The most that a prediction differs from the mean, in largest differences of the samples from it.
const MOST_BEYOND: f64 = 2.0;

/// All samples.
#[derive(Debug)]
pub(super) struct Samples {
    all: Vec<Sample>,
    /// Those whose G is measured, by place.
    placed: PlacedPoints,
    /// The region that each label stands for: regions whose values agree become one.
    merged: Vec<Label>,
    /// The least and the largest value with each label, and the number of its samples.
    ends: Vec<[f64; 2]>,
    counts: Vec<usize>,
    /// How often G jumps between two regions, the smaller label first, and how often it does not.
    borders: BTreeMap<[Label; 2], [usize; 2]>,
    /// Differences of G below this do not matter.
    pub(super) negligible: f64,
}

impl Samples {
    pub(super) fn new(bucket: f64, negligible: f64) -> Self {
        let (all, merged, ends) = (Vec::new(), Vec::new(), Vec::new());
        let (counts, borders) = (Vec::new(), BTreeMap::new());
        let placed = PlacedPoints::new(bucket);
        Self { all, placed, merged, ends, counts, borders, negligible }
    }

    pub(super) fn len(&self) -> usize {
        self.all.len()
    }

    /// The number of regions.
    pub(super) fn regions(&self) -> usize {
        (0..self.merged.len()).filter(|&k| usize::from(self.merged[k]) == k).count()
    }

    /// A sample.
    pub(super) fn get(&self, i: usize) -> Sample {
        Sample { label: self.label(i), ..self.all[i] }
    }

    /// The region of a sample.
    pub(super) fn label(&self, i: usize) -> Label {
        self.current(self.all[i].label)
    }

    /// The region that a label stands for.
    pub(super) fn current(&self, label: Label) -> Label {
        self.merged.get(usize::from(label)).copied().unwrap_or(label)
    }

    /// A new region.
    pub(super) fn new_label(&mut self) -> Label {
        let label = Label::try_from(self.merged.len()).unwrap_or(Label::MAX);
        self.merged.push(label);
        self.ends.push([f64::INFINITY, f64::NEG_INFINITY]);
        self.counts.push(0);
        label
    }

    /// Notes that G jumps, or that it does not, where two regions meet. They become one if it jumps rarely:
    /// a steep slope may look like a jump. Where a jump that is known well fades out, its sides remain two regions.
    pub(super) fn note_border(&mut self, a: Label, b: Label, is_jump: bool) {
        let [a, b] = [self.current(a), self.current(b)];
        if a == b {
            return;
        }
        let [jumps, others] = self.borders.entry([a.min(b), a.max(b)]).or_default();
        *if is_jump { &mut *jumps } else { &mut *others } += 1;
        let is_rare = *others > TUNING.surfaces.rare_jumps * *jumps;
        if is_rare && *jumps < TUNING.surfaces.sure_jumps {
            self.merge(a, b);
        }
    }

    /// Whether nothing is known about the border of two regions.
    pub(super) fn is_unknown_border(&self, a: Label, b: Label) -> bool {
        let [a, b] = [self.current(a), self.current(b)];
        a != b && !self.borders.contains_key(&[a.min(b), a.max(b)])
    }

    /// Makes one region of two.
    fn merge(&mut self, a: Label, b: Label) {
        let [a, b] = [self.current(a), self.current(b)];
        let (kept, lost) = (a.min(b), a.max(b));
        if kept == lost {
            return;
        }
        self.merged.iter_mut().filter(|of| **of == lost).for_each(|of| *of = kept);
        let of_lost = self.ends[usize::from(lost)];
        let ends = &mut self.ends[usize::from(kept)];
        *ends = [ends[0].min(of_lost[0]), ends[1].max(of_lost[1])];
        self.counts[usize::from(kept)] += self.counts[usize::from(lost)];
        for ([a, b], counts) in core::mem::take(&mut self.borders) {
            let [a, b] = [self.current(a), self.current(b)];
            if a != b {
                let of_pair = self.borders.entry([a.min(b), a.max(b)]).or_default();
                *of_pair = [0, 1].map(|k| of_pair[k] + counts[k]);
            }
        }
    }

    /// Whether all values of a region are equal, so that no other value belongs to it. With few values
    /// it is as the other regions are.
    fn is_constant(&self, label: Label) -> bool {
        let is_equal = |k: usize| self.ends[k][1] - self.ends[k][0] <= self.negligible;
        let own = usize::from(label);
        if !is_equal(own) || self.counts[own] >= FOR_CONSTANT {
            return is_equal(own);
        }
        let mut others = (0..self.merged.len()).filter(|&k| usize::from(self.merged[k]) == k);
        others.all(is_equal)
    }

    /// A region of constant values that agree with a value, wherever it is.
    pub(super) fn constant(&self, rate: f64) -> Option<Label> {
        let agrees = |(k, [low, high]): (usize, &[f64; 2])| {
            let is_current = usize::from(self.merged[k]) == k;
            is_current
                && high - low <= self.negligible
                && (rate - low).abs().max((rate - high).abs()) <= self.negligible
        };
        let found = self.ends.iter().enumerate().position(agrees)?;
        Label::try_from(found).ok()
    }

    /// Adds a point that no line of sight reaches. It belongs to no region.
    pub(super) fn add_hidden(&mut self, at: [f64; 3]) -> usize {
        self.all.push(Sample { at, rate: 0.0, label: HIDDEN, is_measured: false });
        self.all.len() - 1
    }

    /// Whether a sample is such a point.
    pub(super) fn is_hidden(&self, i: usize) -> bool {
        self.all[i].label == HIDDEN
    }

    /// Adds a point that is in a region for certain, where G is not evaluated. It takes no part in the
    /// predictions for others.
    pub(super) fn add_inferred(&mut self, at: [f64; 3], rate: f64, label: Label) -> usize {
        self.all.push(Sample { at, rate, label, is_measured: false });
        self.all.len() - 1
    }

    /// What a region predicts at a point; 0 if it has no sample nearby.
    pub(super) fn rate_near(&self, at: [f64; 3], label: Label) -> f64 {
        let few = TUNING.surfaces.nearest_samples;
        let of_region = |count: usize| {
            let near = self.placed.nearest(at, count);
            let is_near = near.iter().any(|&(_, i)| self.label(i) == label);
            is_near.then(|| self.prediction(at, label, &near))
        };
        [few, 8 * few].into_iter().find_map(of_region).map_or(0.0, |of| of.rate)
    }

    /// Makes a sample of such a point.
    pub(super) fn measure(&mut self, number: usize, rate: f64, label: Label) {
        let at = self.all[number].at;
        self.all[number] = Sample { at, rate, label, is_measured: true };
        self.register(number);
    }

    /// Whether G was evaluated at a point.
    pub(super) fn is_measured(&self, i: usize) -> bool {
        self.all[i].is_measured
    }

    /// Whether G was evaluated at a point, and has a value of a region.
    pub(super) fn is_of(&self, i: usize, label: Label) -> bool {
        self.is_measured(i) && self.label(i) == label
    }

    /// Adds a sample of a region. Returns its number.
    pub(super) fn add(&mut self, at: [f64; 3], rate: f64, label: Label) -> usize {
        let number = self.all.len();
        self.all.push(Sample { at, rate, label, is_measured: true });
        self.register(number);
        number
    }

    /// Enters a sample into its region and into its bucket.
    fn register(&mut self, number: usize) {
        let Sample { at, rate, label, .. } = self.all[number];
        let current = usize::from(self.current(label));
        if let Some(ends) = self.ends.get_mut(current) {
            *ends = [ends[0].min(rate), ends[1].max(rate)];
            self.counts[current] += 1;
        }
        self.placed.add(at, number);
    }

    /// The region that the value at a point belongs to; `None` if it fits none nearby.
    pub(super) fn classify(&self, at: [f64; 3], rate: f64) -> Option<Label> {
        // Other regions may be hidden behind many samples of one.
        let few = TUNING.surfaces.nearest_samples;
        [few, 8 * few].into_iter().find_map(|count| self.classify_by(at, rate, count))
    }

    /// What each region predicts at a point from so many of the nearest samples.
    fn predictions(&self, at: [f64; 3], count: usize) -> Vec<Predicted> {
        self.predictions_by(at, &self.placed.nearest(at, count))
    }

    /// The same from samples nearby, the nearest first.
    fn predictions_by(&self, at: [f64; 3], near: &[(f64, usize)]) -> Vec<Predicted> {
        let mut predicted: Vec<Predicted> = Vec::new();
        for &(_, i) in near {
            let label = self.label(i);
            if predicted.iter().all(|of| of.label != label) {
                predicted.push(self.prediction(at, label, near));
            }
        }
        predicted
    }

    /// What a region predicts at a point from its samples among those nearby.
    fn prediction(&self, at: [f64; 3], label: Label, near: &[(f64, usize)]) -> Predicted {
        let own = near.iter().filter(|(_, i)| self.label(*i) == label);
        let own: Vec<(f64, usize)> = own.take(TUNING.surfaces.samples_of_region).copied().collect();
        self.predict(at, label, &own)
    }

    /// The largest difference between what regions predict at a point, and the sum of the two largest errors
    /// of the predictions; none if a region has few samples nearby.
    pub(super) fn largest_jump(&self, at: [f64; 3], labels: &[Label]) -> Option<[f64; 2]> {
        let predicted = self.predictions(at, 8 * TUNING.surfaces.nearest_samples);
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        let mut errors = [0.0; 2];
        for label in labels {
            let of = predicted.iter().find(|of| of.label == *label && of.count >= FOR_CONSTANT)?;
            ends = [ends[0].min(of.rate), ends[1].max(of.rate)];
            let [first, second] = errors;
            errors = [of.error.max(first), of.error.min(first).max(second)];
        }
        Some([(ends[1] - ends[0]).max(0.0), errors[0] + errors[1]])
    }

    /// Whether a value differs from what a region predicts, by more than `least` and than from what another
    /// region does.
    pub(super) fn is_foreign(&self, at: [f64; 3], rate: f64, label: Label, least: f64) -> bool {
        let near = self.placed.nearest(at, 8 * TUNING.surfaces.nearest_samples);
        if near.iter().all(|&(_, i)| self.label(i) == label) {
            return false;
        }
        let predicted = self.predictions_by(at, &near);
        let misfit = |of: &Predicted| (rate - of.rate).abs();
        let [own, others]: [Vec<&Predicted>; 2] = [true, false]
            .map(|own| predicted.iter().filter(|of| (of.label == label) == own).collect());
        let own = own.first().map_or(f64::INFINITY, |of| misfit(of));
        let other = others.into_iter().map(misfit).fold(f64::INFINITY, f64::min);
        own > least && 2.0 * other < own
    }

    /// The region by the values of so many samples.
    fn classify_by(&self, at: [f64; 3], rate: f64, count: usize) -> Option<Label> {
        let mut predicted = self.predictions(at, count);
        let misfit = |of: &Predicted| (rate - of.rate).abs();
        // A constant region has no other values.
        predicted.retain(|of| {
            !self.is_constant_near(of) || (rate - of.rate).abs() <= 2.0 * self.negligible
        });
        let best = predicted.iter().min_by(|a, b| misfit(a).total_cmp(&misfit(b)))?;
        if self.is_constant_near(best) {
            return Some(best.label);
        }
        // Where G varies, a region has all that is nearer to it than to others.
        let others = predicted.iter().filter(|of| of.label != best.label);
        let gap = others.map(|of| (of.rate - best.rate).abs()).fold(f64::INFINITY, f64::min);
        let gap = if gap.is_finite() { gap } else { best.rate.abs() };
        let expected = best.error.max(TUNING.surfaces.least_spread * best.rate.abs());
        let expected = expected.max(TUNING.surfaces.spread_share * best.spread);
        let allowed = (TUNING.surfaces.misfit * expected).max(0.5 * gap) + self.negligible;
        (misfit(best) <= allowed).then_some(best.label)
    }

    /// Whether all values of a region are equal, or those nearby.
    fn is_constant_near(&self, of: &Predicted) -> bool {
        let is_locally = of.spread <= self.negligible && of.count >= FOR_CONSTANT;
        is_locally || self.is_constant(of.label)
    }

    /// The value of a region at a point from its nearest samples, by a plane if there are enough.
    fn predict(&self, at: [f64; 3], label: Label, own: &[(f64, usize)]) -> Predicted {
        let scale =
            own.iter().map(|(distance, _)| *distance).sum::<f64>() / own.len().max(1) as f64;
        let scale = scale.max(f64::MIN_POSITIVE);
        let weight = |distance: f64| 1.0 / (0.05 + distance / scale).powi(2);
        let sum: f64 = own.iter().map(|(distance, _)| weight(*distance)).sum();
        let of = |i: usize| self.all[i].rate;
        let mean = own.iter().map(|&(distance, i)| weight(distance) * of(i)).sum::<f64>() / sum;
        let spread = own.iter().map(|&(_, i)| (of(i) - mean).abs()).fold(0.0, f64::max);
        let count = own.len();
        let constant = Predicted { label, rate: mean, error: spread, spread, count };
        if own.len() < 8 || spread <= self.negligible {
            return constant;
        }
        let root = |distance: f64| weight(distance).sqrt();
        let mut columns =
            Columns::new(own.iter().map(|&(d, i)| root(d) * (of(i) - mean)).collect(), 4);
        let one = columns.add(own.iter().map(|&(distance, _)| root(distance)));
        let slopes = (0..3).all(|axis| {
            let along = |i: usize| (self.all[i].at[axis] - at[axis]) / scale;
            columns.add(own.iter().map(|&(distance, i)| root(distance) * along(i)))
        });
        if !(one && slopes) {
            return constant;
        }
        let left_out = |(k, (distance, _)): (usize, &(f64, usize))| {
            (columns.left_out(k) / root(*distance)).powi(2) * weight(*distance)
        };
        let error = (own.iter().enumerate().map(left_out).sum::<f64>() / sum).sqrt();
        if error >= spread {
            return constant;
        }
        // Samples along a line tell little about slopes across it.
        let value = columns.coefficients().first().copied().unwrap_or(0.0);
        let value = value.clamp(-MOST_BEYOND * spread, MOST_BEYOND * spread);
        Predicted { label, rate: mean + value, error, spread, count }
    }
}

#[cfg(test)]
mod tests;
