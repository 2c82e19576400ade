//! The lines of sight behind the nodes of the image tree: sampled in batches, refined together.

use super::block::Block;
use super::dyadic::{spacing, unit};
use super::image_tree::{ImageTree, Place};
use super::line::Line;
use super::remaining::around;
use crate::emission::Emission;
use crate::error::RenderError;
use crate::meter::{Meter, Weight};
use crate::quadrature::Points;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What keeps samples from being made.
#[derive(Debug)]
pub(crate) enum Stop<E> {
    /// The budget does not suffice for the batch, of which nothing has been evaluated.
    Budget,
    Failed(RenderError<E>),
}

/// Where G is sampled.
pub(crate) struct View<'a, E> {
    pub(crate) meter: &'a Meter<'a, E>,
}

impl<E: Emission> View<'_, E> {
    /// Samples of the radiance per depth, G = g · ds/dz, in one batch.
    fn rates(&self, points: &[(Place, u32)]) -> Result<Vec<f64>, Stop<E::Error>> {
        if points.len() as u64 > self.meter.evaluations_left() {
            return Err(Stop::Budget);
        }
        let mut rates = vec![0.0; points.len()];
        let point = |i: usize| {
            let ([x, y], depth) = points[i];
            [unit(x), unit(y), unit(depth)]
        };
        self.meter
            .evaluate(Points::new(points.len(), &point), Weight::Path, &mut rates)
            .map_err(Stop::Failed)?;
        Ok(rates)
    }
}

/// Depths that are wanted on a line, by the number of its node.
pub(crate) type Wanted = Vec<(usize, Vec<u32>)>;

/// How a line came by its integral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
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
}

/// Lines that follow rules, each with its rule and integral.
#[derive(Debug)]
pub(crate) struct Standing(Vec<(usize, Way, f64)>);

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

impl Sights {
    /// Adds lines without samples until there is one for each of `nodes` nodes.
    pub(crate) fn grow(&mut self, nodes: usize) {
        self.lines.resize_with(nodes, Line::default);
        self.ways.resize(nodes, Way::Full);
    }

