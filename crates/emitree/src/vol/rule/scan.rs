//! The image tree of a layer with its lines, and where they are sampled.

use crate::parallel::prelude::*;
use crate::vol::dyadic::{Place, around, spacing};
use crate::vol::error_weights::WeightsOfSquares;
use crate::vol::image::tree::{ImageTree, Node};
use crate::vol::line::node_lines::{LINES_CACHED, NodeLines, Wanted};
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
        self.node_lines.grow(self.tree.len());
        self.weigh_lines(0);
    }

    /// Replaces the weights of errors.
    pub(crate) fn set_weights(&mut self, weights: WeightsOfSquares) {
        self.weights = Some(weights);
        self.weigh_lines(0);
    }

    /// Sets the weights of the lines from number `first` on. The error of a line affects the image up to
    /// the next nodes.
    fn weigh_lines(&mut self, first: usize) {
        let Some(weights) = &self.weights else { return };
        let nodes = &self.tree.nodes()[first..];
        let of_node = |node: &Node| weights.around(node.place, self.level_of_next(node));
        let found: Vec<f64> = nodes.par_iter().with_min_len(LINES_CACHED).map(of_node).collect();
        self.node_lines.error_weights[first..].copy_from_slice(&found);
    }

    /// The finest level for which a node has a neighbour in all directions.
    pub(crate) fn level_of_next(&self, node: &Node) -> u8 {
        let has_all = |level: &u8| {
            let mut next = around(node.place, spacing(*level), 1);
            next.all(|(_, _, place)| self.tree.find(place).is_some())
        };
        let finer = (node.level + 1..=self.tree.finest_level()).take_while(has_all);
        finer.last().unwrap_or(node.level)
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
