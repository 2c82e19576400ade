//! The remaining error around each node of the image tree: its guarded detail times a decay.
//!
//! The *guarded* detail is the node's own or, if that is larger, a share of the details of its
//! neighbours, so that an accidentally small detail does not end the refinement. Nodes are refined
//! in two steps: the four diagonal children detect variation along x, along y and along both; the
//! four children beside the node follow if its remaining error still matters, which is seldom.

use crate::parallel::prelude::*;
use crate::vol::dyadic::{Place, STENCIL, around, beside, spacing};
use crate::vol::image::tree::{ImageTree, Node};
use crate::vol::tuning::TUNING;

/// The smallest number of nodes that is given to a thread.
const NODES_AT_ONCE: usize = 64;

/// Which children of a node exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Children {
    /// Some of the four diagonal children are missing.
    None,
    /// The diagonal children exist; some of the four beside the node are missing.
    Diagonal,
    /// All eight exist.
    All,
}

/// The remaining error around one node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Remaining {
    pub(crate) children: Children,
    /// The largest expected error of the image around the node, in the unit of the values.
    pub(crate) size: f64,
}

/// The guarded details of all nodes, whose details have to be up to date.
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
            (neighbour.level == level).then_some(share * neighbour.detail.abs())
        });
        neighbours.fold(detail, f64::max)
    };
    let nodes = nodes.par_iter().with_min_len(NODES_AT_ONCE);
    nodes.map(|node| guarded(node.place, node.level, node.detail.abs())).collect()
}

/// The remaining error around each node, given the `guarded` details; `required_level` is the
/// finest level whose nodes every rendering samples.
pub(crate) fn remaining(tree: &ImageTree, guarded: &[f64], required_level: u8) -> Vec<Remaining> {
    let has_kinks = tree.order() < STENCIL;
    let margin = if has_kinks { TUNING.image.kink_margin } else { 1.0 };
    let sibling_share =
        if has_kinks { TUNING.image.sibling_share_of_kinks } else { TUNING.image.sibling_share };
    let finest_level = tree.finest_level();
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
            // Nodes of the required levels get all children in one step.
            Children::Diagonal if node.level >= required_level => {
                of_diagonals.max(TUNING.image.after_diagonals * before)
            }
            _ => before,
        };
        let of_siblings = sibling_share * near.largest_beside_missing(finest_level);
        Remaining { children, size: margin * size.max(of_siblings) }
    };
    let nodes = (0..tree.len()).into_par_iter().with_min_len(NODES_AT_ONCE);
    nodes.map(of_node).collect()
}

/// The lattice of the children of a node, up to the next nodes of its own lattice.
struct Near<'a> {
    tree: &'a ImageTree,
    /// The number of the node.
    centre: usize,
    /// The state of each place, column by column.
    found: [[Found; 5]; 5],
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Found {
    /// The place is outside the image.
    Outside,
    /// There is no node.
    Missing,
    Node(usize),
}

/// The steps to all children: one to either side, or none.
const CHILDREN: [(usize, usize); 8] =
    [(1, 1), (1, 2), (1, 3), (2, 1), (2, 3), (3, 1), (3, 2), (3, 3)];
/// The steps to the next nodes of the node's own lattice.
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

    /// The largest |detail| beside a missing child: on the level of the child, or diagonally beside it on
    /// the level of its own children. The latter are at the border of a part of the image that is resolved
    /// more finely.
    fn largest_beside_missing(&self, finest_level: u8) -> f64 {
        let level = self.level() + 1;
        let missing = CHILDREN.into_iter().filter(|&at| self.is_missing(at));
        let siblings = missing.flat_map(|(i, j)| {
            (i - 1..=i + 1).flat_map(move |a| (j - 1..=j + 1).map(move |b| (a, b)))
        });
        let details = self.nodes(siblings).filter(|(_, node)| node.level == level);
        let details = details.map(|(_, node)| node.detail.abs()).fold(0.0, f64::max);
        if level < finest_level { details.max(self.largest_between(level + 1)) } else { details }
    }

    /// The largest |detail| of nodes of `level` in the middle of four places, of which one is that of a
    /// missing child.
    fn largest_between(&self, level: u8) -> f64 {
        let centre = self.tree.nodes()[self.centre].place;
        let half = spacing(level);
        // From the middle of the first two of five lines, which are two half steps apart, to that of the last two.
        let middles = |from: u32| {
            [(3, false), (1, false), (1, true), (3, true)]
                .map(|(times, up)| beside(from, times * half, up))
        };
        let [columns, rows] = centre.map(middles);
        let mut largest = 0.0_f64;
        for (i, x) in columns.into_iter().enumerate() {
            for (j, y) in rows.into_iter().enumerate() {
                let (Some(x), Some(y)) = (x, y) else { continue };
                let corners = [(i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1)];
                let between =
                    corners.into_iter().any(|at| CHILDREN.contains(&at) && self.is_missing(at));
                if let Some(k) = between.then(|| self.tree.find([x, y])).flatten() {
                    largest = largest.max(self.tree.nodes()[k].detail.abs());
                }
            }
        }
        largest
    }

    fn is_missing(&self, (i, j): (usize, usize)) -> bool {
        self.found[i][j] == Found::Missing
    }

    /// Which children exist, and the largest guarded detail of the diagonal ones.
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

    /// The share of the node's guarded detail that is expected to remain.
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
