//! What a rendering leaves for those of other emissions: the charts of its view, and the functions of each
//! part.
//!
//! The functions of one G often serve another one: what differs is in the values at the pivots. The residuals
//! at scattered samples show whether they do, as for a G of their own.

use crate::projection::charts::depth::Weights;
use crate::projection::charts::stretch::Stretch;
use crate::projection::charts::{Atlas, FoundCut, FoundEdge};
use crate::vol::lowrank::interpolant::Interpolant;
use std::sync::Arc;

/// How a view is divided, as samples of G have shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Division {
    /// Surfaces at which the emission begins.
    pub(crate) edges: Vec<FoundEdge>,
    /// Azimuths at which charts end.
    pub(crate) cuts: Vec<FoundCut>,
    /// The weights of the coordinates of depth in some charts.
    pub(crate) depths: Vec<(usize, Weights)>,
    /// The stretch of the depth of an image plane.
    pub(crate) stretch: Option<Stretch>,
    /// Whether lines are divided by the faces at which they enter and leave bounds that are a box.
    pub(crate) is_by_faces: bool,
}

impl Division {
    /// Whether an atlas of a view has all surfaces and charts that are named.
    pub(crate) fn fits(&self, atlas: Option<&Atlas<'_>>) -> bool {
        let Some(atlas) = atlas else { return self.cuts.is_empty() && self.depths.is_empty() };
        self.cuts.iter().all(|cut| atlas.has_shells(cut.shells))
            && self.depths.iter().all(|(chart, _)| *chart < atlas.len())
    }
}

/// The functions of an interpolant.
#[derive(Clone, Debug)]
pub(crate) struct Functions(pub(super) Arc<Interpolant>);

/// The division of a view and the functions of its parts.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) division: Division,
    /// For each part; `None` if it has no products.
    pub(crate) functions: Vec<Option<Functions>>,
}

impl Start {
    /// Whether all parts have functions.
    pub(crate) fn is_complete(&self) -> bool {
        self.functions.iter().all(Option::is_some)
    }

    /// The number of triples of pivots of all parts.
    pub(super) fn pivots(&self) -> usize {
        let of_part = |Functions(of): &Functions| of.ranks().iter().product::<usize>();
        self.functions.iter().flatten().map(of_part).sum()
    }
}
