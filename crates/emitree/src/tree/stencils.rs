//! Stencils on one level of a tree: gathering the averages around cells, and predicting families from
//! them, one by one or whole blocks of cousins at once.

use super::cousins::{CousinBuffer, CousinReach};
use super::index::{cousins, runs};
use super::level::Level;
use super::points::PointPredictor;
use crate::cell::{power, to_u32};
use crate::parallel::prelude::*;
use crate::prediction::{Predictor, Stencil};

/// The stencil of one cell as families: the same number of them, order / 2 + 1, along each axis,
/// since the order is odd and a family has two cells along an axis.
pub(super) struct Reach<const D: usize> {
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
    pub(super) fn for_each_family(&self, mut visit: impl FnMut([u32; D])) {
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

/// The stencils of the cells of one level.
#[derive(Clone, Copy)]
pub(super) struct Stencils<'a, const D: usize> {
    pub(super) level: &'a Level<D>,
    pub(super) predictor: &'a Predictor,
    /// How values at the centres of cells are predicted; `None` where the numbers are averages.
    pub(super) points: Option<&'a PointPredictor>,
    pub(super) periodic: [bool; D],
}

impl<const D: usize> Stencils<'_, D> {
    /// Which families the stencil of the cell at `position` touches.
    pub(super) fn reach(&self, position: [u32; D]) -> Reach<D> {
        Reach::new(position, self.level.level, self.predictor.order(), self.periodic)
    }

    /// Which families the stencils of the cells of the family at `position` touch.
    pub(super) fn reach_of_family(&self, position: [u32; D]) -> CousinReach<D> {
        CousinReach::new(position, self.level.level, self.predictor.order(), self.periodic)
    }

    /// Fills `buffer.block` with the averages around the cell at `position`, axis 0 fastest; every
    /// family of the stencil must exist.
    ///
    /// Returns the order of the stencil and the offset of the cell along each axis.
    pub(super) fn gather(
        &self,
        position: [u32; D],
        buffer: &mut StencilBuffer,
    ) -> (usize, [usize; D]) {
        let level = self.level;
        let reach = self.reach(position);
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

    /// Predicts the family whose parent is the cell at `position`; the children are left at the start
    /// of `buffer.block`.
    fn predict(&self, position: [u32; D], buffer: &mut StencilBuffer) {
        let (order, offsets) = self.gather(position, buffer);
        let StencilBuffer { block, scratch, .. } = buffer;
        match self.points {
            None => self.predictor.predict_family(order, offsets, block, scratch),
            Some(points) => points.predict_family(order, offsets, block, scratch),
        }
    }

    /// Predicts the children of `families`, which are cells of the level, and calls `settle` with the
    /// number of each child, its entry of `values` and what is predicted.
    pub(super) fn predict_families(
        &self,
        families: &[[u32; D]],
        values: &mut [f64],
        settle: impl Fn(usize, &mut f64, f64) + Sync,
    ) {
        if families.is_empty() {
            return;
        }
        let siblings = Level::<D>::SIBLINGS;
        let order = self.predictor.order();
        let new_buffers = || (StencilBuffer::new::<D>(order), CousinBuffer::new::<D>(order));
        let predict_task =
            |(stencil, of_cousins): &mut (StencilBuffer, CousinBuffer),
             (task, (values, families)): (usize, (&mut [f64], &[[u32; D]]))| {
                let mut children = values.iter_mut();
                let mut numbers = task * FAMILIES_PER_TASK * siblings..;
                let mut settle_family = |predicted: &[f64]| {
                    for ((predicted, number), child) in
                        predicted.iter().zip(&mut numbers).zip(&mut children)
                    {
                        settle(number, child, *predicted);
                    }
                };
                for run in runs(families) {
                    if run.len() < LEAST_COUSINS {
                        for &position in run {
                            self.predict(position, stencil);
                            settle_family(&stencil.block[..siblings]);
                        }
                        continue;
                    }
                    let reach = self.reach_of_family(cousins(run[0]));
                    reach.predict(self.level, self.predictor, self.points, of_cousins);
                    for &position in run {
                        settle_family(of_cousins.children_of(position));
                    }
                }
            };
        values
            .par_chunks_mut(siblings * FAMILIES_PER_TASK)
            .zip(families.par_chunks(FAMILIES_PER_TASK))
            .enumerate()
            .for_each_init(new_buffers, predict_task);
    }
}

/// From so many members on a block of cousins is predicted at once, whatever is missing.
const LEAST_COUSINS: usize = 3;
/// Families that one task of a parallel loop predicts: some microseconds of work.
pub(super) const FAMILIES_PER_TASK: usize = 256;

#[cfg(test)]
mod tests {
    use crate::quadrature::{CellRule, Pointwise};
    use crate::refinement::Threshold;
    use crate::tree::points::PointPredictor;
    use crate::tree::stencils::{LEAST_COUSINS, StencilBuffer};
    use crate::tree::{BuildOptions, SparseTree, build};

    fn tree<const D: usize>(order: usize, periodic: [bool; D]) -> SparseTree<D> {
        let f = |u: [f64; D]| (-20.0 * u.iter().map(|x| (x - 0.2).powi(2)).sum::<f64>()).exp();
        let threshold = Threshold::Absolute(0.02);
        let options = BuildOptions {
            order,
            base_level: 2,
            rule: CellRule::Midpoint,
            threshold,
            finest_level: Some(5),
        };
        build(&Pointwise(f), periodic, &options).unwrap().tree
    }

    /// Families of a block of cousins one by one, and all at once: borders, ghosts and all.
    fn same_bits<const D: usize>(tree: &SparseTree<D>) {
        let siblings = 1 << D;
        for depth in 1..tree.levels.len() {
            let stencils = tree.stencils(depth - 1);
            let families = &tree.levels[depth].families;
            let mut values = vec![0.0; families.len() * siblings];
            stencils.predict_families(families, &mut values, |_, value, predicted| {
                *value = predicted;
            });
            let mut buffer = StencilBuffer::new::<D>(tree.order());
            for (&position, together) in families.iter().zip(values.chunks_exact(siblings)) {
                stencils.predict(position, &mut buffer);
                let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&buffer.block[..siblings]), bits(together), "{position:?}");
            }
        }
    }

    #[test]
    fn blocks_are_predicted_to_the_bit_as_their_members() {
        for order in [1, 3, 5, 7, 9] {
            for periodic in [false, true] {
                same_bits(&tree(order, [periodic; 1]));
                same_bits(&tree(order, [periodic, false]));
                let mut three = tree(order, [false, periodic, false]);
                assert!(three.levels[2].own > LEAST_COUSINS);
                same_bits(&three);
                three.points = Some(PointPredictor::new(order));
                same_bits(&three);
            }
            same_bits(&tree(order.min(3), [false; 4]));
        }
    }
}
