//! How the image of a rendering came about, as files tell it.

use super::map::Rendered;
use emitree::Method;
use emitree_io::{Provenance, Scene};

/// How the image came about.
pub(super) fn provenance<'a>(scene: &'a Scene, rendered: &Rendered) -> Provenance<'a> {
    Provenance {
        scene: &scene.name,
        method: scene.render.method.name(),
        evaluations: rendered.stats.evaluations,
        converged: rendered.converged(),
        energies: rendered.energies(),
        tolerance: scene.render.tolerance,
        estimated_error: rendered.estimated_error(),
        threshold: rendered.tree.as_ref().map(|tree| tree.threshold),
        order: match &scene.render.method {
            Method::Paper(options) => Some(options.order),
            _ => None,
        },
        base_level: rendered.stats.base_level,
        length_unit: scene.length_unit.as_deref(),
        is_cube: rendered.map.is_cube(),
    }
}
