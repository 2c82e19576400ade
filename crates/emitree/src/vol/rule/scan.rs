//! The image tree of a layer with its lines, and where they are sampled.

use crate::vol::dyadic::{Place, around, spacing, unit};
use crate::vol::image::tree::{Around, ImageTree};
use crate::vol::line::node_lines::{LineSource, NodeLines, Wanted};
use crate::vol::sampling::{Stop, View};
use crate::vol::seeds::SeedTargets;

/// The number of steps between a closed node and its neighbours on its lattice at which open places
/// are searched for. Narrower parts of the image are found where they are wider, or contribute
/// little to a pixel.
const BETWEEN: i8 = 4;

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
    /// Whether places outside the view are not evaluated.
    pub(crate) skips_closed: bool,
}

impl Scan<'_> {
    /// Adds nodes without radiances.
    pub(crate) fn add(&mut self, places: &[Place]) {
        let first = self.tree.len();
        places.iter().for_each(|&place| self.tree.add(place));
        self.node_lines.grow(self.tree.len());
        if self.skips_closed {
            for (i, &place) in (first..).zip(places) {
                if !self.view.layer.is_open(place.map(unit)) {
                    self.node_lines.sources[i] = LineSource::Closed;
                    let around = self.open_around(place, self.tree.nodes()[i].level);
                    self.tree.set_around(i, around);
                }
            }
        }
    }

    /// The open places around a closed place of a level, from the geometry of the view without an
    /// evaluation.
    fn open_around(&self, place: Place, level: u8) -> Around {
        let is_open = |distance: u32, reach: i8| {
            let mut places = around(place, distance, reach);
            places.any(|(_, _, at)| self.view.layer.is_open(at.map(unit)))
        };
        let step = spacing(level);
        if is_open(step, 1) {
            return Around::Beside;
        }
        let finer = step / u32::from(BETWEEN.unsigned_abs());
        if finer > 0 && is_open(finer, BETWEEN) { Around::Between } else { Around::Closed }
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
