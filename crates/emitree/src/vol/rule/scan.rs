//! The image tree of a layer with its lines, and where they are sampled.

use crate::vol::dyadic::Place;
use crate::vol::error_weights::WeightsOfSquares;
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
    /// The weights of errors in squares of the image; `None` if all are 1.
    pub(crate) weights: Option<WeightsOfSquares>,
}

impl Scan<'_> {
    /// Adds nodes without radiances.
    pub(crate) fn add(&mut self, places: &[Place]) {
        places.iter().for_each(|&place| self.tree.add(place));
        let first = self.node_lines.lines.len();
        self.node_lines.grow(self.tree.len());
        self.weigh_lines(first);
    }

    /// Replaces the weights of errors.
    pub(crate) fn set_weights(&mut self, weights: WeightsOfSquares) {
        self.weights = Some(weights);
        self.weigh_lines(0);
    }

    /// Sets the weights of the lines from number `first` on. The error of a line affects the image up to
    /// the next nodes of its level.
    fn weigh_lines(&mut self, first: usize) {
        let Some(weights) = &self.weights else { return };
        let nodes = self.tree.nodes()[first..].iter();
        let of_lines = self.node_lines.error_weights[first..].iter_mut();
        of_lines.zip(nodes).for_each(|(of, node)| *of = weights.around(node.place, node.level));
    }

    /// The weight of the error of a line at a place among nodes of `level`.
    pub(crate) fn weight_around(&self, place: Place, level: u8) -> f64 {
        self.weights.as_ref().map_or(1.0, |weights| weights.around(place, level))
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
