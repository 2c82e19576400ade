//! Points of surfaces on the edges of cells whose ends are in different regions.

use crate::projection::vector::{along, difference, norm};
use crate::vol::surfaces::octree::{Facet, HIDDEN};
use crate::vol::surfaces::roots::RootSearch;
use crate::vol::surfaces::search::{Failure, LatticeLine, OpenCell, Search, SurfacePoint, bit};
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashSet;

impl Search<'_> {
    /// Finds points of surfaces on a share of the cut edges of the cells whose patches are not good
    /// enough; on all of them in the last batch.
    pub(super) async fn find_points(
        &mut self,
        cells: &mut [OpenCell],
        batch: usize,
    ) -> Result<(), Failure> {
        let is_last = batch + 1 == TUNING.surfaces.batches;
        self.merge_equal(cells);
        let mut found: Vec<(LatticeLine, u32, u32, RootSearch)> = Vec::new();
        let mut seen = FxHashSet::default();
        for cell in cells.iter().filter(|cell| !cell.is_done) {
            let (_, step) = self.grid.corners(cell.cell);
            let corners = self.corners_of(cell.cell);
            for axis in 0..3 {
                for c in (0..8).filter(|c| bit(*c, axis) == 0) {
                    let ends = [c, c | (1 << axis)];
                    let samples = ends.map(|end| cell.corners[end]);
                    let labels = samples.map(|i| self.samples.label(i));
                    if labels[0] == labels[1] || labels.contains(&HIDDEN) {
                        continue;
                    }
                    let low = corners[c];
                    let turn = low.map(|k| k / step);
                    let number = 5 * turn[0] + 3 * turn[1] + 7 * turn[2];
                    let own = (number as usize + axis) % TUNING.surfaces.batches;
                    if !is_last && own != batch {
                        continue;
                    }
                    let line = (axis, others(axis, low));
                    let [from, to] = [low[axis], low[axis] + step];
                    let known = self.lines.get(&line).into_iter().flatten();
                    let is_known = known
                        .into_iter()
                        .any(|(at, _)| (f64::from(from)..=f64::from(to)).contains(at));
                    if is_known || !seen.insert((line, from)) {
                        continue;
                    }
                    let search = self.root_search(cell, ends.map(|end| corners[end]), samples);
                    found.push((line, from, step, search));
                }
            }
        }
        self.run_searches(&mut found).await?;
        self.measure(found.iter().flat_map(|(.., search)| search.samples)).await?;
        for (line, from, step, search) in found {
            let [low, high] = search.samples;
            let labels = [low, high].map(|i| self.samples.label(i));
            if labels[0] == labels[1] || labels.contains(&HIDDEN) {
                continue;
            }
            let across = |ends: [usize; 2]| {
                let [a, b] = ends.map(|i| self.samples.get(i).rate);
                (b - a).abs()
            };
            let least = TUNING.surfaces.slope_left * across(search.ends);
            let of = |ends: [usize; 2]| ends.map(|i| self.samples.label(i));
            let [a, b] = of([low, high]);
            let is_same = of(search.ends) == [a, b];
            let least = if is_same { least } else { 0.0 };
            // A slope leaves as much as the bracket is wide.
            let width = TUNING.surfaces.slope_excess * search.width_share();
            let least = least.max(width * across(search.ends));
            if across([low, high]) <= least.max(self.samples.negligible) {
                // G does not jump here.
                self.samples.note_border(a, b, false);
                continue;
            }
            self.samples.note_border(a, b, true);
            let (at, point) = search.root();
            let place = f64::from(from) + at * f64::from(step);
            let number = self.points.len();
            self.points.push(SurfacePoint { at: point, samples: [low, high], axis: line.0 });
            self.lines.entry(line).or_default().push((place, number));
        }
        Ok(())
    }

    /// Makes one region of those between which G does not jump.
    fn merge_equal(&mut self, cells: &[OpenCell]) {
        for cell in cells {
            for axis in 0..3 {
                for c in (0..8).filter(|c| bit(*c, axis) == 0) {
                    let ends = [cell.corners[c], cell.corners[c | (1 << axis)]];
                    let [a, b] = ends.map(|i| self.samples.label(i));
                    let [from, to] = ends.map(|i| self.samples.get(i).rate);
                    if a != b
                        && ends.iter().all(|&i| self.samples.is_measured(i))
                        && ![a, b].contains(&HIDDEN)
                        && (to - from).abs() <= self.samples.negligible
                    {
                        self.samples.note_border(a, b, false);
                    }
                }
            }
        }
    }

    /// Evaluates brackets until all are narrow enough.
    async fn run_searches(
        &mut self,
        found: &mut [(LatticeLine, u32, u32, RootSearch)],
    ) -> Result<(), Failure> {
        loop {
            let next: Vec<(usize, [f64; 3])> = found
                .iter()
                .enumerate()
                .filter_map(|(i, (.., search))| Some((i, search.point()?)))
                .collect();
            if next.is_empty() {
                return Ok(());
            }
            let points: Vec<[f64; 3]> = next.iter().map(|(_, point)| *point).collect();
            let samples = self.sample(&points).await?;
            for ((i, _), sample) in next.into_iter().zip(samples) {
                let label = self.samples.label(sample);
                found[i].3.update(sample, label);
            }
        }
    }

    /// The bracket of an edge, from the patches of the cell or of its parent.
    fn root_search(
        &self,
        cell: &OpenCell,
        corners: [[u32; 3]; 2],
        samples: [usize; 2],
    ) -> RootSearch {
        let ends = corners.map(|corner| self.grid.corner(corner));
        let labels = samples.map(|i| self.samples.label(i));
        let size = self.grid.cell_size(cell.cell.0);
        let facet = [cell.facets.as_deref(), cell.guess.facets.as_deref()]
            .into_iter()
            .flatten()
            .filter_map(|facets| {
                let between = |of: &&Facet| {
                    let sides = [of.below, of.above].map(|label| self.samples.current(label));
                    sides == labels || sides == [labels[1], labels[0]]
                };
                facets
                    .iter()
                    .find(between)
                    .filter(|of| of.error < TUNING.surfaces.guess_error * size)
            })
            .min_by(|a, b| a.error.total_cmp(&b.error));
        let length = norm(difference(ends[1], ends[0]));
        if let Some(facet) = facet {
            let width = (TUNING.surfaces.root_share * facet.allowed).min(0.1 * size);
            let [low, high] = ends.map(|end| facet.wall.above(end));
            if low * high < 0.0 {
                let at = self.root_of_patch(facet, ends);
                let slope = ((high - low).abs() / length).max(0.2);
                let scale = TUNING.surfaces.expected_errors * facet.error / slope;
                return RootSearch::new(ends, samples, labels[0], width, Some((at, scale)));
            }
            return RootSearch::new(ends, samples, labels[0], width, None);
        }
        let rates = samples.map(|i| self.samples.get(i).rate);
        let across = self.aim.across(&self.grid, ends[0], (rates[1] - rates[0]).abs());
        let tangent = (self.aim.pixel_size(&self.grid) / (8.0 * size)).sqrt();
        let width = TUNING.surfaces.root_share * across * tangent.min(1.0);
        RootSearch::new(ends, samples, labels[0], width.clamp(1e-4 * size, 0.05 * size), None)
    }

    /// Where a patch crosses an edge, as a fraction of the edge.
    fn root_of_patch(&self, facet: &Facet, [from, to]: [[f64; 3]; 2]) -> f64 {
        let direction = difference(to, from);
        let is_above = |at: f64| facet.wall.above(along(from, at, direction)) > 0.0;
        let first = is_above(0.0);
        let [mut low, mut high] = [0.0, 1.0];
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if is_above(middle) == first { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

/// The places on the other two axes.
fn others(axis: usize, [x, y, z]: [u32; 3]) -> [u32; 2] {
    [[y, z], [x, z], [x, y]][axis]
}
