//! A tree of values at the centres of cells, in place of averages.
//!
//! Every number is the function at the centre of a cell, on all levels: a parent is no mean of its
//! children, and nothing is restricted. Details and ghosts are those of any [`SparseTree`], with the
//! weights of [`points`](super::points). What the tree is at any other point: `point_value.rs`.

use super::SparseTree;
use super::build::{BuildError, BuildOptions, Grown, StopReason, grow};
use super::level::{LEAF, Level};
use super::points::PointPredictor;
use crate::cell::to_u32;
use crate::prediction::Predictor;
use crate::quadrature::AsyncIntegrand;
use crate::refinement::detail_size;

/// Eight cells, the halves of one cell along each axis, and the values at their centres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Family {
    /// The level of the eight cells: there are 2^level of them along each edge of the whole.
    pub level: u8,
    /// The position of the cell that they fill, one level up, in units of its edges.
    pub position: [u32; 3],
    /// The values; cell `n` is the upper half along axis `a` where bit `a` of `n` is set.
    pub values: [f64; 8],
}

/// Families that make no tree.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FamilyDefect {
    /// The order is none of a tree of values.
    #[error("the order is {0}: expected 3, 5 or 7")]
    Order(usize),
    /// The base level is out of range.
    #[error("the base level is {0}: expected 3 to 10")]
    BaseLevel(u8),
    /// The families end before the base grid is full.
    #[error("there are {found} families: expected at least {expected}, those of the base grid")]
    BaseIncomplete {
        /// The families given.
        found: usize,
        /// The families of the base grid.
        expected: usize,
    },
    /// A family of the base grid is not where it should be.
    #[error(
        "family {index} is at {position:?} of level {level}: expected {expected:?} of the base \
         level {base_level}, the first axis fastest"
    )]
    BaseOrder {
        /// The number of the family, from 0.
        index: usize,
        /// Its position.
        position: [u32; 3],
        /// Its level.
        level: u8,
        /// The position that was expected.
        expected: [u32; 3],
        /// The base level.
        base_level: u8,
    },
    /// The levels do not follow each other.
    #[error(
        "family {index} is of level {level}: expected {expected}, or one more, up to {deepest}"
    )]
    LevelOrder {
        /// The number of the family, from 0.
        index: usize,
        /// Its level.
        level: u8,
        /// The level of the family before it.
        expected: u8,
        /// The deepest level that there is.
        deepest: u8,
    },
    /// A family has no parent.
    #[error("family {index} at {position:?} of level {level} fills a cell that the tree has not")]
    Orphan {
        /// The number of the family, from 0.
        index: usize,
        /// Its position.
        position: [u32; 3],
        /// Its level.
        level: u8,
    },
    /// A family comes twice.
    #[error("family {index} at {position:?} of level {level} comes twice: expected each one once")]
    Duplicate {
        /// The number of the later of the two, from 0.
        index: usize,
        /// Its position.
        position: [u32; 3],
        /// Its level.
        level: u8,
    },
    /// A value is no number.
    #[error("family {index} has the value {value}: expected a finite number")]
    NotFinite {
        /// The number of the family, from 0.
        index: usize,
        /// The value.
        value: f64,
    },
}

/// A tree of values at the centres of cells of the unit cube.
#[derive(Clone, Debug)]
pub(crate) struct PointTree {
    pub(super) tree: SparseTree<3>,
    /// The smallest of all values.
    pub(super) lowest: f64,
}

/// A tree of values with the error measures of its growth.
pub(crate) struct GrownPoints {
    pub(crate) tree: PointTree,
    /// The size below which details were dropped.
    pub(crate) threshold: f64,
    pub(crate) ending: StopReason,
    /// The largest |value|.
    pub(crate) largest: f64,
    /// The largest |detail| of cells that were not split: what the last generation has changed.
    pub(crate) largest_dropped: f64,
    /// The number of cells that were not split although a detail of their family exceeded the threshold.
    pub(crate) unresolved_cells: u64,
}

const SIBLINGS: usize = Level::<3>::SIBLINGS;

impl PointTree {
    /// The orders that a tree of values can have: stencils of order + 1 cells fit its base grid.
    pub(crate) const ORDERS: [usize; 3] = [3, 5, 7];
    /// The coarsest base grid that has room for the stencils.
    pub(crate) const LEAST_BASE_LEVEL: u8 = 3;

    /// Grows a tree by the loop of [`build`](super::build()); the rule of `options` must be the
    /// midpoint rule, and the order and the base level in range.
    pub(crate) async fn grow<I: AsyncIntegrand<3>>(
        integrand: &I,
        options: &BuildOptions,
    ) -> Result<GrownPoints, BuildError<I::Error>> {
        let points = Some(PointPredictor::new(options.order));
        let Grown { tree, threshold, ending } =
            grow(integrand, [false; 3], options, points).await?;
        let (mut largest, mut largest_dropped, mut unresolved_cells) = (0.0_f64, 0.0_f64, 0);
        for level in &tree.levels {
            largest = largest.max(detail_size(&level.averages[..level.own_cells()]));
            let families = level.details.chunks_exact(SIBLINGS);
            for (details, children) in families.zip(level.children.chunks_exact(SIBLINGS)) {
                let leaves = children.iter().filter(|&&family| family == LEAF).count() as u64;
                let size = detail_size(details);
                if leaves > 0 {
                    largest_dropped = largest_dropped.max(size);
                }
                if size > 0.0 && size >= threshold {
                    unresolved_cells += leaves;
                }
            }
        }
        if tree.levels.len() == 1 {
            // Nothing is predicted yet, so that no stencil is known to lack a cell.
            (largest_dropped, unresolved_cells) = (largest, tree.cells() as u64);
        }
        let tree = Self::finished(tree);
        Ok(GrownPoints { tree, threshold, ending, largest, largest_dropped, unresolved_cells })
    }

