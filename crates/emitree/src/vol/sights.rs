//! The lines of sight behind the nodes of the image tree: sampled in batches, refined together.

use super::block::Block;
use super::depth_rule::{Profile, has_jump};
use super::dyadic::{spacing, unit};
use super::energies::Bins;
use super::image_tree::{ImageTree, Place};
use super::jumps::{Jump, are_known, jumps, probes};
use super::line::{Line, Sample};
use super::nearest::Nearest;
use super::remaining::around;
use super::scouts::Post;
use super::tracking::{Bracket, NEIGHBOURS, Neighbour, Predicted, predict};
use crate::error::RenderError;
use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::parallel::prelude::*;
use crate::projection::Layer;
use crate::site::{Site, Sites};
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// What keeps samples from being made.
#[derive(Debug)]
pub(crate) enum Stop {
    /// The budget does not suffice for the batch, or the time has ended: there are no new rates.
    Budget,
    Failed(MethodError),
}

/// Where G is sampled.
pub(crate) struct View<'a> {
    pub(crate) meter: &'a Meter,
    pub(crate) layer: &'a dyn Layer,
    /// Which of the tiles of the image it belongs to, and of how many.
    pub(crate) tile: (usize, usize),
    /// The energy of all samples, if there is an energy axis.
    pub(crate) energy: Option<EnergySample>,
}

/// An energy at which G is sampled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnergySample {
    /// In the unit of the energy axis.
    pub(crate) energy: f64,
    /// dE/du over its mean: what G is weighted with.
    pub(crate) density: f64,
}

impl EnergySample {
    /// The energy at a dyadic place of the axis.
    pub(crate) fn at(place: u32, bins: &Bins<'_>) -> Self {
        let u = unit(place);
        Self { energy: bins.axis.energy(u), density: bins.density(u) }
    }
}

impl View<'_> {
    /// One sample of the radiance per depth, G = g · ds/dz · dE/du.
    fn site(&self, [x, y, depth]: [u32; 3], energy: Option<EnergySample>) -> Site {
        let u = [unit(x), unit(y), unit(depth)];
        let mut point = self.layer.world_from_canonical(u);
        if let Some(energy) = energy {
            point.path_per_depth *= energy.density;
        }
        let energy = energy.map(|sample| sample.energy);
        Site { xy: [u[0], u[1]], point, energy, tile: self.tile }
    }

    /// Samples at the energy of the view, in one batch.
    pub(crate) async fn rates(&self, points: &[(Place, u32)]) -> Result<Vec<f64>, Stop> {
        let site = |i: usize| {
            let ([x, y], depth) = points[i];
            self.site([x, y, depth], self.energy)
        };
        evaluate(self.meter, points.len(), &site).await
    }

    /// Samples at points of the `layers`, each at its own place on the energy axis, in one batch.
    pub(crate) async fn spectral_rates(
        layers: &[Self],
        points: &[(Post, u32)],
        bins: &Bins<'_>,
    ) -> Result<Vec<f64>, Stop> {
        let Some(first) = layers.first() else { return Ok(Vec::new()) };
        let site = |i: usize| {
            let (Post { layer, place: [x, y], depth }, energy) = points[i];
            layers[layer].site([x, y, depth], Some(EnergySample::at(energy, bins)))
        };
        evaluate(first.meter, points.len(), &site).await
    }
}

/// Evaluates one batch, if the budget suffices for all of it.
pub(crate) async fn evaluate(
    meter: &Meter,
    count: usize,
    site: &Sites<'_>,
) -> Result<Vec<f64>, Stop> {
    let left = meter.evaluations_left();
    // Points at which nothing can be seen cost nothing; they are counted only where it matters.
    let needed = || (0..count).filter(|&i| site(i).point.path_per_depth != 0.0).count() as u64;
    if count as u64 > left && needed() > left {
        return Err(Stop::Budget);
    }
    let mut rates = vec![0.0; count];
    match meter.evaluate_sites(site, &mut rates).await {
        Err(RenderError::Time { .. }) => Err(Stop::Budget),
        Err(error) => Err(Stop::Failed(error)),
        Ok(()) => Ok(rates),
    }
}

/// Depths that are wanted on a line, by the number of its node.
pub(crate) type Wanted = Vec<(usize, Vec<u32>)>;

/// A depth of one line that those next to it should know of.
#[derive(Clone, Copy, Debug)]
struct Shared {
    depth: u32,
    /// The spacing of its level.
    length: u32,
    /// Whether there is only a jump that it is shared for.
    of_jump: bool,
}

