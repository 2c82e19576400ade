//! Patches of cells: fits to the points around them, and the places of their checks.

use crate::parallel::prelude::*;
use crate::projection::vector::{along, difference, norm, unit};
use crate::vol::lattice;
use crate::vol::surfaces::octree::{Facet, Grid, Label, region};
use crate::vol::surfaces::patch::{FitPoint, Patch};
use crate::vol::surfaces::search::{OpenCell, Search};
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;

/// The points of surfaces between two regions, in buckets as long as the reach of a fit.
struct PointsOfPair {
    buckets: FxHashMap<[i32; 3], Vec<usize>>,
}

/// All points by pairs of regions, the smaller label first.
pub(super) struct PointIndex {
    pairs: FxHashMap<(Label, Label), PointsOfPair>,
    bucket: f64,
}

impl PointIndex {
    fn new(search: &Search<'_>, size: f64) -> Self {
        let bucket = TUNING.surfaces.reach * size;
        let mut pairs: FxHashMap<(Label, Label), PointsOfPair> = FxHashMap::default();
        for (number, point) in search.points.iter().enumerate() {
            let [a, b] = point.samples.map(|i| search.samples.label(i));
            if a == b {
                continue;
            }
            let of_pair = pairs
                .entry((a.min(b), a.max(b)))
                .or_insert_with(|| PointsOfPair { buckets: FxHashMap::default() });
            of_pair.buckets.entry(place(point.at, bucket)).or_default().push(number);
        }
        Self { pairs, bucket }
    }

