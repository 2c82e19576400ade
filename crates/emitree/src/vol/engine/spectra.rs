//! The energies of a cube: selected from sampled spectra, and verified with spectra on new lines.

use crate::energy::EnergyAxis;
use crate::exchange::MethodError;
use crate::vol::dyadic::{STEPS, spacing, unit};
use crate::vol::engine::{Engine, within_budget};
use crate::vol::error_weights::WeightsOfPart;
use crate::vol::image::tree::ImageTree;
use crate::vol::line::Line;
use crate::vol::line::node_lines::NodeLines;
use crate::vol::rule::scan::Scan;
use crate::vol::sampling::View;
use crate::vol::seeds::SeedTargets;
use crate::vol::spectrum::bins::Bins;
use crate::vol::spectrum::energies::{self, Energies};
use crate::vol::spectrum::probes::{ProbePoint, SpectralProbes, SpotCheck};
use crate::vol::spectrum::selection::SelectionLimits;
use crate::vol::tuning::TUNING;
use crate::vol::view::part::Part;
use crate::vol::view::sheet::{Sheet, SheetId};
use crate::vol::view::verification::Verification;
use std::collections::BTreeSet;

mod verification;

/// The sampled spectra, and the error that the selected energies leave.
pub(crate) struct Spectra<'a> {
    pub(super) probes: SpectralProbes<'a>,
    /// The largest weighted residual of the sampled spectra in a voxel of each bin, with a margin.
    pub(crate) unexplained: Vec<f64>,
    /// The residual of each sampled spectrum in a voxel of each bin, without weights; none if these are 1.
    residuals: Vec<Vec<f64>>,
    /// Whether all spectra could be sampled and are explained.
    pub(crate) are_explained: bool,
    share: f64,
    /// For each sheet, the number of nodes that spectral probes have been chosen from.
    probed: Vec<usize>,
    /// For each sheet, the number of lines of its verification that have been compared.
    verified: Vec<usize>,
    /// The number of these lines of all sheets.
    verified_lines: usize,
}

impl<'a> Spectra<'a> {
    /// `lines` are energies, in the unit of the axis, at which every spectrum is sampled.
    pub(crate) fn new(axis: &'a EnergyAxis, lines: &[f64]) -> Self {
        let mut probes = SpectralProbes::new(Bins::new(axis));
        probes.add_line_energies(lines);
        Self {
            probes,
            unexplained: vec![0.0; axis.bins()],
            residuals: Vec::new(),
            are_explained: false,
            share: TUNING.spectra.energy_share,
            probed: Vec::new(),
            verified: Vec::new(),
            verified_lines: 0,
        }
    }

    pub(crate) fn axis(&self) -> &'a EnergyAxis {
        self.probes.bins.axis
    }

    /// Replaces the weights of errors: those of each part on its raster, by bin.
    pub(crate) fn set_weights(&mut self, weights: Vec<WeightsOfPart>) {
        self.probes.set_weights(weights);
    }

    /// Weights the residuals with the present weights of errors.
    pub(crate) fn weigh_residuals(&mut self) {
        let mut largest = vec![0.0; self.unexplained.len()];
        for (residual, probe) in self.residuals.iter().zip(&self.probes.probes) {
            for ((most, effect), weight) in largest.iter_mut().zip(residual).zip(&probe.weights) {
                *most = f64::max(*most, TUNING.spectra.unsampled_margin * effect * weight);
            }
        }
        self.unexplained = largest;
    }

    /// Halves the residual that is allowed.
    pub(crate) fn tighten(&mut self) {
        self.share *= 0.5;
    }
}

impl<'b> Engine<'b> {
    /// The energies at which lines of sight were integrated, in ascending order.
    pub(crate) fn energies_used(&self) -> Vec<f64> {
        let Some(spectra) = &self.spectra else { return Vec::new() };
        let energy = |one: &energies::SelectedEnergy| spectra.axis().energy(unit(one.place));
        let mut energies: Vec<f64> = self.energies.selected.iter().map(energy).collect();
        energies.sort_by(f64::total_cmp);
        energies
    }