/// How a line came by its integral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    /// It has none yet.
    Unknown,
    /// It needs none: no pixel sees it.
    Closed,
    /// It was refined by itself.
    Full,
    /// By the depth rule of a block, which was right to `error` on the lines it was learned from.
    Rule { block: Block, error: f64 },
}

/// The lines of all nodes, in the order of the nodes.
#[derive(Debug, Default)]
pub(crate) struct Sights {
    pub(crate) lines: Vec<Line>,
    pub(crate) ways: Vec<Way>,
    /// Whether jumps are looked for where those of neighbours are.
    pub(crate) tracks_jumps: bool,
    /// Where jumps are expected on lines that have not been refined yet.
    brackets: Vec<Vec<Bracket>>,
    /// What others have asked of each line.
    answers: Vec<Answers>,
}

/// What others ask of a line, worked out when the first one does and kept until there are new samples.
#[derive(Debug, Default)]
struct Answers {
    profile: OnceLock<Profile>,
    jumps: OnceLock<Vec<Jump>>,
    /// Whether no rule can be learned from the line.
    has_jump: OnceLock<bool>,
    /// ∫ |G| dz.
    brightness: OnceLock<f64>,
}

/// Lines that follow rules, each with its rule and integral.
#[derive(Debug)]
pub(crate) struct Standing(Vec<(usize, Way, f64)>);

/// Lines that are worth a thread of their own, which takes some ten microseconds to wake: if all but few
/// of them have answered before…
pub(crate) const LINES_KNOWN: usize = 1024;
/// …if samples are looked up or taken in…
const LINES_READ: usize = 128;
/// …and if all samples of them are looked at.
const LINES_ASSESSED: usize = 8;

/// Depths of a line beyond this level, if jumps are near, are its own: neighbours jump elsewhere.
const SHARED_JUMP_LEVEL: u8 = 6;
/// A sample is looked for on neighbouring lines if its significance is beyond this many tolerances.
const SHARED_SIGNIFICANCE: f64 = 2.0;
/// Neighbours that are coarser than this there, in units of the sample's own spacing.
const COARSER: u32 = 4;
/// Steps from line to line that something found is followed in one round.
const MOST_HOPS: usize = 6;
/// Lines whose depths a new line starts with.
const NEAREST: usize = 4;
/// If one of those has a jump, depths beyond this level are not taken from them…
const STARTING_LEVEL: u8 = 7;
/// …nor samples with a significance below this share of the tolerance: they were made to close in on
/// jumps, or to look whether there is more.
const STARTING_SIGNIFICANCE: f64 = 0.25;

impl Sights {
    /// Adds lines without samples until there is one for each of `nodes` nodes.
    pub(crate) fn grow(&mut self, nodes: usize) {
        self.lines.resize_with(nodes, Line::default);
        self.ways.resize(nodes, Way::Unknown);
        self.brackets.resize(nodes, Vec::new());
        self.answers.resize_with(nodes, Answers::default);
    }

    pub(crate) fn truncate(&mut self, nodes: usize) {
        self.lines.truncate(nodes);
        self.ways.truncate(nodes);
        self.brackets.truncate(nodes);
        self.answers.truncate(nodes);
    }

    /// How the lines that follow rules stand, so that they can be restored.
    pub(crate) fn standing(&self) -> Standing {
        let ruled = (0..self.lines.len()).filter(|&i| !self.is_full(i));
        Standing(ruled.map(|i| (i, self.ways[i], self.lines[i].integral)).collect())
    }

    /// Gives lines back the rules that they had.
    pub(crate) fn restore(&mut self, standing: &Standing) {
        for &(i, way, integral) in &standing.0 {
            self.ways[i] = way;
            self.lines[i].integral = integral;
        }
    }

    pub(crate) fn is_closed(&self, i: usize) -> bool {
        self.ways[i] == Way::Closed
    }

    pub(crate) fn is_full(&self, i: usize) -> bool {
        self.ways[i] == Way::Full
    }

    /// Full line `i` as rules see it.
    pub(crate) fn profile(&self, i: usize) -> &Profile {
        self.answers[i].profile.get_or_init(|| Profile::new(&self.lines[i]))
    }

    /// Whether line `i` has a jump that has been resolved: no rule is learned from it.
    pub(crate) fn has_jump(&self, i: usize) -> bool {
        *self.answers[i].has_jump.get_or_init(|| has_jump(&self.lines[i]))
    }