    /// The points of a pair within the reach of a place, the nearest first.
    fn near(&self, search: &Search<'_>, pair: (Label, Label), at: [f64; 3]) -> Vec<FitPoint> {
        let Some(of_pair) = self.pairs.get(&pair) else { return Vec::new() };
        let middle = place(at, self.bucket);
        let mut near: Vec<(f64, usize)> = Vec::new();
        for turn in 0..27 {
            let around = [middle[0] + turn % 3 - 1, middle[1] + turn / 3 % 3 - 1, middle[2] + turn / 9 - 1];
            for &number in of_pair.buckets.get(&around).into_iter().flatten() {
                let distance = norm(difference(search.points[number].at, at));
                if distance <= self.bucket {
                    near.push((distance, number));
                }
            }
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let point = |(distance, number): (f64, usize)| {
            let point = &search.points[number];
            let is_upward = search.samples.label(point.samples[1]) == pair.1;
            FitPoint { at: point.at, axis: point.axis, is_upward, distance }
        };
        near.into_iter().map(point).collect()
    }
}

fn place(at: [f64; 3], bucket: f64) -> [i32; 3] {
    #[expect(clippy::cast_possible_truncation, reason = "a view has few buckets")]
    at.map(|along| (along / bucket).floor() as i32)
}

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
                let mut points = index.near(self, (a, b), centre);
                let is_near = points.first().is_some_and(|of| of.distance < 1.3 * size);
                if !is_near && labels.len() > 2 {
                    continue;
                }
                let covered = points.get(3).is_some_and(|of| of.distance < 1.3 * size);
                is_complete &= covered;
                let rates = self.mean_jump(index, (a, b), centre);
                let normal = self.first_normal(cell, (a, b), &points);
                points.truncate(TUNING.surfaces.most_points);
                let found = normal.and_then(|normal| Patch::fit(&points, centre, normal, size));
                let Some((patch, error)) = found else {
                    is_complete = false;
                    continue;
                };
                let allowed = self.aim.displacement(&self.grid, &patch, size, rates);
                let facet = Facet { patch, below: a, above: b, error, allowed, jump: rates };
                facets.push(facet);
            }
        }
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

    /// The mean jump at the points nearest to a place.
    fn mean_jump(&self, index: &PointIndex, pair: (Label, Label), at: [f64; 3]) -> f64 {
        let Some(of_pair) = index.pairs.get(&pair) else { return 0.0 };
        let middle = place(at, index.bucket);
        let mut near: Vec<(f64, usize)> = Vec::new();
        for turn in 0..27 {
            let around = [middle[0] + turn % 3 - 1, middle[1] + turn / 3 % 3 - 1, middle[2] + turn / 9 - 1];
            let numbers = of_pair.buckets.get(&around).into_iter().flatten();
            near.extend(numbers.map(|&i| (norm(difference(self.points[i].at, at)), i)));
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(4);
        let jump = |&(_, i): &(f64, usize)| {
            let [a, b] = self.points[i].samples.map(|k| self.samples.get(k).rate);
            (b - a).abs()
        };
        near.iter().map(jump).sum::<f64>() / near.len().max(1) as f64
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
        if let Some(guess) = &cell.guess {
            let of_pair = |of: &&Facet| {
                let sides = [of.below, of.above].map(|label| self.samples.current(label));
                sides == [a, b] || sides == [b, a]
            };
            if let Some(facet) = guess.iter().find(of_pair) {
                let normal = facet.patch.normal(self.grid.centre(cell.cell));
                let is_same = self.samples.current(facet.above) == b;
                return Some(if is_same { normal } else { normal.map(|x| -x) });
            }
        }
        let mut sum = [0.0; 3];
        for point in points.iter().take(TUNING.surfaces.centre_points) {
            sum[point.axis] += if point.is_upward { 1.0 } else { -1.0 };
        }
        unit(sum)
    }

    /// The largest distance from a patch of a sample on the wrong side of it.
    fn worst_wrong(&self, cell: &OpenCell, facets: &[Facet]) -> f64 {
        let wrong = |&i: &usize| {
            let at = self.samples.get(i).at;
            let (label, distance) = region(facets, at);
            if label == self.samples.label(i) { 0.0 } else { distance }
        };
        cell.corners.iter().chain(&cell.inside).map(wrong).fold(0.0, f64::max)
    }

    /// Fits patches to cells without a change of region between their samples, into which the
    /// patches of neighbouring cells continue: they move from `uncut` to `cut`.
    pub(super) fn fit_beside(
        &self,
        level: u8,
        cut: &mut Vec<OpenCell>,
        uncut: &mut Vec<OpenCell>,
    ) {
        let size = self.grid.cell_size(level);
        let numbers: FxHashMap<[u32; 3], usize> =
            uncut.iter().enumerate().map(|(i, cell)| (cell.cell.1, i)).collect();
        let mut poked: FxHashMap<usize, Facet> = FxHashMap::default();
        for cell in cut.iter() {
            let Some([facet]) = cell.facets.as_deref() else { continue };
            if facet.error > 0.3 * size {
                continue;
            }
            for turn in 0..27 {
                let step = [turn % 3, turn / 3 % 3, turn / 9];
                let at: [u32; 3] =
                    core::array::from_fn(|k| (cell.cell.1[k] + step[k]).wrapping_sub(1));
                let Some(&number) = numbers.get(&at) else { continue };
                let own = self.samples.label(uncut[number].corners[0]);
                if self.is_poked(&uncut[number], facet, own, size) {
                    poked.entry(number).or_insert(*facet);
                }
            }
        }
        let index = PointIndex::new(self, size);
        let mut numbers: Vec<usize> = poked.keys().copied().collect();
        numbers.sort_unstable();
        for &number in &numbers {
            let Some(facet) = poked.get(&number) else { continue };
            let cell = &mut uncut[number];
            cell.guess = Some([*facet].into());
            let labels = [facet.below.min(facet.above), facet.below.max(facet.above)];
            self.fit(&index, cell, &labels);
        }
        let is_poked = |cell: &OpenCell| cell.facets.is_some();
        let all = core::mem::take(uncut);
        for cell in all {
            if is_poked(&cell) { cut.push(cell) } else { uncut.push(cell) }
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
            let above = facet.patch.above(self.grid.point(level, place));
            if own == sides[1] { above } else { -above }
        });
        let least = least.fold(f64::INFINITY, f64::min);
        -size < least && least < -0.2 * facet.allowed
    }

    /// The points on both sides of the patches of cells at which they are checked, with the numbers
    /// of the cells.
    pub(super) fn places_of_checks(&self, cells: &[OpenCell]) -> Vec<(usize, [f64; 3])> {
        let mut places = Vec::new();
        let Some(level) = cells.first().map(|cell| cell.cell.0) else { return places };
        let index = PointIndex::new(self, self.grid.cell_size(level));
        for (number, cell) in cells.iter().enumerate().filter(|(_, cell)| cell.is_done) {
            let facets = cell.facets.as_deref().unwrap_or_default();
            for facet in facets {
                let Some(foot) = self.place_of_check(&index, cell, facets, facet) else { continue };
                let normal = facet.patch.normal(foot);
                let distance = TUNING.surfaces.check_distance * facet.allowed;
                let points = [-distance, distance].map(|along_it| along(foot, along_it, normal));
                if points.iter().all(|point| is_in_view(&self.grid, *point)) {
                    places.extend(points.map(|point| (number, point)));
                }
            }
        }
        places
    }

    /// The point of a patch in its cell that is furthest from the points of surfaces; `None` if all
    /// are near.
    fn place_of_check(
        &self,
        index: &PointIndex,
        cell: &OpenCell,
        facets: &[Facet],
        facet: &Facet,
    ) -> Option<[f64; 3]> {
        const PLACES: usize = 24;
        let (level, at) = cell.cell;
        let size = self.grid.cell_size(level);
        let pair = (facet.below.min(facet.above), facet.below.max(facet.above));
        let known = index.near(self, pair, self.grid.centre(cell.cell));
        let mut best: Option<(f64, [f64; 3])> = None;
        for k in 0..PLACES {
            let u = lattice::point(k);
            let place = core::array::from_fn(|k| f64::from(at[k]) + u[k]);
            let foot = facet.patch.foot(self.grid.point(level, place));
            let edges = self.grid.cell_edges(level);
            let is_inside = (0..3).all(|k| {
                let along = foot[k] / edges[k] - f64::from(at[k]);
                (-0.02..=1.02).contains(&along)
            });
            if !is_inside {
                continue;
            }
            if facets.len() > 1 {
                let normal = facet.patch.normal(foot);
                let beside = [-1.0, 1.0].map(|side| {
                    region(facets, along(foot, 2.0 * side * facet.allowed, normal)).0
                });
                if beside != [facet.below, facet.above] {
                    continue;
                }
            }
            let distance = |point: &FitPoint| norm(difference(point.at, foot));
            let nearest = known.iter().map(distance).fold(f64::INFINITY, f64::min);
            if best.is_none_or(|(most, _)| nearest > most) {
                best = Some((nearest, foot));
            }
        }
        best.filter(|(nearest, _)| *nearest > 0.15 * size).map(|(_, foot)| foot)
    }
}

/// Whether a point is in the view.
pub(super) fn is_in_view(grid: &Grid, at: [f64; 3]) -> bool {
    (0..3).all(|k| (0.0..=grid.edges[k]).contains(&at[k]))
}
