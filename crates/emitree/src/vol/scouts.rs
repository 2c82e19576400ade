//! Scouts: points of the volume at which whole spectra are sampled.
//!
//! They tell which energies are worth integrating, and whether those still explain what new lines
//! have found. Some look into every bin; where a spectrum shows structure it is refined. Spot checks are
//! single samples at many places and energies: where one is not explained a scout is sent.

use super::dyadic::{spacing, unit};
use super::energies::Bins;
use super::image_tree::Place;
use super::sights::{Stop, View};
use super::spectrum::{BASE_LEVEL, Spectrum};
use super::whole;
use crate::cell;
use crate::parallel::prelude::*;
use std::collections::BTreeSet;

/// The finest lattice that looks into every bin; with more bins than that, into some of them.
const FINEST_FULL_LEVEL: u8 = 10;
/// The lattice of spot checks, for few bins: a line is as narrow in a wide bin as in a narrow one…
const LEAST_CHECKED_LEVEL: u8 = 7;
/// …is finer than the bins by so many levels…
const CHECKED_LEVELS: u8 = 2;
/// …up to this one.
const FINEST_CHECKED_LEVEL: u8 = 8;
/// The lattice that the energies of lines are rounded to.
pub(crate) const LINE_LEVEL: u8 = 15;
/// The most scouts that spot checks may send.
const MOST_FOLLOWED: usize = 16;
/// No spectrum has to be more precise than others by more than this.
const LEAST_PRECISION: f64 = 1e-4;
/// What the refinement of a spectrum may leave, as a share of what its energies may.
const SPECTRUM_SHARE: f64 = 0.1;

/// A point of a layer: where on the image plane, and at which depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Post {
    /// The number of the layer.
    pub(crate) layer: usize,
    pub(crate) place: Place,
    pub(crate) depth: u32,
}

/// A point with its spectrum.
#[derive(Clone, Debug)]
pub(crate) struct Scout {
    pub(crate) post: Post,
    /// The part of the unit depth that G fills when it is everywhere as large as here.
    pub(crate) path: f64,
    /// Whether it looks into every bin.
    full: bool,
    /// How much more precise than others its spectrum has to be, 1 or less: an energy is learned from
    /// it, and may be brighter elsewhere.
    precision: f64,
    /// Where a spot check has found something.
    wanted: BTreeSet<u32>,
    pub(crate) spectrum: Spectrum,
}

/// One sample that is compared with what the energies make expect.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpotCheck {
    pub(crate) post: Post,
    /// A place of the energy axis.
    pub(crate) energy: u32,
    pub(crate) path: f64,
    pub(crate) expected: f64,
}

/// All scouts.
#[derive(Clone, Debug)]
pub(crate) struct Scouts<'a> {
    pub(crate) bins: Bins<'a>,
    pub(crate) scouts: Vec<Scout>,
    /// Where every spectrum is sampled, whatever it looks like.
    everywhere: BTreeSet<u32>,
}

impl<'a> Scouts<'a> {
    pub(crate) fn new(bins: Bins<'a>) -> Self {
        Self { bins, scouts: Vec::new(), everywhere: BTreeSet::new() }
    }

    /// Adds a scout at one sample of a line, unless there is one already.
    pub(crate) fn add(&mut self, post: Post, path: f64, full: bool) {
        if self.scouts.iter().all(|scout| scout.post != post) {
            self.scouts.push(Scout {
                post,
                path,
                full,
                precision: 1.0,
                wanted: BTreeSet::new(),
                spectrum: Spectrum::default(),
            });
        }
    }

    /// Sends scouts to the posts of the spot checks that the energies explain least, if they leave more
    /// than `allowed`. Each is a post, a place of the energy axis, the path and what is
    /// expected of it.
    pub(crate) async fn spot_check(
        &mut self,
        layers: &[View<'_>],
        checks: &[SpotCheck],
        allowed: f64,
    ) -> Result<(), Stop> {
        let points: Vec<_> = checks.iter().map(|check| (check.post, check.energy)).collect();
        let rates = View::spectral_rates(layers, &points, &self.bins).await?;
        let unexplained = |(check, rate): (&SpotCheck, f64)| {
            let wrong = (rate - check.expected).abs() / self.bins.density(unit(check.energy));
            (wrong * check.path, *check)
        };
        let mut found: Vec<(f64, SpotCheck)> = checks.iter().zip(rates).map(unexplained).collect();
        found.retain(|(wrong, _)| *wrong > allowed);
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, check) in found.into_iter().take(MOST_FOLLOWED) {
            self.add(check.post, check.path, false);
            let scout = self.scouts.iter_mut().find(|scout| scout.post == check.post);
            if let Some(scout) = scout {
                scout.wanted.insert(check.energy);
            }
        }
        Ok(())
    }