    fn jumps(&self, i: usize) -> &[Jump] {
        self.answers[i].jumps.get_or_init(|| jumps(&self.lines[i]))
    }

    /// The largest ∫ |G| dz of a full line.
    pub(crate) fn brightest(&self) -> f64 {
        let all = (0..self.lines.len()).into_par_iter().with_min_len(LINES_KNOWN);
        let full = all.filter(|&i| self.is_full(i));
        let brightness =
            |i: usize| *self.answers[i].brightness.get_or_init(|| self.lines[i].brightness());
        full.map(brightness).reduce(|| 0.0, f64::max)
    }

    /// Whether no sample is negative.
    pub(crate) fn are_nowhere_negative(&self) -> bool {
        let lines = self.lines.par_iter().with_min_len(LINES_KNOWN);
        lines.all(|line| line.samples.iter().all(|sample| sample.rate >= 0.0))
    }

    /// The estimated |error| of the integral of line `i`.
    pub(crate) fn error(&self, i: usize) -> f64 {
        match self.ways[i] {
            Way::Full => self.lines[i].error,
            Way::Rule { error, .. } => error,
            Way::Unknown => f64::INFINITY,
            Way::Closed => 0.0,
        }
    }

    /// Samples all wanted depths in one batch; those that are there already cost nothing, and a depth
    /// may be wanted twice.
    pub(crate) async fn sample(
        &mut self,
        view: &View<'_>,
        tree: &ImageTree,
        wanted: &Wanted,
    ) -> Result<(), Stop> {
        let missing = |(i, depths): &(usize, Vec<u32>)| {
            let line = &self.lines[*i];
            let missing = depths.iter().filter(|&&depth| !line.has(depth));
            missing.map(|&depth| (*i, depth)).collect::<Vec<_>>()
        };
        let wanted = wanted.par_iter().with_min_len(LINES_READ);
        let mut missing: Vec<(usize, u32)> = wanted.flat_map_iter(missing).collect();
        missing.par_sort_unstable();
        missing.dedup();
        let points: Vec<_> = missing.iter().map(|&(i, d)| (tree.nodes()[i].place, d)).collect();
        let rates = view.rates(&points).await?;
        let samples: Vec<_> =
            missing.into_iter().zip(rates).map(|((i, depth), rate)| (i, (depth, rate))).collect();
        let of_lines: Vec<_> = samples.chunk_by(|a, b| a.0 == b.0).collect();
        let numbers = of_lines.iter().map(|of_line| of_line[0].0);
        let lines = chosen(&mut self.lines, numbers.clone());
        let answers = chosen(&mut self.answers, numbers);
        let lines = lines.into_par_iter().zip(answers).zip(of_lines).with_min_len(LINES_READ);
        lines.for_each(|((line, answers), new)| {
            line.add(new.iter().map(|(_, sample)| *sample));
            *answers = Answers::default();
        });
        Ok(())
    }

    /// Samples the wanted depths and refines each line of them until its error is within
    /// `tolerance`, all lines together: one batch for each step.
    pub(crate) async fn refine(
        &mut self,
        view: &View<'_>,
        tree: &ImageTree,
        mut wanted: Wanted,
        tolerance: f64,
        base_level: u8,
    ) -> Result<(), Stop> {
        while !wanted.is_empty() {
            self.sample(view, tree, &wanted).await?;
            wanted = self.assess(wanted.iter().map(|(i, _)| *i), tolerance, base_level);
        }
        Ok(())
    }

    /// Assesses the given lines and returns what they want, the lines in ascending order: first the
    /// jumps that are expected, until all have been found or given up.
    pub(crate) fn assess(
        &mut self,
        numbers: impl Iterator<Item = usize>,
        tolerance: f64,
        base_level: u8,
    ) -> Wanted {
        let mut numbers: Vec<usize> = numbers.collect();
        numbers.sort_unstable();
        numbers.dedup();
        let lines = chosen(&mut self.lines, numbers.iter().copied());
        let brackets = chosen(&mut self.brackets, numbers.iter().copied());
        let answers = chosen(&mut self.answers, numbers.iter().copied());
        let lines = lines.into_par_iter().zip(brackets).zip(answers).zip(&numbers);
        let lines = lines.with_min_len(LINES_ASSESSED);
        let wanted = lines.map(|(((line, brackets), answers), &i)| {
            *answers = Answers::default();
            let searched: Vec<u32> = brackets.iter_mut().filter_map(|b| b.next(line)).collect();
            if searched.is_empty() {
                brackets.clear();
                (i, line.assess(tolerance, base_level))
            } else {
                (i, searched)
            }
        });
        wanted.filter(|(_, depths)| !depths.is_empty()).collect()
    }

