//! The image tree of a layer with its lines, and where they are sampled.

use crate::vol::dyadic::Place;
use crate::vol::image::tree::ImageTree;
use crate::vol::line::node_lines::{NodeLines, Wanted};
use crate::vol::sampling::{Stop, View};
use crate::vol::seeds::SeedTargets;

/// An image tree, its lines, and the view in which they are sampled.
pub(crate) struct Scan<'a> {
    pub(crate) view: View<'a>,
    pub(crate) base_level: u8,
    /// Every full line has all depths of the lattice of this level. It is the base level, or a
    /// finer one after a verification has found structure between the depths.
    pub(crate) depth_level: u8,
    pub(crate) tree: ImageTree,
    pub(crate) node_lines: NodeLines,
    /// Structures that the options name: their nodes are integrated in full, since no rule has been
    /// fitted to them.
    pub(crate) seeds: SeedTargets,
}

impl Scan<'_> {
    /// Adds nodes without radiances.
    pub(crate) fn add(&mut self, places: &[Place]) {
        places.iter().for_each(|&place| self.tree.add(place));
        self.node_lines.grow(self.tree.len());
    }

    /// Removes all nodes but the first `len`.
    pub(crate) fn truncate(&mut self, len: usize) {
        self.tree.truncate(len);
        self.node_lines.truncate(len);
    }

    /// Samples the depths and refines the lines until each is within `tolerance`.
    pub(crate) async fn refine(&mut self, wanted: Wanted, tolerance: f64) -> Result<(), Stop> {
        self.node_lines.refine(&self.view, &self.tree, wanted, tolerance, self.depth_level).await
    }

    /// Samples structure found on the given full lines on their neighbours.
    pub(crate) async fn follow(&mut self, found: &[usize], tolerance: f64) -> Result<(), Stop> {
        self.node_lines.follow(&self.view, &self.tree, found, tolerance, self.depth_level).await
    }
}