    /// The lattice of the energies of spot checks.
    pub(crate) fn checked_level(&self) -> u8 {
        let level = self.level_of_bins();
        (level + CHECKED_LEVELS).clamp(LEAST_CHECKED_LEVEL, FINEST_CHECKED_LEVEL.max(level))
    }

    /// Has every spectrum sampled at these energies from now on, in the unit of the axis.
    pub(crate) fn look_at_lines(&mut self, energies: &[f64]) {
        let cells = f64::from(1_u32 << LINE_LEVEL);
        for u in energies.iter().map(|&energy| self.bins.axis.canonical(energy)) {
            if (0.0..=1.0).contains(&u) {
                self.look_at(cell::to_u32(whole((u * cells).round())) * spacing(LINE_LEVEL));
            }
        }
    }

    /// Where every spectrum is sampled, whatever it looks like, besides the lattice.
    pub(crate) fn everywhere(&self) -> impl Iterator<Item = u32> + '_ {
        self.everywhere.iter().copied()
    }

    /// Has every spectrum sampled at this place from now on.
    pub(crate) fn look_at(&mut self, place: u32) {
        self.everywhere.insert(place);
    }

    /// Asks for a more precise spectrum of scout `i`, so that it can be learned from: its `effect` in a
    /// voxel may be as large as `largest` elsewhere.
    pub(crate) fn sharpen(&mut self, i: usize, effect: f64, largest: f64) {
        let precision = &mut self.scouts[i].precision;
        *precision = precision.min((effect / largest).max(LEAST_PRECISION));
    }

    /// Samples and refines all spectra until each is known to a share of `allowed` in every voxel.
    pub(crate) async fn sample(&mut self, layers: &[View<'_>], allowed: f64) -> Result<(), Stop> {
        loop {
            let of_scout = |(i, scout): (usize, &Scout)| {
                let missing = self.missing(scout);
                let wanted =
                    if missing.is_empty() { self.structure(scout, allowed) } else { missing };
                wanted.into_iter().map(move |place| (i, place)).collect::<Vec<_>>()
            };
            let wanted: Vec<(usize, u32)> =
                self.scouts.par_iter().enumerate().flat_map_iter(of_scout).collect();
            if wanted.is_empty() {
                return Ok(());
            }
            let point = |&(i, energy): &(usize, u32)| (self.scouts[i].post, energy);
            let points: Vec<_> = wanted.iter().map(point).collect();
            let rates = View::spectral_rates(layers, &points, &self.bins).await?;
            for ((i, place), rate) in wanted.into_iter().zip(rates) {
                self.scouts[i].spectrum.add(place, rate);
            }
        }
    }

    /// The places where a spectrum has to be sampled, whatever it looks like.
    fn missing(&self, scout: &Scout) -> Vec<u32> {
        let whole = lattice(if scout.full { self.level_of_bins() } else { BASE_LEVEL });
        let found = self.everywhere.iter().chain(&scout.wanted).copied();
        let mut missing: Vec<u32> = whole.chain(found).collect();
        missing.retain(|&place| !scout.spectrum.has(place));
        missing.sort_unstable();
        missing.dedup();
        missing
    }

    /// The level whose lattice has a place in every bin.
    fn level_of_bins(&self) -> u8 {
        let level = self.bins.factors.len().next_power_of_two().trailing_zeros();
        u8::try_from(level).unwrap_or(u8::MAX).clamp(BASE_LEVEL, FINEST_FULL_LEVEL)
    }

    /// The places at which structure of a spectrum is still to be looked at.
    fn structure(&self, scout: &Scout, allowed: f64) -> Vec<u32> {
        let allowed = SPECTRUM_SHARE * scout.precision * allowed;
        let effect = |place: u32| scout.path / (allowed * self.bins.density(unit(place)));
        scout.spectrum.wanted(self.bins.factors.len(), effect)
    }

    /// The largest voxel that is to be expected of what the scouts have seen.
    pub(crate) fn largest(&self) -> f64 {
        let of_scout = |scout: &Scout| {
            let means = self.bins.means(&scout.spectrum);
            means.iter().map(|mean| mean.abs() * scout.path).fold(0.0, f64::max)
        };
        self.scouts.iter().map(of_scout).fold(0.0, f64::max)
    }
}

/// The places of one lattice.
fn lattice(level: u8) -> impl Iterator<Item = u32> {
    (0..=1_u32 << level).map(move |k| k * spacing(level))
}
