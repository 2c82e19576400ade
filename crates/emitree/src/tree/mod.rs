//! The sparse tree: cell averages on a full base grid, and details where it is refined.
//!
//! # Invariants
//!
//! * Cells come in complete families: a cell has all of its 2^D children or none.
//! * Each parent's average is the mean of its children's (after [restriction](build())).
//! * On every level, average = prediction from the level above + detail, where cells that are not
//!   in the tree have detail 0 (and are called *ghosts* when a stencil needs them). So a tree
//!   stands for one full grid of averages at each level.
//! * The details of a family sum to 0, since prediction is conservative.
//!
//! A tree of values at the centres of cells ([`crate::world_tree`]) is the same with other weights:
//! its numbers are no averages, so that nothing is restricted and the second and the last of these
//! do not hold. It never leaves `point_tree.rs`.
//!
//! A tree is independent of cameras and units: it represents a function on the unit cube.

pub(crate) mod build;
mod cousins;
mod ghosts;
mod halves;
mod index;
mod level;
mod points;
mod point_tree;
mod point_value;
mod progressive;
mod project;
mod reconstruct;
mod sample;
mod stencils;

pub(crate) use build::StopReason;
pub(crate) use build::build_async;
pub use build::{BuildError, BuildOptions, Built, build};
pub use point_tree::{Family, FamilyDefect};
pub(crate) use point_tree::{GrownPoints, PointTree};
pub(crate) use point_value::PointStencil;
pub use progressive::Progression;
pub(crate) use sample::sampled_level;

use crate::cell::CellIndex;
use crate::parallel::prelude::*;
use crate::prediction::Predictor;
use level::{LEAF, Level};
use points::PointPredictor;

/// A sparse tree of cell averages in D dimensions; see [the invariants](self).
#[derive(Clone, Debug)]
pub struct SparseTree<const D: usize> {
    predictor: Predictor,
    /// How values at the centres of cells are predicted; `None` where the numbers are averages.
    points: Option<PointPredictor>,
    periodic: [bool; D],
    /// The base grid, then one refined level after the other.
    levels: Vec<Level<D>>,
}

impl<const D: usize> SparseTree<D> {
    /// The level of the full base grid.
    pub fn base_level(&self) -> u8 {
        self.levels[0].level
    }

    /// The finest level that has cells.
    pub fn finest_level(&self) -> u8 {
        self.levels[self.levels.len() - 1].level
    }

    /// The order of the prediction.
    pub fn order(&self) -> usize {
        self.predictor.order()
    }

    /// Which axes are periodic.
    pub fn periodic(&self) -> [bool; D] {
        self.periodic
    }

    /// The number of cells on all levels, the full base grid included.
    pub fn cells(&self) -> usize {
        self.levels.iter().map(Level::own_cells).sum()
    }

    /// The number of leaves on each level, from level 0 to the finest.
    pub fn leaves_per_level(&self) -> Vec<usize> {
        let mut leaves = vec![0; usize::from(self.base_level())];
        leaves.extend(
            self.levels
                .iter()
                .map(|level| level.children.iter().filter(|&&family| family == LEAF).count()),
        );
        leaves
    }

    /// The integral over the unit cube.
    pub fn integral(&self) -> f64 {
        let base = &self.levels[0];
        base.averages.iter().sum::<f64>() / base.own_cells() as f64
    }

    /// Calls `visit` with every leaf and its average, coarse levels first.
    pub fn for_each_leaf(&self, mut visit: impl FnMut(CellIndex<D>, f64)) {
        for level in &self.levels {
            for (cell, &family) in level.children.iter().enumerate() {
                if family == LEAF {
                    let index = CellIndex::new(level.level, level.cell_position(cell));
                    visit(index, level.averages[cell]);
                }
            }
        }
    }

    /// The same cells with other averages of the leaves, in the order of
    /// [`for_each_leaf`](Self::for_each_leaf).
    pub(crate) fn with_leaves(&self, averages: &[f64]) -> Self {
        let mut tree = self.clone();
        let mut new = averages.iter();
        for level in &mut tree.levels {
            let leaves = level.children.iter().zip(&mut level.averages);
            for (_, average) in leaves.filter(|(family, _)| **family == LEAF) {
                new.next().iter().for_each(|new| *average = **new);
            }
        }
        tree.restrict();
        tree.update_details();
        tree
    }

    /// Makes each parent the mean of its children, from the finest level up.
    fn restrict(&mut self) {
        let siblings = Level::<D>::SIBLINGS;
        for depth in (1..self.levels.len()).rev() {
            let (coarser, finer) = self.levels.split_at_mut(depth);
            let (Level { averages, children, .. }, finer) = (&mut coarser[depth - 1], &finer[0]);
            averages.par_iter_mut().zip(&*children).with_min_len(CELLS_PER_TASK).for_each(
                |(average, &family)| {
                    if family != LEAF {
                        let children = finer.family_averages(family as usize);
                        *average = children.iter().sum::<f64>() / siblings as f64;
                    }
                },
            );
        }
    }

    /// Predicts ghosts anew and makes every detail its cell's average minus the prediction.
    fn update_details(&mut self) {
        self.refresh_ghosts();
        for depth in 1..self.levels.len() {
            self.set_details(depth);
        }
    }

    /// Makes every detail of level `depth` its cell's average minus the prediction.
    fn set_details(&mut self, depth: usize) {
        let (level, coarser) = self.with_coarser(depth);
        let Level { families, averages, details, own, .. } = level;
        coarser.predict_families(&families[..*own], details, |cell, detail, predicted| {
            *detail = averages[cell] - predicted;
        });
    }

    /// Makes every average its prediction plus its detail, from the base level down.
    fn update_averages(&mut self) {
        for depth in 1..self.levels.len() {
            let families = self.levels[depth].families[..self.levels[depth].own].to_vec();
            self.complete(depth - 1, &families);
            let (level, coarser) = self.with_coarser(depth);
            let averages = &mut level.averages[..families.len() * Level::<D>::SIBLINGS];
            coarser.predict_families(&families, averages, |cell, average, predicted| {
                *average = predicted + level.details[cell];
            });
        }
    }
}

/// Cells that one task of a parallel loop is worth while for.
const CELLS_PER_TASK: usize = 1 << 12;

#[cfg(test)]
mod tests;
