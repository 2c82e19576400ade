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
    order: Vec<(Label, Label)>,
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
        let mut order: Vec<(Label, Label)> = pairs.keys().copied().collect();
        order.sort_unstable();
        Self { pairs, order, bucket }
    }

    /// The numbers of the points of a pair within the reach of a place with their distances, the
    /// nearest first.
    fn numbers(
        &self,
        search: &Search<'_>,
        pair: (Label, Label),
        at: [f64; 3],
    ) -> Vec<(f64, usize)> {
        let Some(of_pair) = self.pairs.get(&pair) else { return Vec::new() };
        let middle = place(at, self.bucket);
        let mut near: Vec<(f64, usize)> = Vec::new();
        for turn in 0..27 {
            let step = [turn % 3 - 1, turn / 3 % 3 - 1, turn / 9 - 1];
            let around = core::array::from_fn(|k| middle[k] + step[k]);
            for &number in of_pair.buckets.get(&around).into_iter().flatten() {
                let distance = norm(difference(search.points[number].at, at));
                if distance <= self.bucket {
                    near.push((distance, number));
                }
            }
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near
    }

    /// The points of a pair within the reach of a place, the nearest first.
    fn near(&self, search: &Search<'_>, pair: (Label, Label), at: [f64; 3]) -> Vec<FitPoint> {
        let point = |(distance, number): (f64, usize)| {
            let point = &search.points[number];
            let is_upward = search.samples.label(point.samples[1]) == pair.1;
            FitPoint { at: point.at, axis: point.axis, is_upward, distance }
        };
        self.numbers(search, pair, at).into_iter().map(point).collect()
    }

    /// The mean jump, from the first to the second region of a pair, at the points nearest to a place;
    /// `None` without points.
    fn jump(&self, search: &Search<'_>, pair: (Label, Label), at: [f64; 3]) -> Option<f64> {
        let mut near = self.numbers(search, pair, at);
        near.truncate(4);
        let jump = |&(_, i): &(f64, usize)| {
            let [a, b] = search.points[i].samples.map(|k| search.samples.get(k));
            let is_upward = search.samples.label(search.points[i].samples[1]) == pair.1;
            if is_upward { b.rate - a.rate } else { a.rate - b.rate }
        };
        let sum: f64 = near.iter().map(jump).sum();
        (!near.is_empty()).then(|| sum / near.len() as f64)
    }

    /// The points of other pairs with the same jump, as if they were of a pair: where the emissions
    /// of two bodies add up, their surfaces continue through each other.
    fn continued(
        &self,
        search: &Search<'_>,
        pair: (Label, Label),
        at: [f64; 3],
        jump: f64,
    ) -> Vec<FitPoint> {
        let mut points = Vec::new();
        for &other in &self.order {
            if other == pair {
                continue;
            }
            let Some(of_other) = self.jump(search, other, at) else { continue };
            let is_same = (of_other - jump).abs() <= TUNING.surfaces.same_jump * jump.abs();
            let is_opposite = (of_other + jump).abs() <= TUNING.surfaces.same_jump * jump.abs();
            if is_same || is_opposite {
                points.extend(
                    self.near(search, other, at)
                        .into_iter()
                        .map(|point| FitPoint { is_upward: point.is_upward == is_same, ..point }),
                );
            }
        }
        points
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
                let own = index.near(self, (a, b), centre);
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
                    let found = Patch::fit(&points, centre, normal?, size)?;
                    Some((found.0, found.1, covered))
                };
                let continued = index.continued(self, (a, b), centre, jump);
                let mut both = own.clone();
                both.extend(&continued);
                let mut found = fit(own);
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
                let allowed = self.aim.displacement(&self.grid, &patch, size, jump);
                let allowed = cell.guess.share * allowed;
                facets.push(Facet { patch, below: a, above: b, error, allowed, jump });
            }
        }
        let has_facet =
            |label: &Label| facets.iter().any(|of| of.below == *label || of.above == *label);
        is_complete &= labels.iter().all(has_facet);
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
            cell.guess.facets = Some([*facet].into());
            let labels = [facet.below.min(facet.above), facet.below.max(facet.above)];
            self.fit(&index, cell, &labels);
        }
        let all = core::mem::take(uncut);
        for cell in all {
            let own = self.samples.label(cell.corners[0]);
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
                let beside = [-1.0, 1.0]
                    .map(|side| region(facets, along(foot, 2.0 * side * facet.allowed, normal)).0);
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
