//! Depth rules of another emission: their errors on the lines of this one.

use crate::vol::image::block::Block;
use crate::vol::line::node_lines::{LineSource, NodeLines};
use crate::vol::rule::scan::Scan;
use crate::vol::tuning::TUNING;
use std::collections::{BTreeMap, BTreeSet};

/// A rule on full lines.
struct OnLines {
    /// The largest |error| of an integral, with a margin.
    error: f64,
    /// The range of G at each depth.
    ranges: Vec<(f64, f64)>,
}

impl Scan<'_> {
    /// Sets the errors of the rules that integrate lines: the largest on the full lines around, and where a
    /// line has rates far beyond theirs, the effect of those.
    pub(crate) fn assess_rules(&mut self) {
        let mut of_rules: BTreeMap<(usize, Block), Vec<usize>> = BTreeMap::new();
        for (i, source) in self.node_lines.sources.iter().enumerate() {
            if let LineSource::Rule { block, rule, .. } = *source {
                of_rules.entry((rule, block)).or_default().push(i);
            }
        }
        let full: Vec<usize> =
            (0..self.tree.len()).filter(|&i| self.node_lines.is_full(i)).collect();
        for ((rule, block), nodes) in of_rules {
            let near = self.full_lines_near(&full, block, &nodes);
            let on_lines = OnLines::new(&self.node_lines, rule, &near);
            for i in nodes {
                let error = on_lines.error.max(on_lines.beyond(&self.node_lines, i, rule));
                self.node_lines.sources[i] = LineSource::Rule { block, error, rule };
            }
        }
    }

    /// The full lines in the smallest blocks around some nodes that have enough of them. The rule may have
    /// failed in other parts of its own block.
    fn full_lines_near(&self, full: &[usize], block: Block, nodes: &[usize]) -> Vec<usize> {
        let place = |i: usize| self.tree.nodes()[i].place;
        let finer = (block.level + 1..=TUNING.image.finest_block_level).rev();
        for level in finer {
            let around: BTreeSet<Block> =
                nodes.iter().map(|&i| Block::around(place(i), level)).collect();
            let is_near = |&&i: &&usize| {
                around.iter().any(|of| of.contains(place(i), TUNING.rule.failure_margin))
            };
            let near: Vec<usize> = full.iter().filter(is_near).copied().collect();
            if near.len() >= TUNING.rule.least_lines {
                return near;
            }
        }
        let is_near = |&&i: &&usize| block.contains(place(i), TUNING.rule.training_margin);
        full.iter().filter(is_near).copied().collect()
    }
}

impl OnLines {
    fn new(node_lines: &NodeLines, rule: usize, near: &[usize]) -> Self {
        let weighted = &node_lines.rules[rule];
        let mut error: f64 = 0.0;
        let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); weighted.len()];
        for line in near.iter().map(|&i| &node_lines.lines[i]) {
            let mut integral = 0.0;
            for ((depth, weight), (least, most)) in weighted.iter().zip(&mut ranges) {
                let rate = line.rate(*depth);
                integral += weight * rate;
                (*least, *most) = (least.min(rate), most.max(rate));
            }
            error = error.max((integral - line.integral).abs());
        }
        Self { error: TUNING.rule.given_rule_margin * error, ranges }
    }

    /// The effect of the rates of a line that are far beyond those of the full lines.
    fn beyond(&self, node_lines: &NodeLines, i: usize, rule: usize) -> f64 {
        let line = &node_lines.lines[i];
        let effect = |(&(depth, weight), &(least, most)): (&(u32, f64), &(f64, f64))| {
            let rate = line.rate(depth);
            if least > most {
                // No full line is near.
                return (weight * rate).abs();
            }
            let beyond = (rate - rate.clamp(least, most)).abs();
            let is_far = beyond > TUNING.rule.outlier_range * (most - least);
            if is_far { beyond * weight.abs() } else { 0.0 }
        };
        node_lines.rules[rule].iter().zip(&self.ranges).map(effect).fold(0.0, f64::max)
    }
}
