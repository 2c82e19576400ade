//! What remains unseen around each node of the image tree.
//!
//! A node's *guarded* detail is its own or, if that is larger, a share of its neighbours': a detail
//! that is small by accident does not end the search. What remains is the guarded detail times a
//! decay, and the decay is believed only below the levels that are always looked at. A node is
//! followed in two steps: first its four diagonal children, which see what varies along x, along y
//! or along both; then, if those still matter, the four children beside it. Most nodes never need
//! the second step, and it has two thirds of the children. Last, what the children of neighbours
//! have found is expected of a node's own.
//!
//! A node at which nothing is seen has a value that is continued from others. How wrong that may be
//! remains as well, as long as an edge passes between the node and its neighbours and some of its
//! children are missing: the image on the open side is interpolated from it.

use crate::vol::dyadic::{Place, STENCIL, around, beside, spacing};
use crate::vol::image::tree::{Around, ImageTree, Node};
use crate::vol::tuning::TUNING;
use rayon::prelude::*;

/// Nodes that are worth a thread of their own.
const NODES_AT_ONCE: usize = 64;

/// How far a node's children are there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Children {
    /// Some of the four diagonal children are missing.
    None,
    /// The diagonal children are there, some of the four beside the node are missing.
    Diagonal,
    /// All eight are there.
    All,
}

/// What remains around one node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Remaining {
    pub(crate) children: Children,
    /// The largest error of the image that is expected to be left there, in the unit of the values.
    pub(crate) size: f64,
}

/// The guarded details of all nodes, whose details are up to date.
pub(crate) fn guarded_details(tree: &ImageTree) -> Vec<f64> {
    let nodes = tree.nodes();
    let guarded = |place: Place, level: u8, detail: f64| {
        let neighbours = around(place, spacing(level), 2).filter_map(|(i, j, at)| {
            let neighbour = nodes[tree.find(at)?];
            let share = if i.abs().max(j.abs()) == 1 {
                TUNING.image.first_neighbour_guard
            } else {
                TUNING.image.second_neighbour_guard
            };
            (neighbour.level == level).then_some(share * neighbour.detail_size())
        });
        neighbours.fold(detail, f64::max)
    };
    let nodes = nodes.par_iter().with_min_len(NODES_AT_ONCE);
    nodes.map(|node| guarded(node.place, node.level, node.detail_size())).collect()
}

/// What remains around each node, given the `guarded` details; `required_level` is the finest level that
/// every rendering looks at.
pub(crate) fn remaining(tree: &ImageTree, guarded: &[f64], required_level: u8) -> Vec<Remaining> {
    let has_kinks = tree.order() < STENCIL;
    let margin = if has_kinks { TUNING.image.kink_margin } else { 1.0 };
    let sibling_share =
        if has_kinks { TUNING.image.sibling_share_of_kinks } else { TUNING.image.sibling_share };
    let largest = tree.largest_value();
    let of_node = |i: usize| {
        let node = tree.nodes()[i];
        if node.level + 1 < required_level {
            return Remaining { children: Children::All, size: 0.0 };
        }
        let near = Near::new(tree, i);
        let (children, of_diagonals) = near.children(guarded);
        if children == Children::All {
            return Remaining { children, size: 0.0 };
        }
        let before = guarded[i] * near.decay(guarded, required_level);
        let size = match children {
            // The levels that are always looked at are not looked at in two steps.
            Children::Diagonal if node.level >= required_level => {
                of_diagonals.max(TUNING.image.after_diagonals * before)
            }
            _ => before,
        };
        let of_siblings = sibling_share * near.largest_sibling();
        let of_edge = if near.is_beside_edge() { TUNING.image.edge_margin } else { 1.0 };
        let size = margin * of_edge * size.max(of_siblings);
        let continuation_error = match node.around {
            Around::Closed => 0.0,
            // Known from no neighbour: it may be as bright as anything else.
            Around::Between => largest,
            Around::Beside => (TUNING.image.edge_margin * node.continuation_error).min(largest),
        };
        Remaining { children, size: size.max(continuation_error) }
    };
    let nodes = (0..tree.len()).into_par_iter().with_min_len(NODES_AT_ONCE);
    nodes.map(of_node).collect()
}