    /// The depths that the new full lines `numbers` start with, and where they are expected to
    /// jump, given the full lines before node `before`.
    pub(crate) fn start(
        &mut self,
        tree: &ImageTree,
        numbers: &[usize],
        before: usize,
        tolerance: f64,
        base_level: u8,
    ) -> Wanted {
        let places: Vec<Place> = numbers.iter().map(|&i| tree.nodes()[i].place).collect();
        let starts = self.starts(tree, &places, before, tolerance, base_level);
        let of_line = |(&i, (depths, brackets))| {
            self.expect(i, brackets);
            (i, depths)
        };
        numbers.iter().zip(starts).map(of_line).collect()
    }

    /// The same for lines at any `places`, with the brackets of their jumps.
    pub(crate) fn starts(
        &self,
        tree: &ImageTree,
        places: &[Place],
        before: usize,
        tolerance: f64,
        base_level: u8,
    ) -> Vec<(Vec<u32>, Vec<Bracket>)> {
        let full = self.nearest_full(tree, before);
        let of_line = |&place: &Place| {
            let near = full.find(place, NEIGHBOURS);
            self.starting_depths(tree, place, &near, tolerance, base_level)
        };
        places.par_iter().with_min_len(LINES_ASSESSED).map(of_line).collect()
    }

    /// The full lines before node `before`, by their places.
    pub(crate) fn nearest_full(&self, tree: &ImageTree, before: usize) -> Nearest {
        let full = (0..before).filter(|&i| self.is_full(i));
        let full: Vec<(Place, usize)> = full.map(|i| (tree.nodes()[i].place, i)).collect();
        Nearest::new(full.into_iter())
    }

    /// Sets where line `i` is expected to jump.
    pub(crate) fn expect(&mut self, i: usize, brackets: Vec<Bracket>) {
        self.brackets[i] = brackets;
    }

    /// The depths that a new full line at `place` starts with: those of the base level, what the
    /// nearest of the full lines `near` it have opened, and brackets of the jumps.
    fn starting_depths(
        &self,
        tree: &ImageTree,
        place: Place,
        near: &[(u64, usize)],
        tolerance: f64,
        base_level: u8,
    ) -> (Vec<u32>, Vec<Bracket>) {
        let mut depths = base_depths(base_level);
        let neighbours =
            if self.tracks_jumps { self.neighbours(tree, place, near) } else { Vec::new() };
        // Two, or more if they are as near as the second.
        let farthest = near.get(1).map_or(0, |(distance, _)| *distance);
        let nearest = near.iter().take(NEAREST).filter(|(distance, _)| *distance <= farthest);
        let has_jumps = neighbours.iter().take(NEAREST).any(|one| !one.jumps.is_empty());
        for line in nearest.map(|&(_, i)| &self.lines[i]) {
            let worthwhile = line.samples.iter().enumerate().filter(|(k, sample)| {
                if has_jumps {
                    let significant = sample.significance > STARTING_SIGNIFICANCE * tolerance;
                    return significant
                        && sample.level <= STARTING_LEVEL
                        && !line.is_beside_jump(*k);
                }
                sample.opened || (sample.level <= SHARED_JUMP_LEVEL && line.is_near_jump(*k))
            });
            depths.extend(worthwhile.map(|(_, sample)| sample.depth));
        }
        let Predicted { brackets, probes } = predict(&neighbours, tolerance);
        depths.extend(brackets.iter().flat_map(|bracket| [bracket.low, bracket.high]));
        depths.extend(probes);
        depths.sort_unstable();
        depths.dedup();
        (depths, brackets)
    }

    /// The jumps of full lines near `place`; none at all if the nearest have none.
    fn neighbours(&self, tree: &ImageTree, place: Place, near: &[(u64, usize)]) -> Vec<Neighbour> {
        let unit_distance =
            near.first().map_or(1.0, |(square, _)| (*square as f64).sqrt().max(1.0));
        let neighbour = |&(_, i): &(u64, usize)| {
            let from = tree.nodes()[i].place;
            let along =
                |axis: usize| (f64::from(from[axis]) - f64::from(place[axis])) / unit_distance;
            Neighbour { place: [along(0), along(1)], jumps: self.jumps(i).to_vec() }
        };
        let mut neighbours: Vec<Neighbour> = near.iter().take(NEAREST).map(neighbour).collect();
        if neighbours.iter().any(|one| !one.jumps.is_empty()) {
            neighbours.extend(near.iter().skip(NEAREST).map(neighbour));
        }
        neighbours
    }

