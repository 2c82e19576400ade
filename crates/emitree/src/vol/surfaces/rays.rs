//! Lines of sight through the leaves: segments in regions, and crossings of surfaces.

use crate::vol::surfaces::octree::{Facet, Label, Leaf, Octree, region};
use crate::vol::surfaces::pieces::Pieces;
use crate::vol::tuning::TUNING;

/// The parts of a line in a cell in which crossings are searched for.
const PARTS: usize = 6;
/// The steps of a bisection.
const STEPS: usize = 36;

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
    /// The line at a place of the image.
    pub(super) fn new(tree: &Octree, [x, y]: [f64; 2]) -> Self {
        let mut ray = Self::default();
        let end = tree.grid.edges[2];
        let mut z = 0.0;
        let beside = 1e-12 * end;
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
        let label = |z: f64| region(facets, [x, y, z]).0;
        let place = |k: usize| from + (to - from) * k as f64 / PARTS as f64;
        let mut before = (from, label(from));
        for k in 1..=PARTS {
            let next = (place(k), label(place(k)));
            if next.1 == before.1 {
                self.extend(before.1, [before.0, next.0]);
            } else {
                let [mut low, mut high] = [before.0, next.0];
                for _ in 0..STEPS {
                    let middle = 0.5 * (low + high);
                    if label(middle) == before.1 { low = middle } else { high = middle }
                }
                self.extend(before.1, [before.0, low]);
                self.extend(next.1, [low, next.0]);
                self.add_crossing(facets, [before.1, next.1], [x, y, low], to - from);
            }
            before = next;
        }
    }

    fn add_crossing(&mut self, facets: &[Facet], sides: [Label; 2], at: [f64; 3], length: f64) {
        let between = |of: &&Facet| sides.contains(&of.below) && sides.contains(&of.above);
        let Some(facet) = facets.iter().find(between).or(facets.first()) else { return };
        let slope = facet.wall.normal(at)[2].abs();
        let error = facet.error.max(facet.allowed);
        // A displacement of a surface that a line touches moves the ends of a chord by its root.
        let tangent = (2.0 * error * facet.wall.patch_at(at).curvature()).sqrt();
        let along = (error / slope.max(tangent).max(1e-9)).min(length);
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
