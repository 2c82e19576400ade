//! Patches of cells: fits to the points around them.

use crate::parallel::prelude::*;
use crate::projection::vector::{along, difference, unit};
use crate::vol::lattice;
use crate::vol::surfaces::octree::{Cell, Facet, Label, is_ambiguous, region};
use crate::vol::surfaces::patch::{FitPoint, Patch};
use crate::vol::surfaces::points::PointIndex;
use crate::vol::surfaces::search::{OpenCell, Search};
use crate::vol::surfaces::wall::{Wall, mean_orientation};
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;

/// The reaches within which the points of several patches are taken.
const REACHES: [i32; 3] = [1, 2, 4];

impl Search<'_> {
    /// Fits patches to all cells that have no good ones yet.
    pub(super) fn fit_all(&self, level: u8, cells: &mut [OpenCell]) {
        let index = PointIndex::new(self, self.grid.cell_size(level));
        cells.par_iter_mut().filter(|cell| !cell.is_done).for_each(|cell| {
            let labels = self.labels(cell);
            self.fit(&index, cell, &labels);
        });
    }

    /// Fits the patches between the regions in a cell.
    fn fit(&self, index: &PointIndex, cell: &mut OpenCell, labels: &[Label]) {
        let size = self.grid.cell_size(cell.cell.0);
        let centre = self.grid.centre(cell.cell);
        let (mut facets, mut is_complete) = (Vec::new(), true);
        for (i, &a) in labels.iter().enumerate() {
            for &b in &labels[i + 1..] {
                let own = index.near(self, (a, b), centre, 1);
                let Some(jump) = index.jump(self, (a, b), centre) else { continue };
                let is_near = |of: &FitPoint| of.distance < 1.3 * size;
                if labels.len() > 2 && !own.first().is_some_and(is_near) {
                    continue;
                }
                let normal = self.first_normal(cell, (a, b), &own);
                let fit = |mut points: Vec<FitPoint>| {
                    points.sort_by(|a, b| a.distance.total_cmp(&b.distance));
                    points.truncate(TUNING.surfaces.most_points);
                    let covered = points.get(3).is_some_and(is_near);
                    let found = Patch::fit(&points, centre, normal?, size, 0.0)?;
                    Some((found.0, found.1, covered))
                };
                let continued = index.continued(self, (a, b), centre, jump);
                let mut both = own.clone();
                both.extend(&continued);
                let mut found = fit(own.clone());
                if !continued.is_empty() {
                    let better = fit(both).filter(|(_, error, covered)| {
                        let is_better =
                            |of: &(Patch, f64, bool)| *error < of.1 || (*covered && !of.2);
                        found.as_ref().is_none_or(is_better)
                    });
                    found = better.or(found);
                }
                let Some((patch, error, covered)) = found else {
                    is_complete &= labels.len() > 2;
                    continue;
                };
                if !covered && labels.len() > 2 {
                    // Regions that meet at an edge only have few points between them.
                    continue;
                }
                is_complete &= covered;
                let jump = jump.abs();
                let allowed_at = |wall: &Wall| {
                    let patches = wall.patches().iter();
                    let of_patch =
                        |patch| self.aim.displacement(&self.grid, patch, (size, centre), jump);
                    cell.guess.share * patches.map(of_patch).fold(f64::INFINITY, f64::min)
                };
                let (mut wall, mut error) = (Wall::from(patch), error);
                let wanted = allowed_at(&wall);
                if error > TUNING.surfaces.wall_from * wanted {
                    // Where a single patch is good enough, an edge beyond the points of the cell does not matter.
                    let reaches = if error > wanted { &REACHES[..] } else { &REACHES[..1] };
                    let meeting = self.meeting_patches(index, cell.cell, (a, b), (reaches, wanted));
                    if let Some(better) = meeting.filter(|(_, of_it)| *of_it < error) {
                        (wall, error) = better;
                    }
                }
                let allowed = allowed_at(&wall);
                facets.push(Facet { wall, below: a, above: b, error, allowed, jump });
            }
        }
        let has_facet =
            |label: &Label| facets.iter().any(|of| of.below == *label || of.above == *label);
        is_complete &= labels.iter().all(has_facet);
        is_complete &= !self.has_ambiguous_places(cell.cell, &facets);
        if facets.is_empty() {
            (cell.facets, cell.is_done) = (None, false);
            return;
        }
        let wrong = self.worst_wrong(cell, &facets);
        if let [only] = &mut facets[..] {
            only.error = only.error.max(wrong);
        }
        let is_good = |of: &Facet| of.error <= of.allowed;
        let agrees = facets.len() == 1 || facets.iter().all(|of| wrong <= of.allowed);
        cell.is_done = is_complete && agrees && facets.iter().all(is_good);
        cell.facets = Some(facets);
    }

    /// Whether places of a cell are in several regions.
    pub(super) fn has_ambiguous_places(&self, (level, at): Cell, facets: &[Facet]) -> bool {
        const PLACES: usize = 64;
        if facets.len() == 1 {
            return false;
        }
        (0..PLACES).any(|number| {
            let u = lattice::point(number);
            let place = core::array::from_fn(|k| f64::from(at[k]) + u[k]);
            is_ambiguous(facets, self.grid.point(level, place))
        })
    }

    /// Several patches between two regions in a cell, with their error: of the points within several
    /// reaches those with the least, or the first that reach `wanted`.
    fn meeting_patches(
        &self,
        index: &PointIndex,
        cell: Cell,
        pair: (Label, Label),
        (reaches, wanted): (&[i32], f64),
    ) -> Option<(Wall, f64)> {
        let (size, centre) = (self.grid.cell_size(cell.0), self.grid.centre(cell));
        let mut best: Option<(Wall, f64)> = None;
        for &reaches in reaches {
            // Beside an edge, all further points are those of coarser cells.
            let points = index.near(self, pair, centre, reaches);
            let found = Wall::fit(&points, centre, (size, reaches), wanted);
            best = best.into_iter().chain(found).min_by(|a, b| a.1.total_cmp(&b.1));
            if best.as_ref().is_some_and(|(_, error)| *error <= wanted) {
                break;
            }
        }
        best
    }

    /// A direction from the first to the second of two regions, from the samples of a cell or from
    /// the orientation of the nearest points.
    fn first_normal(
        &self,
        cell: &OpenCell,
        (a, b): (Label, Label),
        points: &[FitPoint],
    ) -> Option<[f64; 3]> {
        let mut sums = [([0.0; 3], 0.0); 2];
        for &i in &cell.corners {
            let sample = self.samples.get(i);
            let label = self.samples.label(i);
            if let Some(side) = [a, b].iter().position(|of| *of == label) {
                sums[side] = (along(sums[side].0, 1.0, sample.at), sums[side].1 + 1.0);
            }
        }
        let [(low, lows), (high, highs)] = sums;
        if lows > 0.0 && highs > 0.0 {
            let normal = difference(high.map(|x| x / highs), low.map(|x| x / lows));
            if let Some(normal) = unit(normal) {
                return Some(normal);
            }
        }
        if let Some(guess) = &cell.guess.facets {
            let of_pair = |of: &&Facet| {
                let sides = [of.below, of.above].map(|label| self.samples.current(label));
                sides == [a, b] || sides == [b, a]
            };
            if let Some(facet) = guess.iter().find(of_pair) {
                let normal = facet.wall.normal(self.grid.centre(cell.cell));
                let is_same = self.samples.current(facet.above) == b;
                return Some(if is_same { normal } else { normal.map(|x| -x) });
            }
        }
        mean_orientation(&points[..points.len().min(TUNING.surfaces.centre_points)])
    }

    /// The largest distance from a patch of a sample on the wrong side of it.
    fn worst_wrong(&self, cell: &OpenCell, facets: &[Facet]) -> f64 {
        let wrong = |&i: &usize| {
            let at = self.samples.get(i).at;
            let (label, distance) = region(facets, at);
            if label == self.samples.label(i) { 0.0 } else { distance }
        };
        self.measured_samples(cell).map(wrong).fold(0.0, f64::max)
    }

    /// Fits patches to cells without a change of region between their samples, into which the
    /// patches of neighbouring cells continue: they move from `uncut` to `cut`.
    pub(super) fn fit_beside(&self, level: u8, cut: &mut Vec<OpenCell>, uncut: &mut Vec<OpenCell>) {
        let size = self.grid.cell_size(level);
        let numbers: FxHashMap<[u32; 3], usize> =
            uncut.iter().enumerate().map(|(i, cell)| (cell.cell.1, i)).collect();
        let mut poked: FxHashMap<usize, Facet> = FxHashMap::default();
        for cell in cut.iter() {
            let Some([facet]) = cell.facets.as_deref() else { continue };
            if !cell.is_done {
                continue;
            }
            for turn in 0..27 {
                let step = [turn % 3, turn / 3 % 3, turn / 9];
                let at: [u32; 3] =
                    core::array::from_fn(|k| (cell.cell.1[k] + step[k]).wrapping_sub(1));
                let Some(&number) = numbers.get(&at) else { continue };
                let own = self.own_label(&uncut[number]);
                if self.is_poked(&uncut[number], facet, own, size) {
                    poked.entry(number).or_insert_with(|| facet.clone());
                }
            }
        }
        let index = PointIndex::new(self, size);
        uncut.par_iter_mut().enumerate().for_each(|(number, cell)| {
            let Some(facet) = poked.get(&number) else { return };
            cell.guess.facets = Some([facet.clone()].into());
            let labels = [facet.below.min(facet.above), facet.below.max(facet.above)];
            self.fit(&index, cell, &labels);
        });
        let all = core::mem::take(uncut);
        for cell in all {
            let own = self.own_label(&cell);
            let is_cut = match cell.facets.as_deref() {
                Some([facet]) => cell.is_done && self.is_poked(&cell, facet, own, size),
                _ => false,
            };
            if is_cut { cut.push(cell) } else { uncut.push(cell) }
        }
    }

    /// Whether the other side of a patch reaches into a cell.
    fn is_poked(&self, cell: &OpenCell, facet: &Facet, own: Label, size: f64) -> bool {
        let sides = [facet.below, facet.above].map(|label| self.samples.current(label));
        if !sides.contains(&own) {
            return false;
        }
        let (level, at) = cell.cell;
        let least = (0..27).map(|turn| {
            let step = [turn % 3, turn / 3 % 3, turn / 9];
            let place = core::array::from_fn(|k| f64::from(at[k]) + 0.5 * f64::from(step[k]));
            let above = facet.wall.above(self.grid.point(level, place));
            if own == sides[1] { above } else { -above }
        });
        let least = least.fold(f64::INFINITY, f64::min);
        -size < least && least < -0.2 * facet.allowed
    }
}
