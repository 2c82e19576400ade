//! The first energy of a cube: that at which some points of the view are brightest. Where these points show no
//! structure, more of them are scattered, and those that do begin the trees.

use crate::cell::{self, whole};
use crate::energy::EnergyAxis;
use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::tile::Tile;
use crate::vol::VolOptions;
use crate::vol::dyadic::{STEPS, from_unit, spacing, unit};
use crate::vol::engine::base_evaluations_of;
use crate::vol::featureless::{points_of_view, sky_factor};
use crate::vol::lattice;
use crate::vol::sampling::{Stop, View, unlike_most};
use crate::vol::seeds::SeedTargets;
use crate::vol::spectrum::bins::Bins;
use crate::vol::spectrum::probes::{
    GOLDEN_RATIO, LINE_LEVEL, ProbePoint, SpectralProbes, energy_of_check, spectral_rates,
};
use crate::vol::tuning::TUNING;
use crate::vol::view::part::Part;

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
pub(crate) struct FirstEnergy {
    /// A place of the axis.
    pub(crate) place: u32,
    pub(crate) hits: Vec<Hit>,
    /// Whether it is one of the lattice of energies: otherwise spectra are narrow or dark.
    pub(crate) is_of_lattice: bool,
    /// The evaluations that it took.
    pub(super) evaluations: u64,
}

/// A point at which g differs from most of the view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(super) point: ProbePoint,
    /// G there, at the first energy.
    pub(super) rate: f64,
}

impl FirstEnergy {
    fn without_hits(place: u32) -> Self {
        Self { place, hits: Vec::new(), is_of_lattice: true, evaluations: 0 }
    }

    fn middle() -> Self {
        Self { is_of_lattice: false, ..Self::without_hits(STEPS / 2) }
    }
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

/// The view in which the first energy is searched for.
pub(crate) struct EnergySearch<'a> {
    meter: &'a Meter,
    tiles: &'a [Tile<'a>],
    parts: &'a [Part<'a>],
    vol: &'a VolOptions,
    /// The bins and the energies of emission lines, without any point.
    probes: SpectralProbes<'a>,
}

