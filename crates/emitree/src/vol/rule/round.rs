//! One round: the radiances of some new nodes, by depth rules where these hold, by full lines
//! elsewhere.
//!
//! Some nodes of each rule are integrated in full to validate it on lines that were not in the fit.
//! Where the rule fails, the nodes in that quarter of its block get a better rule, or full lines.
//! Single nodes whose values are unlike the lines of the fit get full lines too.

use crate::vol::line::node_lines::{LineSource, Wanted, base_depths};
use crate::vol::rule::plan::{BlockRule, Plan};
use crate::vol::rule::scan::Scan;
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;
impl Scan<'_> {
    /// Computes the radiances of the nodes from number `first` on, each to `tolerance`; `guarded`
    /// are the guarded details of the former nodes.
    pub(crate) async fn scan(
        &mut self,
        first: usize,
        guarded: &[f64],
        tolerance: f64,
    ) -> Result<(), Stop> {
        let mut new: Vec<usize> = self.beyond_tolerance(first, tolerance).await?;
        new.extend(first..self.tree.len());
        // Where there is no rule yet, a third of the lines may suffice to fit one.
        let plan = self.plan(&new, first, guarded, tolerance, true);
        let rest = plan.postponed.clone();
        self.execute(plan, first, tolerance).await?;
        let plan = self.plan(&rest, first, guarded, tolerance, false);
        self.execute(plan, first, tolerance).await
    }

    /// Integrates the nodes of a plan, and those in full for which its rules fail.
    async fn execute(&mut self, mut plan: Plan, first: usize, tolerance: f64) -> Result<(), Stop> {
        self.scan_full(&plan, first, tolerance).await?;
        let mut again = self.replace_failed(&mut plan, tolerance);
        again.extend(self.apply(&plan, tolerance).await?);
        self.scan_again(&again, first, tolerance).await?;
        let mut found = plan.full;
        found.extend(again);
        self.replace_contradicted(&found, tolerance).await
    }

    /// Refines the older full lines whose error is above the tolerance, which follows the largest
    /// pixel, and returns the other nodes with such errors.
    async fn beyond_tolerance(&mut self, first: usize, tolerance: f64) -> Result<Vec<usize>, Stop> {
        let is_beyond = |&i: &usize| {
            let tolerance = self.node_lines.tolerance_of(i, tolerance);
            self.node_lines.error(i) > TUNING.rule.refinement_margin * tolerance
        };
        let beyond = (0..first).filter(is_beyond);
        let (full, ruled): (Vec<usize>, Vec<usize>) =
            beyond.partition(|&i| self.node_lines.is_full(i));
        self.refine(full.into_iter().map(|i| (i, Vec::new())).collect(), tolerance).await?;
        Ok(ruled)
    }

    /// Refines the full lines of the plan, and their neighbours where they have new structure.
    async fn scan_full(&mut self, plan: &Plan, first: usize, tolerance: f64) -> Result<(), Stop> {
        plan.full.iter().for_each(|&i| self.node_lines.sources[i] = LineSource::Full);
        let mut wanted = self.start(&plan.full, first, tolerance);
        let position: FxHashMap<usize, usize> =
            plan.full.iter().enumerate().map(|(k, &i)| (i, k)).collect();
        for (i, number) in &plan.validated {
            // The depths of the rule are sampled too, for the comparison with its integral.
            wanted[position[i]].1.extend(&plan.rules[*number].rule.depths);
        }
        self.refine(wanted, tolerance).await?;
        self.follow(&plan.full, tolerance).await
    }

    /// The depths that new full lines start with, given the lines before node `first`.
    fn start(&mut self, nodes: &[usize], first: usize, tolerance: f64) -> Wanted {
        let mut wanted =
            self.node_lines.start(&self.tree, nodes, first, tolerance, self.depth_level);
        for (i, depths) in &mut wanted {
            depths.extend(self.seeds.depths(self.tree.nodes()[*i].place));
        }
        wanted
    }

    /// Assigns the nodes of quarters in which a rule has failed to a better rule. Returns the nodes
    /// for which there is none.
    fn replace_failed(&self, plan: &mut Plan, tolerance: f64) -> BTreeSet<usize> {
        let mut failed = BTreeSet::new();
        for &(i, number) in &plan.validated {
            let BlockRule { block, rule } = &plan.rules[number];
            let line = &self.node_lines.lines[i];
            let rates: Vec<f64> = rule.depths.iter().map(|&depth| line.rate(depth)).collect();
            let error = (rule.integral(&rates) - line.integral).abs();
            // All nodes of the rule get this error.
            let allowed = self.tolerance_of_block(*block, tolerance);
            if error > TUNING.rule.failure_tolerance * allowed {
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
        let training = self.training();
        for (block, quarter) in failed {
            let better = [quarter, block]
                .into_iter()
                .filter_map(|block| {
                    self.fit_rule(
                        block,
                        &training,
                        tolerance,
                        TUNING.rule.most_depths_after_failure,
                    )
                })
                .min_by_key(|better| better.rule.depths.len());
            let better = better.map(|better| {
                plan.rules.push(better);
                plan.rules.len() - 1
            });
            for i in 0..self.tree.len() {
                let of_failed = match (plan.ruled.get(&i), self.node_lines.sources[i]) {
                    (Some(&number), _) => plan.rules[number].block == block,
                    (None, LineSource::Rule { block: of_node, .. }) => of_node == block,
                    (None, LineSource::Full | LineSource::Unknown) => false,
                };
                if !of_failed
                    || !quarter.contains(self.tree.nodes()[i].place, TUNING.rule.failure_margin)
                {
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

    /// Samples the depths of the rules in one batch, and returns the outliers.
    async fn apply(&mut self, plan: &Plan, tolerance: f64) -> Result<Vec<usize>, Stop> {
        let wanted =
            plan.ruled.iter().map(|(&i, &number)| (i, plan.rules[number].rule.depths.clone()));
        self.node_lines.sample(&self.view, &self.tree, &wanted.collect()).await?;
        let mut outliers = Vec::new();
        // The numbers of the rules of the plan among all.
        let mut kept: FxHashMap<usize, usize> = FxHashMap::default();
        for (&i, &number) in &plan.ruled {
            let BlockRule { block, rule } = &plan.rules[number];
            let allowed = self.node_lines.tolerance_of(i, tolerance);
            let line = &mut self.node_lines.lines[i];
            let rates: Vec<f64> = rule.depths.iter().map(|&depth| line.rate(depth)).collect();
            line.integral = rule.integral(&rates);
            let all = &mut self.node_lines.rules;
            let number = *kept.entry(number).or_insert_with(|| {
                all.push(rule.weighted_depths());
                all.len() - 1
            });
            self.node_lines.sources[i] =
                LineSource::Rule { block: *block, error: rule.error, rule: number };
            let is_stricter = rule.error > TUNING.rule.failure_tolerance * allowed;
            if is_stricter || rule.is_outlier(&rates, allowed) {
                outliers.push(i);
            }
        }
        Ok(outliers)
    }

    /// Integrates nodes in full whose rules do not hold.
    pub(super) async fn scan_again(
        &mut self,
        nodes: &BTreeSet<usize>,
        first: usize,
        tolerance: f64,
    ) -> Result<(), Stop> {
        let numbers: Vec<usize> = nodes.iter().copied().collect();
        let wanted = self.start(&numbers, first, tolerance);
        nodes.iter().for_each(|&i| self.node_lines.sources[i] = LineSource::Full);
        self.refine(wanted, tolerance).await
    }

    /// Samples every full line on a lattice of depths that is finer by `levels`, and computes the
    /// radiances of all other nodes with new rules; `guarded` are the guarded details of all nodes.
    pub(crate) async fn refine_depths(
        &mut self,
        levels: u8,
        guarded: &[f64],
        tolerance: f64,
    ) -> Result<(), Stop> {
        self.depth_level += levels;
        let depths = base_depths(self.depth_level);
        let in_view = 0..self.tree.len();
        let (full, ruled): (Vec<usize>, Vec<usize>) =
            in_view.partition(|&i| self.node_lines.is_full(i));
        self.refine(full.iter().map(|&i| (i, depths.clone())).collect(), tolerance).await?;
        self.follow(&full, tolerance).await?;
        let (first, postpone) = (self.tree.len(), false);
        let plan = self.plan(&ruled, first, guarded, tolerance, postpone);
        self.execute(plan, first, tolerance).await
    }

    /// Integrates nodes in full, with the given depths in addition, and samples new structure on
    /// their neighbours. Rules that are wrong on them are replaced beside them.
    pub(crate) async fn integrate_in_full(
        &mut self,
        nodes: &[usize],
        depths: &[u32],
        tolerance: f64,
    ) -> Result<(), Stop> {
        let mut wanted = self.start(nodes, self.tree.len(), tolerance);
        wanted.iter_mut().for_each(|(_, of_line)| of_line.extend(depths));
        nodes.iter().for_each(|&i| self.node_lines.sources[i] = LineSource::Full);
        self.refine(wanted, tolerance).await?;
        self.follow(nodes, tolerance).await?;
        self.replace_contradicted(nodes, tolerance).await
    }
}