    /// The tree of `families`: first those of the base grid in the order of their positions, the
    /// first axis fastest; then one level after the other.
    pub(crate) fn from_families(
        order: usize,
        base_level: u8,
        families: &[Family],
    ) -> Result<Self, FamilyDefect> {
        let predictor = match Predictor::new(order) {
            Ok(predictor) if Self::ORDERS.contains(&order) => predictor,
            _ => return Err(FamilyDefect::Order(order)),
        };
        let deepest = BuildOptions::deepest_base_level::<3>();
        if !(Self::LEAST_BASE_LEVEL..=deepest).contains(&base_level) {
            return Err(FamilyDefect::BaseLevel(base_level));
        }
        for (index, family) in families.iter().enumerate() {
            if let Some(&value) = family.values.iter().find(|value| !value.is_finite()) {
                return Err(FamilyDefect::NotFinite { index, value });
            }
        }
        let (base, mut rest) = base_of(base_level, families)?;
        let points = Some(PointPredictor::new(order));
        let mut tree = SparseTree { predictor, points, periodic: [false; 3], levels: vec![base] };
        while let Some(first) = rest.first() {
            let level = first.level;
            let count = rest.iter().take_while(|family| family.level == level).count();
            let index = families.len() - rest.len();
            tree.add_families(index, &rest[..count])?;
            rest = &rest[count..];
        }
        Ok(Self::finished(tree))
    }

    /// Adds what values between the centres need, and drops what only growth does.
    fn finished(tree: SparseTree<3>) -> Self {
        let mut finished = Self { tree, lowest: f64::INFINITY };
        for level in &mut finished.tree.levels {
            level.details = Vec::new();
            let own = &level.averages[..level.own_cells()];
            finished.lowest = own.iter().copied().fold(finished.lowest, f64::min);
        }
        finished.complete_leaves();
        finished
    }

    /// All families, as [`from_families`](Self::from_families) takes them.
    pub(crate) fn families(&self) -> impl Iterator<Item = Family> + '_ {
        self.tree.levels.iter().flat_map(|level| {
            (0..level.own).map(|family| {
                let mut values = [0.0; SIBLINGS];
                values.copy_from_slice(level.family_averages(family));
                Family { level: level.level, position: level.families[family], values }
            })
        })
    }

    /// The tree behind: its order, levels and cells. Its numbers are no averages.
    pub(crate) fn cells(&self) -> &SparseTree<3> {
        &self.tree
    }
}

/// The base grid, and the families after it.
fn base_of(base_level: u8, families: &[Family]) -> Result<(Level<3>, &[Family]), FamilyDefect> {
    let count = 1 << (3 * (base_level - 1));
    if families.len() < count {
        return Err(FamilyDefect::BaseIncomplete { found: families.len(), expected: count });
    }
    let (of_base, rest) = families.split_at(count);
    let mut base = Level::base(base_level);
    for (index, family) in of_base.iter().enumerate() {
        let (expected, Family { level, position, values }) = (base.families[index], *family);
        if level != base_level || position != expected {
            return Err(FamilyDefect::BaseOrder { index, position, level, expected, base_level });
        }
        base.averages[index * SIBLINGS..][..SIBLINGS].copy_from_slice(&values);
    }
    Ok((base, rest))
}

impl SparseTree<3> {
    /// Adds a level of `families`; the first of them is number `first` of all.
    fn add_families(&mut self, first: usize, families: &[Family]) -> Result<(), FamilyDefect> {
        let coarser = &self.levels[self.levels.len() - 1];
        let deepest = crate::cell::CellIndex::<3>::MAX_LEVEL;
        let mut split = Vec::with_capacity(families.len());
        let mut taken = vec![false; coarser.own_cells()];
        for (index, family) in (first..).zip(families) {
            let Family { level, position, .. } = *family;
            if level != coarser.level + 1 || level > deepest {
                let expected = coarser.level;
                return Err(FamilyDefect::LevelOrder { index, level, expected, deepest });
            }
            let inside = position.iter().all(|&p| p >> coarser.level == 0);
            let parent = coarser.family_at(position.map(|p| p >> 1)).filter(|_| inside);
            // A family of the coarser level that is a ghost has no cells of the tree.
            let Some(parent) = parent.filter(|&parent| parent < coarser.own) else {
                return Err(FamilyDefect::Orphan { index, position, level });
            };
            let child = (0..3).fold(0, |child, a| child | (position[a] as usize & 1) << a);
            let cell = parent * SIBLINGS + child;
            if core::mem::replace(&mut taken[cell], true) {
                return Err(FamilyDefect::Duplicate { index, position, level });
            }
            split.push(to_u32(cell));
        }
        self.add_level(split, families.iter().map(|family| family.position).collect());
        let last = self.levels.len() - 1;
        let values = self.levels[last].averages.chunks_exact_mut(SIBLINGS);
        for (values, family) in values.zip(families) {
            values.copy_from_slice(&family.values);
        }
        Ok(())
    }
}
