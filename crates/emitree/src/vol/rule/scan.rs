//! One round: the radiances of some new nodes, by depth rules where these hold, by full lines
//! elsewhere.
//!
//! Some nodes of each rule are integrated in full to validate it on lines that were not in the fit.
//! Where the rule fails, the nodes in that quarter of its block get a better rule, or full lines.
//! Single nodes whose values are unlike the lines of the fit get full lines too.

use crate::vol::dyadic::{Place, around, spacing, unit};
use crate::vol::image::tree::{Around, ImageTree};
use crate::vol::line::node_lines::{LineSource, NodeLines, Wanted, base_depths};
use crate::vol::rule::plan::{BlockRule, Plan};
use crate::vol::sampling::{Stop, View};
use crate::vol::seeds::SeedTargets;
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// The number of steps between a closed node and its neighbours on its lattice at which open places
/// are searched for. Narrower parts of the image are found where they are wider, or contribute
/// little to a pixel.
const BETWEEN: i8 = 4;

/// An image tree, its lines, and the view in which they are sampled.
pub(crate) struct Scan<'a> {
    pub(crate) view: View<'a>,
    pub(crate) base_level: u8,
    /// Every full line has all depths of the lattice of this level. It is the base level, or a
    /// finer one after a verification has found structure between the depths.
    pub(crate) depth_level: u8,
    pub(crate) tree: ImageTree,
    pub(crate) node_lines: NodeLines,
    /// Structures that the options name: their nodes are integrated in full, since no rule has been
    /// fitted to them.
    pub(crate) seeds: SeedTargets,
    /// Whether places outside the view are not evaluated.
    pub(crate) skips_closed: bool,
}

impl Scan<'_> {
    /// Adds nodes without radiances.
    pub(crate) fn add(&mut self, places: &[Place]) {
        let first = self.tree.len();
        places.iter().for_each(|&place| self.tree.add(place));
        self.node_lines.grow(self.tree.len());
        if self.skips_closed {
            for (i, &place) in (first..).zip(places) {
                if !self.view.layer.is_open(place.map(unit)) {
                    self.node_lines.sources[i] = LineSource::Closed;
                    let around = self.open_around(place, self.tree.nodes()[i].level);
                    self.tree.set_around(i, around);
                }
            }
        }
    }

    /// The open places around a closed place of a level, from the geometry of the view without an
    /// evaluation.
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

    /// Removes all nodes but the first `len`.
    pub(crate) fn truncate(&mut self, len: usize) {
        self.tree.truncate(len);
        self.node_lines.truncate(len);
    }

    /// Samples the depths and refines the lines until each is within `tolerance`.
    pub(crate) async fn refine(&mut self, wanted: Wanted, tolerance: f64) -> Result<(), Stop> {
        self.node_lines.refine(&self.view, &self.tree, wanted, tolerance, self.depth_level).await
    }

    /// Samples structure found on the given full lines on their neighbours.
    pub(crate) async fn follow(&mut self, found: &[usize], tolerance: f64) -> Result<(), Stop> {
        self.node_lines.follow(&self.view, &self.tree, found, tolerance, self.depth_level).await
    }

    /// Computes the radiances of the nodes from number `first` on, each to `tolerance`; `guarded`
    /// are the guarded details of the former nodes.
    pub(crate) async fn scan(
        &mut self,
        first: usize,
        guarded: &[f64],
        tolerance: f64,
    ) -> Result<(), Stop> {
        let mut new: Vec<usize> = self.beyond_tolerance(first, tolerance).await?;
        new.extend((first..self.tree.len()).filter(|&i| !self.node_lines.is_closed(i)));
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
        self.scan_again(&again, first, tolerance).await
    }

    /// Refines the older full lines whose error is above the tolerance, which follows the largest
    /// pixel, and returns the other nodes with such errors.
    async fn beyond_tolerance(&mut self, first: usize, tolerance: f64) -> Result<Vec<usize>, Stop> {
        let beyond = (0..first)
            .filter(|&i| self.node_lines.error(i) > TUNING.rule.refinement_margin * tolerance);
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
            if error > TUNING.rule.failure_tolerance * tolerance {
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
                    (None, LineSource::Full | LineSource::Unknown | LineSource::Closed) => false,
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
        for (&i, &number) in &plan.ruled {
            let BlockRule { block, rule } = &plan.rules[number];
            let line = &mut self.node_lines.lines[i];
            let rates: Vec<f64> = rule.depths.iter().map(|&depth| line.rate(depth)).collect();
            line.integral = rule.integral(&rates);
            self.node_lines.sources[i] = LineSource::Rule { block: *block, error: rule.error };
            if rule.is_outlier(&rates, tolerance) {
                outliers.push(i);
            }
        }
        Ok(outliers)
    }

    /// Integrates nodes in full whose rules do not hold.
    async fn scan_again(
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
        let in_view = (0..self.tree.len()).filter(|&i| !self.node_lines.is_closed(i));
        let (full, ruled): (Vec<usize>, Vec<usize>) =
            in_view.partition(|&i| self.node_lines.is_full(i));
        self.refine(full.iter().map(|&i| (i, depths.clone())).collect(), tolerance).await?;
        self.follow(&full, tolerance).await?;
        let (first, postpone) = (self.tree.len(), false);
        let plan = self.plan(&ruled, first, guarded, tolerance, postpone);
        self.execute(plan, first, tolerance).await
    }

    /// Integrates nodes in full, with the given depths in addition, and samples new structure on
    /// their neighbours.
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
        self.follow(nodes, tolerance).await
    }
}
