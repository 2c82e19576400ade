//! The plan of a round: which nodes are integrated by a depth rule, and which in full.

use crate::cell::whole;
use crate::parallel::prelude::*;
use crate::vol::dyadic::{Place, around, spacing};
use crate::vol::image::block::Block;
use crate::vol::line::node_lines::LINES_CACHED;
use crate::vol::line::profile::Profile;
use crate::vol::rule::depth_rule::DepthRule;
use crate::vol::rule::scan::Scan;
use crate::vol::tuning::TUNING;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;

/// A depth rule and the block that it is fitted for.
#[derive(Clone, Debug)]
pub(crate) struct BlockRule {
    pub(crate) block: Block,
    pub(crate) rule: DepthRule,
}

/// The full lines that rules are fitted to: their numbers and places.
pub(crate) struct TrainingLines {
    /// In the order of the nodes.
    pub(crate) lines: Vec<(usize, Place)>,
    /// The places of those with jumps.
    pub(crate) jumping: Vec<Place>,
}

impl TrainingLines {
    /// Whether lines in a block or in a margin around it have jumps: then no rule is fitted.
    fn have_jumps(&self, block: Block) -> bool {
        self.jumping.iter().any(|&place| block.contains(place, TUNING.rule.training_margin))
    }
}

/// The integration of some nodes.
#[derive(Debug, Default)]
pub(crate) struct Plan {
    pub(crate) rules: Vec<BlockRule>,
    /// Nodes that are integrated in full.
    pub(crate) full: Vec<usize>,
    /// Nodes that are postponed until rules can be fitted to the full lines among them.
    pub(crate) postponed: Vec<usize>,
    /// Nodes that are integrated in full and compared with the rule of this number.
    pub(crate) validated: Vec<(usize, usize)>,
    /// Nodes that are integrated by the rule of this number.
    pub(crate) ruled: BTreeMap<usize, usize>,
}

impl Scan<'_> {
    /// The full lines of all nodes, to which rules may be fitted.
    pub(crate) fn training(&self) -> TrainingLines {
        let full = (0..self.tree.len()).filter(|&i| self.node_lines.is_full(i));
        let lines: Vec<_> = full.map(|i| (i, self.tree.nodes()[i].place)).collect();
        let known = lines.par_iter().with_min_len(LINES_CACHED);
        let jumping = known.filter(|(i, _)| self.node_lines.has_jump(*i));
        let jumping = jumping.map(|(_, place)| *place).collect();
        TrainingLines { lines, jumping }
    }

    /// The rule of a block, fitted to the full lines in it and in a margin around it.
    pub(crate) fn fit_rule(
        &self,
        block: Block,
        training: &TrainingLines,
        tolerance: f64,
        most_depths: usize,
    ) -> Option<BlockRule> {
        if training.have_jumps(block) {
            return None;
        }
        let near = training
            .lines
            .iter()
            .filter(|(_, at)| block.contains(*at, TUNING.rule.training_margin));
        let near: Vec<usize> = near.map(|(i, _)| *i).collect();
        if near.len() < TUNING.rule.least_lines {
            return None;
        }
        // Most blocks of an image with jumps have no rule: profiles are computed only where one is
        // fitted.
        let lines: Vec<&Profile> = near.par_iter().map(|&i| self.node_lines.profile(i)).collect();
        let tolerance = self.tolerance_of_block(block, tolerance);
        let rule = DepthRule::fit(&lines, tolerance, most_depths)?;
        Some(BlockRule { block, rule })
    }

    /// The tolerance of a rule, that of the strictest of the lines in its block, from that of a line with the
    /// weight 1.
    pub(crate) fn tolerance_of_block(&self, block: Block, tolerance: f64) -> f64 {
        // Lines affect the image up to their next nodes, which may be beyond the block.
        tolerance / self.weight_around(block.middle(), block.level)
    }

    /// The rules of all blocks around some nodes for which one can be fitted.
    fn rules_around(
        &self,
        nodes: &[usize],
        training: &TrainingLines,
        tolerance: f64,
    ) -> Vec<BlockRule> {
        let samples = training.lines.iter().map(|(i, _)| self.node_lines.lines[*i].samples.len());
        let most_depths = most_depths(samples.sum(), training.lines.len());
        let mut met = FxHashSet::default();
        let around = nodes.iter().flat_map(|&i| blocks_around(self.tree.nodes()[i].place));
        let blocks: Vec<Block> = around.filter(|&block| met.insert(block)).collect();
        let fit = |&block: &Block| self.fit_rule(block, training, tolerance, most_depths);
        blocks.par_iter().filter_map(fit).collect()
    }

    /// Assigns each of the `new` nodes to the rule around it with the fewest depths, or to full
    /// integration.
    pub(crate) fn plan(
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
        let training = self.training();
        let rules = self.rules_around(&unseeded, &training, tolerance);
        let mut plan = Plan { rules, full: seeded, ..Plan::default() };
        let numbers = plan.rules.iter().zip(0..).map(|(rule, number)| (rule.block, number));
        let numbers: FxHashMap<Block, usize> = numbers.collect();
        let mut jumping: FxHashMap<Block, bool> = FxHashMap::default();
        let mut of_rule: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for i in unseeded {
            let rules = blocks_around(place(i)).filter_map(|block| numbers.get(&block).copied());
            // The first one of equal length is that of the largest block.
            let shortest = rules.min_by_key(|&number| plan.rules[number].rule.depths.len());
            if let Some(number) = shortest {
                of_rule.entry(number).or_default().push(i);
                continue;
            }
            // No rule can be fitted where there are jumps.
            let block = Block::around(place(i), TUNING.image.finest_block_level);
            let has_jumps = *jumping.entry(block).or_insert_with(|| training.have_jumps(block));
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

    /// The nodes of a rule that are integrated in full: half of them where the largest guarded
    /// details are near, half distributed over the rest.
    fn validated(&self, nodes: &[usize], first: usize, guarded: &[f64]) -> Vec<usize> {
        let nearby = |&i: &usize| {
            let node = &self.tree.nodes()[i];
            let neighbours = around(node.place, spacing(node.level), 1)
                .filter_map(|(_, _, place)| self.tree.find(place).filter(|&k| k < first));
            neighbours.map(|k| guarded[k]).fold(0.0, f64::max)
        };
        let mut ranked: Vec<(f64, usize)> = nodes.iter().map(|i| (nearby(i), *i)).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let count = whole((TUNING.rule.validation_factor * (nodes.len() as f64).sqrt()).ceil())
            .min(nodes.len());
        let largest = count.div_ceil(2);
        let rest = &ranked[largest..];
        let stride = rest.len().checked_div(count - largest).unwrap_or(0).max(1);
        let spread = rest.iter().skip(stride / 2).step_by(stride).take(count - largest);
        ranked[..largest].iter().chain(spread).map(|(_, i)| *i).collect()
    }
}

/// The blocks around a place that may have a rule, the largest first.
fn blocks_around(place: Place) -> impl Iterator<Item = Block> {
    (0..=TUNING.image.finest_block_level).map(move |level| Block::around(place, level))
}

/// The most depths of a rule, if `lines` full lines have `samples` samples together.
fn most_depths(samples: usize, lines: usize) -> usize {
    whole(TUNING.rule.most_depths_share * samples as f64 / lines.max(1) as f64)
}
