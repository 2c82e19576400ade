//! Prediction of a whole block of cousins at once: of the families whose parents are the cells of one family.
//!
//! The stencils of neighbouring cells have most of their cells in common. For order 3 in three
//! dimensions a block of cousins needs 4³ averages from 27 families, found in 8 look-ups, where its members one
//! by one need 8 · 3³ averages from 8 · 8 families; and what is made along one axis serves two cells
//! along the next. Every number is made as [`Predictor::predict_family`] makes it, from the same
//! numbers in the same order: the result is the same to the last bit.
//!
//! [`Predictor::predict_family`]: crate::prediction::Predictor

use super::halves::{Halves, Means, Values};
use super::index::{NONE, cousins, member};
use super::level::Level;
use super::points::PointPredictor;
use crate::cell::{power, to_u32};
use crate::prediction::{MAX_ORDER, Predictor, Stencil};

/// Families that the stencils of a block of cousins touch along an axis, at the most.
const MOST_FAMILIES: usize = MAX_ORDER / 2 + 2;
/// And their blocks.
const MOST_BLOCKS: usize = MOST_FAMILIES / 2 + 1;

/// What the stencils of the two cells of a family touch along one axis.
#[derive(Clone, Copy)]
struct Span {
    /// The stencil of each cell.
    stencils: [Stencil; 2],
    /// Where the second one begins in the cells of both.
    shift: usize,
    /// Which half of the first family they begin with.
    half: usize,
    /// Positions of the families.
    families: [u32; MOST_FAMILIES],
    /// The number of families.
    count: usize,
}

impl Span {
    /// Of the family at `position` of `level`.
    fn new(position: u32, level: u8, order: usize, periodic: bool) -> Self {
        let around = |half| Stencil::around(2 * position + half, level, order, periodic);
        let stencils = [around(0), around(1)];
        let cells = 1_u32 << level;
        let [first, second] = stencils.map(|stencil| stencil.start);
        let shift = (second.wrapping_sub(first) & (cells - 1)) as usize;
        let half = (first & 1) as usize;
        let count = (half + stencils[0].order + shift).div_ceil(2);
        let mut families = [0; MOST_FAMILIES];
        for (family, at) in families[..count].iter_mut().zip(first >> 1..) {
            // A periodic axis wraps between families.
            *family = at & ((cells >> 1) - 1);
        }
        Self { stencils, shift, half, families, count }
    }
}

/// What the stencils of all cells of one family touch.
pub(super) struct CousinReach<const D: usize> {
    spans: [Span; D],
}

/// Working memory for one block of cousins, kept from block to block.
#[derive(Debug)]
pub(super) struct CousinBuffer {
    /// Numbers of the blocks that the reach touches, and of its families: axis 0 slowest.
    cousin_blocks: Vec<u32>,
    families: Vec<u32>,
    /// Averages around the block of cousins, and in the end those of its members' cells, axis 0 slowest.
    block: Vec<f64>,
    scratch: Vec<f64>,
    /// Where the upper halves of each child are in a block of 4^D.
    places: Vec<usize>,
    children: Vec<f64>,
}

impl CousinBuffer {
    pub(super) fn new<const D: usize>(order: usize) -> Self {
        // Each pass makes 4 of `order` + 1.
        let length = power((order + 1).max(4), D);
        Self {
            cousin_blocks: Vec::with_capacity(power(MOST_BLOCKS, D)),
            families: Vec::with_capacity(power(order / 2 + 2, D)),
            block: vec![0.0; length],
            scratch: vec![0.0; length],
            places: (0..1 << D).map(place::<D>).collect(),
            children: vec![0.0; 1 << D],
        }
    }

    /// The children of the family at `position`, a member of the block of cousins that was predicted.
    pub(super) fn children_of<const D: usize>(&mut self, position: [u32; D]) -> &[f64] {
        let block = &self.block[2 * self.places[member(position)]..];
        for (child, &place) in self.children.iter_mut().zip(&self.places) {
            *child = block[place];
        }
        &self.children
    }
}

