//! A rendering with what this command alone has of it: counts, and the tree.

use super::counts::Counts;
use emitree::result::{RenderStats, RenderedTree};
use emitree::{Cube, Rendering};
use emitree_io::{RenderedScene, Report, Scene};
use std::ops::Deref;

/// A rendering of a scene, in its quantity, and its cost.
#[derive(Debug)]
pub(crate) struct Rendered {
    rendered: RenderedScene,
    /// A bound for the error of the image of the whole energy band.
    pub(crate) band_error: Option<Cube>,
    /// The counts of the instrument of the scene, if it has one.
    pub(crate) counts: Option<Counts>,
    /// The cost of the rendering.
    pub(crate) stats: RenderStats,
    pub(crate) tree: Option<RenderedTree>,
}

impl Deref for Rendered {
    type Target = RenderedScene;

    fn deref(&self) -> &RenderedScene {
        &self.rendered
    }
}

impl Rendered {
    pub(crate) fn new(scene: &Scene, found: Rendering<Cube>, counts: Option<Counts>) -> Self {
        let rendered = RenderedScene::new(scene, &found);
        let band_error = rendered.band_error();
        Self { rendered, band_error, counts, stats: found.stats, tree: found.tree }
    }

    /// The report of the rendering and its counts.
    pub(crate) fn report(&self) -> Report<'_> {
        self.rendered.report(self.counts.as_ref().map(|counts| counts.report(&self.account)))
    }
}
