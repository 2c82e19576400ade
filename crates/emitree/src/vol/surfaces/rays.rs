//! Lines of sight through the leaves: segments in regions, and crossings of surfaces.

use crate::vol::surfaces::beam::{Beam, Content};
use crate::vol::surfaces::crossings::find_crossings;
use crate::vol::surfaces::octree::{Facet, HIDDEN, Label, Octree, is_smooth, region};
use crate::vol::surfaces::patch::Patch;
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
    /// For each crossing its depth, the error of the integral, and the displacement along z.
    pub(super) crossings: Vec<[f64; 3]>,
    /// The error due to cells that remain unresolved, and their numbers.
    pub(super) unresolved: f64,
    pub(super) unresolved_leaves: Vec<usize>,
    /// Room for the depths of crossings in one cell.
    depths: Vec<f64>,
}

/// What a line contributes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LineIntegral {
    pub(super) value: f64,
    pub(super) error: f64,
}

impl Ray {
    /// The line at a place of the image between two depths.
    pub(super) fn new(tree: &Octree, xy: [f64; 2], ends: [f64; 2]) -> Self {
        let mut ray = Self::default();
        ray.follow(&Beam::new(tree, [xy; 2]), xy, ends);
        ray
    }

    /// Becomes the line at a place of a beam between two depths.
    pub(super) fn follow(&mut self, beam: &Beam<'_>, xy: [f64; 2], [from, end]: [f64; 2]) {
        self.segments.clear();
        self.crossings.clear();
        self.unresolved = 0.0;
        self.unresolved_leaves.clear();
        let mut z = 0.0;
        if from > 0.0 {
            self.extend(HIDDEN, [0.0, from]);
            z = from;
        }
        for part in beam.parts(xy) {
            if z >= end {
                break;
            }
            let top = part.top.min(end);
            if top <= z {
                continue;
            }
            match &part.content {
                Content::Region(label) => self.extend(*label, [z, top]),
                Content::Unresolved(label, jump, leaf) => {
                    self.extend(*label, [z, top]);
                    self.unresolved += 0.5 * jump * (top - z);
                    self.unresolved_leaves.push(*leaf);
                }
                Content::Cut(facets, crossed) => self.cross(facets, crossed, xy, [z, top]),
            }
            z = top;
        }
    }

    fn extend(&mut self, label: Label, ends: [f64; 2]) {
        match self.segments.last_mut() {
            Some(last) if last.label == label => last.ends[1] = ends[1],
            _ => self.segments.push(Segment { label, ends }),
        }
    }

    /// Adds the segments in a cell with patches, of which some may be crossed.
    fn cross(
        &mut self,
        facets: &[Facet],
        crossed: &[&Patch],
        [x, y]: [f64; 2],
        [from, to]: [f64; 2],
    ) {
        let mut depths = core::mem::take(&mut self.depths);
        find_crossings(crossed, [x, y], [from, to], &mut depths);
        let mut last: Option<Label> = None;
        let mut low = from;
        for high in depths.iter().copied().chain([to]) {
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
        self.depths = depths;
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
        // Patches are wrong by more between their points. Smooth ones have been compared with their neighbours more closely.
        let margin = match is_smooth(facets) {
            true => TUNING.surfaces.smooth_margin,
            false => TUNING.surfaces.crossing_margin,
        };
        self.crossings.push([at[2], margin * facet.jump * along, along]);
    }

    /// The error of the integral due to the surfaces, whose own errors are independent of each other.
    pub(super) fn error_of_surfaces(&self) -> f64 {
        let squares: f64 = self.crossings.iter().map(|[_, error, _]| error * error).sum();
        self.unresolved + squares.sqrt()
    }
}

#[cfg(test)]
mod tests;
