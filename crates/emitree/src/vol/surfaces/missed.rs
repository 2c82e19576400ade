//! Surfaces between samples of one region, which no edge of the first lattice crosses: those of a small cavity.
//!
//! A region with such a surface needs more and more polynomials. Where these are worst, G is searched for a jump.

use crate::projection::vector::{difference, norm};
use crate::vol::surfaces::bisection::Bracket;
use crate::vol::surfaces::boxes::OpenBox;
use crate::vol::surfaces::octree::{Leaf, Octree};
use crate::vol::surfaces::search::{Failure, Search, of_tolerance};

/// The nodes of a region at 1 % from which on it is searched for jumps, and how many times as many it has the next time.
const FIRST_NODES: f64 = 150.0;
const MORE_NODES: u64 = 2;
/// The boxes that are searched at once.
const BOXES: usize = 8;
/// The samples of a box that are compared with each other.
const MOST_SAMPLES: usize = 64;
/// When a region is searched for jumps.
pub(super) struct Schedule {
    next: u64,
}

impl Schedule {
    pub(super) fn new(tolerance: f64) -> Self {
        Self { next: of_tolerance(FIRST_NODES, tolerance) }
    }

    /// Whether it is time, with so many nodes.
    pub(super) fn is_due(&mut self, nodes: usize) -> bool {
        let is_due = nodes as u64 > self.next;
        if is_due {
            self.next = MORE_NODES * nodes as u64;
        }
        is_due
    }
}

impl Search<'_> {
    /// Whether G jumps between samples of a region in those of its boxes whose polynomials have the largest errors, and
    /// where no patch is known: a patch that is not good enough is refined without this.
    pub(super) async fn jumps_within(
        &mut self,
        tree: &Octree,
        boxes: &[OpenBox],
        errors: &[f64],
    ) -> Result<bool, Failure> {
        let mut worst: Vec<(&f64, &OpenBox)> = errors.iter().zip(boxes).collect();
        worst.sort_by(|a, b| b.0.total_cmp(a.0));
        let pairs = worst.into_iter().filter_map(|(_, of)| self.steepest(tree, of)).take(BOXES);
        Ok(self.are_jumps(pairs.collect(), &mut Vec::new()).await?.contains(&true))
    }

    /// The two samples of a box, in leaves without patches, between which G is steepest.
    fn steepest(&self, tree: &Octree, of: &OpenBox) -> Option<Bracket> {
        let stride = of.samples.len() / MOST_SAMPLES + 1;
        let samples = of.samples.iter().step_by(stride).map(|&i| self.samples.get(i));
        let is_uncut = |at: [f64; 3]| matches!(tree.leaf(at), Leaf::Uncut(_));
        let samples: Vec<([f64; 3], f64)> =
            samples.filter(|of| is_uncut(of.at)).map(|of| (of.at, of.rate)).collect();
        let pairs = (0..samples.len()).flat_map(|i| (0..i).map(move |j| [i, j]));
        let with_slope = pairs.map(|pair| {
            let [a, b] = pair.map(|i| samples[i]);
            ((b.1 - a.1).abs() / norm(difference(b.0, a.0)), [a, b])
        });
        // Without those of two samples at one place.
        let steep = with_slope.filter(|(slope, _)| *slope > 0.0);
        steep.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, pair)| pair)
    }
}

#[cfg(test)]
mod tests;
