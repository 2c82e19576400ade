//! The energies of a cube: found from spectra, tested on spectra where new lines have looked.

use super::dyadic::{STEPS, spacing, unit};
use super::energies::{self, Bins, Energies, Rest};
use super::engine::{Engine, within_budget};
use super::exam::Exam;
use super::image_tree::ImageTree;
use super::line::Line;
use super::round::Scan;
use super::scouts::{LINE_LEVEL, Post, Scouts, SpotCheck};
use super::seeds::Looks;
use super::sheet::Sheet;
use super::sights::{EnergySample, Sights, Stop, View};
use super::whole;
use crate::cell;
use crate::energy::EnergyAxis;
use crate::exchange::MethodError;
use crate::parallel::prelude::*;
use std::collections::BTreeSet;

/// The share of the tolerance that the energies may leave unexplained.
const ENERGY_SHARE: f64 = 0.1;
/// New energies are learned until they leave this share of that: the next spectra differ a little.
const LEARNED_SHARE: f64 = 0.5;
/// Spectra that nobody has sampled are worse explained than those that have been, by this much.
const UNSEEN_MARGIN: f64 = 1.5;
/// Before anything is known G is sampled at so many points along each axis…
const FIRST_LOOK: u32 = 4;
/// …or at so many of each layer, if there are more layers than this…
const FIRST_LOOK_OF_MANY: u32 = 2;
const MANY_LAYERS: usize = 3;
/// …and on the energy axis on the lattice of this level.
const FIRST_LOOK_LEVEL: u8 = 2;
/// Scouts on the base lines of the first energy.
const FIRST_SCOUTS: usize = 24;
/// Scouts on the base lines of each later one.
const LATER_SCOUTS: usize = 4;
/// Scouts on the new lines of each round.
const ROUND_SCOUTS: usize = 4;
/// One scout in so many looks into every bin.
const FULL_SCOUTS: usize = 3;
/// A third of the scouts are where lines are brightest, a third on lines beyond this share of the
/// brightest one, and a third anywhere: at other energies they may be bright.
const DIM: f64 = 1e-2;
/// From line to line spot checks of dark lines go on by so many depths.
const DEPTH_STRIDE: usize = 5;
/// Each line of the base is checked at one of so many energies.
const CHECKED_PARTS: u32 = 8;
/// The most energies: this many for each bin, and some more.
const ENERGIES_PER_BIN: usize = 2;
const MORE_ENERGIES: usize = 16;

/// What is known of the spectra.
pub(crate) struct Spectra<'a> {
    scouts: Scouts<'a>,
    /// What the energies leave in a voxel of each bin, as far as spectra have been sampled.
    pub(crate) unexplained: Vec<f64>,
    /// Whether all spectra that were to be sampled have been.
    pub(crate) are_explained: bool,
    share: f64,
    /// Nodes of each sheet that scouts have been chosen from.
    scouted: Vec<usize>,
}

impl<'a> Spectra<'a> {
    /// `lines` are energies at which every spectrum is looked at, in the unit of the axis.
    pub(crate) fn new(axis: &'a EnergyAxis, lines: &[f64]) -> Self {
        let mut scouts = Scouts::new(Bins::new(axis));
        scouts.look_at_lines(lines);
        Self {
            scouts,
            unexplained: vec![0.0; axis.bins()],
            are_explained: false,
            share: ENERGY_SHARE,
            scouted: Vec::new(),
        }
    }

    pub(crate) fn axis(&self) -> &'a EnergyAxis {
        self.scouts.bins.axis
    }

    /// The energies of the first look: a coarse lattice, and the lines that were named.
    fn first_energies(&self) -> Vec<u32> {
        let lattice = (0..=1_u32 << FIRST_LOOK_LEVEL).map(|k| k * spacing(FIRST_LOOK_LEVEL));
        let mut energies: Vec<u32> = lattice.chain(self.scouts.everywhere()).collect();
        energies.sort_unstable();
        energies.dedup();
        energies
    }

    /// Leaves less to be unexplained.
    pub(crate) fn tighten(&mut self) {
        self.share *= 0.5;
    }
}

impl<'b> Engine<'b> {
    /// The energies at which lines were integrated, ascending.
    pub(crate) fn energies_used(&self) -> Vec<f64> {
        let Some(spectra) = &self.spectra else { return Vec::new() };
        let energy = |one: &energies::Learned| spectra.axis().energy(unit(one.place));
        let mut energies: Vec<f64> = self.energies.learned.iter().map(energy).collect();
        energies.sort_by(f64::total_cmp);
        energies
    }

