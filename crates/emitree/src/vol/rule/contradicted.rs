//! Nodes of depth rules beside full lines on which these rules are wrong.
//!
//! A rule is fitted to the full lines of its time. Structure that none of them has met, such as a wire
//! that passes between them, may be at none of its depths. Later lines that meet it show where the rule
//! does not hold: their samples give what the rule would have made of them, without an evaluation.

use crate::parallel::prelude::*;
use crate::vol::dyadic::{around, spacing};
use crate::vol::line::node_lines::{LINES_ASSESSED, LineSource};
use crate::vol::rule::scan::Scan;
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use std::collections::BTreeSet;

impl Scan<'_> {
    /// Integrates the nodes of rules in full that are wrong on the full lines `found` beside them, and those
    /// beside these.
    pub(crate) async fn replace_contradicted(
        &mut self,
        found: &[usize],
        tolerance: f64,
    ) -> Result<(), Stop> {
        let mut found = found.to_vec();
        // Each step makes full lines of nodes with rules.
        loop {
            let contradicted = self.contradicted(&found, tolerance);
            if contradicted.is_empty() {
                return Ok(());
            }
            found = contradicted.iter().copied().collect();
            self.scan_again(&contradicted, self.tree.len(), tolerance).await?;
        }
    }

    /// The nodes of rules beside the full lines `found` on which these rules are wrong.
    fn contradicted(&self, found: &[usize], tolerance: f64) -> BTreeSet<usize> {
        let beside = |&i: &usize| {
            let node = &self.tree.nodes()[i];
            let step = spacing(node.level.max(self.base_level));
            let nodes = around(node.place, step, 1).filter_map(|(_, _, at)| self.tree.find(at));
            nodes.filter(|&k| self.is_wrong_on(k, i, tolerance)).collect::<Vec<_>>()
        };
        let found = found.par_iter().with_min_len(LINES_ASSESSED);
        found.flat_map_iter(beside).collect()
    }

    /// Whether node `k` has a rule that is wrong on the full line `i`.
    fn is_wrong_on(&self, k: usize, i: usize, tolerance: f64) -> bool {
        let LineSource::Rule { rule, .. } = self.node_lines.sources[k] else { return false };
        let line = &self.node_lines.lines[i];
        let terms = self.node_lines.rules[rule].iter().map(|&(depth, w)| w * line.rate(depth));
        let error = (terms.sum::<f64>() - line.integral).abs();
        error > TUNING.rule.contradiction * self.node_lines.tolerance_of(k, tolerance)
    }
}
