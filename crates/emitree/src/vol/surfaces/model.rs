//! What represents G: the leaves with their surfaces, and the polynomials beside these.

use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::beam::Beam;
use crate::vol::surfaces::octree::{Label, Octree};
use crate::vol::surfaces::pieces::Pieces;
use crate::vol::surfaces::rays::{LineIntegral, Segment};

/// The surfaces with the pieces beside them.
#[derive(Clone)]
pub(super) struct Model {
    pub(super) tree: Octree,
    /// For each label its pieces.
    pub(super) pieces: Vec<Option<Pieces>>,
}

impl Model {
    /// The place in the grid of a place of the image, in pixels.
    pub(super) fn place(&self, aim: &Aim<'_>, [column, row]: [f64; 2]) -> [f64; 2] {
        let [height, width] = [aim.scale.height(), aim.scale.width()];
        let edges = self.tree.grid.edges;
        [column / width as f64 * edges[0], row / height as f64 * edges[1]]
    }

    /// The integral of segments of a line at a place of the grid, with the error of its surfaces.
    pub(super) fn integral(
        &self,
        xy: [f64; 2],
        segments: impl Iterator<Item = Segment>,
        error: f64,
    ) -> LineIntegral {
        let mut sum = [0.0, error];
        for segment in segments {
            if let Some(of) = self.pieces.get(usize::from(segment.label)).and_then(Option::as_ref) {
                let [value, error] = of.integral(xy, segment.ends);
                sum = [sum[0] + value, sum[1] + error];
            }
        }
        let [value, error] = sum.map(|of| of / self.tree.grid.edges[2]);
        LineIntegral { value, error }
    }

    /// The lines of a pixel.
    pub(super) fn beam(&self, aim: &Aim<'_>, pixel: usize) -> Beam<'_> {
        let [column, row] = aim.corner(pixel);
        let corners = [[column, row], [column + 1.0, row + 1.0]];
        Beam::new(&self.tree, corners.map(|at| self.place(aim, at)))
    }

    /// G at a point of the grid.
    pub(super) fn value(&self, at: [f64; 3]) -> f64 {
        self.value_of(self.tree.leaf(at).region(at), at)
    }

    /// G of a region at a point of the grid, continued there if the point is outside of the region.
    pub(super) fn value_of(&self, region: Label, at: [f64; 3]) -> f64 {
        let pieces = self.pieces.get(usize::from(region)).and_then(Option::as_ref);
        pieces.map_or(0.0, |of| of.value(at))
    }
}
