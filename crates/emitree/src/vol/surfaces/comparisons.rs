//! Leaves compared with those around them: where they disagree about the region beside their common face.

use crate::parallel::prelude::*;
use crate::projection::vector::along;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::octree::{Cell, Facet, Label, Leaf, Octree, is_among, is_smooth};
use crate::vol::tuning::TUNING;
use rustc_hash::{FxHashMap, FxHashSet};

/// The distance of compared points from the face, in edges of the cell.
const BESIDE: f64 = 1e-7;
/// A jump is another one than that of a cell if it is larger by this factor.
const LARGER: f64 = 1.5;

/// Two leaves that disagree at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disagreement {
    pub(super) leaves: [Cell; 2],
    pub(super) at: [f64; 3],
    pub(super) labels: [Label; 2],
    /// The smaller distance of the two from the region of the other.
    pub(super) clearance: f64,
}

/// A leaf compared with those around it.
#[derive(Clone, Debug, Default)]
struct Comparison {
    beside: Vec<Cell>,
    found: Vec<Disagreement>,
}

/// The last comparisons of all leaves: they need not be repeated for those that remain as they are, with all beside them.
#[derive(Debug, Default)]
pub(super) struct Comparisons {
    leaves: Vec<(Cell, Leaf)>,
    all: FxHashMap<Cell, Comparison>,
}

impl Comparisons {
    /// Compares all leaves with those around them. Returns where they disagree.
    pub(super) fn repeat(&mut self, tree: &Octree, aim: &Aim<'_>) -> Vec<Disagreement> {
        let all = self.compare(tree, aim);
        let found = all.iter().flat_map(|of| of.found.iter().copied()).collect();
        *self = Self::new(tree, all);
        found
    }

    fn new(tree: &Octree, of_leaves: Vec<Comparison>) -> Self {
        let cells = tree.leaves.iter().map(|(cell, _)| *cell);
        let all = cells.zip(of_leaves).filter(|(_, of)| !of.beside.is_empty()).collect();
        Self { leaves: tree.leaves.clone(), all }
    }

    fn compare(&self, tree: &Octree, aim: &Aim<'_>) -> Vec<Comparison> {
        let same = tree.leaves.iter().filter(|of| is_among(&self.leaves, of)).map(|of| of.0);
        let same: FxHashSet<Cell> = same.collect();
        let numbers: Vec<usize> = (0..tree.leaves.len()).collect();
        let compare = |&leaf: &usize| {
            let cell = &tree.leaves[leaf].0;
            let last = self.all.get(cell).filter(|of| {
                same.contains(cell) && of.beside.iter().all(|other| same.contains(other))
            });
            last.cloned().unwrap_or_else(|| comparison(tree, aim, leaf))
        };
        numbers.par_iter().map(compare).collect()
    }
}

/// A leaf with patches compared with those around it.
fn comparison(tree: &Octree, aim: &Aim<'_>, leaf: usize) -> Comparison {
    let (cell, own) = &tree.leaves[leaf];
    let Leaf::Cut(facets) = own else { return Comparison::default() };
    let count = match is_smooth(facets) {
        true => TUNING.surfaces.face_points,
        false => TUNING.surfaces.face_points_beside_edges,
    };
    let spacing = tree.grid.cell_size(cell.0) / count as f64;
    let is_seen = |at: &[f64; 3]| tree.grid.contains(*at) && !aim.hides(&tree.grid, *at);
    let (mut beside, mut found) = (Vec::new(), Vec::new());
    for turn in 0..6 {
        let (axis, side) = (turn / 2, turn % 2);
        for k in 0..count * count {
            let place = [k % count, k / count].map(|k| (k as f64 + 0.5) / count as f64);
            let mut places = cell.1.map(f64::from);
            places[axis] += if side == 1 { 1.0 + BESIDE } else { -BESIDE };
            places[(axis + 1) % 3] += place[0];
            places[(axis + 2) % 3] += place[1];
            let at = tree.grid.point(cell.0, places);
            if !is_seen(&at) {
                continue;
            }
            let (other_cell, other) = &tree.leaves[tree.find(at)];
            if beside.last() != Some(other_cell) {
                beside.push(*other_cell);
            }
            let (leaves, cells) = ([own, other], [*cell, *other_cell]);
            let middles = middles(leaves, at, spacing).into_iter().filter(is_seen);
            let all = core::iter::once(at).chain(middles);
            found.extend(all.filter_map(|at| disagreement(leaves, cells, at)));
        }
    }
    Comparison { beside, found }
}

/// What two leaves say of a point, if they disagree about it further than allowed.
fn disagreement(leaves: [&Leaf; 2], cells: [Cell; 2], at: [f64; 3]) -> Option<Disagreement> {
    let labels = leaves.map(|of| of.region(at));
    if labels[0] == labels[1] || matches!(leaves[1], Leaf::Hidden) {
        return None;
    }
    let clearance = match leaves[1] {
        // What remains unresolved there is known, unless it is a larger jump.
        Leaf::Unresolved(_, jump) if leaves[0].least_jump(labels[0]) <= LARGER * jump => {
            return None;
        }
        Leaf::Unresolved(..) => leaves[0].clearance(at),
        _ => {
            let [a, b] = [0, 1].map(|k| leaves[k].distance_to(labels[1 - k], at));
            a.min(b)
        }
    };
    let are_smooth = leaves.iter().all(|of| matches!(of, Leaf::Cut(facets) if is_smooth(facets)));
    let most = match are_smooth {
        true => TUNING.surfaces.smooth_face_distance,
        false => TUNING.surfaces.face_distance,
    };
    (clearance > most).then_some(Disagreement { leaves: cells, at, labels, clearance })
}

/// The points in the middle between two surfaces, one of each leaf and both between the same regions, that are near a
/// point of the face: points of the face are further apart than two surfaces that disagree.
fn middles(leaves: [&Leaf; 2], at: [f64; 3], spacing: f64) -> Vec<[f64; 3]> {
    let [Leaf::Cut(own), Leaf::Cut(others)] = leaves else { return Vec::new() };
    let pairs = own.iter().flat_map(|a| others.iter().map(move |b| (a, b)));
    let middle = |(a, b): (&Facet, &Facet)| {
        let sign = match [b.below, b.above] {
            sides if sides == [a.below, a.above] => 1.0,
            sides if sides == [a.above, a.below] => -1.0,
            _ => return None,
        };
        let heights = [a.wall.above(at), sign * b.wall.above(at)];
        let is_near = heights.iter().all(|height| height.abs() < spacing);
        let upward = a.wall.patch_at(at).axis();
        is_near.then(|| along(at, -0.5 * (heights[0] + heights[1]), upward))
    };
    pairs.filter_map(middle).collect()
}

#[cfg(test)]
mod tests;
