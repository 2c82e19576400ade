//! The edges of cells: from corner to corner, or to the place at which bounds or a limb end them.
//!
//! Corners that no line of sight reaches tell nothing about the cell. What is between a surface and the bounds is met
//! by samples at the last points of edges that lines of sight reach.

use crate::projection::vector::{along, difference};
use crate::vol::surfaces::inferred::NewPoints;
use crate::vol::surfaces::search::{Failure, LatticeLine, OpenCell, Search, bit};
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;

/// The halvings of an edge until its end is known.
const HALVINGS: usize = 24;
/// The distance of a sample from the end of an edge, as a share of the edge: more than rounding changes, and much less than
/// the width of a pixel.
const INSET: f64 = 1e-6;

/// An edge of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) line: LatticeLine,
    /// The place of its first corner on the line, and its length, in steps of the finest level.
    pub(super) from: u32,
    step: u32,
    /// The corners of the cell at its ends.
    corners: [usize; 2],
}

impl Edge {
    /// The batch in which its points are found, which does not depend on the cell.
    pub(super) fn batch(&self) -> usize {
        let (axis, [a, b]) = self.line;
        let at: [u32; 3] = match axis {
            0 => [self.from, a, b],
            1 => [a, self.from, b],
            _ => [a, b, self.from],
        };
        let [x, y, z] = at.map(|k| k / self.step);
        ((5 * x + 3 * y + 7 * z) as usize + axis) % TUNING.surfaces.batches
    }
}

/// The edges of a cell whose lowest corner is given.
pub(super) fn edges(low: [u32; 3], step: u32) -> impl Iterator<Item = Edge> {
    let edge = move |(axis, c): (usize, usize)| {
        let corner: [u32; 3] = core::array::from_fn(|k| low[k] + step * bit(c, k));
        let line = (axis, others(axis, corner));
        Edge { line, from: corner[axis], step, corners: [c, c | (1 << axis)] }
    };
    let all = (0..3).flat_map(|axis| (0..8).map(move |c| (axis, c)));
    all.filter(|&(axis, c)| bit(c, axis) == 0).map(edge)
}

/// The places on the other two axes.
fn others(axis: usize, [x, y, z]: [u32; 3]) -> [u32; 2] {
    [[y, z], [x, z], [x, y]][axis]
}

impl Search<'_> {
    /// The ends of an edge that lines of sight reach: their places on the line, and the samples there.
    pub(super) fn ends_of(&self, cell: &OpenCell, edge: &Edge) -> [(f64, usize); 2] {
        let corners = [edge.from, edge.from + edge.step].map(f64::from);
        let samples = edge.corners.map(|corner| cell.corners[corner]);
        let is_hidden = samples.map(|i| self.samples.is_hidden(i));
        let end = self.end_on(edge).filter(|_| is_hidden[0] != is_hidden[1]);
        [0, 1].map(|k| match end {
            Some(end) if is_hidden[k] => end,
            _ => (corners[k], samples[k]),
        })
    }

    /// The end at bounds or a limb on an edge.
    fn end_on(&self, edge: &Edge) -> Option<(f64, usize)> {
        let places = f64::from(edge.from)..=f64::from(edge.from + edge.step);
        let known = self.ends.get(&edge.line).into_iter().flatten();
        known.copied().find(|(at, _)| places.contains(at))
    }

    /// Samples the last points of edges that lines of sight reach, where the other corner is hidden.
    pub(super) async fn sample_ends(
        &mut self,
        level: u8,
        cells: &[OpenCell],
    ) -> Result<(), Failure> {
        if self.aim.visible.is_none() {
            return Ok(());
        }
        let size = self.grid.cell_size(level);
        let (mut new, mut places) = (NewPoints::default(), FxHashMap::default());
        for cell in cells {
            let (low, step) = self.grid.corners(cell.cell);
            for edge in edges(low, step) {
                let [a, b] = self.ends_of(cell, &edge);
                let is_hidden = [a, b].map(|(_, sample)| self.samples.is_hidden(sample));
                if is_hidden[0] == is_hidden[1] {
                    continue;
                }
                let [seen, hidden] = if is_hidden[0] { [b, a] } else { [a, b] };
                let [from, to] = [seen, hidden].map(|(_, sample)| self.samples.get(sample).at);
                let share = self.share_in_view(from, to);
                let point = along(from, share, difference(to, from));
                let key = (edge.line, edge.from);
                places.insert(key, seen.0 + share * (hidden.0 - seen.0));
                new.add(key, point, self.inferred(&cell.guess, point, size));
            }
        }
        let keys: Vec<(LatticeLine, u32)> = new.keys().copied().collect();
        let samples = self.sample_or_infer(new).await?;
        for (key, sample) in keys.into_iter().zip(samples) {
            self.ends.entry(key.0).or_default().push((places[&key], sample));
        }
        Ok(())
    }

    /// Adds the samples at the ends of the edges of a cell to those in it.
    pub(super) fn add_ends(&self, cell: &mut OpenCell) {
        if self.ends.is_empty() {
            return;
        }
        let (low, step) = self.grid.corners(cell.cell);
        for (_, sample) in edges(low, step).filter_map(|edge| self.end_on(&edge)) {
            if !cell.inside.contains(&sample) {
                cell.inside.push(sample);
            }
        }
    }

    /// The share of an edge up to a point just before its end, of which the first point is seen and the last one is not.
    fn share_in_view(&self, from: [f64; 3], to: [f64; 3]) -> f64 {
        let [mut seen, mut hidden] = [0.0, 1.0];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (seen + hidden);
            let is_hidden = self.hides(along(from, middle, difference(to, from)));
            *(if is_hidden { &mut hidden } else { &mut seen }) = middle;
        }
        f64::max(seen - INSET, 0.0)
    }
}
