//! Parts of a line of sight in which its region is not certain, as surfaces may be displaced.
//!
//! A pixel is a mean over lines, and a surface that is displaced changes few of them. A line alone may touch a surface that
//! the model has just beside it, or miss one that is there. The regions on the line in each cell with patches are therefore
//! compared with those on lines that are displaced by the error of the patches.

use crate::vol::surfaces::crossings::find_crossings;
use crate::vol::surfaces::model::Model;
use crate::vol::surfaces::octree::{Facet, Label, Leaf, region};
use crate::vol::surfaces::patch::Patch;
use crate::vol::tuning::TUNING;
use core::f64::consts::TAU;

/// The directions in which lines are displaced.
const DIRECTIONS: usize = 8;

/// An uncertain part of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Uncertain {
    /// Its ends along z.
    pub(super) ends: [f64; 2],
    /// The error of the integral over it, in the unit of the grid.
    pub(super) error: f64,
    /// Whether it is all of a cell whose regions are not known.
    is_unresolved: bool,
}

/// The error of parts together: displacements in different cells are independent of each other.
pub(super) fn error_of(parts: &[Uncertain]) -> f64 {
    parts.iter().map(|of| of.error * of.error).sum::<f64>().sqrt()
}

/// A line between two depths in a cell with patches.
struct InCell<'a> {
    facets: &'a [Facet],
    patches: Vec<&'a Patch>,
    ends: [f64; 2],
}

impl Model {
    /// The uncertain parts of the line at a place of the grid, between two depths: ascending and apart from each other.
    pub(super) fn uncertain(&self, xy: [f64; 2], [begin, end]: [f64; 2]) -> Vec<Uncertain> {
        let farthest = self.cut(xy, xy).map(|(_, facets)| displacement(facets));
        let farthest = farthest.fold(0.0, f64::max);
        let [low, high] = [-farthest, farthest].map(|by| xy.map(|along| along + by));
        let mut found = Vec::new();
        for (number, facets) in self.cut(low, high) {
            let [bottom, top] = self.tree.ends(number, 2);
            if bottom < end && top > begin {
                let patches = facets.iter().flat_map(|of| of.wall.patches()).collect();
                let cell = InCell { facets, patches, ends: [bottom.max(begin), top.min(end)] };
                found.extend(cell.uncertain(xy));
            }
        }
        let places = self.tree.grid.places(xy);
        for number in self.tree.passed([places; 2]) {
            let [bottom, top] = self.tree.ends(number, 2);
            if let Leaf::Unresolved(_, jump) = &self.tree.leaves[number].1
                && bottom < end
                && top > begin
            {
                // All of the jump may be missing.
                let ends = [bottom.max(begin), top.min(end)];
                let error = jump * (ends[1] - ends[0]);
                found.push(Uncertain { ends, error, is_unresolved: true });
            }
        }
        found.sort_by(|a, b| a.ends[0].total_cmp(&b.ends[0]));
        found.dedup_by(|next, before| {
            let meets = next.ends[0] <= before.ends[1];
            if meets {
                before.ends[1] = before.ends[1].max(next.ends[1]);
                before.is_unresolved &= next.is_unresolved;
                before.error = match before.is_unresolved {
                    true => before.error + next.error,
                    false => before.error.hypot(next.error),
                };
            }
            meets
        });
        found
    }

    /// The leaves with patches that lines in a rectangle pass.
    fn cut(&self, low: [f64; 2], high: [f64; 2]) -> impl Iterator<Item = (usize, &[Facet])> {
        let leaves = self.tree.passed([low, high].map(|at| self.tree.grid.places(at)));
        leaves.into_iter().filter_map(|number| match &self.tree.leaves[number].1 {
            Leaf::Cut(facets) => Some((number, &facets[..])),
            _ => None,
        })
    }
}

/// How far the surfaces of a cell may be displaced.
fn displacement(facets: &[Facet]) -> f64 {
    TUNING.surfaces.line_margin * facets.iter().map(|of| of.error).fold(0.0, f64::max)
}

impl InCell<'_> {
    /// The uncertain parts of the line at (x, y), of surfaces that are displaced across the line, and along it; they
    /// may have parts in common. Each has a share of the error of the cell.
    fn uncertain(&self, [x, y]: [f64; 2]) -> Vec<Uncertain> {
        let displacement = displacement(self.facets);
        let mut parts = Vec::new();
        let own = self.regions([x, y]);
        let mut longest: f64 = 0.0;
        for k in 0..DIRECTIONS {
            let (sin, cos) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
            let other = self.regions([x + displacement * cos, y + displacement * sin]);
            let first = parts.len();
            self.add_differences(&own, &other, &mut parts);
            let length: f64 = parts[first..].iter().map(|[low, high]| high - low).sum();
            longest = longest.max(length);
        }
        let crossings = &own[1..];
        let [from, to] = self.ends;
        let around = |z: f64| [(z - displacement).max(from), (z + displacement).min(to)];
        parts.extend(crossings.iter().map(|(_, z)| around(*z)));
        let jump = self.facets.iter().map(|of| of.jump).fold(0.0, f64::max);
        let length = longest + displacement * crossings.len() as f64;
        let error = TUNING.surfaces.crossing_margin * jump * length;
        let squares: f64 = parts.iter().map(|[low, high]| (high - low).powi(2)).sum();
        let of_part = |ends: [f64; 2]| {
            let error = error * (ends[1] - ends[0]) / squares.sqrt().max(f64::MIN_POSITIVE);
            Uncertain { ends, error, is_unresolved: false }
        };
        parts.into_iter().map(of_part).collect()
    }

    /// The regions on the line at (x, y), with the depths at which they begin.
    fn regions(&self, [x, y]: [f64; 2]) -> Vec<(Label, f64)> {
        let (mut depths, mut found) = (Vec::new(), Vec::<(Label, f64)>::new());
        find_crossings(&self.patches, [x, y], self.ends, &mut depths);
        let mut low = self.ends[0];
        for high in depths.into_iter().chain([self.ends[1]]) {
            let (label, _) = region(self.facets, [x, y, 0.5 * (low + high)]);
            if high > low && found.last().is_none_or(|last| last.0 != label) {
                found.push((label, low));
            }
            low = low.max(high);
        }
        if found.is_empty() {
            found.push((region(self.facets, [x, y, low]).0, low));
        }
        found
    }

    /// Adds the parts of a line in which two divisions into regions differ.
    fn add_differences(
        &self,
        one: &[(Label, f64)],
        other: &[(Label, f64)],
        parts: &mut Vec<[f64; 2]>,
    ) {
        let (mut a, mut b, mut low) = (0, 0, self.ends[0]);
        let begins = |of: &[(Label, f64)], k: usize| of.get(k + 1).map_or(self.ends[1], |of| of.1);
        while low < self.ends[1] {
            let (next_a, next_b) = (begins(one, a), begins(other, b));
            let high = next_a.min(next_b);
            if one[a].0 != other[b].0 && high > low {
                parts.push([low, high]);
            }
            a += usize::from(next_a <= high && a + 1 < one.len());
            b += usize::from(next_b <= high && b + 1 < other.len());
            low = high;
        }
    }
}
