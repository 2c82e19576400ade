//! The image tree: values at nested dyadic nodes of the image plane, and their details.
//!
//! A node of level l is predicted from the lattice of level l − 1, along each axis in which its
//! index is odd, with the stencils of [`midpoint_weights`]; its detail is its value minus the
//! prediction. A lattice point without a node has its own prediction as its value, so that a tree
//! with holes represents the same function as the full lattice with details of 0 there.

use crate::cell;
use crate::parallel::prelude::*;
use crate::vol::dyadic::{
    DEEPEST_LEVEL, Place, STENCIL, STEPS, level_of, midpoint_weights, spacing,
};
use rustc_hash::FxHashMap;

/// A node of the image plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) place: Place,
    /// The level of the coarsest lattice that contains the node.
    pub(crate) level: u8,
    pub(crate) value: f64,
    /// The value minus its prediction from the next coarser lattice.
    pub(crate) detail: f64,
}

/// Nodes of the image plane, in the order in which they were added.
#[derive(Clone, Debug)]
pub(crate) struct ImageTree {
    nodes: Vec<Node>,
    index: FxHashMap<u64, u32>,
    order: usize,
}

/// The smallest number of nodes that share a cache of predictions.
pub(crate) const NODES_PER_TASK: usize = 512;

impl Default for ImageTree {
    fn default() -> Self {
        Self { nodes: Vec::new(), index: FxHashMap::default(), order: STENCIL }
    }
}

impl ImageTree {
    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The order of the predictions, 6 by default.
    pub(crate) fn order(&self) -> usize {
        self.order
    }

    /// Sets the order of the predictions, an even number up to 6. Details keep the former order
    /// until they are updated.
    pub(crate) fn set_order(&mut self, order: usize) {
        self.order = order;
    }

    /// The number of the node at a place.
    pub(crate) fn find(&self, place: Place) -> Option<usize> {
        self.index.get(&key(place)).map(|&i| i as usize)
    }

    /// Adds a node, which must be new; its value is set later.
    pub(crate) fn add(&mut self, place: Place) {
        let level = level_of_place(place);
        self.index.insert(key(place), cell::to_u32(self.nodes.len()));
        self.nodes.push(Node { place, level, value: 0.0, detail: 0.0 });
    }

    pub(crate) fn set(&mut self, node: usize, value: f64) {
        self.nodes[node].value = value;
    }

    /// Removes all nodes but the first `len`.
    pub(crate) fn truncate(&mut self, len: usize) {
        for node in self.nodes.drain(len..) {
            self.index.remove(&key(node.place));
        }
    }

    /// The level of the finest node.
    pub(crate) fn finest_level(&self) -> u8 {
        self.nodes.iter().map(|node| node.level).max().unwrap_or(0)
    }

    /// Computes all details from the values.
    pub(crate) fn update_details(&mut self) {
        let detail = |ghosts: &mut FxHashMap<u64, f64>, node: &Node| {
            let prediction = if node.level == 0 { 0.0 } else { self.predict(node.place, ghosts) };
            node.value - prediction
        };
        let nodes = self.nodes.par_iter().with_min_len(NODES_PER_TASK);
        let details: Vec<f64> = nodes.map_init(FxHashMap::default, detail).collect();
        for (node, detail) in self.nodes.iter_mut().zip(details) {
            node.detail = detail;
        }
    }

    /// The value at a place: that of the node or the prediction. Predictions are stored in
    /// `ghosts`.
    pub(crate) fn value(&self, place: Place, ghosts: &mut FxHashMap<u64, f64>) -> f64 {
        if let Some(i) = self.find(place) {
            return self.nodes[i].value;
        }
        let key = key(place);
        if let Some(&ghost) = ghosts.get(&key) {
            return ghost;
        }
        let ghost = self.predict(place, ghosts);
        ghosts.insert(key, ghost);
        ghost
    }

    /// The prediction at a place from the next lattice coarser than its own.
    fn predict(&self, place: Place, ghosts: &mut FxHashMap<u64, f64>) -> f64 {
        let step = spacing(level_of_place(place));
        let [x, y] = place.map(|along| stencil(self.order, along, step));
        let mut sum = 0.0;
        for (i, weight_x) in x.weights.iter().enumerate() {
            for (j, weight_y) in y.weights.iter().enumerate() {
                let at =
                    [x.first + cell::to_u32(i) * 2 * step, y.first + cell::to_u32(j) * 2 * step];
                sum += weight_x * weight_y * self.value(at, ghosts);
            }
        }
        sum
    }
}

/// A place as one integer, for hashing. The bits are reversed: places of coarse lattices end in
/// zeros, and a multiplicative hash would leave these digits zero.
pub(crate) fn key([x, y]: Place) -> u64 {
    let reversed = |along: u32| u64::from(along.reverse_bits() >> (u32::BITS - DIGITS));
    reversed(x) | reversed(y) << DIGITS
}

/// Binary digits of a place: the last place, 2^24, has one more than the others.
const DIGITS: u32 = DEEPEST_LEVEL as u32 + 1;

/// The level of the coarsest lattice that contains a place.
pub(crate) fn level_of_place([x, y]: Place) -> u8 {
    level_of(x).max(level_of(y))
}

struct Stencil {
    first: u32,
    weights: &'static [f64],
}

/// The stencil of `order` points along one axis, on the lattice with twice the spacing `step`.
fn stencil(order: usize, along: u32, step: u32) -> Stencil {
    if (along / step).is_multiple_of(2) {
        return Stencil { first: along, weights: &[1.0] };
    }
    let intervals = (STEPS / (2 * step)) as usize;
    let (first, weights) = midpoint_weights(order, intervals, (along / (2 * step)) as usize);
    Stencil { first: cell::to_u32(first) * 2 * step, weights }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::dyadic::unit;
    use proptest::prelude::*;

    pub(crate) fn tree_of(
        places: impl IntoIterator<Item = Place>,
        value: impl Fn(f64, f64) -> f64,
    ) -> ImageTree {
        let mut tree = ImageTree::default();
        for place in places {
            if tree.find(place).is_none() {
                tree.add(place);
                tree.set(tree.len() - 1, value(unit(place[0]), unit(place[1])));
            }
        }
        tree.update_details();
        tree
    }

    fn lattice(level: u8) -> impl Iterator<Item = Place> {
        let step = spacing(level);
        (0..=1_u32 << level)
            .flat_map(move |i| (0..=1_u32 << level).map(move |j| [i * step, j * step]))
    }

    proptest! {
        #[test]
        fn quintics_have_no_details_below_level_3(
            c in prop::array::uniform6(-1.0..1.0f64),
            fine in prop::collection::vec([0..=64u32, 0..=64u32], 20),
        ) {
            let along = |x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
            let fine = fine.into_iter().map(|place| place.map(|k| k * spacing(6)));
            let tree = tree_of(lattice(3).chain(fine), |x, y| along(x) * along(1.0 - y));
            for node in tree.nodes().iter().filter(|node| node.level > 3) {
                prop_assert!(node.detail.abs() < 1e-13, "{node:?}");
            }
        }
    }

    #[test]
    fn truncating_forgets_the_last_nodes() {
        let mut tree = tree_of(lattice(1), |x, y| x + y);
        tree.add([spacing(2), 0]);
        tree.truncate(9);
        assert_eq!((tree.len(), tree.find([spacing(2), 0])), (9, None));
        assert!(tree.find([STEPS, STEPS]).is_some());
    }
}