    /// Adds a sheet for each layer, at a place of the energy axis if there is one.
    pub(crate) fn add_sheets(&mut self, energy: Option<u32>) {
        let spectra = self.spectra.as_ref();
        let energy = spectra.zip(energy).map(|(s, place)| EnergySample::at(place, &s.scouts.bins));
        for visible in &self.layers {
            let layer = visible.layer;
            let view =
                View { meter: self.meter, layer, tile: (visible.tile, self.tiles.len()), energy };
            let scan = Scan {
                view,
                base_level: self.base_level,
                depth_level: self.base_level,
                tree: ImageTree::default(),
                sights: Sights::default(),
                seeds: Looks::at(self.seeds, layer, self.base_level, self.finest_level),
                closes: false,
            };
            self.sheets.push(Sheet {
                scan,
                tile: visible.tile,
                layers: visible.layers,
                shares: visible.shares.clone(),
                scale: visible.scale.clone(),
                exam: Exam::default(),
            });
        }
    }

    fn views(&self) -> Vec<View<'b>> {
        let view = |visible: &super::visible::Visible<'b>| View {
            meter: self.meter,
            layer: visible.layer,
            tile: (visible.tile, self.tiles.len()),
            energy: None,
        };
        self.layers.iter().map(view).collect()
    }

    /// How many evaluations the first look at energies takes.
    pub(crate) fn cost_of_first_energy(&self) -> u64 {
        let energies = self.spectra.as_ref().map_or(0, |spectra| spectra.first_energies().len());
        (self.first_posts().len() * energies) as u64
    }

    /// Where on the energy axis a few points of the volume are brightest; the middle of the axis if
    /// they are all dark.
    pub(crate) async fn brightest_energy(&self) -> Result<Option<u32>, Stop> {
        let Some(spectra) = &self.spectra else { return Ok(None) };
        let bins = &spectra.scouts.bins;
        let energies = spectra.first_energies();
        let posts = self.first_posts();
        let points: Vec<_> = posts
            .iter()
            .flat_map(|&post| energies.iter().map(move |&energy| (post, energy)))
            .collect();
        let rates = View::spectral_rates(&self.views(), &points, bins).await?;
        let mut sums = vec![0.0; energies.len()];
        for rates in rates.chunks(energies.len()) {
            for ((sum, rate), &place) in sums.iter_mut().zip(rates).zip(&energies) {
                *sum += rate.abs() / bins.density(unit(place));
            }
        }
        let middle = energies.len() / 2;
        let brightest =
            (0..sums.len()).fold(middle, |best, k| if sums[k] > sums[best] { k } else { best });
        if sums[brightest] > 0.0 {
            return Ok(Some(energies[brightest]));
        }
        // A spectrum may lie between these energies: each point looks at others.
        let (step, cell) = (spacing(FIRST_LOOK_LEVEL), spacing(LINE_LEVEL));
        let shifted = |(number, &post): (usize, &Post)| {
            // The golden ratio keeps the shifts of any number of points apart.
            let shift = (0.618_033_988_749_895 * (number as f64 + 1.0)).fract();
            let shift = cell::to_u32(whole(shift * f64::from(step / cell))) * cell;
            (0..1_u32 << FIRST_LOOK_LEVEL).map(move |k| (post, k * step + shift))
        };
        let points: Vec<_> = posts.iter().enumerate().flat_map(shifted).collect();
        let rates = View::spectral_rates(&self.views(), &points, bins).await?;
        let size = |i: usize| rates[i].abs() / bins.density(unit(points[i].1));
        let brightest =
            (0..points.len()).fold(0, |best, i| if size(i) > size(best) { i } else { best });
        let is_dark = points.is_empty() || size(brightest) == 0.0;
        Ok(Some(if is_dark { STEPS / 2 } else { points[brightest].1 }))
    }

    /// The points of the first look at energies: the middles of equal parts of each layer.
    fn first_posts(&self) -> Vec<Post> {
        let per_axis =
            if self.layers.len() > MANY_LAYERS { FIRST_LOOK_OF_MANY } else { FIRST_LOOK };
        let along = |k: u32| (2 * k + 1) * (STEPS / (2 * per_axis));
        let of_layer = |layer: usize| {
            (0..per_axis.pow(3)).map(move |k| {
                let [i, j, k] = [k % per_axis, k / per_axis % per_axis, k / per_axis / per_axis];
                Post { layer, place: [along(i), along(j)], depth: along(k) }
            })
        };
        (0..self.layers.len()).flat_map(of_layer).collect()
    }

    /// The energies that the spectra on the base lines of the first one need, and their base lines;
    /// whether the budget allowed it.
    pub(crate) async fn look_at_first_spectra(
        &mut self,
        first: Option<u32>,
    ) -> Result<bool, MethodError> {
        self.energies = Energies::default();
        self.add_scouts(FIRST_SCOUTS);
        let views = self.views();
        let Some(spectra) = &mut self.spectra else { return Ok(true) };
        let first = first.unwrap_or_default();
        spectra.scouts.look_at(first);
        // How bright the voxels are is known once some of the spectra are.
        let mut looked = within_budget(spectra.scouts.sample(&views, f64::INFINITY).await)?;
        let largest = spectra.scouts.largest();
        let allowed = spectra.share * self.tolerance * largest;
        looked = looked && within_budget(spectra.scouts.sample(&views, allowed).await)?;
        let Scouts { scouts, bins, .. } = &spectra.scouts;
        let rest = |scout| self.energies.rest(scout, bins);
        let mut rests: Vec<Rest> = scouts.iter().map(rest).collect();
        let effect = |i: &usize| rests[*i].effect_at(first, bins);
        let brightest = (0..rests.len()).max_by(|a, b| effect(a).total_cmp(&effect(b)));
        let learned =
            brightest.is_some_and(|i| self.energies.learn(&mut rests, i, Some(first), bins));
        if !learned {
            // Nothing glows there, or it is not known what does.
            let weight = if looked { 0.0 } else { 1.0 };
            self.energies = Energies::unlearned(first, bins.factors.len(), weight);
        }
        if !looked {
            return Ok(false);
        }
        Ok(self.learn_energies(largest).await?
            && self.spot_check(largest).await?
            && self.learn_energies(largest).await?)
    }

    /// Samples spectra on new lines, and adds the energies that they need; whether the budget
    /// allowed it. `largest` is the largest voxel.
    pub(crate) async fn look_at_spectra(&mut self, largest: f64) -> Result<bool, MethodError> {
        self.add_scouts(ROUND_SCOUTS);
        self.learn_energies(largest).await
    }

    /// Adds energies until all sampled spectra are explained, with their base lines; whether the
    /// budget allowed it.
    async fn learn_energies(&mut self, largest: f64) -> Result<bool, MethodError> {
        loop {
            let known = self.energies.len();
            let views = self.views();
            let Some(spectra) = &mut self.spectra else { return Ok(true) };
            // How bright new ones are is part of the target.
            if !within_budget(spectra.scouts.sample(&views, f64::INFINITY).await)? {
                spectra.are_explained = false;
                return Ok(false);
            }
            let target = self.tolerance * largest.max(spectra.scouts.largest());
            if !self.explain_spectra(target).await? {
                return Ok(false);
            }
            let places: Vec<u32> =
                self.energies.learned[known..].iter().map(|one| one.place).collect();
            if places.is_empty() {
                return Ok(true);
            }
            let first = self.sheets.len();
            for &place in &places {
                self.add_sheets(Some(place));
                self.spectra.iter_mut().for_each(|spectra| spectra.scouts.look_at(place));
            }
            let tolerances = self.line_tolerances(target);
            if !self.look_at_base(first, Some(&tolerances)).await? {
                self.sheets.truncate(first);
                self.energies.learned.truncate(known);
                return Ok(false);
            }
            self.add_scouts(LATER_SCOUTS * places.len());
        }
    }

    /// Adds energies until all sampled spectra are explained to their share of `target`; whether the
    /// budget allowed it.
    async fn explain_spectra(&mut self, target: f64) -> Result<bool, MethodError> {
        let views = self.views();
        let Some(spectra) = &mut self.spectra else { return Ok(true) };
        let allowed = spectra.share * target;
        let most = ENERGIES_PER_BIN * spectra.scouts.bins.factors.len() + MORE_ENERGIES;
        let mut sampled = within_budget(spectra.scouts.sample(&views, allowed).await)?;
        let Spectra { scouts, unexplained, .. } = &mut *spectra;
        let rest = |scout| self.energies.rest(scout, &scouts.bins);
        let mut rests: Vec<Rest> = scouts.scouts.par_iter().map(rest).collect();
        let left = energies::unexplained(&rests, &scouts.bins);
        *unexplained = left.iter().map(|left| UNSEEN_MARGIN * left).collect();
        let mut goal = allowed;
        while sampled && self.energies.len() < most {
            let worst =
                (0..rests.len()).max_by(|a, b| rests[*a].largest().total_cmp(&rests[*b].largest()));
            let Some(worst) = worst.filter(|&i| rests[i].largest() > goal) else { break };
            goal = LEARNED_SHARE * allowed;
            scouts.sharpen(worst, rests[worst].largest(), target / self.tolerance);
            sampled = within_budget(scouts.sample(&views, allowed).await)?;
            rests[worst] = self.energies.rest(&scouts.scouts[worst], &scouts.bins);
            if !self.energies.learn(&mut rests, worst, None, &scouts.bins) {
                break;
            }
        }
        spectra.are_explained = sampled;
        Ok(sampled)
    }

    /// Adds scouts on lines that no scout has been chosen from yet, at the brightest depth and at
    /// others in turn.
    fn add_scouts(&mut self, most: usize) {
        let layers = self.layers.len();
        let Some(spectra) = &mut self.spectra else { return };
        spectra.scouted.resize(self.sheets.len(), 0);
        let mut lines: Vec<(f64, usize, usize)> = Vec::new();
        for (i, sheet) in self.sheets.iter().enumerate() {
            let sights = &sheet.scan.sights;
            let new = (spectra.scouted[i]..sights.lines.len()).filter(|&k| !sights.is_closed(k));
            lines.extend(new.map(|k| (sights.lines[k].brightness(), i, k)));
            spectra.scouted[i] = sights.lines.len();
        }
        lines.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let of_brightest = DIM * lines.first().map_or(0.0, |line| line.0);
        let not_dim = lines.partition_point(|line| line.0 > of_brightest);
        let third = most.div_ceil(3);
        let spread = |from: usize, to: usize| {
            let stride = (to.saturating_sub(from) / third).max(1);
            (from + stride / 2..to).step_by(stride).take(third)
        };
        let bright = third.min(lines.len());
        let chosen = (0..bright).chain(spread(bright, not_dim)).chain(spread(bright, lines.len()));
        let mut chosen: BTreeSet<usize> = chosen.collect();
        // The brightest line of each energy.
        let mut energies = BTreeSet::new();
        let first_of_energy = |&number: &usize| energies.insert(lines[number].1 / layers);
        chosen.extend((0..lines.len()).filter(first_of_energy));
        let lines = chosen.into_iter().map(|number| lines[number]);
        for (number, (_, i, k)) in lines.enumerate() {
            let scan = &self.sheets[i].scan;
            let line = &scan.sights.lines[k];
            let mut by_rate: Vec<usize> = (0..line.samples.len()).collect();
            let rate = |s: &usize| line.samples[*s].rate.abs();
            by_rate.sort_by(|a, b| rate(b).total_cmp(&rate(a)).then(a.cmp(b)));
            // The brightest sample, then one of the brighter half, and so on.
            let of_line = match number % 2 {
                0 => 0,
                _ => 1 + number / 2 % (by_rate.len() / 2).max(1),
            };
            let Some(&sample) = by_rate.get(of_line) else { continue };
            let sample = &line.samples[sample];
            if sample.rate != 0.0 {
                let place = scan.tree.nodes()[k].place;
                let post = Post { layer: i % layers, place, depth: sample.depth };
                let path = path_of(line, sample.rate);
                spectra.scouts.add(post, path, number.is_multiple_of(FULL_SCOUTS));
            }
        }
    }

    /// Single samples on all lines of the base, each line at a part of the energies, and scouts where
    /// those are not explained; whether the budget allowed it.
    async fn spot_check(&mut self, largest: f64) -> Result<bool, MethodError> {
        let views = self.views();
        let layers = self.layers.len();
        let Some(spectra) = &mut self.spectra else { return Ok(true) };
        let step = spacing(spectra.scouts.checked_level());
        let mut checks = Vec::new();
        for (layer, sheet) in self.sheets[..layers].iter().enumerate() {
            let Scan { sights, tree, base_level, .. } = &sheet.scan;
            for (i, line) in sights.lines.iter().enumerate().filter(|(i, _)| !sights.is_closed(*i))
            {
                let brighter = |best: usize, k: usize| {
                    let [a, b] = [best, k].map(|k| line.samples[k].rate.abs());
                    if b > a { k } else { best }
                };
                // Dark lines look at different depths.
                let samples = 0..line.samples.len();
                let any = DEPTH_STRIDE * i % samples.len().max(1);
                let brightest = &line.samples[samples.fold(any, brighter)];
                let path = path_of(line, brightest.rate);
                let post = Post { layer, place: tree.nodes()[i].place, depth: brightest.depth };
                // Neighbours look at different energies.
                let [x, y] = post.place.map(|along| along / spacing(*base_level));
                let first = (3 * x + y) % CHECKED_PARTS;
                let rates = || {
                    let of_layer = self.sheets.iter().skip(layer).step_by(layers);
                    of_layer.map(|sheet| sheet.scan.sights.lines[i].rate(post.depth))
                };
                let energies = (first..=STEPS / step).step_by(CHECKED_PARTS as usize);
                checks.extend(energies.map(|k| k * step).map(|energy| SpotCheck {
                    post,
                    energy,
                    path,
                    expected: self.energies.explained(rates(), energy),
                }));
            }
        }
        let allowed = spectra.share * self.tolerance * largest;
        within_budget(spectra.scouts.spot_check(&views, &checks, allowed).await)
    }
}

/// The part of the unit depth that G fills when it is everywhere as large as at a sample of a line;
/// all of it if that is not known.
fn path_of(line: &Line, rate: f64) -> f64 {
    let path = line.brightness() / rate.abs();
    if path > 0.0 { path.min(1.0) } else { 1.0 }
}
