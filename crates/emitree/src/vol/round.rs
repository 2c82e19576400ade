//! One round: the radiances of some new nodes, by depth rules where they hold, by full lines
//! elsewhere.
//!
//! Some nodes of each rule get a full line all the same: the rule has to be right on lines that it
//! has not seen. Where it is not, the nodes of the quarter of its block get a better one, or full
//! lines; so do single nodes whose values are unlike those that the rule was learned from.

use super::block::{Block, FINEST_BLOCKS};
use super::depth_rule::{DepthRule, LEAST_LINES, Profile};
use super::dyadic::{spacing, unit};
use super::image_tree::{Around, ImageTree, Place};
use super::remaining::around;
use super::seeds::Looks;
use super::sights::{LINES_KNOWN, Sights, Stop, View, Wanted, Way, base_depths};
use super::whole;
use crate::parallel::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::{BTreeMap, BTreeSet};

/// Lines around a block that are learned from too, as a share of its edge.
const TRAINING_MARGIN: f64 = 0.26;
/// Nodes around a quarter in which a rule has failed that get what the quarter gets.
const FAILED_MARGIN: f64 = 0.05;
/// A rule of more depths than this share of a full line's samples saves too little.
const MOST_DEPTHS: f64 = 0.7;
/// The most depths of a rule for a quarter in which another one has failed.
const MOST_DEPTHS_AGAIN: usize = 40;
/// Of n nodes of a rule, this many times √n get a full line.
const VALIDATED: f64 = 0.4;
/// A rule has failed where it is wrong by this many tolerances.
const FAILURE: f64 = 1.0;
/// Lines are refined again if they are beyond the tolerance by more than this.
const AGAIN: f64 = 1.02;

/// Between a closed node and its neighbours on its lattice, open places are looked for at this many
/// steps: narrower parts of the image are found where they widen, or are no part of a pixel that counts.
const BETWEEN: i8 = 4;

/// The image tree, its lines, and where they are sampled.
pub(crate) struct Scan<'a> {
    pub(crate) view: View<'a>,
    pub(crate) base_level: u8,
    /// Every full line has all depths of the lattice of this level: that of the base, or a finer one after
    /// an exam has found that lines step over something.
    pub(crate) depth_level: u8,
    pub(crate) tree: ImageTree,
    pub(crate) sights: Sights,
    /// Structures that were named: no rule has learned of them.
    pub(crate) seeds: Looks,
    /// Whether nothing is evaluated at places that no pixel sees.
    pub(crate) closes: bool,
}

/// A depth rule and where it holds.
#[derive(Clone, Debug)]
struct BlockRule {
    block: Block,
    rule: DepthRule,
}

/// The full lines that rules are learned from: their numbers and places.
struct Lessons {
    /// In the order of the nodes.
    lines: Vec<(usize, Place)>,
    /// The places of those with jumps.
    jumping: Vec<Place>,
}

impl Lessons {
    /// Whether lines in a block or a little around it have jumps: no rule can be learned there.
    fn have_jumps(&self, block: Block) -> bool {
        self.jumping.iter().any(|&place| block.contains(place, TRAINING_MARGIN))
    }
}

/// What is to be done with some nodes.
#[derive(Debug, Default)]
struct Plan {
    rules: Vec<BlockRule>,
    /// Nodes that get a full line.
    full: Vec<usize>,
    /// Nodes that wait for what the full lines among them teach.
    postponed: Vec<usize>,
    /// Nodes whose full line is compared with the rule of this number.
    validated: Vec<(usize, usize)>,
    /// Nodes that get their radiance from the rule of this number.
    ruled: BTreeMap<usize, usize>,
}

