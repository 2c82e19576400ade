//! The error allowed while the view is divided for the first time, from the cells so far.
//!
//! The columns of the first lattice tell little of the largest pixel: a sheet that is thinner than the steps along
//! them is on few of its corners, and a shape that is smaller than its cells on none. Displacements allowed follow
//! from the largest pixel. The image of the cells of each level is therefore computed from the patches found by then,
//! which needs no evaluation, and cells whose patches were accepted with larger displacements are looked at again.

use crate::parallel::prelude::*;
use crate::vol::surfaces::octree::{Cell, Facet, HIDDEN, Label, Leaf, Octree};
use crate::vol::surfaces::rays::{Ray, Segment};
use crate::vol::surfaces::search::{Guess, Search};
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// About the most lines of sight of such an image.
const LINES: usize = 2048;
/// The level of the cells in which a region has one value.
const LEVEL_OF_RATES: u8 = 2;

/// A line through the cells so far.
struct RoughLine {
    pixel: usize,
    xy: [f64; 2],
    segments: Vec<Segment>,
    /// The integral in cells without patches.
    rest: f64,
}

impl RoughLine {
    /// The middles of its segments in view, with their regions and lengths.
    fn parts(&self) -> impl Iterator<Item = ([f64; 3], Label, f64)> + '_ {
        let [x, y] = self.xy;
        let part = move |&Segment { label, ends: [from, to] }: &Segment| {
            ([x, y, 0.5 * (from + to)], label, to - from)
        };
        self.segments.iter().map(part).filter(|(_, label, _)| *label != HIDDEN)
    }
}

impl Search<'_> {
    /// Sets the error allowed by the image of the leaves and of the cells of a level that are to be divided, of which
    /// the children are given.
    pub(super) fn retarget(&mut self, level: u8, children: &BTreeMap<[u32; 3], Guess>) {
        let largest = self.largest_so_far(level, children);
        if largest > 0.0 && largest.is_finite() {
            let target = self.tolerance * largest;
            let ratio = (target / self.aim.target).min(1.0);
            self.samples.negligible *= ratio;
            self.aim.target = target;
        }
    }

    /// Takes the leaves away whose patches were accepted with displacements that are too large now. Returns them with
    /// these patches.
    pub(super) fn take_loose(&mut self) -> Vec<(Cell, Guess)> {
        let is_loose = |(cell, leaf): &(&Cell, &Leaf)| {
            let Leaf::Cut(facets) = leaf else { return false };
            let (size, centre) = (self.grid.cell_size(cell.0), self.grid.centre(**cell));
            facets.iter().any(|of| {
                let patches = of.wall.patches().iter();
                let now = patches
                    .map(|patch| self.aim.displacement(&self.grid, patch, (size, centre), of.jump));
                of.allowed > TUNING.surfaces.loose * now.fold(f64::INFINITY, f64::min)
            })
        };
        let loose: Vec<Cell> = self.leaves.iter().filter(is_loose).map(|(cell, _)| *cell).collect();
        loose.into_iter().filter_map(|cell| Some((cell, self.take(cell, 1.0)?))).collect()
    }

    /// Takes a leaf with patches away. Returns these, for the same cell with a share of the displacements allowed.
    pub(super) fn take(&mut self, cell: Cell, share: f64) -> Option<Guess> {
        match self.leaves.remove(&cell)? {
            Leaf::Cut(facets) => {
                Some(Guess { facets: Some(facets.into()), share, is_refuted: false })
            }
            other => {
                self.leaves.insert(cell, other);
                None
            }
        }
    }

    /// About the largest pixel.
    fn largest_so_far(&self, level: u8, children: &BTreeMap<[u32; 3], Guess>) -> f64 {
        let tree = self.rough_tree(level, children);
        let pixels = self.aim.scale.pixels();
        let stride = pixels.len().div_ceil(LINES).max(1);
        let seen: Vec<usize> =
            (0..pixels.len()).step_by(stride).filter(|pixel| pixels[*pixel] != 0.0).collect();
        let line = |&pixel: &usize| {
            let ([x, y], _) = self.aim.line(pixel, [0.5; 2]);
            let xy = [x * self.grid.edges[0], y * self.grid.edges[1]];
            let Ray { segments, unresolved, .. } =
                Ray::new(&tree, xy, self.aim.ends_of_line(&self.grid, xy));
            RoughLine { pixel, xy, segments, rest: unresolved }
        };
        let lines: Vec<RoughLine> = seen.par_iter().map(line).collect();
        // One rate for each region of a cell: that at the first segment in it.
        let key = |(at, label, _): (_, Label, _)| (self.grid.cell_at(LEVEL_OF_RATES, at), label);
        let mut numbers: FxHashMap<([u32; 3], Label), usize> = FxHashMap::default();
        let mut places: Vec<([f64; 3], Label)> = Vec::new();
        for part in lines.iter().flat_map(RoughLine::parts) {
            numbers.entry(key(part)).or_insert_with(|| {
                places.push((part.0, part.1));
                places.len() - 1
            });
        }
        let rates = places.par_iter().map(|(at, label)| self.samples.rate_near(*at, *label));
        let rates: Vec<f64> = rates.collect();
        let rate = |part| numbers.get(&key(part)).map_or(0.0, |&number| rates[number]);
        let mut largest: f64 = 0.0;
        for line in &lines {
            let sum = line.parts().fold(line.rest, |sum, part| sum + rate(part) * part.2);
            largest = largest.max((sum / self.grid.edges[2] * pixels[line.pixel]).abs());
        }
        largest
    }

    /// The leaves so far, with the cells that are to be divided: those without patches have the mean of G at their
    /// corners.
    fn rough_tree(&self, level: u8, children: &BTreeMap<[u32; 3], Guess>) -> Octree {
        let mut leaves = self.current_leaves();
        for (_, leaf) in &mut leaves {
            if let Leaf::Unresolved(_, jump) = leaf {
                *jump = 0.0;
            }
        }
        let parents: BTreeMap<[u32; 3], &Guess> =
            children.iter().map(|(at, guess)| (at.map(|k| k / 2), guess)).collect();
        for (at, guess) in parents {
            let cell = (level, at);
            let current = |of: &Facet| {
                let [below, above] = [of.below, of.above].map(|label| self.samples.current(label));
                Facet { below, above, ..of.clone() }
            };
            let leaf = match &guess.facets {
                Some(facets) => Leaf::Cut(facets.iter().map(current).collect()),
                // A ray counts half of the jump in it.
                None => Leaf::Unresolved(HIDDEN, 2.0 * self.mean_of_corners(cell)),
            };
            leaves.push((cell, leaf));
        }
        Octree::new(self.grid, leaves)
    }

    fn mean_of_corners(&self, cell: Cell) -> f64 {
        let corners = self.corners_of(cell);
        let rates = corners.iter().filter_map(|corner| self.corners.get(corner));
        0.125 * rates.map(|&i| self.samples.get(i).rate).sum::<f64>()
    }
}
