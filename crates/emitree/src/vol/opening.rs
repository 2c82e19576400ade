//! Opening: which nodes get children, so that every pixel can be expected to be good enough.
//!
//! The largest contributions first, each taken off a copy of the error map, until no pixel is above
//! the goal: a node next to a bad pixel is left alone if larger ones are expected to mend it.

use super::dyadic::{spacing, unit};
use super::error_map::Footprint;
use super::image_tree::{ImageTree, Place};
use super::remaining::{Children, Remaining, around};
use crate::cell;
use crate::image::Image;
use rustc_hash::FxHashSet;

/// Every pixel is to be expected below this share of the tolerance.
const GOAL: f64 = 0.7;
/// What opening a node takes away of its contribution.
const EXPECTED_GAIN: f64 = 0.95;
/// A contribution below this share of the tolerance is left alone.
const LEAST_CONTRIBUTION: f64 = 1e-3;

/// What the choice is made from.
pub(crate) struct Choice<'a> {
    pub(crate) tree: &'a ImageTree,
    pub(crate) remaining: &'a [Remaining],
    /// For each node, where what remains reaches the image, if anything does.
    pub(crate) footprints: &'a [Option<Footprint>],
    pub(crate) error: &'a Image,
    pub(crate) scale: &'a Image,
    /// The error allowed, in the unit of the image.
    pub(crate) tolerance: f64,
    /// The deepest level that nodes may have.
    pub(crate) finest_level: u8,
    /// The finest level that every rendering looks at.
    pub(crate) always: u8,
}

/// The nodes to be opened of each of the trees whose images add up, the most worthwhile first: they
/// compete for the same error.
pub(crate) fn worthwhile(choices: &[Choice<'_>]) -> Vec<Vec<usize>> {
    let mut opened = vec![Vec::new(); choices.len()];
    let Some(first) = choices.first() else { return opened };
    let of_tree = |(tree, choice): (usize, &Choice<'_>)| {
        let found = choice.candidates().into_iter();
        found.map(|(contribution, i)| (contribution, tree, i)).collect::<Vec<_>>()
    };
    let mut candidates: Vec<_> = choices.iter().enumerate().flat_map(of_tree).collect();
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut expected = first.error.clone();
    for (_, tree, i) in candidates {
        let choice = &choices[tree];
        let Some(footprint) = &choice.footprints[i] else { continue };
        if footprint.touches_above(&expected, choice.scale, GOAL * choice.tolerance) {
            footprint.add_to(&mut expected, choice.scale, -EXPECTED_GAIN);
            opened[tree].push(i);
        }
    }
    opened
}

impl Choice<'_> {
    /// The nodes that may be opened, with what each may contribute to a pixel's error.
    fn candidates(&self) -> Vec<(f64, usize)> {
        let [height, width] = [self.error.height(), self.error.width()].map(|n| n as f64);
        let mut candidates = Vec::new();
        for (i, node) in self.tree.nodes().iter().enumerate() {
            if self.footprints[i].is_some() && node.level < self.finest_level {
                let half_width = unit(spacing(node.level));
                let share = (half_width * width).min(1.0) * (half_width * height).min(1.0);
                let contribution = self.remaining[i].size * share;
                if contribution >= LEAST_CONTRIBUTION * self.tolerance {
                    candidates.push((contribution, i));
                }
            }
        }
        candidates
    }

    /// The places of the children that are missing around `nodes`, in that order, each once.
    pub(crate) fn places(&self, nodes: &[usize]) -> Vec<Place> {
        let mut seen = FxHashSet::default();
        let mut places = Vec::new();
        for &i in nodes {
            let node = self.tree.nodes()[i];
            let diagonal_only =
                node.level >= self.always && self.remaining[i].children == Children::None;
            for (dx, dy, child) in around(node.place, spacing(node.level + 1), 1) {
                let beside = dx == 0 || dy == 0;
                if (diagonal_only && beside) || self.tree.find(child).is_some() {
                    continue;
                }
                if seen.insert(cell::key(child)) {
                    places.push(child);
                }
            }
        }
        places
    }
}
