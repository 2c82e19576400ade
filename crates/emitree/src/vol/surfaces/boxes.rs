//! Boxes that are to have polynomials, tightened around a region.

use crate::projection::vector::difference;
use crate::vol::lattice;
use crate::vol::surfaces::octree::Octree;
use crate::vol::surfaces::polynomial::Polynomial;

/// The candidates for samples of a box.
pub(super) const CANDIDATES: usize = 512;

/// A box that has no polynomial yet.
#[derive(Debug)]
pub(super) struct OpenBox {
    pub(super) node: usize,
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
    pub(super) level: u8,
    /// Samples of the region in it, and leaves that may contain some of the region.
    pub(super) samples: Vec<usize>,
    pub(super) leaves: Vec<usize>,
}

impl OpenBox {
    /// What is there before there are samples.
    pub(super) fn zero(&self) -> Polynomial {
        Polynomial::zero(self.low, self.high)
    }

    /// Leaves out the leaves that are not in the box, and then the part of the box without leaves.
    pub(super) fn tightened(mut self, tree: &Octree) -> Self {
        let overlap = |leaf: usize, axis: usize| {
            let [from, to] = tree.ends(leaf, axis);
            [from.max(self.low[axis]), to.min(self.high[axis])]
        };
        self.leaves.retain(|&leaf| {
            (0..3).all(|axis| {
                let [from, to] = overlap(leaf, axis);
                from < to
            })
        });
        let bounds = |axis: usize| {
            let ends = self.leaves.iter().map(|&leaf| overlap(leaf, axis));
            let join = |[a, b]: [f64; 2], [from, to]: [f64; 2]| [a.min(from), b.max(to)];
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], join)
        };
        if !self.leaves.is_empty() {
            let bounds = [0, 1, 2].map(bounds);
            (self.low, self.high) = (bounds.map(|of| of[0]), bounds.map(|of| of[1]));
        }
        self
    }

    /// The two halves along an axis, whose nodes follow.
    pub(super) fn halves(
        &self,
        axis: usize,
        node: usize,
        is_below: impl Fn(usize) -> bool,
    ) -> [Self; 2] {
        let at = 0.5 * (self.low[axis] + self.high[axis]);
        [0, 1].map(|half| {
            let (mut low, mut high) = (self.low, self.high);
            if half == 0 {
                high[axis] = at;
            } else {
                low[axis] = at;
            }
            let is_in = |i: &&usize| is_below(**i) == (half == 0);
            let samples = self.samples.iter().filter(is_in).copied().collect();
            let (node, leaves) = (node + half, self.leaves.clone());
            Self { node, low, high, level: self.level + 1, samples, leaves }
        })
    }
}

/// The point at shares `u` of the edges of a box from its corner.
pub(super) fn along_each(low: [f64; 3], u: [f64; 3], edges: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|k| low[k] + u[k] * edges[k])
}

/// Scattered points of a box that are in the region.
pub(super) fn candidates(of: &OpenBox, is_in_region: &dyn Fn([f64; 3]) -> bool) -> Vec<[f64; 3]> {
    let edges = difference(of.high, of.low);
    let mut found = Vec::new();
    for k in 0..16 * CANDIDATES {
        let u = lattice::point(k);
        let at = along_each(of.low, u, edges);
        if is_in_region(at) {
            found.push(at);
        }
        if found.len() == CANDIDATES / 2 || (k >= 4 * CANDIDATES && found.is_empty()) {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::surfaces::octree::{Grid, Label, Leaf};

    const EMPTY: Label = 0;
    const REGION: Label = 1;

    /// A region in two of the eight cells, beside each other along y.
    fn tree() -> Octree {
        let grid = Grid { edges: [1.0; 3], base: [2; 3], finest: 1 };
        let is_region = |at: [u32; 3]| at[0] == 1 && at[2] == 0;
        let leaf = |k: u32| {
            let at = [k / 4, k / 2 % 2, k % 2];
            let label = if is_region(at) { REGION } else { EMPTY };
            ((0, at), Leaf::Uncut(label))
        };
        Octree::new(grid, (0..8).map(leaf).collect())
    }

    fn whole(tree: &Octree) -> OpenBox {
        let leaves = (0..8).filter(|&leaf| tree.leaves[leaf].1.has(REGION)).collect();
        let (low, high) = ([0.0; 3], [1.0; 3]);
        OpenBox { node: 0, low, high, level: 0, samples: vec![3, 4, 5], leaves }
    }

    #[test]
    fn a_box_is_tightened_to_the_leaves_of_a_region() {
        let tree = tree();
        let tight = whole(&tree).tightened(&tree);
        assert_eq!((tight.low, tight.high), ([0.5, 0.0, 0.0], [1.0, 1.0, 0.5]));
        let found = candidates(&tight, &|at| tree.leaf(at).region(at) == REGION);
        assert_eq!(found.len(), CANDIDATES / 2);
    }

    #[test]
    fn halves_share_samples_and_leaves() {
        let tree = tree();
        let [below, above] = whole(&tree).tightened(&tree).halves(1, 7, |sample| sample < 4);
        assert_eq!([below.node, above.node, usize::from(above.level)], [7, 8, 1]);
        assert_eq!((below.samples.as_slice(), above.samples.as_slice()), (&[3][..], &[4, 5][..]));
        let tight = above.tightened(&tree);
        assert_eq!((tight.low, tight.high), ([0.5, 0.5, 0.0], [1.0, 1.0, 0.5]));
        assert_eq!(tight.leaves.len(), 1);
    }

    #[test]
    fn a_box_beside_the_region_has_no_leaves() {
        let tree = tree();
        let beside = OpenBox { high: [0.5, 1.0, 1.0], ..whole(&tree) };
        assert!(beside.tightened(&tree).leaves.is_empty());
    }
}