    /// Adds a sheet for each part, at a place of the energy axis if there is one.
    pub(crate) fn add_sheets(&mut self, energy: Option<u32>) {
        let spectra = self.spectra.as_ref();
        let energy = spectra.zip(energy).map(|(s, place)| s.probes.bins.sample_at(place));
        let number = self.sheets.last().map_or(0, |last| last.id.energy + 1);
        let parts =
            self.parts.iter().enumerate().filter(|(number, _)| self.products[*number].is_none());
        for (part_number, part) in parts {
            let base_level = part.base_level(self.base_level);
            let scan = Scan {
                view: View { energy, ..self.view(part) },
                base_level,
                depth_level: base_level,
                tree: ImageTree::default(),
                node_lines: NodeLines::default(),
                seeds: self.seed_targets(part_number, base_level),
                weights: None,
            };
            self.sheets.push(Sheet {
                id: SheetId { part: part_number, energy: number },
                scan,
                pieces_of_line: part.pieces_of_line,
                footing: self.footings[part_number].clone(),
                scale: part.scale.clone(),
                weighted_scale: part.scale.clone(),
                verification: Verification::default(),
            });
        }
    }

    /// The nodes and depths of a part that the options and the first hits require.
    fn seed_targets(&self, part: usize, base_level: u8) -> SeedTargets {
        let chart = &*self.parts[part].chart;
        let mut targets = SeedTargets::at(&self.vol.seeds, chart, base_level, self.finest_level);
        let hits = self.first_hits.iter().filter(|hit| hit.point.part == part);
        for hit in hits {
            hit.add_to(&mut targets, base_level, self.finest_level);
        }
        targets
    }

