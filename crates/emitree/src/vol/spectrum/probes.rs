//! Spectral probes: points of the volume at which whole spectra are sampled.
//!
//! Energies are selected from their spectra, and new probes show whether these still explain the
//! spectra on new lines. Some probes sample every bin; all spectra are refined where they have
//! structure. Spot checks are single samples at many places and energies; one that is not explained
//! becomes a spectral probe.

use crate::cell::{self, whole};
use crate::image::Image;
use crate::parallel::prelude::*;
use crate::vol::dyadic::{Place, STEPS, spacing, unit};
use crate::vol::error_weights::WeightsOfPart;
use crate::vol::sampling::{Stop, View, evaluate};
use crate::vol::spectrum::bins::Bins;
use crate::vol::spectrum::{BASE_LEVEL, Spectrum};
use crate::vol::tuning::TUNING;
use std::collections::BTreeSet;

/// The level of the lattice to which the energies of emission lines are rounded.
pub(crate) const LINE_LEVEL: u8 = 15;

/// Multiples of the golden ratio, modulo 1, are distinct and evenly distributed for any number of them.
pub(crate) const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;

/// A point of a part: a place in the image plane and a depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ProbePoint {
    /// The number of the part.
    pub(crate) part: usize,
    pub(crate) place: Place,
    pub(crate) depth: u32,
}

/// A point with its spectrum.
#[derive(Clone, Debug)]
pub(crate) struct SpectralProbe {
    pub(crate) point: ProbePoint,
    /// The effective path: the part of the unit depth that would give the integral of the line with
    /// the rate at this point.
    pub(crate) path: f64,
    /// Whether every bin is sampled.
    full: bool,
    /// The factor on the error allowed in the spectrum, at most 1. It is smaller for a spectrum
    /// that becomes a function, which may be multiplied by larger values elsewhere.
    precision: f64,
    /// The weight of an error in each bin; none if all are 1.
    pub(crate) weights: Vec<f64>,
    /// Places at which spot checks were not explained.
    wanted: BTreeSet<u32>,
    pub(crate) spectrum: Spectrum,
}

impl SpectralProbe {
    /// The weight of an error at a dyadic place of the axis, that of its bin.
    fn weight_at(&self, place: u32) -> f64 {
        weight_of_bin(&self.weights, place)
    }
}

/// The weight of an error at a dyadic place of the axis, given those of the bins; 1 if there are none.
pub(crate) fn weight_of_bin(weights: &[f64], place: u32) -> f64 {
    let bin = whole(unit(place) * weights.len() as f64);
    weights.get(bin).or(weights.last()).copied().unwrap_or(1.0)
}

/// A single sample that is compared with the selected energies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpotCheck {
    pub(crate) point: ProbePoint,
    /// A place of the energy axis.
    pub(crate) energy: u32,
    pub(crate) path: f64,
    pub(crate) expected: f64,
    /// The weight of an error there.
    pub(crate) weight: f64,
}

/// All spectral probes.
#[derive(Clone, Debug)]
pub(crate) struct SpectralProbes<'a> {
    pub(crate) bins: Bins<'a>,
    pub(crate) probes: Vec<SpectralProbe>,
    /// Places at which every spectrum is sampled, in addition to the lattice.
    common_energies: BTreeSet<u32>,
    /// For each part of the view the weights of errors on its raster, by bin; none if all are 1.
    weights: Vec<WeightsOfPart>,
}

impl<'a> SpectralProbes<'a> {
    pub(crate) fn new(bins: Bins<'a>) -> Self {
        let common_energies = BTreeSet::new();
        Self { bins, probes: Vec::new(), common_energies, weights: Vec::new() }
    }

    /// Replaces the weights of errors: those of each part on its raster, by bin.
    pub(crate) fn set_weights(&mut self, weights: Vec<WeightsOfPart>) {
        self.weights = weights;
        for i in 0..self.probes.len() {
            self.probes[i].weights = self.weights_at(&self.probes[i].point);
        }
    }

    /// The weight of an error at a point in each bin; none if all are 1.
    fn weights_at(&self, point: &ProbePoint) -> Vec<f64> {
        let of_part = self.weights.get(point.part).into_iter().flatten();
        of_part.map(|map| weight_in(map, point)).collect()
    }

