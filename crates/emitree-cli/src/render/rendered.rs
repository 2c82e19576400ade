//! A rendering in the quantity of its scene: image or cube, error, counts, cost.

use super::counts::Counts;
use super::map::Map;
use emitree::result::{RenderStats, RenderedTree};
use emitree::{Cube, Rendering, StopReason};
use emitree_io::Scene;

/// A rendering of a scene, in its quantity, and its cost.
#[derive(Debug)]
pub(crate) struct Rendered {
    /// The image or the cube.
    pub(crate) map: Map,
    /// The estimated error of each value, if the method has one.
    pub(crate) error: Option<Map>,
    /// The image of the whole energy band, if there are energies.
    pub(crate) band: Option<Map>,
    /// A bound for the error of that image.
    pub(crate) band_error: Option<Map>,
    /// The counts of the instrument of the scene, if it has one.
    pub(crate) counts: Option<Counts>,
    /// The cost of the rendering.
    pub(crate) stats: RenderStats,
    pub(crate) evaluations_per_pixel: Map,
    pub(crate) tree: Option<RenderedTree>,
}

impl Rendered {
    pub(crate) fn new(scene: &Scene, rendering: Rendering<Cube>, counts: Option<Counts>) -> Self {
        let map = |cube: &Cube| Map::of_scene(scene, scene.cube_in_quantity(cube));
        let (values, error) = (map(&rendering.values), rendering.error.as_ref().map(map));
        Self {
            band: values.whole_band(scene),
            band_error: error.as_ref().and_then(|error| error.whole_band(scene)),
            counts,
            map: values,
            error,
            evaluations_per_pixel: rendering.stats.evaluations_per_pixel.to_image().into(),
            stats: rendering.stats,
            tree: rendering.tree,
        }
    }

    /// How many energies were evaluated, if the method takes some.
    pub(crate) fn energies(&self) -> Option<usize> {
        Some(self.stats.energies.len()).filter(|&energies| energies > 0)
    }

    /// Whether the stopping criterion was met.
    pub(crate) fn converged(&self) -> bool {
        self.stats.ending == StopReason::Complete
    }

    /// The largest estimated error over the largest |value|.
    pub(crate) fn estimated_error(&self) -> Option<f64> {
        let error = self.error.as_ref()?.cube().largest();
        Some(if error > 0.0 { error / self.map.cube().largest() } else { 0.0 })
    }
}
