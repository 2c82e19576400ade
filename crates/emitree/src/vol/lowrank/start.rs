//! What a rendering leaves for those of other emissions: the charts of its view, and the functions or the image
//! tree of each part.
//!
//! The functions of one G often serve another one: what differs is in the values at the pivots. The residuals
//! at scattered samples show whether they do, as for a G of their own.

use crate::energy::EnergyAxis;
use crate::projection::charts::stretch::Stretch;
use crate::projection::charts::{Atlas, FittedDepth, FoundCut, FoundEdge};
use crate::vol::lowrank::interpolant::Interpolant;
use crate::vol::spectrum::energies::Energies;
use crate::vol::view::tree_start::TreeStart;
use std::sync::Arc;

/// How a view is divided, as samples of G have shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Division {
    /// Surfaces at which the emission begins.
    pub(crate) edges: Vec<FoundEdge>,
    /// Azimuths at which charts end.
    pub(crate) cuts: Vec<FoundCut>,
    /// Whether the depths of charts are divided at the points nearest to a centre.
    pub(crate) is_halved: bool,
    /// The weights of the coordinates of depth in some charts.
    pub(crate) depths: Vec<FittedDepth>,
    /// The stretch of the depth of an image plane.
    pub(crate) stretch: Option<Stretch>,
    /// Whether lines are divided by the faces at which they enter and leave bounds that are a box.
    pub(crate) is_by_faces: bool,
    /// The least cosine between the line of sight in the middle and the normals of planes that divide the image plane
    /// into layers, if they do.
    pub(crate) layered_from: Option<f64>,
}

impl Division {
    /// Whether an atlas of a view has all surfaces and charts that are named.
    pub(crate) fn fits(&self, atlas: Option<&Atlas<'_>>) -> bool {
        let Some(atlas) = atlas else { return self.cuts.is_empty() && self.depths.is_empty() };
        self.cuts.iter().all(|cut| atlas.has_shells(cut.shells))
            && self.depths.iter().all(|fitted| atlas.has_shells(fitted.shells))
    }
}

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
