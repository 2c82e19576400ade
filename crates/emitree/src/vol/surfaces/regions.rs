//! Regions at the beginning: parts of the base lattice between which G jumps.

use crate::vol::surfaces::focus::CellBox;
use crate::vol::surfaces::octree::Grid;
use crate::vol::surfaces::search::{Failure, Search};
use crate::vol::tuning::TUNING;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;

/// The most edges that are tested at once, and how often.
const MOST_TESTS: usize = 96;
const ROUNDS: usize = 8;
/// The number of jumps found between two parts after which no more edges between them are tested.
const ENOUGH_JUMPS: usize = 2;

/// An edge of the base lattice between two corners.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [usize; 2],
    rates: [f64; 2],
    /// |difference| over the sum of the |values|.
    change: f64,
}

/// Two points of an edge with their values.
type Bracket = [([f64; 3], f64); 2];

/// Corners of the base lattice, or of a finer one in a part of the view, with their values.
pub(super) struct BaseLattice {
    pub(super) cells: CellBox,
    /// The number of corners along each axis.
    count: [usize; 3],
    /// The value of each corner that a line of sight reaches.
    pub(super) rates: Vec<Option<f64>>,
    /// The representative of the part of each corner, or another of it.
    part: Vec<usize>,
    tested: FxHashMap<usize, bool>,
    /// Whether the value of each corner is that of a plateau.
    plateau: Vec<bool>,
}

impl BaseLattice {
    pub(super) fn new(cells: CellBox, rates: Vec<Option<f64>>) -> Self {
        let count = cells.cells.map(|k| k as usize + 1);
        let corners = count.iter().product();
        let (part, plateau) = ((0..corners).collect(), vec![false; corners]);
        Self { cells, count, rates, part, tested: FxHashMap::default(), plateau }
    }

    /// The number of a corner.
    pub(super) fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.count[1] + y) * self.count[2] + z
    }

    /// The corner of a number.
    pub(super) fn corner(&self, number: usize) -> [usize; 3] {
        let [_, ny, nz] = self.count;
        [number / (ny * nz), number / nz % ny, number % nz]
    }

    /// The number of corners.
    pub(super) fn corners(&self) -> usize {
        self.part.len()
    }

    /// The corners that lines of sight reach, with their values.
    pub(super) fn samples(&self, grid: &Grid) -> impl Iterator<Item = ([f64; 3], f64)> {
        let of_corner =
            |(number, rate): (usize, &Option<f64>)| Some((self.point(grid, number), (*rate)?));
        self.rates.iter().enumerate().filter_map(of_corner)
    }

    /// The point of a corner.
    pub(super) fn point(&self, grid: &Grid, number: usize) -> [f64; 3] {
        self.cells.point(grid, self.corner(number))
    }

    fn find(&self, mut corner: usize) -> usize {
        while self.part[corner] != corner {
            corner = self.part[corner];
        }
        corner
    }

    fn join(&mut self, [a, b]: [usize; 2]) {
        let [a, b] = [self.find(a), self.find(b)];
        self.part[a.max(b)] = a.min(b);
    }

    /// The value next to an edge on its line, beyond the first or the second end.
    fn beyond(&self, ends: [usize; 2], axis: usize, second: bool) -> Option<f64> {
        let mut at = self.corner(ends[usize::from(second)]);
        at[axis] = if second { at[axis] + 1 } else { at[axis].checked_sub(1)? };
        if at[axis] < self.count[axis] { self.rates[self.number(at)] } else { None }
    }

    /// Whether the value of a corner recurs next to it along an axis.
    fn recurs(&self, corner: usize, axis: usize, negligible: f64) -> bool {
        let Some(own) = self.rates[corner] else { return false };
        let equals = |value: f64| (value - own).abs() <= negligible;
        [false, true].iter().any(|&k| self.beyond([corner; 2], axis, k).is_some_and(equals))
    }

    /// Finds the values of plateaus: a scattered sample has exactly the same value, as happens to no
    /// function that varies.
    fn find_plateaus(&mut self, scattered: &[f64]) {
        let mut scattered = scattered.to_vec();
        scattered.sort_by(f64::total_cmp);
        let recurs = |rate: &Option<f64>| {
            rate.is_some_and(|rate| scattered.binary_search_by(|of| of.total_cmp(&rate)).is_ok())
        };
        self.plateau = self.rates.iter().map(recurs).collect();
    }

    /// Whether an edge is between parts of constant values: the values recur next to its ends, and
    /// somewhere along its line. Those of a function of one coordinate do not recur along a line.
    fn is_between_constants(&self, ends: [usize; 2], axis: usize, negligible: f64) -> bool {
        let mut line = (0..self.count[axis]).map(|k| {
            let mut at = self.corner(ends[0]);
            at[axis] = k;
            self.number(at)
        });
        let is_level = |&end: &usize| (0..3).any(|other| self.recurs(end, other, negligible));
        ends.iter().all(is_level) && line.any(|corner| self.recurs(corner, axis, negligible))
    }

    /// Whether the differences next to an edge predict that of the edge. Between parts of constant
    /// values there is no slope, even if there are steps on both sides of the edge.
    fn is_slope(&self, ends: [usize; 2], [a, b]: [f64; 2], axis: usize, negligible: f64) -> bool {
        if self.is_between_constants(ends, axis, negligible) {
            return false;
        }
        let allowed = TUNING.surfaces.slope_share * (b - a).abs();
        let before = self.beyond(ends, axis, false).map(|p| (b - (2.0 * a - p)).abs());
        let after = self.beyond(ends, axis, true).map(|q| (a - (2.0 * b - q)).abs());
        let both: Vec<f64> = before.into_iter().chain(after).collect();
        !both.is_empty() && both.iter().all(|error| *error <= allowed)
    }

    /// Joins the corners between which G changes little or steadily. Returns the other edges.
    fn join_smooth(&mut self, scattered: &[f64], negligible: f64) -> Vec<Edge> {
        self.find_plateaus(scattered);
        let mut others = Vec::new();
        for number in 0..self.rates.len() {
            for axis in 0..3 {
                let mut end = self.corner(number);
                end[axis] += 1;
                if end[axis] >= self.count[axis] {
                    continue;
                }
                let ends = [number, self.number(end)];
                let [Some(a), Some(b)] = ends.map(|i| self.rates[i]) else { continue };
                let difference = (b - a).abs();
                let is_step = difference > negligible && ends.iter().all(|&end| self.plateau[end]);
                if is_step {
                    // A jump, or a slope that is as steep.
                    continue;
                }
                if difference <= negligible || self.is_slope(ends, [a, b], axis, negligible) {
                    self.join(ends);
                } else {
                    others.push(Edge {
                        ends,
                        rates: [a, b],
                        change: difference / (a.abs() + b.abs()),
                    });
                }
            }
        }
        others.sort_by(|a, b| a.change.total_cmp(&b.change).then(a.ends.cmp(&b.ends)));
        others
    }
}

