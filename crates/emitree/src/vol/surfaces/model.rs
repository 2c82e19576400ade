//! What represents G: the leaves with their surfaces, and the polynomials beside these.

use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::beam::Beam;
use crate::vol::surfaces::octree::{Label, Octree};
use crate::vol::surfaces::pieces::Pieces;
use crate::vol::surfaces::rays::{LineIntegral, Ray, Segment};

/// The surfaces with the pieces beside them.
#[derive(Clone)]
pub(super) struct Model {
    pub(super) tree: Octree,
    /// For each label its pieces.
    pub(super) pieces: Vec<Option<Pieces>>,
}

impl Model {
    /// The place in the grid of the line at a place of a pixel, from 0 to 1, and its weight in the mean.
    pub(super) fn line(&self, aim: &Aim<'_>, pixel: usize, place: [f64; 2]) -> ([f64; 2], f64) {
        let edges = self.tree.grid.edges;
        let ([x, y], weight) = aim.line(pixel, place);
        ([x * edges[0], y * edges[1]], weight)
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

    /// The lines of a pixel, if they are those of a rectangle.
    pub(super) fn beam(&self, aim: &Aim<'_>, pixel: usize) -> Option<Beam<'_>> {
        let corners = || [[0.0; 2], [1.0; 2]].map(|place| self.line(aim, pixel, place).0);
        aim.sky.is_none().then(|| Beam::new(&self.tree, corners()))
    }

    /// Makes a ray the line at a place of the grid, as far as it is seen: one of a beam, if that is given.
    pub(super) fn follow(
        &self,
        ray: &mut Ray,
        aim: &Aim<'_>,
        beam: Option<&Beam<'_>>,
        xy: [f64; 2],
    ) {
        let ends = aim.ends_of_line(&self.tree.grid, xy);
        match beam {
            Some(beam) => ray.follow(beam, xy, ends),
            None => ray.follow(&Beam::new(&self.tree, [xy; 2]), xy, ends),
        }
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