    /// The weight of an error at a point and a place of the axis.
    pub(crate) fn weight_at(&self, point: &ProbePoint, energy: u32) -> f64 {
        let Some(of_part) = self.weights.get(point.part) else { return 1.0 };
        let bin = whole(unit(energy) * of_part.len() as f64).min(of_part.len() - 1);
        weight_in(&of_part[bin], point)
    }

    /// Adds a spectral probe at one sample of a line, unless there is one already.
    pub(crate) fn add(&mut self, point: ProbePoint, path: f64, full: bool) {
        if self.probes.iter().all(|probe| probe.point != point) {
            let weights = self.weights_at(&point);
            self.probes.push(SpectralProbe {
                point,
                path,
                full,
                precision: 1.0,
                weights,
                wanted: BTreeSet::new(),
                spectrum: Spectrum::default(),
            });
        }
    }

    /// Evaluates spot checks. The points of those with the largest errors, if these are above
    /// `allowed`, become spectral probes. Returns the number of such errors.
    pub(crate) async fn spot_check(
        &mut self,
        parts: &[View<'_>],
        checks: &[SpotCheck],
        allowed: f64,
    ) -> Result<usize, Stop> {
        let points: Vec<_> = checks.iter().map(|check| (check.point, check.energy)).collect();
        let rates = spectral_rates(parts, &points, &self.bins).await?;
        let unexplained = |(check, rate): (&SpotCheck, f64)| {
            let wrong = (rate - check.expected).abs() / self.bins.density(unit(check.energy));
            (wrong * check.path * check.weight, *check)
        };
        let mut found: Vec<(f64, SpotCheck)> = checks.iter().zip(rates).map(unexplained).collect();
        found.retain(|(wrong, _)| *wrong > allowed);
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let number = found.len();
        for (_, check) in found.into_iter().take(TUNING.spectra.most_followed_checks) {
            self.add(check.point, check.path, false);
            let probe = self.probes.iter_mut().find(|probe| probe.point == check.point);
            if let Some(probe) = probe {
                probe.wanted.insert(check.energy);
            }
        }
        Ok(number)
    }

    /// The level of the lattice of the energies of spot checks.
    pub(crate) fn checked_level(&self) -> u8 {
        let level = self.level_of_bins();
        (level + TUNING.spectra.checked_levels).clamp(
            TUNING.spectra.least_checked_level,
            TUNING.spectra.finest_checked_level.max(level),
        )
    }

    /// Adds energies, in the unit of the axis, at which every spectrum is sampled from now on.
    pub(crate) fn add_line_energies(&mut self, energies: &[f64]) {
        let cells = f64::from(1_u32 << LINE_LEVEL);
        for u in energies.iter().map(|&energy| self.bins.axis.canonical(energy)) {
            if (0.0..=1.0).contains(&u) {
                self.add_common_energy(
                    cell::to_u32(whole((u * cells).round())) * spacing(LINE_LEVEL),
                );
            }
        }
    }

    /// The places at which every spectrum is sampled, in addition to the lattice.
    pub(crate) fn common_energies(&self) -> impl Iterator<Item = u32> + '_ {
        self.common_energies.iter().copied()
    }

    /// Adds a place at which every spectrum is sampled from now on.
    pub(crate) fn add_common_energy(&mut self, place: u32) {
        self.common_energies.insert(place);
    }

    /// Reduces the error allowed in the spectrum of probe `i`, which becomes a function: its
    /// `effect` in a voxel may be as large as `largest` elsewhere.
    pub(crate) fn raise_precision(&mut self, i: usize, effect: f64, largest: f64) {
        let precision = &mut self.probes[i].precision;
        *precision = precision.min((effect / largest).max(TUNING.spectra.least_precision));
    }

