//! Points of surfaces on the edges of cells whose ends are in different regions.

use crate::projection::vector::{along, difference, norm};
use crate::vol::surfaces::edges::edges;
use crate::vol::surfaces::octree::{Facet, HIDDEN};
use crate::vol::surfaces::roots::RootSearch;
use crate::vol::surfaces::search::{Failure, LatticeLine, OpenCell, Search, SurfacePoint};
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
        let mut found: Vec<(LatticeLine, [f64; 2], RootSearch)> = Vec::new();
        let mut seen = FxHashSet::default();
        for cell in cells.iter().filter(|cell| !cell.is_done) {
            let (low, step) = self.grid.corners(cell.cell);
            for edge in edges(low, step) {
                let [from, to] = self.ends_of(cell, &edge);
                let samples = [from.1, to.1];
                let labels = samples.map(|i| self.samples.label(i));
                if labels[0] == labels[1] || labels.contains(&HIDDEN) {
                    continue;
                }
                if !is_last && edge.batch() != batch {
                    continue;
                }
                let places = [from.0, to.0];
                let known = self.lines.get(&edge.line).into_iter().flatten();
                let is_known =
                    known.into_iter().any(|(at, _)| (places[0]..=places[1]).contains(at));
                if is_known || !seen.insert((edge.line, edge.from)) {
                    continue;
                }
                found.push((edge.line, places, self.root_search(cell, samples)));
            }
        }
        self.run_searches(&mut found).await?;
        self.measure(found.iter().flat_map(|(.., search)| search.samples)).await?;
        for (line, [from, to], search) in found {
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
            let place = from + at * (to - from);
            let number = self.points.len();
            self.points.push(SurfacePoint { at: point, samples: [low, high], axis: line.0 });
            self.lines.entry(line).or_default().push((place, number));
        }
        Ok(())
    }

    /// Makes one region of those between which G does not jump.
    fn merge_equal(&mut self, cells: &[OpenCell]) {
        for cell in cells {
            let (low, step) = self.grid.corners(cell.cell);
            for edge in edges(low, step) {
                let ends = self.ends_of(cell, &edge).map(|(_, sample)| sample);
                let [a, b] = ends.map(|i| self.samples.label(i));
                let [from, to] = ends.map(|i| self.samples.get(i).rate);
                if a != b
                    && ends.iter().all(|&i| self.samples.is_measured(i))
                    && (to - from).abs() <= self.samples.negligible
                {
                    self.samples.note_border(a, b, false);
                }
            }
        }
    }

    /// Evaluates brackets until all are narrow enough.
    async fn run_searches(
        &mut self,
        found: &mut [(LatticeLine, [f64; 2], RootSearch)],
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
                found[i].2.update(sample, label);
            }
        }
    }

    /// The bracket between two samples on an edge, from the patches of the cell or of its parent.
    fn root_search(&self, cell: &OpenCell, samples: [usize; 2]) -> RootSearch {
        let ends = samples.map(|i| self.samples.get(i).at);
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