impl<const D: usize> CousinReach<D> {
    /// Of the family at `position` of `level`.
    pub(super) fn new(position: [u32; D], level: u8, order: usize, periodic: [bool; D]) -> Self {
        let span = |axis: usize| Span::new(position[axis], level, order, periodic[axis]);
        Self { spans: core::array::from_fn(span) }
    }

    /// The order of the stencils.
    fn order(&self) -> usize {
        self.spans[0].stencils[0].order
    }

    /// Finds the families in their level: [`NONE`] for those that it lacks.
    fn find(&self, level: &Level<D>, buffer: &mut CousinBuffer) {
        let CousinBuffer { cousin_blocks, families, .. } = buffer;
        cousin_blocks.clear();
        families.clear();
        let position_of =
            |at: [usize; D]| core::array::from_fn(|axis| self.spans[axis].families[at[axis]]);
        let counts = self.spans.each_ref().map(|span| span.count);
        let Some(index) = level.index() else {
            for_each(counts, |at| {
                families.push(level.family_at(position_of(at)).map_or(NONE, to_u32));
            });
            return;
        };
        // Along each axis, the block of cousins of each family, and a family of each block.
        let (mut block_of, mut family_of) = ([[0; MOST_FAMILIES]; D], [[0; MOST_BLOCKS]; D]);
        let mut block_counts = [1; D];
        for axis in 0..D {
            let Span { families, count, .. } = &self.spans[axis];
            for family in 1..*count {
                if families[family] >> 1 != families[family - 1] >> 1 {
                    family_of[axis][block_counts[axis]] = family;
                    block_counts[axis] += 1;
                }
                block_of[axis][family] = block_counts[axis] - 1;
            }
        }
        for_each(block_counts, |at| {
            let family = core::array::from_fn(|axis| family_of[axis][at[axis]]);
            cousin_blocks.push(index.block_at(cousins(position_of(family))));
        });
        let last = &self.spans[D - 1];
        let mut rows = counts;
        rows[D - 1] = 1;
        for_each(rows, |at| {
            let (mut first, mut half) = (0, 0);
            for axis in 0..D - 1 {
                first = (first + block_of[axis][at[axis]]) * block_counts[axis + 1];
                half |= (self.spans[axis].families[at[axis]] as usize & 1) << axis;
            }
            for (cousins, family) in block_of[D - 1].iter().zip(&last.families[..last.count]) {
                let half = half | (*family as usize & 1) << (D - 1);
                families.push(match cousin_blocks[first + cousins] {
                    NONE => NONE,
                    cousins => index.member_of(cousins, half),
                });
            }
        });
    }

    /// Calls `visit` with the positions of the families that the level lacks.
    pub(super) fn for_each_missing(
        &self,
        level: &Level<D>,
        buffer: &mut CousinBuffer,
        mut visit: impl FnMut([u32; D]),
    ) {
        self.find(level, buffer);
        if !buffer.families.contains(&NONE) {
            return;
        }
        let mut found = buffer.families.iter();
        for_each(self.spans.each_ref().map(|span| span.count), |at| {
            if found.next() == Some(&NONE) {
                visit(core::array::from_fn(|axis| self.spans[axis].families[at[axis]]));
            }
        });
    }