    /// Samples and refines all spectra until the error of each is within a share of `allowed` in
    /// every voxel.
    pub(crate) async fn sample(&mut self, parts: &[View<'_>], allowed: f64) -> Result<(), Stop> {
        loop {
            let of_probe = |(i, probe): (usize, &SpectralProbe)| {
                let missing = self.missing(probe);
                let wanted =
                    if missing.is_empty() { self.structure(probe, allowed) } else { missing };
                wanted.into_iter().map(move |place| (i, place)).collect::<Vec<_>>()
            };
            let wanted: Vec<(usize, u32)> =
                self.probes.par_iter().enumerate().flat_map_iter(of_probe).collect();
            if wanted.is_empty() {
                return Ok(());
            }
            let point = |&(i, energy): &(usize, u32)| (self.probes[i].point, energy);
            let points: Vec<_> = wanted.iter().map(point).collect();
            let rates = spectral_rates(parts, &points, &self.bins).await?;
            for ((i, place), rate) in wanted.into_iter().zip(rates) {
                self.probes[i].spectrum.add(place, rate);
            }
        }
    }

    /// The places without a sample at which a spectrum is sampled independently of its structure.
    fn missing(&self, probe: &SpectralProbe) -> Vec<u32> {
        let whole = lattice(if probe.full { self.level_of_bins() } else { BASE_LEVEL });
        let found = self.common_energies.iter().chain(&probe.wanted).copied();
        let mut missing: Vec<u32> = whole.chain(found).collect();
        missing.retain(|&place| !probe.spectrum.has(place));
        missing.sort_unstable();
        missing.dedup();
        missing
    }

    /// The level whose lattice has a place in every bin.
    fn level_of_bins(&self) -> u8 {
        let level = self.bins.factors.len().next_power_of_two().trailing_zeros();
        u8::try_from(level).unwrap_or(u8::MAX).clamp(BASE_LEVEL, TUNING.spectra.finest_full_level)
    }

    /// The places at which the structure of a spectrum has to be refined.
    fn structure(&self, probe: &SpectralProbe, allowed: f64) -> Vec<u32> {
        let allowed = TUNING.spectra.spectrum_share * probe.precision * allowed;
        let effect = |place: u32| {
            probe.weight_at(place) * probe.path / (allowed * self.bins.density(unit(place)))
        };
        probe.spectrum.wanted(self.bins.factors.len(), effect)
    }

    /// The largest voxel that is expected from the spectra of the probes.
    pub(crate) fn largest(&self) -> f64 {
        let of_probe = |probe: &SpectralProbe| {
            let means = self.bins.means(&probe.spectrum);
            let matters = |bin: usize| probe.weights.get(bin).is_none_or(|weight| *weight > 0.0);
            let means = means.iter().enumerate().filter(|(bin, _)| matters(*bin));
            means.map(|(_, mean)| mean.abs() * probe.path).fold(0.0, f64::max)
        };
        self.probes.iter().map(of_probe).fold(0.0, f64::max)
    }
}

/// The weight at the place of a point on the raster of its part.
fn weight_in(map: &Image, point: &ProbePoint) -> f64 {
    let cell = |along: u32, cells: usize| whole(unit(along) * cells as f64).min(cells - 1);
    map[(cell(point.place[1], map.height()), cell(point.place[0], map.width()))]
}

/// G at points of the `parts`, each at its own place on the energy axis, in one batch.
pub(crate) async fn spectral_rates(
    parts: &[View<'_>],
    points: &[(ProbePoint, u32)],
    bins: &Bins<'_>,
) -> Result<Vec<f64>, Stop> {
    let Some(first) = parts.first() else { return Ok(Vec::new()) };
    let site = |i: usize| {
        let (ProbePoint { part, place: [x, y], depth }, energy) = points[i];
        parts[part].site([x, y, depth], Some(bins.sample_at(energy)))
    };
    evaluate(first.meter, points.len(), &site).await
}

/// The energies of line `number`: one in each of equal parts of the band, at a place that differs
/// from line to line.
pub(crate) fn energies_of_line(number: usize) -> impl Iterator<Item = u32> {
    let parts = TUNING.spectra.energies_per_line;
    let cells = f64::from(STEPS / spacing(LINE_LEVEL));
    let shift = (GOLDEN_RATIO * (number as f64 + 1.0)).fract();
    let place = move |part: u32| (f64::from(part) + shift) / f64::from(parts);
    (0..parts).map(move |part| cell::to_u32(whole(place(part) * cells)) * spacing(LINE_LEVEL))
}

/// The energy of check `number`, at another place of the band than those of the checks before.
pub(crate) fn energy_of_check(number: usize) -> u32 {
    let cells = f64::from(STEPS / spacing(LINE_LEVEL));
    let place = (GOLDEN_RATIO * (number as f64 + 1.0)).fract();
    cell::to_u32(whole(place * cells)) * spacing(LINE_LEVEL)
}

/// The places of one lattice.
fn lattice(level: u8) -> impl Iterator<Item = u32> {
    (0..=1_u32 << level).map(move |k| k * spacing(level))
}
