//! The first energy of a cube: that at which some points of the view are brightest. Where these points show no
//! structure, more of them are scattered, and those that do begin the trees.

use crate::cell::{self, whole};
use crate::vol::dyadic::{STEPS, from_unit, spacing, unit};
use crate::vol::engine::spectra::Spectra;
use crate::vol::engine::{Engine, base_evaluations_of};
use crate::vol::featureless::{points_of_view, sky_factor};
use crate::vol::lattice;
use crate::vol::sampling::{Stop, unlike_most};
use crate::vol::seeds::SeedTargets;
use crate::vol::spectrum::probes::{
    GOLDEN_RATIO, LINE_LEVEL, ProbePoint, energy_of_check, spectral_rates,
};
use crate::vol::tuning::TUNING;

/// The most points of a structure that the trees begin with.
const MOST_HITS: usize = 8;
/// The share of the budget that scattered points may take.
const MOST_BUDGET_SHARE: u64 = 4;
/// Scattered points of all parts at first.
const FIRST_POINTS: usize = 512;
/// By how many levels the nodes and depths around a hit are finer than the base lattice.
const LEVELS_AROUND: u8 = 4;

/// An energy, and the few points at which g differs from the other ones there.
#[derive(Debug)]
pub(super) struct FirstEnergy {
    pub(super) place: u32,
    pub(super) hits: Vec<Hit>,
}

/// A point at which g differs from most of the view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub(super) point: ProbePoint,
    /// G there, at the first energy.
    pub(super) rate: f64,
}

impl Hit {
    /// Requires nodes and depths around it.
    pub(super) fn add_to(&self, targets: &mut SeedTargets, base_level: u8, finest_level: u8) {
        let depth = self.point.depth;
        let around = |level: u8| {
            let step = spacing(level);
            let below = depth / step * step;
            [below, (below + step).min(spacing(0))]
        };
        let finest = (base_level + LEVELS_AROUND).min(finest_level);
        let depths: Vec<u32> = (base_level..=finest).flat_map(around).collect();
        for level in base_level + 1..=finest {
            targets.add_depths_around(self.point.place, level, &depths);
        }
    }
}

