//! Lines of sight through the leaves: segments in regions, and crossings of surfaces.

use crate::vol::surfaces::crossings::crossings;
use crate::vol::surfaces::octree::{Facet, Label, Leaf, Octree, region};
use crate::vol::surfaces::pieces::Pieces;
use crate::vol::tuning::TUNING;

/// A part of a line in one region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    pub(super) label: Label,
    pub(super) ends: [f64; 2],
}

/// A line of sight through the leaves.
#[derive(Clone, Debug, Default)]
pub(super) struct Ray {
    pub(super) segments: Vec<Segment>,
    /// For each crossing its depth, the error of the integral that is allowed, and the displacement along z.
    pub(super) crossings: Vec<[f64; 3]>,
    /// The error due to cells that remain unresolved, and their numbers.
    pub(super) unresolved: f64,
    pub(super) unresolved_leaves: Vec<usize>,
}

/// What a line contributes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LineIntegral {
    pub(super) value: f64,
    pub(super) error: f64,
}

impl Ray {
    /// The line at a place of the image, to the depth `end`.
    pub(super) fn new(tree: &Octree, [x, y]: [f64; 2], end: f64) -> Self {
        let mut ray = Self::default();
        let mut z = 0.0;
        let beside = 1e-12 * tree.grid.edges[2];
        while z < end - beside {
            let number = tree.find([x, y, z + beside]);
            let [_, top] = tree.ends(number, 2);
            let top = if top > z { top.min(end) } else { end };
            match &tree.leaves[number].1 {
                Leaf::Uncut(label) => ray.extend(*label, [z, top]),
                Leaf::Unresolved(label, jump) => {
                    ray.extend(*label, [z, top]);
                    ray.unresolved += 0.5 * jump * (top - z);
                    ray.unresolved_leaves.push(number);
                }
                // Only the end of a line is near a hidden cell.
                Leaf::Hidden => {}
                Leaf::Cut(facets) => ray.cross(facets, [x, y], [z, top]),
            }
            z = top;
        }
        ray
    }

    fn extend(&mut self, label: Label, ends: [f64; 2]) {
        match self.segments.last_mut() {
            Some(last) if last.label == label => last.ends[1] = ends[1],
            _ => self.segments.push(Segment { label, ends }),
        }
    }

    /// Adds the segments in a cell with patches.
    fn cross(&mut self, facets: &[Facet], [x, y]: [f64; 2], [from, to]: [f64; 2]) {
        let mut last: Option<Label> = None;
        let mut low = from;
        for high in crossings(facets, [x, y], [from, to]).into_iter().chain([to]) {
            if high <= low {
                continue;
            }
            let (label, _) = region(facets, [x, y, 0.5 * (low + high)]);
            if let Some(before) = last.filter(|before| *before != label) {
                self.add_crossing(facets, [before, label], [x, y, low]);
            }
            self.extend(label, [low, high]);
            last = Some(label);
            low = high;
        }
    }

    fn add_crossing(&mut self, facets: &[Facet], sides: [Label; 2], at: [f64; 3]) {
        let between = |of: &&Facet| sides.contains(&of.below) && sides.contains(&of.above);
        let Some(facet) = facets.iter().find(between).or(facets.first()) else { return };
        let slope = facet.wall.normal(at)[2].abs();
        let error = facet.error.max(facet.allowed);
        // A displacement of a surface that a line touches moves the ends of a chord by its root. A surface
        // that is parallel to the lines may go on beyond the cell: the longest edge of a view is 1.
        let tangent = (2.0 * error * facet.wall.patch_at(at).curvature()).sqrt();
        let along = (error / slope.max(tangent).max(1e-9)).min(1.0);
        self.crossings.push([at[2], facet.jump * along, along]);
    }

    /// The integral of the pieces along the line, over the canonical depth.
    pub(super) fn integral(
        &self,
        pieces: &[Option<Pieces>],
        xy: [f64; 2],
        depth: f64,
    ) -> LineIntegral {
        let mut sum = [0.0, self.unresolved];
        // The errors of patches are independent of each other.
        let squares: f64 = self.crossings.iter().map(|[_, error, _]| error * error).sum();
        sum[1] += TUNING.surfaces.crossing_margin * squares.sqrt();
        for segment in &self.segments {
            if let Some(of) = pieces.get(usize::from(segment.label)).and_then(Option::as_ref) {
                let [value, error] = of.integral(xy, segment.ends);
                sum = [sum[0] + value, sum[1] + error];
            }
        }
        LineIntegral { value: sum[0] / depth, error: sum[1] / depth }
    }
}

#[cfg(test)]
mod tests;
