//! The layers of a view that are visible in some pixels.

use crate::image::Image;
use crate::projection::Layer;
use crate::tile::Tile;
use crate::vol::view::fractions::{CoverageFractions, Regions};
use std::sync::Arc;

/// A layer that is visible in some pixels.
pub(crate) struct Visible<'a> {
    /// The number of its tile.
    pub(crate) tile: usize,
    pub(crate) layer: &'a dyn Layer,
    /// The number of visible layers of its tile.
    pub(crate) layers_of_tile: usize,
    pub(crate) fractions: Option<Arc<CoverageFractions>>,
    /// For each pixel, the ratio of its radiance to the mean of the irradiance density, times the
    /// mean coverage fraction.
    pub(crate) scale: Arc<Image>,
}

/// The visible layers of all tiles, in the order of the tiles. Layers without a visible pixel are
/// left out: the far side of a body that fills the view, or the shadow of one on another tile.
/// `scales` are the ratios of the radiance to the mean of the irradiance density; those of pixels
/// that a rim crosses are computed anew.
pub(crate) fn visible_layers<'a>(
    tiles: &[Tile<'_>],
    layers: &'a [Vec<Box<dyn Layer + 'a>>],
    scales: &mut [Image],
) -> Vec<Visible<'a>> {
    let mut visible: Vec<Visible<'a>> = Vec::new();
    for (number, (tile, layers)) in tiles.iter().zip(layers).enumerate() {
        let regions = Regions::of(tile.projection, tile.shape);
        if let Some(regions) = &regions {
            scales[number] = regions.scale(tile.projection, &scales[number]);
        }
        let first = visible.len();
        for layer in layers {
            let layer: &dyn Layer = &**layer;
            let fractions = regions.as_ref().map(|regions| CoverageFractions::new(layer, regions));
            if fractions.as_ref().is_some_and(|fractions| fractions.reach.largest() == 0.0) {
                continue;
            }
            let mut scale = scales[number].clone();
            if let Some(fractions) = &fractions {
                let reached = scale.pixels_mut().iter_mut().zip(fractions.reach.pixels());
                reached.for_each(|(scale, reach)| *scale *= reach);
            }
            let (fractions, scale) = (fractions.map(Arc::new), Arc::new(scale));
            visible.push(Visible { tile: number, layer, layers_of_tile: 0, fractions, scale });
        }
        let of_tile = visible.len() - first;
        visible[first..].iter_mut().for_each(|layer| layer.layers_of_tile = of_tile);
    }
    visible
}
