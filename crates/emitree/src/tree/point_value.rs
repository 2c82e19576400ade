//! The value of a tree of values at any point.
//!
//! At a point the level of the leaf around it counts: the polynomial through the centres of
//! order + 1 cells of that level along each axis, half of them on either side of the point (all of
//! them inside the cube). On one level neighbouring polynomials agree where they meet, so that the
//! value is continuous; where leaves of two levels meet it may jump, by about the details that were
//! dropped there.
//!
//! A polynomial may undershoot between positive values. Where no value of the tree is negative,
//! what falls below 0 is 0, which is nearer to any function that is nowhere negative.

use super::level::{LEAF, Level};
use super::point_tree::PointTree;
use crate::cell::to_u32;

const SIBLINGS: usize = Level::<3>::SIBLINGS;
/// Families that a stencil of 8 cells touches along an axis, at the most.
const MOST_FAMILIES: usize = 5;

/// The values of one stencil, kept while points lie between the same centres.
#[derive(Debug)]
pub(crate) struct PointStencil {
    /// The level, as an index, and the first cell; `None` before the first point.
    place: Option<(usize, [u32; 3])>,
    /// Values, axis 0 fastest.
    values: Vec<f64>,
}

impl PointStencil {
    /// A stencil for `tree`.
    pub(crate) fn new(tree: &PointTree) -> Self {
        let nodes = tree.tree.order() + 1;
        Self { place: None, values: vec![0.0; nodes * nodes * nodes] }
    }
}

impl PointTree {
    /// The value at a point of the unit cube, borders included.
    pub(crate) fn value(&self, u: [f64; 3], stencil: &mut PointStencil) -> f64 {
        let value = match self.tree.order() {
            3 => self.interpolate::<4>(u, stencil),
            5 => self.interpolate::<6>(u, stencil),
            _ => self.interpolate::<8>(u, stencil),
        };
        if self.lowest >= 0.0 { value.max(0.0) } else { value }
    }

    fn interpolate<const N: usize>(&self, u: [f64; 3], stencil: &mut PointStencil) -> f64 {
        let depth = self.depth_of_leaf(u);
        let level = &self.tree.levels[depth];
        let mut start = [0; 3];
        let mut weights = [[0.0; N]; 3];
        for axis in 0..3 {
            // In cells from the first centre.
            let from_centre = u[axis] * f64::from(1_u32 << level.level) - 0.5;
            start[axis] = first_cell(whole(from_centre.floor()), N, level.level);
            weights[axis] = lagrange(from_centre - f64::from(start[axis]));
        }
        if stencil.place != Some((depth, start)) {
            level.gather_values::<N>(start, &mut stencil.values);
            stencil.place = Some((depth, start));
        }
        let along = |weights: &[f64; N], at: usize| {
            let row = &stencil.values[at * N..][..N];
            weights.iter().zip(row).map(|(w, v)| w * v).sum::<f64>()
        };
        let [x, y, z] = &weights;
        let plane = |k: usize| (0..N).map(|j| y[j] * along(x, k * N + j)).sum::<f64>();
        (0..N).map(|k| z[k] * plane(k)).sum()
    }

    /// The level of the leaf around a point, as an index.
    fn depth_of_leaf(&self, u: [f64; 3]) -> usize {
        let levels = &self.tree.levels;
        let finest = levels[levels.len() - 1].level;
        let cells = 1_u32 << finest;
        let fine = u.map(|x| whole((x * f64::from(cells)).floor()).max(0).cast_unsigned());
        let fine = fine.map(|cell| cell.min(cells - 1));
        let base_family = fine.map(|cell| cell >> (finest - levels[0].level) >> 1);
        // The base grid is dense: the family is there.
        let mut family = levels[0].family_at(base_family).unwrap_or(0);
        for (depth, level) in levels.iter().enumerate() {
            let shift = finest - level.level;
            let half = |axis: usize| ((fine[axis] >> shift & 1) as usize) << axis;
            let child = half(0) | half(1) | half(2);
            match level.children[family * SIBLINGS + child] {
                LEAF => return depth,
                next => family = next as usize,
            }
        }
        levels.len() - 1
    }

    /// Makes the ghosts that the stencils of all leaves need.
    pub(super) fn complete_leaves(&mut self) {
        let nodes = self.tree.order() + 1;
        for depth in 1..self.tree.levels.len() {
            let level = &self.tree.levels[depth];
            let leaves = level.children.chunks_exact(SIBLINGS).map(|c| c.contains(&LEAF));
            let mut missing = Vec::new();
            for (&position, _) in level.families.iter().zip(leaves).filter(|(_, leaves)| *leaves) {
                level.for_each_missing(position, nodes, |family| missing.push(family));
            }
            self.tree.complete_families(depth, missing);
        }
    }
}

