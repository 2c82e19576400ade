//! One level of a sparse tree: families of sibling cells, found by their position.

use super::index::FamilyIndex;
use crate::cell::{self, power, to_u32};

/// Marks a cell that has no children.
pub(super) const LEAF: u32 = u32::MAX;

/// Cells of one level, in families of 2^D siblings (child bit `a` is the half along axis `a`).
///
/// Cell `c` is child `c % 2^D` of family `c / 2^D`. The families that the tree itself has come
/// first; after them come *ghosts*: families without data, whose averages are predicted, kept only
/// because a stencil needs them.
#[derive(Clone, Debug)]
pub(super) struct Level<const D: usize> {
    pub(super) level: u8,
    /// Whether this is the base grid: every family is there, in the order of its position.
    dense: bool,
    /// Position of each family: that of its parent cell, one level up.
    pub(super) families: Vec<[u32; D]>,
    /// How many of the families are the tree's own; the rest are ghosts.
    pub(super) own: usize,
    /// Cell averages, ghosts included.
    pub(super) averages: Vec<f64>,
    /// Actual minus predicted, for each own cell; empty on the base level.
    pub(super) details: Vec<f64>,
    /// For each own family the index of its parent among the cells one level up; empty on the base.
    pub(super) parents: Vec<u32>,
    /// For each own cell the index of its family one level down, or [`LEAF`].
    pub(super) children: Vec<u32>,
    /// Family by position; empty on the base level, which is dense.
    index: FamilyIndex<D>,
}

impl<const D: usize> Level<D> {
    pub(super) const SIBLINGS: usize = 1 << D;

    /// The full base grid of `level`, averages 0: families in the order of their position, axis 0
    /// fastest.
    pub(super) fn base(level: u8) -> Self {
        let per_axis = 1_usize << (level - 1);
        let count = power(per_axis, D);
        let position = |family: usize| {
            core::array::from_fn(|axis| to_u32(family / power(per_axis, axis) % per_axis))
        };
        let cells = count * Self::SIBLINGS;
        Self {
            level,
            dense: true,
            families: (0..count).map(position).collect(),
            own: count,
            averages: vec![0.0; cells],
            details: Vec::new(),
            parents: Vec::new(),
            children: vec![LEAF; cells],
            index: FamilyIndex::default(),
        }
    }

    /// A refined level with own `families` of the given parents, averages and details 0.
    pub(super) fn refined(level: u8, families: Vec<[u32; D]>, parents: Vec<u32>) -> Self {
        let (own, cells) = (families.len(), families.len() * Self::SIBLINGS);
        let index = FamilyIndex::of(&families);
        Self {
            level,
            dense: false,
            own,
            averages: vec![0.0; cells],
            details: vec![0.0; cells],
            parents,
            children: vec![LEAF; cells],
            index,
            families,
        }
    }

    /// The number of the tree's own cells.
    pub(super) fn own_cells(&self) -> usize {
        self.own * Self::SIBLINGS
    }

    pub(super) fn is_base(&self) -> bool {
        self.dense
    }

    /// The index of the family at `position`, own or ghost.
    pub(super) fn family_at(&self, position: [u32; D]) -> Option<usize> {
        if self.is_base() {
            let shift = self.level - 1;
            let linear = position.iter().rev().fold(0, |linear, &p| linear << shift | p as usize);
            return Some(linear);
        }
        self.index.get(position)
    }

    /// Where families are; `None` on the base level, where positions say it.
    pub(super) fn index(&self) -> Option<&FamilyIndex<D>> {
        (!self.dense).then_some(&self.index)
    }

    /// The averages of the family with the given index.
    pub(super) fn family_averages(&self, family: usize) -> &[f64] {
        &self.averages[family * Self::SIBLINGS..][..Self::SIBLINGS]
    }

    /// Appends ghost families at these positions, none of which is there, averages not yet predicted.
    pub(super) fn push_ghosts(&mut self, ghosts: &[[u32; D]]) {
        self.families.reserve_exact(ghosts.len());
        for &position in ghosts {
            self.index.insert(position, self.families.len());
            self.families.push(position);
        }
        let cells = self.families.len() * Self::SIBLINGS;
        self.averages.reserve_exact(cells - self.averages.len());
        self.averages.resize(cells, 0.0);
    }

    /// Position of own or ghost cell `cell`.
    pub(super) fn cell_position(&self, cell: usize) -> [u32; D] {
        cell::child_position(self.families[cell / Self::SIBLINGS], cell % Self::SIBLINGS)
    }
}