impl Scan<'_> {
    /// Adds nodes, without radiances.
    pub(crate) fn add(&mut self, places: &[Place]) {
        let first = self.tree.len();
        places.iter().for_each(|&place| self.tree.add(place));
        self.sights.grow(self.tree.len());
        if self.closes {
            for (i, &place) in (first..).zip(places) {
                if !self.view.layer.is_open(place.map(unit)) {
                    self.sights.ways[i] = Way::Closed;
                    let around = self.open_around(place, self.tree.nodes()[i].level);
                    self.tree.set_around(i, around);
                }
            }
        }
    }

    /// What is open around a closed place of a level: known from geometry, without an evaluation.
    fn open_around(&self, place: Place, level: u8) -> Around {
        let is_open = |distance: u32, reach: i8| {
            let mut places = around(place, distance, reach);
            places.any(|(_, _, at)| self.view.layer.is_open(at.map(unit)))
        };
        let step = spacing(level);
        if is_open(step, 1) {
            return Around::Beside;
        }
        let finer = step / u32::from(BETWEEN.unsigned_abs());
        if finer > 0 && is_open(finer, BETWEEN) { Around::Between } else { Around::Closed }
    }

    /// Forgets all nodes but the first `len`.
    pub(crate) fn truncate(&mut self, len: usize) {
        self.tree.truncate(len);
        self.sights.truncate(len);
    }

    /// Samples the depths and refines the lines until each is within `tolerance`.
    pub(crate) async fn refine(&mut self, wanted: Wanted, tolerance: f64) -> Result<(), Stop> {
        self.sights.refine(&self.view, &self.tree, wanted, tolerance, self.depth_level).await
    }

    /// Looks on neighbours for what the given full lines have found.
    pub(crate) async fn follow(&mut self, found: &[usize], tolerance: f64) -> Result<(), Stop> {
        self.sights.follow(&self.view, &self.tree, found, tolerance, self.depth_level).await
    }

    /// Finds the radiances of the nodes from `first` on, each to `tolerance`; `guarded` are the
    /// guarded details of those before.
    pub(crate) async fn scan(
        &mut self,
        first: usize,
        guarded: &[f64],
        tolerance: f64,
    ) -> Result<(), Stop> {
        let mut new: Vec<usize> = self.no_longer_good(first, tolerance).await?;
        new.extend((first..self.tree.len()).filter(|&i| !self.sights.is_closed(i)));
        // Where there is no rule yet, a third of the lines may be enough to learn one.
        let plan = self.plan(&new, first, guarded, tolerance, true);
        let rest = plan.postponed.clone();
        self.carry_out(plan, first, tolerance).await?;
        let plan = self.plan(&rest, first, guarded, tolerance, false);
        self.carry_out(plan, first, tolerance).await
    }

    /// Does what is planned, and what turns out to be needed besides.
    async fn carry_out(
        &mut self,
        mut plan: Plan,
        first: usize,
        tolerance: f64,
    ) -> Result<(), Stop> {
        self.scan_full(&plan, first, tolerance).await?;
        let mut again = self.replace_failed(&mut plan, tolerance);
        again.extend(self.apply(&plan, tolerance).await?);
        self.scan_again(&again, first, tolerance).await
    }

    /// Refines the older full lines that the tolerance has left behind, and returns the other nodes
    /// that it has: it falls with the largest pixel.
    async fn no_longer_good(&mut self, first: usize, tolerance: f64) -> Result<Vec<usize>, Stop> {
        let beyond = (0..first).filter(|&i| self.sights.error(i) > AGAIN * tolerance);
        let (full, ruled): (Vec<usize>, Vec<usize>) = beyond.partition(|&i| self.sights.is_full(i));
        self.refine(full.into_iter().map(|i| (i, Vec::new())).collect(), tolerance).await?;
        Ok(ruled)
    }

    /// What the full lines of all nodes may teach.
    fn lessons(&self) -> Lessons {
        let full = (0..self.tree.len()).filter(|&i| self.sights.is_full(i));
        let lines: Vec<_> = full.map(|i| (i, self.tree.nodes()[i].place)).collect();
        let known = lines.par_iter().with_min_len(LINES_KNOWN);
        let jumping = known.filter(|(i, _)| self.sights.has_jump(*i));
        let jumping = jumping.map(|(_, place)| *place).collect();
        Lessons { lines, jumping }
    }

    /// The rule of a block, learned from the full lines in it and a little around it.
    fn learn(
        &self,
        block: Block,
        lessons: &Lessons,
        tolerance: f64,
        most_depths: usize,
    ) -> Option<BlockRule> {
        if lessons.have_jumps(block) {
            return None;
        }
        let near = lessons.lines.iter().filter(|(_, at)| block.contains(*at, TRAINING_MARGIN));
        let near: Vec<usize> = near.map(|(i, _)| *i).collect();
        if near.len() < LEAST_LINES {
            return None;
        }
        // Most blocks of an image with jumps have no rule: profiles are made where there is one.
        let lines: Vec<&Profile> = near.par_iter().map(|&i| self.sights.profile(i)).collect();
        let rule = DepthRule::learn(&lines, tolerance, most_depths)?;
        Some(BlockRule { block, rule })
    }

    /// The rules of all blocks around some nodes that have one.
    fn rules_around(&self, nodes: &[usize], lessons: &Lessons, tolerance: f64) -> Vec<BlockRule> {
        let samples = lessons.lines.iter().map(|(i, _)| self.sights.lines[*i].samples.len());
        let most_depths = most_depths(samples.sum(), lessons.lines.len());
        let mut met = FxHashSet::default();
        let around = nodes.iter().flat_map(|&i| blocks_around(self.tree.nodes()[i].place));
        let blocks: Vec<Block> = around.filter(|&block| met.insert(block)).collect();
        let learn = |&block: &Block| self.learn(block, lessons, tolerance, most_depths);
        blocks.par_iter().filter_map(learn).collect()
    }

    /// Gives each of the `new` nodes to the shortest rule around it, or to a full line.
    fn plan(
        &self,
        new: &[usize],
        first: usize,
        guarded: &[f64],
        tolerance: f64,
        postpone: bool,
    ) -> Plan {
        let place = |i: usize| self.tree.nodes()[i].place;
        let (unseeded, seeded): (Vec<usize>, Vec<usize>) =
            new.iter().partition(|&&i| self.seeds.depths(place(i)).is_empty());
        let lessons = self.lessons();
        let rules = self.rules_around(&unseeded, &lessons, tolerance);
        let mut plan = Plan { rules, full: seeded, ..Plan::default() };
        let numbers = plan.rules.iter().zip(0..).map(|(rule, number)| (rule.block, number));
        let numbers: FxHashMap<Block, usize> = numbers.collect();
        let mut jumping: FxHashMap<Block, bool> = FxHashMap::default();
        let mut of_rule: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for i in unseeded {
            let rules = blocks_around(place(i)).filter_map(|block| numbers.get(&block).copied());
            // The first of the shortest: that of the largest block.
            let shortest = rules.min_by_key(|&number| plan.rules[number].rule.depths.len());
            if let Some(number) = shortest {
                of_rule.entry(number).or_default().push(i);
                continue;
            }
            // No rule will be learned where there are jumps.
            let block = Block::around(place(i), FINEST_BLOCKS);
            let has_jumps = *jumping.entry(block).or_insert_with(|| lessons.have_jumps(block));
            let waits = postpone && !has_jumps && !self.is_third(i);
            if waits { plan.postponed.push(i) } else { plan.full.push(i) }
        }
        for (number, nodes) in of_rule {
            let validated = self.validated(&nodes, first, guarded);
            plan.full.extend(&validated);
            plan.validated.extend(validated.iter().map(|&i| (i, number)));
            plan.ruled.extend(nodes.into_iter().map(|i| (i, number)));
            for i in &validated {
                plan.ruled.remove(i);
            }
        }
        plan.full.sort_unstable();
        plan
    }

    fn is_third(&self, i: usize) -> bool {
        let node = &self.tree.nodes()[i];
        let [a, b] = node.place.map(|along| along / (2 * spacing(node.level)));
        (a + b).is_multiple_of(3)
    }

    /// Which of the nodes of a rule get a full line: half of them where the largest details are
    /// near, half spread over the rest.
    fn validated(&self, nodes: &[usize], first: usize, guarded: &[f64]) -> Vec<usize> {
        let nearby = |&i: &usize| {
            let node = &self.tree.nodes()[i];
            let neighbours = around(node.place, spacing(node.level), 1)
                .filter_map(|(_, _, place)| self.tree.find(place).filter(|&k| k < first));
            neighbours.map(|k| guarded[k]).fold(0.0, f64::max)
        };
        let mut ranked: Vec<(f64, usize)> = nodes.iter().map(|i| (nearby(i), *i)).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let count = whole((VALIDATED * (nodes.len() as f64).sqrt()).ceil()).min(nodes.len());
        let largest = count.div_ceil(2);
        let rest = &ranked[largest..];
        let stride = rest.len().checked_div(count - largest).unwrap_or(0).max(1);
        let spread = rest.iter().skip(stride / 2).step_by(stride).take(count - largest);
        ranked[..largest].iter().chain(spread).map(|(_, i)| *i).collect()
    }

    /// Refines the full lines of the plan, and what they find on their neighbours.
    async fn scan_full(&mut self, plan: &Plan, first: usize, tolerance: f64) -> Result<(), Stop> {
        plan.full.iter().for_each(|&i| self.sights.ways[i] = Way::Full);
        let mut wanted = self.start(&plan.full, first, tolerance);
        let position: FxHashMap<usize, usize> =
            plan.full.iter().enumerate().map(|(k, &i)| (i, k)).collect();
        for (i, number) in &plan.validated {
            // The depths of the rule too: it is compared with what it would have seen.
            wanted[position[i]].1.extend(&plan.rules[*number].rule.depths);
        }
        self.refine(wanted, tolerance).await?;
        self.follow(&plan.full, tolerance).await
    }

    /// The depths that new full lines start with, given the lines before node `first`.
    fn start(&mut self, nodes: &[usize], first: usize, tolerance: f64) -> Wanted {
        let mut wanted = self.sights.start(&self.tree, nodes, first, tolerance, self.depth_level);
        for (i, depths) in &mut wanted {
            depths.extend(self.seeds.depths(self.tree.nodes()[*i].place));
        }
        wanted
    }

    /// Gives the nodes of quarters in which a rule has failed to a better rule; returns those that
    /// there is none for.
    fn replace_failed(&self, plan: &mut Plan, tolerance: f64) -> BTreeSet<usize> {
        let mut failed = BTreeSet::new();
        for &(i, number) in &plan.validated {
            let BlockRule { block, rule } = &plan.rules[number];
            let line = &self.sights.lines[i];
            let rates: Vec<f64> = rule.depths.iter().map(|&depth| line.rate(depth)).collect();
            let error = (rule.integral(&rates) - line.integral).abs();
            if error > FAILURE * tolerance {
                failed.insert((*block, block.quarter(self.tree.nodes()[i].place)));
            } else {
                let rule = &mut plan.rules[number].rule;
                rule.error = rule.error.max(error);
            }
        }
        let mut without = BTreeSet::new();
        if failed.is_empty() {
            return without;
        }
        let lessons = self.lessons();
        for (block, quarter) in failed {
            let better = [quarter, block]
                .into_iter()
                .filter_map(|block| self.learn(block, &lessons, tolerance, MOST_DEPTHS_AGAIN))
                .min_by_key(|better| better.rule.depths.len());
            let better = better.map(|better| {
                plan.rules.push(better);
                plan.rules.len() - 1
            });
            for i in 0..self.tree.len() {
                let of_failed = match (plan.ruled.get(&i), self.sights.ways[i]) {
                    (Some(&number), _) => plan.rules[number].block == block,
                    (None, Way::Rule { block: of_node, .. }) => of_node == block,
                    (None, Way::Full | Way::Unknown | Way::Closed) => false,
                };
                if !of_failed || !quarter.contains(self.tree.nodes()[i].place, FAILED_MARGIN) {
                    continue;
                }
                match better {
                    Some(number) => {
                        plan.ruled.insert(i, number);
                    }
                    None => {
                        plan.ruled.remove(&i);
                        without.insert(i);
                    }
                }
            }
        }
        without
    }

    /// Samples the depths of the rules, in one batch, and returns the nodes that are odd.
    async fn apply(&mut self, plan: &Plan, tolerance: f64) -> Result<Vec<usize>, Stop> {
        let wanted =
            plan.ruled.iter().map(|(&i, &number)| (i, plan.rules[number].rule.depths.clone()));
        self.sights.sample(&self.view, &self.tree, &wanted.collect()).await?;
        let mut odd = Vec::new();
        for (&i, &number) in &plan.ruled {
            let BlockRule { block, rule } = &plan.rules[number];
            let line = &mut self.sights.lines[i];
            let rates: Vec<f64> = rule.depths.iter().map(|&depth| line.rate(depth)).collect();
            line.integral = rule.integral(&rates);
            self.sights.ways[i] = Way::Rule { block: *block, error: rule.error };
            if rule.is_odd(&rates, tolerance) {
                odd.push(i);
            }
        }
        Ok(odd)
    }

    /// Full lines for nodes whose rules do not hold.
    async fn scan_again(
        &mut self,
        nodes: &BTreeSet<usize>,
        first: usize,
        tolerance: f64,
    ) -> Result<(), Stop> {
        let numbers: Vec<usize> = nodes.iter().copied().collect();
        let wanted = self.start(&numbers, first, tolerance);
        nodes.iter().for_each(|&i| self.sights.ways[i] = Way::Full);
        self.refine(wanted, tolerance).await
    }

    /// Samples every full line on a lattice of depths finer by some `levels`, and finds the radiances of all
    /// other nodes anew from these lines; `guarded` are the guarded details of all nodes.
    pub(crate) async fn refine_depths(
        &mut self,
        levels: u8,
        guarded: &[f64],
        tolerance: f64,
    ) -> Result<(), Stop> {
        self.depth_level += levels;
        let depths = base_depths(self.depth_level);
        let in_view = (0..self.tree.len()).filter(|&i| !self.sights.is_closed(i));
        let (full, ruled): (Vec<usize>, Vec<usize>) =
            in_view.partition(|&i| self.sights.is_full(i));
        self.refine(full.iter().map(|&i| (i, depths.clone())).collect(), tolerance).await?;
        self.follow(&full, tolerance).await?;
        let (first, postpone) = (self.tree.len(), false);
        let plan = self.plan(&ruled, first, guarded, tolerance, postpone);
        self.carry_out(plan, first, tolerance).await
    }

    /// Full lines for these nodes, sampled at the given depths besides; what they find is looked for on
    /// their neighbours.
    pub(crate) async fn integrate_in_full(
        &mut self,
        nodes: &[usize],
        depths: &[u32],
        tolerance: f64,
    ) -> Result<(), Stop> {
        let mut wanted = self.start(nodes, self.tree.len(), tolerance);
        wanted.iter_mut().for_each(|(_, of_line)| of_line.extend(depths));
        nodes.iter().for_each(|&i| self.sights.ways[i] = Way::Full);
        self.refine(wanted, tolerance).await?;
        self.follow(nodes, tolerance).await
    }
}

/// The blocks around a place that may have a rule, the largest first.
fn blocks_around(place: Place) -> impl Iterator<Item = Block> {
    (0..=FINEST_BLOCKS).map(move |level| Block::around(place, level))
}

/// The most depths of a rule, when `lines` full lines have so many `samples` together.
fn most_depths(samples: usize, lines: usize) -> usize {
    whole(MOST_DEPTHS * samples as f64 / lines.max(1) as f64)
}