impl<'a> EnergySearch<'a> {
    pub(crate) fn new(
        meter: &'a Meter,
        tiles: &'a [Tile<'a>],
        parts: &'a [Part<'a>],
        axis: &'a EnergyAxis,
        vol: &'a VolOptions,
    ) -> Self {
        let mut probes = SpectralProbes::new(Bins::new(axis));
        probes.add_line_energies(&vol.line_energies);
        Self { meter, tiles, parts, vol, probes }
    }

    /// The first energy, before base lattices of this level: the middle of the axis if the budget does not suffice for both.
    pub(crate) async fn run(&self, base_level: u8) -> Result<FirstEnergy, MethodError> {
        let before = self.meter.evaluations();
        let base = base_evaluations_of(self.parts, base_level);
        let is_affordable = base + self.cost() <= self.meter.evaluations_left();
        let found = match is_affordable {
            true => self.search(base).await,
            false => Err(Stop::Budget),
        };
        let mut first = match found {
            Err(Stop::Budget) => FirstEnergy::middle(),
            Err(Stop::Failed(error)) => return Err(error),
            Ok(found) => found,
        };
        first.evaluations = self.meter.evaluations() - before;
        Ok(first)
    }

    /// The number of evaluations at the first points.
    pub(super) fn cost(&self) -> u64 {
        (self.first_points().len() * self.first_energies().len()) as u64
    }

    /// The energies at which the first energy is searched for: a coarse lattice, and the emission
    /// lines that the options name.
    fn first_energies(&self) -> Vec<u32> {
        let lattice = (0..=1_u32 << TUNING.spectra.initial_level)
            .map(|k| k * spacing(TUNING.spectra.initial_level));
        let mut energies: Vec<u32> = lattice.chain(self.probes.common_energies()).collect();
        energies.sort_unstable();
        energies.dedup();
        energies
    }

    /// The energy at which some points of the view are brightest, with the few at which g differs from the others there.
    /// Where it does at none, more points are scattered. If all are dark, it is the middle of the axis.
    /// `base` is the number of evaluations of the base lattices that follow.
    async fn search(&self, base: u64) -> Result<FirstEnergy, Stop> {
        let (points, energies) = (self.first_points(), self.first_energies());
        let sampled: Vec<_> = points
            .iter()
            .flat_map(|&point| energies.iter().map(move |&energy| (point, energy)))
            .collect();
        let rates = self.rates_of(&sampled).await?;
        let mut sums = vec![0.0; energies.len()];
        for rates in rates.chunks(energies.len()) {
            for ((sum, rate), &place) in sums.iter_mut().zip(rates).zip(&energies) {
                *sum += rate.abs() / self.probes.bins.density(unit(place));
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
                none if none.is_empty() => match self.scattered_hits(base, place).await {
                    Err(Stop::Budget) => Vec::new(),
                    scattered => scattered?,
                },
                few if few.len() <= MOST_HITS => few,
                _ => Vec::new(),
            };
            return Ok(FirstEnergy { hits, ..FirstEnergy::without_hits(place) });
        }
        // Spectra may lie between these energies: each point is sampled at different ones.
        let (step, cell) = (spacing(TUNING.spectra.initial_level), spacing(LINE_LEVEL));
        let shifted = |(number, &point): (usize, &ProbePoint)| {
            let shift = (GOLDEN_RATIO * (number as f64 + 1.0)).fract();
            let shift = cell::to_u32(whole(shift * f64::from(step / cell))) * cell;
            (0..1_u32 << TUNING.spectra.initial_level).map(move |k| (point, k * step + shift))
        };
        let sampled: Vec<_> = points.iter().enumerate().flat_map(shifted).collect();
        if let Some((_, place)) = self.brightest_of(&sampled).await? {
            return Ok(FirstEnergy { is_of_lattice: false, ..FirstEnergy::without_hits(place) });
        }
        self.first_of_dark(base).await
    }

    /// The energy of the brightest of scattered points, each of which has an energy of its own, with that point; the middle
    /// of the axis if all are dark.
    async fn first_of_dark(&self, base: u64) -> Result<FirstEnergy, Stop> {
        for numbers in self.batches(base, true) {
            let points = numbers.flat_map(|number| {
                let energy = energy_of_check(number);
                self.points_of_lattice(number).map(move |point| (point, energy))
            });
            let points: Vec<_> = points.collect();
            if let Some((hit, place)) = self.brightest_of(&points).await? {
                return Ok(FirstEnergy { hits: vec![hit], ..FirstEnergy::without_hits(place) });
            }
        }
        Ok(FirstEnergy::middle())
    }

    /// Those of scattered points at which g differs from the others at an energy.
    async fn scattered_hits(&self, base: u64, place: u32) -> Result<Vec<Hit>, Stop> {
        let mut samples: Vec<(ProbePoint, f64)> = Vec::new();
        for numbers in self.batches(base, false) {
            let points: Vec<_> =
                numbers.flat_map(|number| self.points_of_lattice(number)).collect();
            let sampled: Vec<_> = points.iter().map(|point| (*point, place)).collect();
            let rates = self.rates_of(&sampled).await?;
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
    fn batches(&self, base: u64, is_dark: bool) -> Vec<core::ops::Range<usize>> {
        let sky_factor = sky_factor(self.tiles);
        if sky_factor == 1 && !is_dark {
            return Vec::new();
        }
        let of_view = points_of_view(self.vol.tolerance, 1.0);
        let all = sky_factor * TUNING.lowrank.dark_factor * of_view;
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
    async fn rates_of(&self, points: &[(ProbePoint, u32)]) -> Result<Vec<f64>, Stop> {
        let &Self { meter, tiles, .. } = self;
        let view = |part: &'a Part<'a>| View {
            meter,
            chart: &*part.chart,
            tiles: tiles.len(),
            energy: None,
        };
        let views: Vec<View<'a>> = self.parts.iter().map(view).collect();
        spectral_rates(&views, points, &self.probes.bins).await
    }

    /// The brightest of points at energies; `None` if all are dark.
    async fn brightest_of(&self, points: &[(ProbePoint, u32)]) -> Result<Option<(Hit, u32)>, Stop> {
        let rates = self.rates_of(points).await?;
        let size = |i: usize| rates[i].abs() / self.probes.bins.density(unit(points[i].1));
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