impl Engine<'_> {
    /// The number of evaluations of the search for the first energy at its first points.
    pub(super) fn cost_of_first_energy(&self) -> u64 {
        let energies = self.spectra.as_ref().map_or(0, |spectra| spectra.first_energies().len());
        (self.first_points().len() * energies) as u64
    }

    /// The energy at which some points of the view are brightest, with the few at which g differs from the others there.
    /// Where it does at none, more points are scattered. If all are dark, it is the middle of the axis.
    pub(super) async fn first_energy(&self) -> Result<Option<FirstEnergy>, Stop> {
        let Some(spectra) = &self.spectra else { return Ok(None) };
        let (points, energies) = (self.first_points(), spectra.first_energies());
        let sampled: Vec<_> = points
            .iter()
            .flat_map(|&point| energies.iter().map(move |&energy| (point, energy)))
            .collect();
        let rates = self.rates_of(spectra, &sampled).await?;
        let mut sums = vec![0.0; energies.len()];
        for rates in rates.chunks(energies.len()) {
            for ((sum, rate), &place) in sums.iter_mut().zip(rates).zip(&energies) {
                *sum += rate.abs() / spectra.probes.bins.density(unit(place));
            }
        }
        let middle = energies.len() / 2;
        let brightest =
            (0..sums.len()).fold(middle, |best, k| if sums[k] > sums[best] { k } else { best });
        if sums[brightest] > 0.0 {
            let of_energy = rates.iter().copied().skip(brightest).step_by(energies.len());
            let samples: Vec<(ProbePoint, f64)> = points.into_iter().zip(of_energy).collect();
            let place = energies[brightest];
            let hits = match self.differing(&samples) {
                none if none.is_empty() => match self.scattered_hits(spectra, place).await {
                    Err(Stop::Budget) => Vec::new(),
                    scattered => scattered?,
                },
                few if few.len() <= MOST_HITS => few,
                _ => Vec::new(),
            };
            return Ok(Some(FirstEnergy { place, hits }));
        }
        // Spectra may lie between these energies: each point is sampled at different ones.
        let (step, cell) = (spacing(TUNING.spectra.initial_level), spacing(LINE_LEVEL));
        let shifted = |(number, &point): (usize, &ProbePoint)| {
            let shift = (GOLDEN_RATIO * (number as f64 + 1.0)).fract();
            let shift = cell::to_u32(whole(shift * f64::from(step / cell))) * cell;
            (0..1_u32 << TUNING.spectra.initial_level).map(move |k| (point, k * step + shift))
        };
        let sampled: Vec<_> = points.iter().enumerate().flat_map(shifted).collect();
        if let Some((_, place)) = self.brightest_of(spectra, &sampled).await? {
            return Ok(Some(FirstEnergy { place, hits: Vec::new() }));
        }
        self.first_of_dark(spectra).await.map(Some)
    }

    /// The energy of the brightest of scattered points, each of which has an energy of its own, with that point; the middle
    /// of the axis if all are dark.
    async fn first_of_dark(&self, spectra: &Spectra<'_>) -> Result<FirstEnergy, Stop> {
        for numbers in self.batches(true) {
            let points = numbers.flat_map(|number| {
                let energy = energy_of_check(number);
                self.points_of_lattice(number).map(move |point| (point, energy))
            });
            let points: Vec<_> = points.collect();
            if let Some((hit, place)) = self.brightest_of(spectra, &points).await? {
                return Ok(FirstEnergy { place, hits: vec![hit] });
            }
        }
        Ok(FirstEnergy { place: STEPS / 2, hits: Vec::new() })
    }

    /// Those of scattered points at which g differs from the others at an energy.
    async fn scattered_hits(&self, spectra: &Spectra<'_>, place: u32) -> Result<Vec<Hit>, Stop> {
        let mut samples: Vec<(ProbePoint, f64)> = Vec::new();
        for numbers in self.batches(false) {
            let points: Vec<_> =
                numbers.flat_map(|number| self.points_of_lattice(number)).collect();
            let sampled: Vec<_> = points.iter().map(|point| (*point, place)).collect();
            let rates = self.rates_of(spectra, &sampled).await?;
            samples.extend(points.into_iter().zip(rates));
            let hits = self.differing(&samples);
            if !hits.is_empty() {
                return Ok(if hits.len() > MOST_HITS { Vec::new() } else { hits });
            }
        }
        Ok(Vec::new())
    }

    /// The numbers of points of the scattered lattice of each part, in batches that double: as many as an image
    /// without structure in any of them has; none of a narrow view that is not dark.
    fn batches(&self, is_dark: bool) -> Vec<core::ops::Range<usize>> {
        let sky_factor = sky_factor(self.tiles);
        if sky_factor == 1 && !is_dark {
            return Vec::new();
        }
        let of_view = points_of_view(self.vol.tolerance, 1.0);
        let all = sky_factor * TUNING.lowrank.dark_factor * of_view;
        // The base lattice follows.
        let base = base_evaluations_of(self.parts, self.base_level);
        let left = self.meter.evaluations_left().saturating_sub(base);
        let affordable = (left / MOST_BUDGET_SHARE).min(all as u64) as usize;
        let [first, all] = [FIRST_POINTS, affordable].map(|count| count / self.parts.len().max(1));
        let mut batches = Vec::new();
        let mut from = 0;
        while from < all {
            let to = (2 * from).max(first).clamp(1, all);
            batches.push(from..to);
            from = to;
        }
        batches
    }

    /// The point of a number in each part.
    fn points_of_lattice(&self, number: usize) -> impl Iterator<Item = ProbePoint> + use<> {
        let [x, y, depth] = lattice::point(number).map(from_unit);
        (0..self.parts.len()).map(move |part| ProbePoint { part, place: [x, y], depth })
    }

    /// G at points and energies, times the density of energies.
    async fn rates_of(
        &self,
        spectra: &Spectra<'_>,
        points: &[(ProbePoint, u32)],
    ) -> Result<Vec<f64>, Stop> {
        spectral_rates(&self.views(), points, &spectra.probes.bins).await
    }

    /// The brightest of points at energies; `None` if all are dark.
    async fn brightest_of(
        &self,
        spectra: &Spectra<'_>,
        points: &[(ProbePoint, u32)],
    ) -> Result<Option<(Hit, u32)>, Stop> {
        let rates = self.rates_of(spectra, points).await?;
        let size = |i: usize| rates[i].abs() / spectra.probes.bins.density(unit(points[i].1));
        let brightest =
            (0..points.len()).fold(0, |best, i| if size(i) > size(best) { i } else { best });
        let found = points.get(brightest).filter(|_| size(brightest) > 0.0);
        Ok(found.map(|&(point, place)| (Hit { point, rate: rates[brightest] }, place)))
    }

    /// The samples at which g is not the median.
    fn differing(&self, samples: &[(ProbePoint, f64)]) -> Vec<Hit> {
        let rate = |(point, rate): &(ProbePoint, f64)| {
            let [x, y] = point.place.map(unit);
            let chart = &*self.parts[point.part].chart;
            let path = chart.world_from_chart([x, y, unit(point.depth)]).path_per_depth;
            (path > 0.0).then(|| rate / path)
        };
        // A point out of view has no rate.
        let in_view = samples.iter().filter_map(|sample| Some((sample, rate(sample)?)));
        let (in_view, rates): (Vec<&(ProbePoint, f64)>, Vec<f64>) = in_view.unzip();
        let hit = |number: usize| {
            let &(point, rate) = in_view[number];
            Hit { point, rate }
        };
        unlike_most(&rates).into_iter().map(hit).collect()
    }

    /// The points of the search for the first energy: the centres of equal cells of each part of the view.
    fn first_points(&self) -> Vec<ProbePoint> {
        let per_axis = if self.parts.len() > TUNING.spectra.many_parts {
            TUNING.spectra.initial_points_of_many
        } else {
            TUNING.spectra.initial_points
        };
        let along = |k: u32| (2 * k + 1) * (STEPS / (2 * per_axis));
        let of_part = |part: usize| {
            (0..per_axis.pow(3)).map(move |k| {
                let [i, j, k] = [k % per_axis, k / per_axis % per_axis, k / per_axis / per_axis];
                ProbePoint { part, place: [along(i), along(j)], depth: along(k) }
            })
        };
        (0..self.parts.len()).flat_map(of_part).collect()
    }
}