impl Level<3> {
    /// Calls `visit` with the families that stencils of `nodes` cells at points in the family at
    /// `position` touch and that are missing.
    fn for_each_missing(&self, position: [u32; 3], nodes: usize, mut visit: impl FnMut([u32; 3])) {
        let (first, last) = (
            // A point of the lower half may be before its centre, one of the upper half behind.
            position.map(|p| first_cell(whole_cell(2 * p) - 1, nodes, self.level) >> 1),
            position.map(|p| {
                (first_cell(whole_cell(2 * p + 1), nodes, self.level) + to_u32(nodes) - 1) >> 1
            }),
        );
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    if self.family_at([x, y, z]).is_none() {
                        visit([x, y, z]);
                    }
                }
            }
        }
    }

    /// Writes the values of N³ cells from `start` on, axis 0 fastest; their families must exist.
    fn gather_values<const N: usize>(&self, start: [u32; 3], values: &mut [f64]) {
        let first = start.map(|cell| cell >> 1);
        let count = start.map(|cell| (((cell + to_u32(N) - 1) >> 1) - (cell >> 1)) as usize + 1);
        let half = start.map(|cell| (cell & 1) as usize);
        let mut rows = values.chunks_exact_mut(N);
        let mut families = [[0; MOST_FAMILIES]; MOST_FAMILIES];
        let mut gathered = u32::MAX;
        for k in 0..N {
            let at = [0, half[1], half[2] + k];
            let z = first[2] + to_u32(at[2] >> 1);
            if z != gathered {
                gathered = z;
                for (j, row) in (first[1]..).zip(&mut families[..count[1]]) {
                    for (i, family) in (first[0]..).zip(&mut row[..count[0]]) {
                        let found = self.family_at([i, j, z]);
                        debug_assert!(found.is_some(), "stencils of leaves are complete");
                        *family = found.unwrap_or(0) * SIBLINGS;
                    }
                }
            }
            for (j, row) in (half[1]..).zip(rows.by_ref().take(N)) {
                let child = (j & 1) << 1 | (at[2] & 1) << 2;
                for (i, value) in (half[0]..).zip(row) {
                    *value = self.averages[families[j >> 1][i >> 1] + (child | i & 1)];
                }
            }
        }
    }
}

/// The first of `nodes` cells with half of them at or before cell `before`, or the closest cells
/// that the axis has.
fn first_cell(before: i32, nodes: usize, level: u8) -> u32 {
    let nodes = whole_cell(to_u32(nodes));
    (before - (nodes / 2 - 1)).clamp(0, (1 << level) - nodes).cast_unsigned()
}

/// A number of cells: at most 2^19 along an axis.
fn whole_cell(cells: u32) -> i32 {
    cells.cast_signed()
}

#[expect(clippy::cast_possible_truncation, reason = "there are at most 2^19 cells along an axis")]
fn whole(cells: f64) -> i32 {
    cells as i32
}

/// The values at `t` of the Lagrange polynomials on the nodes 0, 1, …, N − 1.
fn lagrange<const N: usize>(t: f64) -> [f64; N] {
    // Products of what is left and what is right of a node, over k! (N − 1 − k)! with its sign.
    let mut weights = [1.0; N];
    let (mut left, mut right) = (1.0, 1.0);
    for k in 0..N {
        weights[k] *= left;
        weights[N - 1 - k] *= right;
        let (low, high) = (k as f64, (N - 1 - k) as f64);
        left *= (t - low) / (low + 1.0);
        right *= (high - t) / (low + 1.0);
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cubic through 0, 1, 2 and 3 in the middle, at a node and beyond the last.
    #[test]
    fn weights_of_four_centres() {
        for (t, expected) in [
            (1.5, [-1.0 / 16.0, 9.0 / 16.0, 9.0 / 16.0, -1.0 / 16.0]),
            (2.0, [0.0, 0.0, 1.0, 0.0]),
            (3.5, [-5.0 / 16.0, 21.0 / 16.0, -35.0 / 16.0, 35.0 / 16.0]),
        ] {
            let weights = lagrange::<4>(t);
            assert!(
                weights.iter().zip(expected).all(|(w, e)| (w - e).abs() < 1e-15),
                "{weights:?}"
            );
        }
    }

    #[test]
    fn stencils_stay_inside_the_axis() {
        // Half of six cells at or before the given one, of an axis of 16.
        let first = |before| first_cell(before, 6, 4);
        assert_eq!([-1, 0, 2, 3, 7].map(first), [0, 0, 0, 1, 5]);
        assert_eq!([12, 13, 15].map(first), [10, 10, 10]);
    }
}
