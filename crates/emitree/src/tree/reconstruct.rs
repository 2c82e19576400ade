//! Reconstruction: the full grid of averages that a tree stands for at one level.

use super::SparseTree;
use super::level::Level;
use crate::cell::to_u32;
use crate::parallel::prelude::*;
use crate::prediction::{Predictor, Stencil};

impl<const D: usize> SparseTree<D> {
    /// All averages of `level`, 2^level along each axis, axis 0 fastest.
    ///
    /// Cells finer than `level` are summed up (their parents' averages are their means), coarser
    /// ones are predicted in.
    ///
    /// # Panics
    ///
    /// If `level` is below the base level.
    pub fn reconstruct(&self, level: u8) -> Vec<f64> {
        let base = self.base_level();
        assert!(level >= base, "level {level} is below the base level {base}");
        let mut grid = vec![0.0; 1 << (usize::from(base) * D)];
        self.levels[0].scatter(&self.levels[0].averages, &mut grid, |to, average| {
            *to = average;
        });
        for finer in base + 1..=level {
            for axis in 0..D {
                grid = split_axis::<D>(&self.predictor, &grid, finer, axis, self.periodic[axis]);
            }
            if let Some(tree_level) = self.levels.get(usize::from(finer - base)) {
                tree_level.scatter(&tree_level.details, &mut grid, |to, detail| *to += detail);
            }
        }
        grid
    }
}

impl<const D: usize> Level<D> {
    /// Applies one value of each own cell to its place in a full grid.
    fn scatter(&self, values: &[f64], grid: &mut [f64], mut apply: impl FnMut(&mut f64, f64)) {
        for (cell, &value) in values.iter().enumerate() {
            let position = self.cell_position(cell);
            let shift = self.level;
            let linear = position.iter().rev().fold(0, |at, &p| at << shift | p as usize);
            apply(&mut grid[linear], value);
        }
    }
}

/// Splits every cell of a grid along one axis, from level `finer` − 1 to `finer`. The axes before
/// `axis` are at the finer level already.
fn split_axis<const D: usize>(
    predictor: &Predictor,
    grid: &[f64],
    finer: u8,
    axis: usize,
    periodic: bool,
) -> Vec<f64> {
    let cells = 1_usize << (finer - 1);
    let stride = 1 << (usize::from(finer) * axis);
    let mut split = vec![0.0; 2 * grid.len()];
    // A slab is everything along this axis and the faster ones.
    let slabs = split.par_chunks_mut(2 * cells * stride).zip(grid.par_chunks(cells * stride));
    slabs.for_each(|(fine, coarse)| {
        for at in 0..cells {
            let stencil = Stencil::around(to_u32(at), finer - 1, predictor.order(), periodic);
            let weights = predictor.lower_half(stencil);
            let (lower, upper) = fine[2 * at * stride..][..2 * stride].split_at_mut(stride);
            for (k, weight) in weights.iter().enumerate() {
                let row = &coarse[(stencil.start as usize + k) % cells * stride..][..stride];
                for (lower, average) in lower.iter_mut().zip(row) {
                    *lower += weight * average;
                }
            }
            let own = &coarse[at * stride..][..stride];
            for ((upper, lower), average) in upper.iter_mut().zip(lower).zip(own) {
                *upper = 2.0 * average - *lower;
            }
        }
    });
    split
}