    pub(crate) fn truncate(&mut self, nodes: usize) {
        self.lines.truncate(nodes);
        self.ways.truncate(nodes);
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

    /// Takes a new line out of the full ones, until a rule has given it its integral.
    pub(crate) fn await_rule(&mut self, i: usize) {
        self.ways[i] = Way::Rule { block: Block::around([0; 2], 0), error: f64::INFINITY };
    }

    pub(crate) fn is_full(&self, i: usize) -> bool {
        self.ways[i] == Way::Full
    }

    /// The estimated |error| of the integral of line `i`.
    pub(crate) fn error(&self, i: usize) -> f64 {
        match self.ways[i] {
            Way::Full => self.lines[i].error,
            Way::Rule { error, .. } => error,
        }
    }

    /// Samples all wanted depths in one batch; those that are there already cost nothing, and a depth
    /// may be wanted twice.
    pub(crate) fn sample<E: Emission>(
        &mut self,
        view: &View<'_, E>,
        tree: &ImageTree,
        wanted: &Wanted,
    ) -> Result<(), Stop<E::Error>> {
        let missing = wanted.iter().flat_map(|(i, depths)| {
            depths.iter().filter(|&&depth| !self.lines[*i].has(depth)).map(|&depth| (*i, depth))
        });
        let mut missing: Vec<(usize, u32)> = missing.collect();
        missing.sort_unstable();
        missing.dedup();
        let points: Vec<_> = missing.iter().map(|&(i, d)| (tree.nodes()[i].place, d)).collect();
        let rates = view.rates(&points)?;
        for (&(i, depth), rate) in missing.iter().zip(rates) {
            self.lines[i].add([(depth, rate)]);
        }
        Ok(())
    }

    /// Samples the wanted depths and refines each line of them until its error is within
    /// `tolerance`, all lines together: one batch for each step.
    pub(crate) fn refine<E: Emission>(
        &mut self,
        view: &View<'_, E>,
        tree: &ImageTree,
        mut wanted: Wanted,
        tolerance: f64,
        base_level: u8,
    ) -> Result<(), Stop<E::Error>> {
        while !wanted.is_empty() {
            self.sample(view, tree, &wanted)?;
            wanted = self.assess(wanted.iter().map(|(i, _)| *i), tolerance, base_level);
        }
        Ok(())
    }

    /// Assesses the given lines and returns what they want, the lines in ascending order.
    pub(crate) fn assess(
        &mut self,
        numbers: impl Iterator<Item = usize>,
        tolerance: f64,
        base_level: u8,
    ) -> Wanted {
        let mut chosen = vec![false; self.lines.len()];
        numbers.for_each(|i| chosen[i] = true);
        let lines = self.lines.par_iter_mut().zip(chosen).enumerate();
        let wanted = lines
            .filter(|(_, (_, chosen))| *chosen)
            .map(|(i, (line, _))| (i, line.assess(tolerance, base_level)));
        wanted.filter(|(_, depths)| !depths.is_empty()).collect()
    }

    /// The depths that a new full line at `place` starts with: those of the base level, and what the
    /// nearest of the full lines before node `before` have opened.
    pub(crate) fn starting_depths(
        &self,
        tree: &ImageTree,
        place: Place,
        before: usize,
        base_level: u8,
    ) -> Vec<u32> {
        let mut depths = base_depths(base_level);
        for i in self.nearest_full(tree, place, before) {
            let line = &self.lines[i];
            let worthwhile = line.samples.iter().enumerate().filter(|(k, sample)| {
                sample.opened || (sample.level <= SHARED_JUMP_LEVEL && line.is_near_jump(*k))
            });
            depths.extend(worthwhile.map(|(_, sample)| sample.depth));
        }
        depths.sort_unstable();
        depths.dedup();
        depths
    }

    /// The nearest full lines before node `before`: two, or up to [`NEAREST`] as near as the second.
    fn nearest_full(&self, tree: &ImageTree, place: Place, before: usize) -> Vec<usize> {
        let mut nearest: Vec<(u64, usize)> = Vec::with_capacity(NEAREST + 1);
        for i in (0..before).filter(|&i| self.is_full(i)) {
            let along =
                |axis: usize| u64::from(tree.nodes()[i].place[axis].abs_diff(place[axis])).pow(2);
            let entry = (along(0) + along(1), i);
            if nearest.len() < NEAREST || entry < nearest[NEAREST - 1] {
                let at = nearest.partition_point(|other| *other < entry);
                nearest.insert(at, entry);
                nearest.truncate(NEAREST);
            }
        }
        let farthest = nearest.get(1).map_or(0, |(distance, _)| *distance);
        nearest.retain(|(distance, _)| *distance <= farthest);
        nearest.into_iter().map(|(_, i)| i).collect()
    }

    /// Looks on neighbouring full lines for what the lines `found` have found, and from there on.
    pub(crate) fn follow<E: Emission>(
        &mut self,
        view: &View<'_, E>,
        tree: &ImageTree,
        found: &[usize],
        tolerance: f64,
        base_level: u8,
    ) -> Result<(), Stop<E::Error>> {
        let mut found = found.to_vec();
        for _ in 0..MOST_HOPS {
            let mut wanted: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
            for &i in &found {
                let node = &tree.nodes()[i];
                let step = spacing(node.level.max(base_level));
                let depths = self.shared_depths(i, tolerance, base_level);
                for (_, _, neighbour) in around(node.place, step, 1) {
                    let Some(k) = tree.find(neighbour).filter(|&k| self.is_full(k)) else {
                        continue;
                    };
                    let unseen = |&&(depth, length): &&(u32, u32)| self.is_coarse(k, depth, length);
                    let unseen: Vec<u32> = depths.iter().filter(unseen).map(|d| d.0).collect();
                    if !unseen.is_empty() {
                        wanted.entry(k).or_default().extend(unseen);
                    }
                }
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
            self.refine(view, tree, wanted, tolerance, base_level)?;
        }
        Ok(())
    }

    /// The depths of line `i` that its neighbours should know of, each with its spacing.
    fn shared_depths(&self, i: usize, tolerance: f64, base_level: u8) -> Vec<(u32, u32)> {
        let line = &self.lines[i];
        let worthwhile = line.samples.iter().enumerate().filter(|(k, sample)| {
            let significant =
                sample.opened && sample.significance > SHARED_SIGNIFICANCE * tolerance;
            let beside_jump = sample.level <= SHARED_JUMP_LEVEL
                && sample.level > base_level
                && line.is_near_jump(*k);
            (significant && sample.level >= base_level) || beside_jump
        });
        worthwhile.map(|(_, sample)| (sample.depth, spacing(sample.level))).collect()
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

/// All depths of the lattice of `level`.
pub(crate) fn base_depths(level: u8) -> Vec<u32> {
    (0..=1_u32 << level).map(|k| k * spacing(level)).collect()
}
