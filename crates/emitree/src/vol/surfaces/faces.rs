//! Faces between leaves: a surface does not end at the face of a cell.
//!
//! Where two leaves disagree about the region beside their common face, one evaluation decides, and
//! the leaf that is wrong is divided. A surface that has been found once is so continued through all
//! of its folds.

use crate::vol::surfaces::comparisons::Disagreement;
use crate::vol::surfaces::octree::{Cell, Leaf, Octree};
use crate::vol::surfaces::search::{Failure, Search};
use rustc_hash::FxHashSet;

impl Search<'_> {
    /// The leaves as a tree.
    pub(super) fn octree(&self) -> Octree {
        Octree::new(self.grid, self.current_leaves())
    }

    /// The leaves, with the regions that their labels stand for.
    pub(super) fn current_leaves(&self) -> Vec<(Cell, Leaf)> {
        let current = |(cell, leaf): (&Cell, &Leaf)| {
            let mut leaf = leaf.clone();
            match &mut leaf {
                Leaf::Uncut(label) | Leaf::Unresolved(label, _) => {
                    *label = self.samples.current(*label);
                }
                Leaf::Hidden => {}
                Leaf::Cut(facets) => facets.iter_mut().for_each(|of| {
                    of.below = self.samples.current(of.below);
                    of.above = self.samples.current(of.above);
                }),
            }
            (*cell, leaf)
        };
        self.leaves.iter().map(current).collect()
    }

    /// The leaves that are wrong beside a face, as far as they can be divided.
    pub(super) async fn disagreeing(&mut self) -> Result<Vec<Cell>, Failure> {
        let tree = self.octree();
        let mut found: Vec<Disagreement> = self.comparisons.repeat(&tree, &self.aim);
        found.sort_by(|a, b| b.clearance.total_cmp(&a.clearance).then(a.leaves.cmp(&b.leaves)));
        let mut asked = Vec::new();
        let mut seen = FxHashSet::default();
        for of in found {
            let [a, b] = of.leaves;
            let is_finest = of.leaves.iter().all(|(level, _)| *level == self.grid.finest);
            if !is_finest && seen.insert((a.min(b), a.max(b))) {
                asked.push(of);
            }
        }
        let points: Vec<[f64; 3]> = asked.iter().map(|of| of.at).collect();
        let samples = self.sample(&points).await?;
        let mut wrong: Vec<Cell> = Vec::new();
        for (of, sample) in asked.iter().zip(samples) {
            let label = self.samples.label(sample);
            let both = of.leaves.iter().zip(&of.labels);
            wrong.extend(both.filter(|(_, own)| **own != label).map(|(leaf, _)| *leaf));
        }
        wrong.sort_unstable();
        wrong.dedup();
        wrong.retain(|(level, _)| *level < self.grid.finest);
        Ok(wrong)
    }
}
