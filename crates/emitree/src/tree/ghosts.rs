//! Ghosts: the families that stencils need and a sparse tree lacks.
//!
//! The average of a ghost is predicted from its parent's level, where neighbours may be ghosts in
//! turn. So a tree stands for one full grid at every level: prediction everywhere, plus the details
//! where there are any.

use super::SparseTree;
use super::cousins::CousinBuffer;
use super::index::{cousins, runs};
use super::level::Level;
use super::stencils::{FAMILIES_PER_TASK, Stencils};
use crate::parallel::prelude::*;
use core::cmp::Ordering;

impl<const D: usize> SparseTree<D> {
    /// The stencils of the cells of level `depth`, an index of `self.levels`.
    pub(super) fn stencils(&self, depth: usize) -> Stencils<'_, D> {
        Stencils {
            level: &self.levels[depth],
            predictor: &self.predictor,
            points: self.points.as_ref(),
            periodic: self.periodic,
        }
    }

    /// Level `depth`, 1 or more, and the stencils of the one above it.
    pub(super) fn with_coarser(&mut self, depth: usize) -> (&mut Level<D>, Stencils<'_, D>) {
        let (coarser, finer) = self.levels.split_at_mut(depth);
        let stencils = Stencils {
            level: &coarser[depth - 1],
            predictor: &self.predictor,
            points: self.points.as_ref(),
            periodic: self.periodic,
        };
        (&mut finer[0], stencils)
    }

    /// Makes sure that the stencils around `cells` of level `depth` are complete: missing families
    /// become ghosts there and, for the stencils of those, at coarser levels.
    pub(super) fn complete(&mut self, depth: usize, cells: &[[u32; D]]) {
        let missing = self.missing(depth, cells);
        self.add_ghosts(depth, missing);
    }

    /// Makes sure that `families` of level `depth` are there: missing ones become ghosts.
    pub(super) fn complete_families(&mut self, depth: usize, mut families: Vec<[u32; D]>) {
        let level = &self.levels[depth];
        families.retain(|&family| level.family_at(family).is_none());
        self.add_ghosts(depth, families);
    }

    /// Adds `missing` families, which may come several times, as ghosts of level `depth`; completes
    /// the coarser levels for them, and predicts all ghosts that are new.
    fn add_ghosts(&mut self, depth: usize, mut missing: Vec<[u32; D]>) {
        let first_ghost: Vec<usize> =
            self.levels[..=depth].iter().map(|level| level.families.len()).collect();
        for depth in (1..=depth).rev() {
            missing.par_sort_unstable_by(along_the_curve);
            missing.dedup();
            self.levels[depth].push_ghosts(&missing);
            missing = self.missing(depth - 1, &missing);
        }
        for (depth, &first) in first_ghost.iter().enumerate().skip(1) {
            self.predict_ghosts(depth, first);
        }
    }

    /// Predicts all ghosts anew, after the averages of own cells have changed.
    pub(super) fn refresh_ghosts(&mut self) {
        for depth in 1..self.levels.len() {
            self.predict_ghosts(depth, self.levels[depth].own);
        }
    }

    /// Predicts the ghosts of level `depth` from family `first` on.
    fn predict_ghosts(&mut self, depth: usize, first: usize) {
        let (level, coarser) = self.with_coarser(depth);
        let averages = &mut level.averages[first * Level::<D>::SIBLINGS..];
        let ghosts = &level.families[first..];
        coarser.predict_families(ghosts, averages, |_, average, predicted| *average = predicted);
    }

    /// The families of level `depth` that stencils around `cells` of it touch and that are missing;
    /// some of them several times.
    fn missing(&self, depth: usize, cells: &[[u32; D]]) -> Vec<[u32; D]> {
        if cells.is_empty() || self.levels[depth].is_base() {
            return Vec::new();
        }
        let stencils = self.stencils(depth);
        let new = || (Vec::new(), CousinBuffer::new::<D>(self.order()));
        let of_task = |(mut missing, mut buffer): (Vec<_>, CousinBuffer), cells: &[[u32; D]]| {
            for run in runs(cells) {
                stencils.missing_of_run(run, &mut buffer, &mut missing);
            }
            (missing, buffer)
        };
        let together = |mut all: Vec<_>, mut more: Vec<_>| {
            all.append(&mut more);
            all
        };
        let tasks = cells.par_chunks(FAMILIES_PER_TASK).fold(new, of_task);
        tasks.map(|(missing, _)| missing).reduce(Vec::new, together)
    }
}

impl<const D: usize> Stencils<'_, D> {
    /// Appends the families that stencils around cells of one family touch and that are missing.
    fn missing_of_run(
        &self,
        cells: &[[u32; D]],
        buffer: &mut CousinBuffer,
        missing: &mut Vec<[u32; D]>,
    ) {
        if cells.len() == Level::<D>::SIBLINGS {
            let reach = self.reach_of_family(cousins(cells[0]));
            reach.for_each_missing(self.level, buffer, |family| missing.push(family));
            return;
        }
        for &position in cells {
            self.reach(position).for_each_family(|family| {
                if self.level.family_at(family).is_none() {
                    missing.push(family);
                }
            });
        }
    }
}

/// Order along the curve of Morton, so that what is near in space is near in memory: the axis with
/// the highest bit in which positions differ decides.
fn along_the_curve<const D: usize>(a: &[u32; D], b: &[u32; D]) -> Ordering {
    let (mut decides, mut most) = (0, 0);
    for axis in (0..D).rev() {
        let differ = a[axis] ^ b[axis];
        if most < differ && most < (most ^ differ) {
            (decides, most) = (axis, differ);
        }
    }
    a[decides].cmp(&b[decides])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Axis 0 is the fastest, as among siblings.
    #[test]
    fn the_curve_visits_siblings_before_their_neighbours() {
        let mut cells = vec![[2, 0], [1, 1], [0, 0], [0, 2], [0, 1], [1, 0], [3, 3], [1, 1]];
        cells.sort_by(along_the_curve);
        assert_eq!(cells, [[0, 0], [1, 0], [0, 1], [1, 1], [1, 1], [2, 0], [0, 2], [3, 3]]);
    }
}