    /// The view in which a part is sampled.
    fn view(&self, part: &'b Part<'b>) -> View<'b> {
        View { meter: self.meter, chart: &*part.chart, tiles: self.tiles.len(), energy: None }
    }

    pub(super) fn views(&self) -> Vec<View<'b>> {
        self.parts.iter().map(|part| self.view(part)).collect()
    }

    /// Selects the energies that the spectra on the base lines of the first one require, and
    /// samples their base lines. Returns whether the budget sufficed.
    pub(crate) async fn sample_first_spectra(
        &mut self,
        first: Option<u32>,
    ) -> Result<bool, MethodError> {
        self.energies = Energies::default();
        self.add_probes(TUNING.spectra.first_probes);
        let views = self.views();
        let Some(spectra) = &mut self.spectra else { return Ok(true) };
        let first = first.unwrap_or_default();
        spectra.probes.add_common_energy(first);
        // The size of the voxels is known only after the first samples of the spectra.
        let mut sampled = within_budget(spectra.probes.sample(&views, f64::INFINITY).await)?;
        let largest = spectra.probes.largest();
        let allowed = spectra.share * self.tolerance * largest;
        sampled = sampled && within_budget(spectra.probes.sample(&views, allowed).await)?;
        let selected = Energies::first(&spectra.probes, first);
        let bins = spectra.probes.bins.factors.len();
        self.energies = selected.unwrap_or_else(|| {
            // All spectra are dark there, or the budget did not suffice to sample them.
            Energies::unselected(first, bins, if sampled { 0.0 } else { 1.0 })
        });
        if !sampled {
            return Ok(false);
        }
        Ok(self.select_energies(largest).await?
            && self.spot_check(largest).await?
            && self.select_energies(largest).await?)
    }

    /// Samples spectra on the lines of trees that another emission has left, and adds the energies that they
    /// require, unless the trees are fixed. Returns whether the budget sufficed.
    pub(crate) async fn sample_spectra_of_start(&mut self) -> Result<bool, MethodError> {
        self.add_probes(TUNING.spectra.first_probes);
        if let Some(spectra) = &mut self.spectra {
            for energy in &self.energies.selected {
                spectra.probes.add_common_energy(energy.place);
            }
        }
        let largest = self.assemble()?.largest_pixel();
        Ok(self.select_energies(largest).await?
            && self.spot_check(largest).await?
            && self.select_energies(largest).await?)
    }

    /// Samples spectra on new lines, and adds the energies that they require; `largest` is the
    /// largest voxel. Returns whether the budget sufficed.
    pub(crate) async fn sample_spectra(&mut self, largest: f64) -> Result<bool, MethodError> {
        self.add_probes(TUNING.spectra.round_probes);
        self.select_energies(largest).await
    }

    /// Adds energies, with their base lines, until all sampled spectra are explained. Returns
    /// whether the budget sufficed.
    async fn select_energies(&mut self, largest: f64) -> Result<bool, MethodError> {
        loop {
            let known = self.energies.len();
            let views = self.views();
            let Some(spectra) = &mut self.spectra else { return Ok(true) };
            // The target depends on the brightness of new spectra.
            if !within_budget(spectra.probes.sample(&views, f64::INFINITY).await)? {
                spectra.are_explained = false;
                return Ok(false);
            }
            let target = self.tolerance * largest.max(spectra.probes.largest());
            if !self.explain_spectra(target).await? {
                return Ok(false);
            }
            let places: Vec<u32> =
                self.energies.selected[known..].iter().map(|one| one.place).collect();
            if places.is_empty() {
                return Ok(true);
            }
            let first = self.sheets.len();
            for &place in &places {
                self.add_sheets(Some(place));
                self.spectra.iter_mut().for_each(|spectra| spectra.probes.add_common_energy(place));
            }
            let tolerances = self.line_tolerances(target);
            if !self.sample_base(first, Some(&tolerances)).await? {
                self.sheets.truncate(first);
                self.energies.selected.truncate(known);
                return Ok(false);
            }
            self.add_probes(TUNING.spectra.later_probes * places.len());
        }
    }

    /// Adds energies until all sampled spectra are explained to their share of `target`. Returns
    /// whether the budget sufficed.
    async fn explain_spectra(&mut self, target: f64) -> Result<bool, MethodError> {
        let views = self.views();
        let Some(spectra) = &mut self.spectra else { return Ok(true) };
        let allowed = spectra.share * target;
        let most = match self.is_fixed {
            true => 0,
            false => SelectionLimits::most_of_bins(spectra.probes.bins.factors.len()),
        };
        let mut sampled = within_budget(spectra.probes.sample(&views, allowed).await)?;
        let Spectra { probes, unexplained, residuals: of_probes, .. } = &mut *spectra;
        let mut residuals = self.energies.residuals(probes);
        if sampled {
            let limits = SelectionLimits { allowed, largest: target / self.tolerance, most };
            let selection =
                self.energies.select_until_explained(probes, &mut residuals, &views, &limits);
            sampled = within_budget(selection.await)?;
        }
        *unexplained = energies::expected(&residuals, &probes.bins);
        if !self.vol.is_uniform() {
            *of_probes = residuals.iter().map(|residual| residual.effects.clone()).collect();
        }
        spectra.are_explained = sampled;
        Ok(sampled)
    }

    /// Adds spectral probes on lines that none has been chosen from, in turn at the brightest depth
    /// and at others.
    fn add_probes(&mut self, most: usize) {
        let Some(spectra) = &mut self.spectra else { return };
        spectra.probed.resize(self.sheets.len(), 0);
        let mut lines: Vec<(f64, usize, usize)> = Vec::new();
        for (i, sheet) in self.sheets.iter().enumerate() {
            let node_lines = &sheet.scan.node_lines;
            let new = spectra.probed[i]..node_lines.lines.len();
            lines.extend(new.map(|k| (node_lines.lines[k].brightness(), i, k)));
            spectra.probed[i] = node_lines.lines.len();
        }
        lines.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let of_brightest = TUNING.spectra.dim_share * lines.first().map_or(0.0, |line| line.0);
        let not_dim = lines.partition_point(|line| line.0 > of_brightest);
        let third = most.div_ceil(3);
        let spread = |from: usize, to: usize| {
            let stride = (to.saturating_sub(from) / third).max(1);
            (from + stride / 2..to).step_by(stride).take(third)
        };
        let bright = third.min(lines.len());
        let chosen = (0..bright).chain(spread(bright, not_dim)).chain(spread(bright, lines.len()));
        let mut chosen: BTreeSet<usize> = chosen.collect();
        // In addition, the brightest line of each energy has a probe.
        let mut energies = BTreeSet::new();
        let first_of_energy =
            |&number: &usize| energies.insert(self.sheets[lines[number].1].id.energy);
        chosen.extend((0..lines.len()).filter(first_of_energy));
        let lines = chosen.into_iter().map(|number| lines[number]);
        for (number, (_, i, k)) in lines.enumerate() {
            let scan = &self.sheets[i].scan;
            let line = &scan.node_lines.lines[k];
            let mut by_rate: Vec<usize> = (0..line.samples.len()).collect();
            let rate = |s: &usize| line.samples[*s].rate.abs();
            by_rate.sort_by(|a, b| rate(b).total_cmp(&rate(a)).then(a.cmp(b)));
            // Every second probe is at the brightest sample, the others are spread over the
            // brighter half.
            let of_line = match number % 2 {
                0 => 0,
                _ => 1 + number / 2 % (by_rate.len() / 2).max(1),
            };
            let Some(&sample) = by_rate.get(of_line) else { continue };
            let sample = &line.samples[sample];
            if sample.rate != 0.0 {
                let place = scan.tree.nodes()[k].place;
                let point = ProbePoint { part: self.sheets[i].id.part, place, depth: sample.depth };
                let path = path_of(line, sample.rate);
                spectra.probes.add(
                    point,
                    path,
                    number.is_multiple_of(TUNING.spectra.full_probe_stride),
                );
            }
        }
    }

    /// Compares single samples on all base lines, each at a part of the energies, with the selected
    /// energies. Samples that are not explained become spectral probes. Returns whether the budget
    /// sufficed.
    async fn spot_check(&mut self, largest: f64) -> Result<bool, MethodError> {
        let views = self.views();
        let parts = self.parts.len();
        let Some(spectra) = &mut self.spectra else { return Ok(true) };
        let step = spacing(spectra.probes.checked_level());
        let mut checks = Vec::new();
        for (part, sheet) in self.sheets[..parts].iter().enumerate() {
            let Scan { node_lines, tree, base_level, .. } = &sheet.scan;
            // The first nodes of each sheet.
            let base_lines = ((1_usize << base_level) + 1).pow(2);
            for (i, line) in node_lines.lines.iter().take(base_lines).enumerate() {
                let brighter = |best: usize, k: usize| {
                    let [a, b] = [best, k].map(|k| line.samples[k].rate.abs());
                    if b > a { k } else { best }
                };
                // On dark lines the depth changes from line to line.
                let samples = 0..line.samples.len();
                let any = TUNING.spectra.depth_stride * i % samples.len().max(1);
                let brightest = &line.samples[samples.fold(any, brighter)];
                let path = path_of(line, brightest.rate);
                let point =
                    ProbePoint { part, place: tree.nodes()[i].place, depth: brightest.depth };
                // Neighbouring lines are sampled at different energies.
                let [x, y] = point.place.map(|along| along / spacing(*base_level));
                let first = (3 * x + y) % TUNING.spectra.checked_parts;
                let rates = || {
                    let of_part = self.sheets.iter().filter(|sheet| sheet.id.part == part);
                    of_part.map(|sheet| sheet.scan.node_lines.lines[i].rate(point.depth))
                };
                let energies =
                    (first..=STEPS / step).step_by(TUNING.spectra.checked_parts as usize);
                checks.extend(energies.map(|k| k * step).map(|energy| SpotCheck {
                    point,
                    energy,
                    path,
                    weight: spectra.probes.weight_at(&point, energy),
                    expected: self.energies.explained(rates(), energy),
                }));
            }
        }
        let allowed = spectra.share * self.tolerance * largest;
        within_budget(spectra.probes.spot_check(&views, &checks, allowed).await.map(|_| ()))
    }
}

/// The effective path at a sample of a line: ∫ |G| dz over |G| there, at most 1; 1 if it is not
/// defined.
fn path_of(line: &Line, rate: f64) -> f64 {
    let path = line.brightness() / rate.abs();
    if path > 0.0 { path.min(1.0) } else { 1.0 }
}
