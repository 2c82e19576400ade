//! A spectrum: G at one point of the volume, sampled at nested dyadic places of the energy axis.
//!
//! Between samples it is defined like the function of an image tree along one axis: a place of
//! level l without a sample has its prediction from the lattice of level l − 1.

pub(crate) mod bins;
pub(crate) mod cube_spectra;
pub(crate) mod energies;
pub(crate) mod probes;
pub(crate) mod selection;

use crate::cell;
use crate::vol::dyadic::{STEPS, beside, level_of, midpoint_weights, spacing, unit};
use crate::vol::image::pixels::AxisWeights;
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// The level of the lattice on which every spectrum is sampled.
pub(crate) const BASE_LEVEL: u8 = 3;
/// The finest level of a spectrum: narrower structure is below double precision in the means over
/// bins.
pub(crate) const FINEST_LEVEL: u8 = 16;
/// The order of predictions.
const ORDER: usize = 6;

/// Samples of one spectrum.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spectrum {
    samples: BTreeMap<u32, f64>,
}

impl Spectrum {
    pub(crate) fn add(&mut self, place: u32, rate: f64) {
        self.samples.insert(place, rate);
    }

    pub(crate) fn has(&self, place: u32) -> bool {
        self.samples.contains_key(&place)
    }

    pub(crate) fn places(&self) -> impl Iterator<Item = u32> + '_ {
        self.samples.keys().copied()
    }

    pub(crate) fn finest_level(&self) -> u8 {
        self.places().map(level_of).max().unwrap_or(0).max(BASE_LEVEL)
    }

    /// Every sample times `factor`.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.samples.values_mut().for_each(|rate| *rate *= factor);
    }

    /// This spectrum minus `amount` times another one, at the samples of both.
    pub(crate) fn less(&self, amount: f64, other: &Self) -> Self {
        let [mut of_self, mut of_other] = [FxHashMap::default(), FxHashMap::default()];
        let mut places: Vec<u32> = self.places().chain(other.places()).collect();
        places.sort_unstable();
        places.dedup();
        let mut residual = |place: u32| {
            self.value(place, &mut of_self) - amount * other.value(place, &mut of_other)
        };
        Self { samples: places.into_iter().map(|place| (place, residual(place))).collect() }
    }

    /// G at a place, sampled or predicted.
    pub(crate) fn rate(&self, place: u32) -> f64 {
        self.value(place, &mut FxHashMap::default())
    }

    fn value(&self, place: u32, ghosts: &mut FxHashMap<u32, f64>) -> f64 {
        if let Some(&rate) = self.samples.get(&place).or_else(|| ghosts.get(&place)) {
            return rate;
        }
        let rate = self.predict(place, ghosts);
        ghosts.insert(place, rate);
        rate
    }

    fn predict(&self, place: u32, ghosts: &mut FxHashMap<u32, f64>) -> f64 {
        let level = level_of(place);
        if level == 0 {
            return 0.0;
        }
        let coarser = spacing(level - 1);
        let intervals = 1_usize << (level - 1);
        let (first, weights) = midpoint_weights(ORDER, intervals, (place / coarser) as usize);
        let at = |k: usize| cell::to_u32(first + k) * coarser;
        weights.iter().enumerate().map(|(k, weight)| weight * self.value(at(k), ghosts)).sum()
    }

    /// The sampled places, each with its detail: the difference from its prediction.
    fn details(&self) -> Vec<(u32, f64)> {
        let mut ghosts = FxHashMap::default();
        let of_place =
            |(&place, &rate): (&u32, &f64)| (place, rate - self.predict(place, &mut ghosts));
        self.samples.iter().map(of_place).collect()
    }

    /// The places to be sampled next, for the mean over every bin; `effect` is the change of a mean
    /// by a detail of 1 at a place, in units of the error allowed.
    pub(crate) fn wanted(&self, bins: usize, effect: impl Fn(u32) -> f64) -> Vec<u32> {
        let mut wanted: Vec<u32> = Vec::new();
        for (place, guarded) in self.guarded() {
            let remains = TUNING.spectra.decay * guarded * effect(place);
            // Structure as wide as the gap between samples changes the mean over a wider bin by
            // this share.
            let share = |at: u32| (bins as f64 * unit(self.gap(at))).min(1.0);
            wanted.extend(self.missing_around(place).filter(|&at| remains * share(at) > 1.0));
        }
        wanted.sort_unstable();
        wanted.dedup();
        wanted
    }

    /// The places around which finer ones are missing, each with the larger of its own detail and a
    /// share of those beside it.
    fn guarded(&self) -> Vec<(u32, f64)> {
        let details: BTreeMap<u32, f64> = self.details().into_iter().collect();
        let of_place = |&place: &u32| {
            let level = level_of(place).max(BASE_LEVEL);
            if level >= FINEST_LEVEL || self.missing_around(place).next().is_none() {
                return None;
            }
            let around = [0, 1, 2].map(|k| k * spacing(level));
            let around = around.iter().flat_map(|&distance| {
                [false, true].map(|up| (distance, beside(place, distance, up)))
            });
            // Details of coarser places belong to coarser structure.
            let on_level =
                |&(_, at): &(u32, Option<u32>)| at.is_some_and(|at| level_of(at) == level);
            let size = |(distance, at): (u32, Option<u32>)| {
                let detail = at.and_then(|at| details.get(&at)).map_or(0.0, |detail| detail.abs());
                if distance == 0 { detail } else { TUNING.spectra.neighbour_guard * detail }
            };
            Some((place, around.filter(on_level).map(size).fold(0.0, f64::max)))
        };
        details.keys().filter_map(of_place).collect()
    }

    /// The distance between the samples on either side of a place without one.
    fn gap(&self, place: u32) -> u32 {
        let below = self.samples.range(..place).next_back().map_or(0, |(at, _)| *at);
        let above = self.samples.range(place + 1..).next().map_or(STEPS, |(at, _)| *at);
        above - below
    }

    /// The places around one place that have not been sampled: half a spacing away for finer
    /// structure, one spacing for the values that predict it, and two for values that it predicts,
    /// where predictions oscillate.
    fn missing_around(&self, place: u32) -> impl Iterator<Item = u32> + '_ {
        let level = level_of(place).max(BASE_LEVEL);
        let distances = [spacing(level + 1), spacing(level), 2 * spacing(level)];
        let around = distances
            .into_iter()
            .flat_map(move |distance| [false, true].map(|up| beside(place, distance, up)));
        around.flatten().filter(|at| !self.has(*at))
    }

    /// The mean over each bin.
    pub(crate) fn means(&self, weights: &BinWeights) -> Vec<f64> {
        let mut means = vec![0.0; weights.bins];
        for (place, detail) in self.details() {
            let level = level_of(place).max(BASE_LEVEL);
            let amount = if level_of(place) <= BASE_LEVEL { self.samples[&place] } else { detail };
            weights.add(&mut means, level, place, amount);
        }
        means
    }
}

