//! Stencils on a sparse tree: gathering neighbours, and predicting those that are missing.
//!
//! A neighbour that the tree lacks is a *ghost*: its average is predicted from its parent's level,
//! where neighbours may be ghosts in turn. So a tree stands for one full grid at every level:
//! prediction everywhere, plus the details where there are any.

use super::SparseTree;
use super::level::Level;
use crate::cell::{power, to_u32};
use crate::prediction::Stencil;
use rayon::prelude::*;

/// The stencil of one cell as families: the same number of them, order / 2 + 1, along each axis,
/// since the order is odd and a family has two cells along an axis.
struct Reach<const D: usize> {
    order: usize,
    /// Offset of the cell in the stencil.
    offsets: [usize; D],
    /// Position of the first family.
    first: [u32; D],
    /// Which half of the first family the stencil starts with.
    half: [usize; D],
    /// The last family of a whole axis.
    last: u32,
}

impl<const D: usize> Reach<D> {
    fn new(position: [u32; D], level: u8, order: usize, periodic: [bool; D]) -> Self {
        let around = |axis: usize| Stencil::around(position[axis], level, order, periodic[axis]);
        let stencils: [Stencil; D] = core::array::from_fn(around);
        Self {
            order: stencils[0].order,
            offsets: stencils.map(|stencil| stencil.offset),
            first: stencils.map(|stencil| stencil.start >> 1),
            half: stencils.map(|stencil| (stencil.start & 1) as usize),
            last: (1 << (level - 1)) - 1,
        }
    }

    /// The number of families along one axis.
    fn per_axis(&self) -> usize {
        self.order / 2 + 1
    }

    /// Calls `visit` with the position of every family, axis 0 fastest.
    fn for_each_family(&self, mut visit: impl FnMut([u32; D])) {
        let mut offset = [0_u32; D];
        let end = to_u32(self.per_axis());
        loop {
            // A periodic axis wraps between families.
            visit(core::array::from_fn(|axis| (self.first[axis] + offset[axis]) & self.last));
            if !advance(&mut offset, end) {
                return;
            }
        }
    }
}

/// Counts up digits from 0 to `end` − 1, the first one fastest; `false` after the last number.
fn advance(digits: &mut [u32], end: u32) -> bool {
    for digit in digits {
        *digit += 1;
        if *digit < end {
            return true;
        }
        *digit = 0;
    }
    false
}

/// Working memory for one stencil, kept from family to family.
#[derive(Debug)]
pub(super) struct StencilBuffer {
    pub(super) block: Vec<f64>,
    scratch: Vec<f64>,
    /// First cell of each family of the stencil.
    families: Vec<usize>,
}

impl StencilBuffer {
    pub(super) fn new<const D: usize>(order: usize) -> Self {
        // A prediction of order 1 still makes 2 values an axis.
        let length = power(order.max(2), D);
        Self {
            block: vec![0.0; length],
            scratch: vec![0.0; length],
            families: Vec::with_capacity(power(order / 2 + 1, D)),
        }
    }
}

impl<const D: usize> SparseTree<D> {
    /// Fills `buffer.block` with the averages around the cell at `position` of level `depth` (an
    /// index of `self.levels`), axis 0 fastest; every family of the stencil must exist.
    ///
    /// Returns the order of the stencil and the offset of the cell along each axis.
    pub(super) fn gather(
        &self,
        depth: usize,
        position: [u32; D],
        buffer: &mut StencilBuffer,
    ) -> (usize, [usize; D]) {
        let level = &self.levels[depth];
        let reach = Reach::new(position, level.level, self.predictor.order(), self.periodic);
        let StencilBuffer { block, families, .. } = buffer;
        families.clear();
        reach.for_each_family(|family| {
            let family = level.family_at(family);
            debug_assert!(family.is_some(), "stencils are completed before they are gathered");
            families.push(family.unwrap_or(0) * Level::<D>::SIBLINGS);
        });
        let (order, per_axis) = (reach.order, reach.per_axis());
        // Row by row along axis 0.
        let mut row = [0_u32; D];
        for block in block[..power(order, D)].chunks_exact_mut(order) {
            let (mut in_families, mut child, mut stride) = (0, 0, 1);
            for (axis, (at, half)) in row.iter().zip(reach.half).enumerate().skip(1) {
                stride *= per_axis;
                let at = *at as usize + half;
                in_families += (at >> 1) * stride;
                child |= (at & 1) << axis;
            }
            let families = &families[in_families..][..per_axis];
            for (k, average) in block.iter_mut().enumerate() {
                let at = k + reach.half[0];
                *average = level.averages[families[at >> 1] + (child | at & 1)];
            }
            advance(&mut row[1..], to_u32(order));
        }
        (order, reach.offsets)
    }