impl Search<'_> {
    /// Divides a lattice into regions, and adds the samples of the lattice of the whole view, if that is
    /// another one, and the other samples known.
    pub(super) async fn find_regions(
        &mut self,
        mut base: BaseLattice,
        whole: Option<BaseLattice>,
        known: Vec<([f64; 3], f64)>,
    ) -> Result<(), Failure> {
        let scattered: Vec<f64> = known.iter().map(|(_, rate)| *rate).collect();
        let edges = base.join_smooth(&scattered, self.samples.negligible);
        let mut found: Vec<([f64; 3], f64)> = Vec::new();
        for _ in 0..ROUNDS {
            let mut jumps: FxHashMap<[usize; 2], usize> = FxHashMap::default();
            let parts = |base: &BaseLattice, edge: &Edge| {
                let [a, b] = edge.ends.map(|end| base.find(end));
                [a.min(b), a.max(b)]
            };
            for (number, edge) in edges.iter().enumerate() {
                if base.tested.get(&number) == Some(&true) {
                    *jumps.entry(parts(&base, edge)).or_default() += 1;
                }
            }
            let mut seen = FxHashSet::default();
            let is_open = |(number, edge): &(usize, &Edge)| {
                let parts = parts(&base, edge);
                parts[0] != parts[1]
                    && !base.tested.contains_key(number)
                    && jumps.get(&parts).is_none_or(|count| *count < ENOUGH_JUMPS)
                    && seen.insert(parts)
            };
            let tests = edges.iter().enumerate().filter(is_open).take(MOST_TESTS);
            let tests: Vec<(usize, Edge)> = tests.map(|(number, edge)| (number, *edge)).collect();
            if tests.is_empty() {
                break;
            }
            let are_jumps = self.test(&base, &tests, &mut found).await?;
            for ((number, edge), is_jump) in tests.into_iter().zip(are_jumps) {
                base.tested.insert(number, is_jump);
                if !is_jump {
                    base.join(edge.ends);
                }
            }
        }
        self.label_base(&base)?;
        if let Some(whole) = whole {
            self.add_corners(&whole)?;
        }
        for (at, rate) in found.into_iter().chain(known) {
            if self.hides(at) {
                continue;
            }
            self.add(at, rate)?;
        }
        Ok(())
    }

    /// Adds the corners of a lattice that are not in another one, each to the region of its value.
    fn add_corners(&mut self, lattice: &BaseLattice) -> Result<(), Failure> {
        for (number, rate) in lattice.rates.iter().enumerate() {
            let corner = lattice.cells.finest(&self.grid, lattice.corner(number));
            if self.corners.contains_key(&corner) {
                continue;
            }
            let at = lattice.point(&self.grid, number);
            let sample = match rate {
                Some(rate) => self.add(at, *rate)?,
                None => self.samples.add_hidden(at),
            };
            self.corners.insert(corner, sample);
        }
        Ok(())
    }

    /// Whether G jumps on each edge: its steepest half is divided repeatedly.
    async fn test(
        &mut self,
        base: &BaseLattice,
        tests: &[(usize, Edge)],
        found: &mut Vec<([f64; 3], f64)>,
    ) -> Result<Vec<bool>, Failure> {
        let point = |number: usize| base.point(&self.grid, number);
        let mut brackets: Vec<Bracket> = tests
            .iter()
            .map(|(_, edge)| [0, 1].map(|k| (point(edge.ends[k]), edge.rates[k])))
            .collect();
        // The differences before the last two halvings: an edge may cross several surfaces, and a slope
        // leaves little of a difference behind.
        let mut before = vec![f64::INFINITY; brackets.len()];
        for halving in 0..TUNING.surfaces.halvings {
            if halving + 2 == TUNING.surfaces.halvings {
                before = brackets.iter().map(|[a, b]| (b.1 - a.1).abs()).collect();
            }
            let middle = |[a, b]: &Bracket| core::array::from_fn(|k| 0.5 * (a.0[k] + b.0[k]));
            let points: Vec<[f64; 3]> = brackets.iter().map(middle).collect();
            let rates = self.rates(&points).await?;
            for ((bracket, at), rate) in brackets.iter_mut().zip(points).zip(rates) {
                found.push((at, rate));
                let [a, b] = bracket.map(|(_, end)| (end - rate).abs());
                bracket[usize::from(a > b)] = (at, rate);
            }
        }
        let is_jump = |(([a, b], before), (_, edge)): ((&Bracket, f64), &(usize, Edge))| {
            let [from, to] = edge.rates;
            let left = (b.1 - a.1).abs();
            left > TUNING.surfaces.jump_share * before
                && left > TUNING.surfaces.slope_left * (to - from).abs()
        };
        Ok(brackets.iter().zip(before).zip(tests).map(is_jump).collect())
    }

    /// Makes samples of all corners. Parts of equal constant values are one region.
    fn label_base(&mut self, base: &BaseLattice) -> Result<(), Failure> {
        let mut parts: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        let seen = base.rates.iter().enumerate();
        for (corner, rate) in seen.filter_map(|(corner, rate)| Some((corner, (*rate)?))) {
            let ends = parts.entry(base.find(corner)).or_insert([rate; 2]);
            *ends = [ends[0].min(rate), ends[1].max(rate)];
        }
        let mut labels: BTreeMap<usize, u16> = BTreeMap::new();
        let mut constants: Vec<(f64, u16)> = Vec::new();
        let negligible = self.samples.negligible;
        for (part, [low, high]) in &parts {
            let is_constant = high - low <= negligible;
            let known = constants.iter().find(|(value, _)| (value - low).abs() <= negligible);
            let label = match known.filter(|_| is_constant) {
                Some((_, label)) => *label,
                None => self.samples.new_label(),
            };
            if is_constant {
                constants.push((*low, label));
            }
            labels.insert(*part, label);
        }
        if self.samples.regions() > TUNING.surfaces.most_regions {
            return Err(Failure::TooComplex);
        }
        for (number, &rate) in base.rates.iter().enumerate() {
            let at = base.point(&self.grid, number);
            let label = labels.get(&base.find(number)).copied().unwrap_or(0);
            let sample = match rate {
                Some(rate) => self.samples.add(at, rate, label),
                None => self.samples.add_hidden(at),
            };
            let corner = base.cells.finest(&self.grid, base.corner(number));
            self.corners.insert(corner, sample);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
