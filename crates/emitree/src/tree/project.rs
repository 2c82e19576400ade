//! Projection: dropping an axis by one sum per coefficient (the paper's Fig. 7).
//!
//! Prediction works axis by axis and conserves the mean along each, so the mean along an axis of
//! what is predicted is the prediction of the means. Hence each level can be projected on its own,
//! base averages as well as details, **exactly**: projecting and then reconstructing equals
//! reconstructing and then projecting, to rounding.

use super::SparseTree;
use super::level::Level;
use crate::cell::{self, to_u32};
use rustc_hash::FxHashMap;

impl<const D: usize> SparseTree<D> {
    /// The tree of the integral along `axis`: a tree in E = D − 1 dimensions, whose axes are the
    /// others in their order.
    ///
    /// ```
    /// use emitree::quadrature::Pointwise;
    /// use emitree::tree::{BuildOptions, build};
    ///
    /// let built = build(&Pointwise(|[x, z]: [f64; 2]| x + z), [false; 2], &BuildOptions::default())?;
    /// let image = built.tree.project::<1>(1);
    /// assert!((image.integral() - 1.0).abs() < 1e-14);
    /// # Ok::<(), emitree::tree::BuildError<std::convert::Infallible>>(())
    /// ```
    ///
    /// # Panics
    ///
    /// If `axis` is not an axis of the tree.
    pub fn project<const E: usize>(&self, axis: usize) -> SparseTree<E> {
        let mut projected = self.project_skeleton(axis);
        for depth in 1..self.levels.len() {
            let level = &self.levels[depth];
            for family in 0..level.own {
                self.project_family(axis, depth, family, &mut projected);
            }
        }
        projected.update_averages();
        projected
    }

    /// The projection of the base grid, with all families that the projection has, details 0.
    pub(super) fn project_skeleton<const E: usize>(&self, axis: usize) -> SparseTree<E> {
        const { assert!(E + 1 == D, "a projection drops one axis") };
        assert!(axis < D, "axis {axis} of {D}");
        let base = &self.levels[0];
        let mut flat = Level::<E>::base(base.level);
        let depth = cell::edge(base.level);
        for (family, &position) in base.families.iter().enumerate() {
            // The base is dense: the family is there.
            let to = flat.family_at(without(axis, position)).unwrap_or(0);
            for (child, average) in base.family_averages(family).iter().enumerate() {
                let to = to * Level::<E>::SIBLINGS + child_without(axis, child);
                flat.averages[to] += average * depth;
            }
        }
        let mut levels = vec![flat];
        for level in &self.levels[1..] {
            let coarser = levels.len() - 1;
            let mut seen = FxHashMap::default();
            let mut families = Vec::new();
            for &position in &level.families[..level.own] {
                let position: [u32; E] = without(axis, position);
                seen.entry(cell::key(position)).or_insert_with(|| families.push(position));
            }
            let parents: Vec<u32> =
                families.iter().map(|&cell| levels[coarser].cell_at(cell)).collect();
            for (family, &parent) in parents.iter().enumerate() {
                levels[coarser].children[parent as usize] = to_u32(family);
            }
            levels.push(Level::refined(level.level, families, parents));
        }
        SparseTree {
            predictor: self.predictor.clone(),
            points: None,
            periodic: without(axis, self.periodic),
            levels,
        }
    }

    /// Adds the details of one family, integrated along `axis`, to those of `projected`.
    pub(super) fn project_family<const E: usize>(
        &self,
        axis: usize,
        depth: usize,
        family: usize,
        projected: &mut SparseTree<E>,
    ) {
        let from = &self.levels[depth];
        let to = &mut projected.levels[depth];
        let edge = cell::edge(from.level);
        // The skeleton has every family of the projection.
        let flat = to.family_at(without(axis, from.families[family])).unwrap_or(0);
        let siblings = Level::<D>::SIBLINGS;
        let details = &from.details[family * siblings..][..siblings];
        for (child, detail) in details.iter().enumerate() {
            let child = flat * Level::<E>::SIBLINGS + child_without(axis, child);
            to.details[child] += detail * edge;
        }
    }
}

impl<const D: usize> Level<D> {
    /// The index of the cell at `position`, whose family must exist.
    fn cell_at(&self, position: [u32; D]) -> u32 {
        let family = self.family_at(position.map(|p| p >> 1)).unwrap_or(0);
        let child = (0..D).fold(0, |child, axis| child | (position[axis] as usize & 1) << axis);
        to_u32(family * Self::SIBLINGS + child)
    }
}

/// The entries of all axes but one.
fn without<T: Copy, const D: usize, const E: usize>(axis: usize, entries: [T; D]) -> [T; E] {
    core::array::from_fn(|other| entries[other + usize::from(other >= axis)])
}

/// The number of a child in its family, once an axis is gone.
fn child_without(axis: usize, child: usize) -> usize {
    let low = child & ((1 << axis) - 1);
    low | (child >> (axis + 1)) << axis
}