    /// Looks on neighbouring full lines for what the lines `found` have found, and from there on.
    pub(crate) async fn follow(
        &mut self,
        view: &View<'_>,
        tree: &ImageTree,
        found: &[usize],
        tolerance: f64,
        base_level: u8,
    ) -> Result<(), Stop> {
        let mut found = found.to_vec();
        for _ in 0..MOST_HOPS {
            let mut wanted: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
            let unseen = |&i: &usize| self.unseen_by_neighbours(tree, i, tolerance, base_level);
            let found_lines = found.par_iter().with_min_len(LINES_ASSESSED);
            let of_lines: Vec<Wanted> = found_lines.map(unseen).collect();
            for (k, depths) in of_lines.into_iter().flatten() {
                wanted.entry(k).or_default().extend(depths);
            }
            for depths in wanted.values_mut() {
                depths.sort_unstable();
                depths.dedup();
            }
            found = wanted.keys().copied().collect();
            if found.is_empty() {
                break;
            }
            let wanted = wanted.into_iter().collect();
            self.refine(view, tree, wanted, tolerance, base_level).await?;
        }
        Ok(())
    }

    /// What line `i` has found that full lines next to it have not looked for.
    fn unseen_by_neighbours(
        &self,
        tree: &ImageTree,
        i: usize,
        tolerance: f64,
        base_level: u8,
    ) -> Wanted {
        let node = &tree.nodes()[i];
        let step = spacing(node.level.max(base_level));
        let depths = self.shared_depths(i, tolerance, base_level);
        let own = if self.tracks_jumps { self.jumps(i) } else { &[] };
        if own.is_empty() && depths.is_empty() {
            return Vec::new();
        }
        let of_neighbour = |(_, _, neighbour)| {
            let k = tree.find(neighbour).filter(|&k| self.is_full(k))?;
            let line = &self.lines[k];
            let theirs = if own.is_empty() { &[] } else { self.jumps(k) };
            let is_unseen = |shared: &&Shared| {
                let is_theirs = shared.of_jump && are_known(own, theirs, shared.depth);
                !is_theirs && self.is_coarse(k, shared.depth, shared.length)
            };
            let mut unseen = probes(own, theirs, line);
            unseen.extend(depths.iter().filter(is_unseen).map(|shared| shared.depth));
            (!unseen.is_empty()).then_some((k, unseen))
        };
        around(node.place, step, 1).filter_map(of_neighbour).collect()
    }

    /// The depths of line `i` that its neighbours should know of.
    fn shared_depths(&self, i: usize, tolerance: f64, base_level: u8) -> Vec<Shared> {
        let line = &self.lines[i];
        let of_sample = |(k, sample): (usize, &Sample)| {
            let significant = sample.opened
                && sample.level >= base_level
                && sample.significance > SHARED_SIGNIFICANCE * tolerance;
            let beside_jump = sample.level <= SHARED_JUMP_LEVEL
                && sample.level > base_level
                && line.is_near_jump(k);
            (significant || beside_jump).then(|| Shared {
                depth: sample.depth,
                length: spacing(sample.level),
                of_jump: !significant,
            })
        };
        line.samples.iter().enumerate().filter_map(of_sample).collect()
    }

    /// Whether line `k` has no sample at `depth`, and none near it in terms of `length`.
    fn is_coarse(&self, k: usize, depth: u32, length: u32) -> bool {
        let line = &self.lines[k];
        match line.find(depth) {
            Ok(_) => false,
            Err(0) => true,
            Err(after) if after == line.samples.len() => true,
            Err(after) => {
                let interval = line.samples[after].depth - line.samples[after - 1].depth;
                interval >= COARSER * length
            }
        }
    }
}

/// The entries of these numbers, which ascend.
fn chosen<T>(all: &mut [T], numbers: impl Iterator<Item = usize>) -> Vec<&mut T> {
    let (mut rest, mut passed) = (all.iter_mut(), 0);
    let entry = |i: usize| {
        let entry = rest.nth(i - passed);
        passed = i + 1;
        entry
    };
    numbers.filter_map(entry).collect()
}

/// All depths of the lattice of `level`.
pub(crate) fn base_depths(level: u8) -> Vec<u32> {
    (0..=1_u32 << level).map(|k| k * spacing(level)).collect()
}