/// Weights of the means over the bins, for the lattices of all levels.
#[derive(Clone, Debug)]
pub(crate) struct BinWeights {
    bins: usize,
    /// The weights on the lattices from [`BASE_LEVEL`] on.
    levels: Vec<AxisWeights>,
}

impl BinWeights {
    /// The weights for spectra whose finest samples are of level `finest`.
    pub(crate) fn new(finest: u8, bins: usize) -> Self {
        let mut levels = vec![AxisWeights::finest(finest.max(BASE_LEVEL), bins)];
        for _ in BASE_LEVEL..finest {
            let coarser = levels[levels.len() - 1].coarser(ORDER);
            levels.push(coarser);
        }
        levels.reverse();
        Self { bins, levels }
    }

    fn add(&self, means: &mut [f64], level: u8, place: u32, amount: f64) {
        let axis = &self.levels[usize::from(level - BASE_LEVEL)];
        let index = (place / spacing(level)) as usize;
        for bin in axis.around(index) {
            means[bin] += amount * axis.weight(bin, index);
        }
    }
}

#[cfg(test)]
mod tests_of_energies;

#[cfg(test)]
mod tests {
    use super::*;

    /// A spectrum refined until no expected change of a mean over a bin is above `allowed`.
    fn refined(bins: usize, allowed: f64, f: impl Fn(f64) -> f64) -> Spectrum {
        let mut spectrum = Spectrum::default();
        let base = (0..=1_u32 << BASE_LEVEL).map(|k| k * spacing(BASE_LEVEL));
        base.for_each(|place| spectrum.add(place, f(unit(place))));
        loop {
            let wanted = spectrum.wanted(bins, |_| 1.0 / allowed);
            if wanted.is_empty() {
                return spectrum;
            }
            wanted.into_iter().for_each(|place| spectrum.add(place, f(unit(place))));
        }
    }

    fn worst_mean(spectrum: &Spectrum, bins: usize, integral: impl Fn(f64) -> f64) -> f64 {
        let means = spectrum.means(&BinWeights::new(spectrum.finest_level(), bins));
        let of_bin = |(bin, mean): (usize, &f64)| {
            let [low, high] = [bin, bin + 1].map(|edge| integral(edge as f64 / bins as f64));
            (mean - (high - low) * bins as f64).abs()
        };
        means.iter().enumerate().map(of_bin).fold(0.0, f64::max)
    }

    #[test]
    fn means_over_bins_are_right_to_what_was_allowed() {
        for bins in [1, 7, 32] {
            let smooth = refined(bins, 1e-4, |u| (-3.0 * u).exp());
            assert!(smooth.places().count() <= 17);
            assert!(worst_mean(&smooth, bins, |u| -(-3.0 * u).exp() / 3.0) < 1e-4);
            let edge = refined(bins, 1e-3, |u| if u < 0.3 { 1.0 } else { 0.2 });
            let integral = |u: f64| u.min(0.3) + 0.2 * (u - 0.3).max(0.0);
            assert!(worst_mean(&edge, bins, integral) < 1e-3, "{bins} bins");
            assert!(edge.places().count() < 200, "{}", edge.places().count());
        }
    }

    #[test]
    fn one_sample_of_a_narrow_line_is_followed() {
        let line = |u: f64| (-((u - 0.4) / 1e-3).powi(2)).exp();
        let missed = refined(10, 1e-4, line);
        assert_eq!(missed.places().count(), 9);
        let mut spectrum = missed;
        let step = spacing(FINEST_LEVEL - 1);
        spectrum.add(26 * STEPS / 65 / step * step, line(0.4));
        loop {
            let wanted = spectrum.wanted(10, |_| 1e4);
            if wanted.is_empty() {
                break;
            }
            wanted.into_iter().for_each(|place| spectrum.add(place, line(unit(place))));
        }
        let means = spectrum.means(&BinWeights::new(spectrum.finest_level(), 10));
        let exact = 10.0 * 1e-3 * core::f64::consts::PI.sqrt();
        assert!((means[3] + means[4] - exact).abs() < 1e-4, "{means:?}");
        assert!(spectrum.places().count() < 300);
    }

    #[test]
    fn quartics_are_exact_from_the_base_on() {
        let spectrum = refined(10, 1e-12, |u| u.powi(4) - u);
        assert_eq!(spectrum.places().count(), 9);
        assert!(worst_mean(&spectrum, 10, |u| u.powi(5) / 5.0 - u * u / 2.0) < 1e-14);
    }
}
