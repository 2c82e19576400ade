//! Progressive rendering: the coefficients projected by size, the largest first.

use super::SparseTree;
use super::level::Level;
use crate::cell;
use crate::refinement::detail_size;

/// A tree's projections with more and more of its coefficients, the largest first.
///
/// A family's size is its largest |detail| times the depth of its cells: the size with which it
/// reaches the image. Frames have the base grid alone, then 1, 2, 4, … times as many details
/// besides, and at last all of them.
#[derive(Debug)]
pub struct Progression<'a, const D: usize, const E: usize> {
    tree: &'a SparseTree<D>,
    axis: usize,
    projected: SparseTree<E>,
    /// (depth, family), the largest first.
    order: Vec<(usize, usize)>,
    used: usize,
    next: usize,
}

/// One frame of a [`Progression`].
#[derive(Clone, Debug)]
pub struct Frame<const E: usize> {
    /// How many coefficients went into it: the base averages and 2^D details a family.
    pub coefficients: usize,
    /// The projection of these coefficients.
    pub tree: SparseTree<E>,
}

impl<const D: usize> SparseTree<D> {
    /// The projections along `axis` with the largest coefficients first; the last one equals
    /// [`project`](Self::project) to rounding.
    ///
    /// ```
    /// use emitree::quadrature::Pointwise;
    /// use emitree::tree::{BuildOptions, build};
    ///
    /// let peak = Pointwise(|[x, y, z]: [f64; 3]| (-90.0 * (x * x + y * y + z * z)).exp());
    /// let built = build(&peak, [false; 3], &BuildOptions::default())?;
    /// for frame in built.tree.progression::<2>(2) {
    ///     let image = frame.tree.sample(64, 64);
    ///     assert!((image.pixels().iter().sum::<f64>() / 4096.0 - built.tree.integral()).abs() < 1e-12);
    /// }
    /// # Ok::<(), emitree::tree::BuildError<std::convert::Infallible>>(())
    /// ```
    ///
    /// # Panics
    ///
    /// If `axis` is not an axis of the tree.
    pub fn progression<const E: usize>(&self, axis: usize) -> Progression<'_, D, E> {
        let mut sized = Vec::new();
        for (depth, level) in self.levels.iter().enumerate().skip(1) {
            let edge = cell::edge(level.level);
            let families = level.details.chunks_exact(Level::<D>::SIBLINGS).enumerate();
            sized.extend(families.map(|(f, details)| (detail_size(details) * edge, depth, f)));
        }
        // Of equal sizes the coarser comes first: the sort is stable.
        sized.sort_by(|a, b| b.0.total_cmp(&a.0));
        Progression {
            tree: self,
            axis,
            projected: self.project_skeleton(axis),
            order: sized.into_iter().map(|(_, depth, family)| (depth, family)).collect(),
            used: 0,
            next: 0,
        }
    }
}

impl<const D: usize, const E: usize> Iterator for Progression<'_, D, E> {
    type Item = Frame<E>;

    fn next(&mut self) -> Option<Frame<E>> {
        if self.used == self.order.len() && self.next > self.used {
            return None;
        }
        let end = self.next.min(self.order.len());
        for &(depth, family) in &self.order[self.used..end] {
            self.tree.project_family(self.axis, depth, family, &mut self.projected);
        }
        self.used = end;
        let (base, siblings) = (self.tree.levels[0].own, Level::<D>::SIBLINGS);
        self.next = if self.next == 0 { base } else { 2 * self.next }.max(end + 1);
        let mut tree = self.projected.clone();
        tree.update_averages();
        Some(Frame { coefficients: (base + end) * siblings, tree })
    }
}
