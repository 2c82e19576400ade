//! How a view is divided into parts, as samples of G have shown, and the charts that follow.

use crate::projection::charts::stretch::Stretch;
use crate::projection::charts::{Atlas, FittedDepth, FoundCut, FoundEdge};
use crate::tile::Tile;
use crate::vol::tuning::is_plane_forced;

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

    /// The atlas of a view that is divided so; `None` without limbs, and without faces that divide it.
    pub(crate) fn atlas<'a>(&self, tiles: &[Tile<'a>]) -> Option<Atlas<'a>> {
        let atlas = match self.is_by_faces {
            true => atlas_of_box(tiles),
            false => atlas(tiles, &self.edges)
                .map(|atlas| atlas.with_weights(&self.depths).with_cuts(&self.cuts)),
        };
        let atlas = if self.is_halved { atlas.map(Atlas::with_halves) } else { atlas };
        match self.layered_from {
            // Layers of the image plane need fewer evaluations than those of angles about the centre.
            Some(from) => {
                atlas.filter(|atlas| !atlas.is_inside_bounds()).map(|atlas| atlas.with_layers(from))
            }
            None => atlas,
        }
    }
}

/// The atlas of a view with the edges found, if there are limbs.
pub(crate) fn atlas<'a>(tiles: &[Tile<'a>], found: &[FoundEdge]) -> Option<Atlas<'a>> {
    if is_plane_forced() {
        return None;
    }
    let planes = tiles.iter().filter_map(|tile| tile.projection.view_geometry());
    Atlas::new(planes.collect(), tiles.first()?.shape, found)
}

/// The atlas of a view whose only surfaces are those of bounds that are a box.
pub(crate) fn atlas_of_box<'a>(tiles: &[Tile<'a>]) -> Option<Atlas<'a>> {
    let planes = tiles.iter().filter_map(|tile| tile.projection.view_geometry());
    Atlas::of_box(planes.collect())
}