/// The lattice of a node's children around it, as far as the next nodes of its own.
struct Near<'a> {
    tree: &'a ImageTree,
    /// The number of the node.
    centre: usize,
    /// What is at each place, column by column.
    found: [[Found; 5]; 5],
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Found {
    /// The place is not on the image.
    Outside,
    /// There is no node.
    Missing,
    Node(usize),
}

/// Steps to all children: one to either side, or none.
const CHILDREN: [(usize, usize); 8] =
    [(1, 1), (1, 2), (1, 3), (2, 1), (2, 3), (3, 1), (3, 2), (3, 3)];
/// Steps to the next nodes of the own lattice.
const BESIDE: [(usize, usize); 8] =
    [(0, 0), (0, 2), (0, 4), (2, 0), (2, 4), (4, 0), (4, 2), (4, 4)];

impl<'a> Near<'a> {
    fn new(tree: &'a ImageTree, centre: usize) -> Self {
        let node = &tree.nodes()[centre];
        let step = spacing(node.level + 1);
        let mut found = [[Found::Outside; 5]; 5];
        found[2][2] = Found::Node(centre);
        let lines = |from: u32| {
            let below = |times: u32| beside(from, times * step, false);
            let above = |times: u32| beside(from, times * step, true);
            [below(2), below(1), Some(from), above(1), above(2)]
        };
        let [columns, rows] = node.place.map(lines);
        for (found, x) in found.iter_mut().zip(columns) {
            for (found, y) in found.iter_mut().zip(rows) {
                if let (Some(x), Some(y), Found::Outside) = (x, y, *found) {
                    *found = tree.find([x, y]).map_or(Found::Missing, Found::Node);
                }
            }
        }
        Self { tree, centre, found }
    }

    /// The nodes at some of the places, with their numbers.
    fn nodes(
        &self,
        at: impl Iterator<Item = (usize, usize)>,
    ) -> impl Iterator<Item = (usize, &Node)> {
        at.filter_map(|(i, j)| match self.found[i][j] {
            Found::Node(k) => Some((k, &self.tree.nodes()[k])),
            Found::Outside | Found::Missing => None,
        })
    }

    fn level(&self) -> u8 {
        self.tree.nodes()[self.centre].level
    }

    /// Whether the node is beside one that nothing is seen of.
    fn is_beside_edge(&self) -> bool {
        self.nodes(BESIDE.into_iter()).any(|(_, node)| node.is_continued)
    }

    /// The largest |detail| beside a missing child, on the child's level.
    fn largest_sibling(&self) -> f64 {
        let level = self.level() + 1;
        let missing = CHILDREN.into_iter().filter(|&(i, j)| self.found[i][j] == Found::Missing);
        let siblings = missing.flat_map(|(i, j)| {
            (i - 1..=i + 1).flat_map(move |a| (j - 1..=j + 1).map(move |b| (a, b)))
        });
        let details = self.nodes(siblings).filter(|(_, node)| node.level == level);
        details.map(|(_, node)| node.detail_size()).fold(0.0, f64::max)
    }

    /// Which children are there, and the largest guarded detail of the diagonal ones.
    fn children(&self, guarded: &[f64]) -> (Children, f64) {
        let (mut children, mut largest) = (Children::All, 0.0_f64);
        for (i, j) in CHILDREN {
            let diagonal = i != 2 && j != 2;
            match self.found[i][j] {
                Found::Node(k) if diagonal => largest = largest.max(guarded[k]),
                Found::Missing if diagonal => children = Children::None,
                Found::Missing if children == Children::All => children = Children::Diagonal,
                Found::Outside | Found::Missing | Found::Node(_) => {}
            }
        }
        (children, largest)
    }

    /// Which part of the node's guarded detail is expected to remain.
    fn decay(&self, guarded: &[f64], required_level: u8) -> f64 {
        let level = self.level();
        if level <= required_level {
            return 1.0;
        }
        let parents = self.nodes(BESIDE.into_iter()).filter(|(_, node)| node.level + 1 == level);
        let coarser = parents.map(|(parent, _)| guarded[parent]).fold(0.0, f64::max);
        let least = if level == required_level + 1 {
            TUNING.image.first_least_decay
        } else {
            TUNING.image.least_decay
        };
        let decay =
            TUNING.image.decay_margin * guarded[self.centre] / (coarser + f64::MIN_POSITIVE);
        decay.clamp(least, 1.0)
    }
}