    /// Fills the block with the averages of N + 1 cells along each axis; the last ones are not used
    /// where both stencils are the same, and what the level lacks is 0.
    fn gather<const N: usize>(&self, level: &Level<D>, buffer: &mut CousinBuffer) {
        self.find(level, buffer);
        let CousinBuffer { families, block, .. } = buffer;
        // Along each axis, of each cell: what it adds to the index of its family, and of the child.
        let mut places = [[(0, 0); MAX_ORDER + 1]; D];
        let mut stride = 1;
        for axis in (0..D).rev() {
            let Span { half, count, .. } = self.spans[axis];
            for (k, place) in places[axis][..=N].iter_mut().enumerate() {
                let at = (half + k).min(2 * count - 1);
                *place = ((at >> 1) * stride, (at & 1) << axis);
            }
            stride *= count;
        }
        let mut lengths = [N + 1; D];
        lengths[D - 1] = 1;
        let mut rows = block.chunks_exact_mut(N + 1);
        for_each(lengths, |at| {
            let (mut first, mut child) = (0, 0);
            for axis in 0..D - 1 {
                let place = places[axis][at[axis]];
                (first, child) = (first + place.0, child | place.1);
            }
            for (value, place) in rows.next().into_iter().flatten().zip(&places[D - 1]) {
                let family = families[first + place.0];
                let cell = family as usize * Level::<D>::SIBLINGS + (child | place.1);
                *value = level.averages.get(cell).copied().unwrap_or(0.0);
            }
        });
    }

    /// Predicts the families of the block of cousins, for [`children_of`](CousinBuffer::children_of). Those that the
    /// level lacks a cell for get numbers without a meaning.
    pub(super) fn predict(
        &self,
        level: &Level<D>,
        predictor: &Predictor,
        points: Option<&PointPredictor>,
        buffer: &mut CousinBuffer,
    ) {
        match self.order() {
            1 => self.predict_with::<1>(level, predictor, points, buffer),
            3 => self.predict_with::<3>(level, predictor, points, buffer),
            5 => self.predict_with::<5>(level, predictor, points, buffer),
            7 => self.predict_with::<7>(level, predictor, points, buffer),
            _ => self.predict_with::<MAX_ORDER>(level, predictor, points, buffer),
        }
    }

    /// A function for each order, so that each is compiled for itself.
    #[inline(never)]
    fn predict_with<const N: usize>(
        &self,
        level: &Level<D>,
        predictor: &Predictor,
        points: Option<&PointPredictor>,
        buffer: &mut CousinBuffer,
    ) {
        self.gather::<N>(level, buffer);
        match points {
            None => self.split(buffer, |stencil| Means::<N>::new(predictor, stencil)),
            Some(points) => self.split(buffer, |stencil| Values::<N>::new(points, stencil)),
        }
    }

    /// Makes 4 halves of 2 cells along one axis after the other, axis 0 first.
    fn split<const N: usize, H: Halves<N>>(
        &self,
        buffer: &mut CousinBuffer,
        halves: impl Fn(Stencil) -> H,
    ) {
        let CousinBuffer { block, scratch, .. } = buffer;
        let (mut done, mut rest) = (1, power(N + 1, D - 1));
        for Span { stencils, shift, .. } in &self.spans {
            let of_cells = stencils.map(&halves);
            let from = block[..done * (N + 1) * rest].chunks_exact((N + 1) * rest);
            for (from, to) in from.zip(scratch.chunks_exact_mut(4 * rest)) {
                let (lower, upper) = to.split_at_mut(2 * rest);
                of_cells[0].split(from, rest, lower);
                of_cells[1].split(&from[shift * rest..], rest, upper);
            }
            core::mem::swap(block, scratch);
            done *= 4;
            rest = (rest / (N + 1)).max(1);
        }
    }
}

/// Where the upper halves of a child are in a block of 4^D, axis 0 slowest.
fn place<const D: usize>(child: usize) -> usize {
    (0..D).fold(0, |place, axis| place << 2 | child >> axis & 1)
}

/// Calls `visit` with all digits below `ends`, the last one fastest.
fn for_each<const D: usize>(ends: [usize; D], mut visit: impl FnMut([usize; D])) {
    let mut digits = [0; D];
    loop {
        for last in 0..ends[D - 1] {
            digits[D - 1] = last;
            visit(digits);
        }
        let mut axis = D - 1;
        loop {
            if axis == 0 {
                return;
            }
            axis -= 1;
            digits[axis] += 1;
            if digits[axis] < ends[axis] {
                break;
            }
            digits[axis] = 0;
        }
    }
}
