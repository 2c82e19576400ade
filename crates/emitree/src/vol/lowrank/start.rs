//! What a rendering leaves for those of other emissions: the charts of its view, and the functions or the image
//! tree of each part.
//!
//! The functions of one G often serve another one: what differs is in the values at the pivots. The residuals
//! at scattered samples show whether they do, as for a G of their own.

use crate::energy::EnergyAxis;
use crate::vol::lowrank::interpolant::Interpolant;
use crate::vol::spectrum::energies::Energies;
use crate::vol::view::division::Division;
use crate::vol::view::tree_start::TreeStart;
use std::sync::Arc;

/// The functions of an interpolant.
#[derive(Clone, Debug)]
pub(crate) struct Functions(pub(super) Arc<Interpolant>);

/// The energies of a cube of products, and the functions of all parts at each of them.
#[derive(Debug)]
pub(crate) struct CubeStart {
    pub(super) axis: EnergyAxis,
    pub(super) energies: Energies,
    pub(super) functions: Vec<Vec<Option<Functions>>>,
}

/// The division of a view, and the functions or the tree of each part.
#[derive(Clone, Debug, Default)]
pub(crate) struct Start {
    pub(crate) division: Division,
    /// For each part; `None` if it has no products.
    pub(crate) functions: Vec<Option<Functions>>,
    /// The trees of the parts without products.
    pub(crate) trees: Option<Arc<TreeStart>>,
    /// The functions of a cube, instead of those of the parts of an image.
    pub(crate) cube: Option<Arc<CubeStart>>,
}

impl Start {
    /// Whether it is of so many parts, each with functions or a tree, and of a cube with this axis if there is
    /// one.
    pub(crate) fn serves(&self, parts: usize, axis: Option<&EnergyAxis>) -> bool {
        if let Some(cube) = &self.cube {
            return axis == Some(&cube.axis)
                && cube.functions.iter().all(|functions| functions.len() == parts);
        }
        let has_tree = |part| self.trees.as_ref().is_some_and(|trees| trees.has_part(part));
        let of_trees = self.trees.as_ref().map(|trees| trees.axis.as_ref());
        self.functions.len() == parts
            && (0..parts).all(|part| self.functions[part].is_some() || has_tree(part))
            && of_trees.unwrap_or(None) == axis
    }

    /// Whether some part has functions.
    pub(crate) fn has_functions(&self) -> bool {
        self.functions.iter().any(Option::is_some) || self.cube.is_some()
    }

    /// The number of triples of pivots of all parts, with so many probes of each, and of the depths of
    /// trees.
    pub(super) fn points(&self, probes: usize) -> usize {
        let of_part = |Functions(of): &Functions| of.ranks().iter().product::<usize>() + probes;
        let of_cube = self.cube.iter().flat_map(|cube| cube.functions.iter().flatten());
        let functions = self.functions.iter().chain(of_cube).flatten();
        let of_functions: usize = functions.map(of_part).sum();
        of_functions + self.trees.as_ref().map_or(0, |trees| trees.samples())
    }
}
