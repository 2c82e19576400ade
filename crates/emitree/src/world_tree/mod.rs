//! A tree in the world: built once from an expensive emission, then rendered from any camera.
//!
//! A [`WorldTree`] holds an emission rate that is the same in all directions, in a box of world
//! coordinates: g at the centres of cells that are small where g needs it ([`tree`](crate::tree)).
//! It is an [`Emission`] itself, so that everything that renders g renders the tree, without another
//! call of g. [`build_world_tree`] makes it.
//!
//! # Guarantees
//!
//! A cell is split where prediction from the coarser level misses g at a centre of its family by
//! `tolerance` times the largest |g| so far, or more. So every value that was evaluated is in the tree,
//! and was predicted to the tolerance before where cells were left whole; between the centres of
//! those cells, half as far apart, the error of a smooth g is smaller by about 2^order. It is **not**
//! a bound: a structure between the centres of the coarsest cells can be missed, and where g jumps
//! the error is that of the finest cells there are. [`BuiltWorldTree::largest_dropped`] is what
//! was measured. On one level the tree is continuous; between levels it may jump by about what was
//! dropped.

mod bounds;
mod build;
mod error;

pub use bounds::{BoxError, WorldBox};
pub use build::{BuiltWorldTree, WorldTreeOptions, build_world_tree};
pub use error::WorldTreeError;

use crate::emission::{Emission, Samples};
use crate::tree::{Family, FamilyDefect, PointStencil, PointTree};
use core::convert::Infallible;

/// An emission rate in a box of the world, as a sparse tree of values at the centres of cells; see
/// [the guarantees](self).
///
/// Outside the box the rate is 0.
///
/// ```
/// use emitree::world_tree::{WorldBox, WorldTreeOptions, build_world_tree};
/// use emitree::{Emission, FromFn, Samples};
///
/// let corona = FromFn(|[x, y, z]: [f64; 3], _| (-(x * x + y * y + z * z) / 4.0).exp());
/// let bounds = WorldBox::new([-8.0; 3], [8.0; 3])?;
/// let built = build_world_tree(&corona, bounds, &WorldTreeOptions::default())?;
///
/// let directions = [[0.0, 0.0, 1.0]; 2];
/// let mut rates = [f64::NAN; 2];
/// let samples = Samples::new(&[[1.0, 2.0, 0.5], [9.0, 0.0, 0.0]], &directions);
/// built.tree.emission_rates(&samples, &mut rates)?;
/// assert!((rates[0] - (-5.25_f64 / 4.0).exp()).abs() < 1e-3);
/// assert_eq!(rates[1], 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct WorldTree {
    bounds: WorldBox,
    points: PointTree,
}

impl WorldTree {
    /// The tree of `families` in a box: first those of the base grid in the order of their positions,
    /// the first axis fastest, then one level after the other, as [`families`](Self::families) has
    /// them.
    ///
    /// # Errors
    ///
    /// [`FamilyDefect`] names the first family that is out of place.
    pub fn from_families(
        bounds: WorldBox,
        order: usize,
        base_level: u8,
        families: &[Family],
    ) -> Result<Self, FamilyDefect> {
        Ok(Self { bounds, points: PointTree::from_families(order, base_level, families)? })
    }

    /// All families of the tree, the base grid first: together with the box, the order and the base
    /// level they are the tree.
    ///
    /// ```
    /// use emitree::FromFn;
    /// use emitree::world_tree::{WorldBox, WorldTree, WorldTreeOptions, build_world_tree};
    ///
    /// let ramp = FromFn(|[x, _, _]: [f64; 3], _| x);
    /// let bounds = WorldBox::new([0.0; 3], [1.0; 3])?;
    /// let tree = build_world_tree(&ramp, bounds, &WorldTreeOptions::default())?.tree;
    /// let families: Vec<_> = tree.families().collect();
    /// let again = WorldTree::from_families(bounds, tree.order(), tree.base_level(), &families)?;
    /// assert_eq!(again.cells(), tree.cells());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn families(&self) -> impl Iterator<Item = Family> + '_ {
        self.points.families()
    }

    /// The box that the tree fills.
    pub fn bounds(&self) -> WorldBox {
        self.bounds
    }

    /// The order p: polynomials of degree p − 1 are reproduced at any point.
    pub fn order(&self) -> usize {
        self.points.cells().order()
    }

    /// The level of the full base grid: 2^level cells along each edge of the box.
    pub fn base_level(&self) -> u8 {
        self.points.cells().base_level()
    }

    /// The finest level that has cells.
    pub fn finest_level(&self) -> u8 {
        self.points.cells().finest_level()
    }

    /// The number of cells on all levels: of the values that are kept.
    pub fn cells(&self) -> usize {
        self.points.cells().cells()
    }

    /// The number of leaves on each level, from level 0 to the finest.
    pub fn leaves_per_level(&self) -> Vec<usize> {
        self.points.cells().leaves_per_level()
    }
}

impl Emission for WorldTree {
    type Error = Infallible;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Infallible> {
        let mut stencil = PointStencil::new(&self.points);
        for (rate, &position) in rates.iter_mut().zip(samples.positions()) {
            *rate = match self.bounds.unit_from_world(position) {
                Some(u) => self.points.value(u, &mut stencil),
                None => 0.0,
            };
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