    /// Predicts the family whose parent is the cell at `position` of level `depth`; the children
    /// are left at the start of `buffer.block`.
    fn predict(&self, depth: usize, position: [u32; D], buffer: &mut StencilBuffer) {
        let (order, offsets) = self.gather(depth, position, buffer);
        let StencilBuffer { block, scratch, .. } = buffer;
        match &self.points {
            None => self.predictor.predict_family(order, offsets, block, scratch),
            Some(points) => points.predict_family(order, offsets, block, scratch),
        }
    }

    /// Predicted averages of families `from..to` of level `depth`, in their order.
    pub(super) fn predict_families(&self, depth: usize, from: usize, to: usize) -> Vec<f64> {
        let siblings = Level::<D>::SIBLINGS;
        let families = &self.levels[depth].families[from..to];
        let mut predicted = vec![0.0; families.len() * siblings];
        let new_buffer = || StencilBuffer::new::<D>(self.predictor.order());
        predicted
            .par_chunks_mut(siblings * FAMILIES_PER_TASK)
            .zip(families.par_chunks(FAMILIES_PER_TASK))
            .for_each_init(new_buffer, |buffer, (predicted, families)| {
                for (children, &position) in predicted.chunks_exact_mut(siblings).zip(families) {
                    self.predict(depth - 1, position, buffer);
                    children.copy_from_slice(&buffer.block[..siblings]);
                }
            });
        predicted
    }

    /// Makes sure that the stencils around `cells` of level `depth` are complete: missing families
    /// become ghosts there and, for the stencils of those, at coarser levels.
    pub(super) fn complete(&mut self, depth: usize, cells: impl Iterator<Item = [u32; D]>) {
        let first_ghost = self.families_to(depth);
        self.add_missing(depth, cells);
        self.settle_ghosts(depth, &first_ghost);
    }

    /// Makes sure that `families` of level `depth` are there: missing ones become ghosts.
    pub(super) fn complete_families(
        &mut self,
        depth: usize,
        families: impl Iterator<Item = [u32; D]>,
    ) {
        let first_ghost = self.families_to(depth);
        let level = &mut self.levels[depth];
        for family in families {
            if level.family_at(family).is_none() {
                level.push_ghost(family);
            }
        }
        self.settle_ghosts(depth, &first_ghost);
    }

    /// The number of families of each level down to `depth`.
    fn families_to(&self, depth: usize) -> Vec<usize> {
        self.levels[..=depth].iter().map(|level| level.families.len()).collect()
    }

    /// Completes the coarser levels for the ghosts of level `depth` from `first_ghost` on, and
    /// predicts all ghosts that are new.
    fn settle_ghosts(&mut self, depth: usize, first_ghost: &[usize]) {
        for depth in (1..depth).rev() {
            let ghosts = self.levels[depth + 1].families[first_ghost[depth + 1]..].to_vec();
            self.add_missing(depth, ghosts.into_iter());
        }
        for (depth, &first) in first_ghost.iter().enumerate().skip(1) {
            self.predict_ghosts(depth, first, self.levels[depth].families.len());
        }
    }

    /// Predicts all ghosts anew, after the averages of own cells have changed.
    pub(super) fn refresh_ghosts(&mut self) {
        for depth in 1..self.levels.len() {
            let level = &self.levels[depth];
            let (from, to) = (level.own, level.families.len());
            self.predict_ghosts(depth, from, to);
        }
    }

    fn predict_ghosts(&mut self, depth: usize, from: usize, to: usize) {
        let predicted = self.predict_families(depth, from, to);
        let siblings = Level::<D>::SIBLINGS;
        self.levels[depth].averages[from * siblings..to * siblings].copy_from_slice(&predicted);
    }

    /// Adds, as ghosts without values, the families of level `depth` that stencils around `cells`
    /// of it touch and that are missing.
    fn add_missing(&mut self, depth: usize, cells: impl Iterator<Item = [u32; D]>) {
        let (order, periodic) = (self.predictor.order(), self.periodic);
        let level = &mut self.levels[depth];
        if level.is_base() {
            return;
        }
        for position in cells {
            Reach::new(position, level.level, order, periodic).for_each_family(|family| {
                if level.family_at(family).is_none() {
                    level.push_ghost(family);
                }
            });
        }
    }
}

/// Families that one task of a parallel loop predicts: some microseconds of work.
const FAMILIES_PER_TASK: usize = 256;
