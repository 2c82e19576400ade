//! Regions at the beginning: parts of the base lattice between which G jumps.

use crate::vol::surfaces::focus::CellBox;
use crate::vol::surfaces::octree::Grid;
use crate::vol::surfaces::search::{Failure, Search};
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashSet;
use std::collections::BTreeMap;

/// The most edges that are tested at once, and how often.
const MOST_TESTS: usize = 96;
const ROUNDS: usize = 8;
/// The number of jumps found between two parts after which no more edges between them are tested.
const ENOUGH_JUMPS: usize = 2;
/// The number of edges within a part that are tested at once, and of those without a jump after which no
/// more are tested.
const TESTS_WITHIN: usize = 8;
const ENOUGH_WITHIN: usize = 8;

/// An edge of the base lattice between two corners.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [usize; 2],
    rates: [f64; 2],
    /// |difference| over the sum of the |values|.
    change: f64,
    /// Whether values nearby predict the difference.
    is_smooth: bool,
    /// Whether G jumps on the edge, once this has been tested.
    is_jump: Option<bool>,
}

/// Corners of the base lattice, or of a finer one in a part of the view, with their values.
#[derive(Clone)]
pub(super) struct BaseLattice {
    pub(super) cells: CellBox,
    /// The number of corners along each axis.
    count: [usize; 3],
    /// The value of each corner that a line of sight reaches.
    pub(super) rates: Vec<Option<f64>>,
    /// The representative of the part of each corner, or another of it.
    part: Vec<usize>,
    /// The value of the plateau of each corner that is on one.
    plateau: Vec<Option<f64>>,
}

impl BaseLattice {
    pub(super) fn new(cells: CellBox, rates: Vec<Option<f64>>) -> Self {
        let count = cells.cells.map(|k| k as usize + 1);
        let corners = count.iter().product();
        let (part, plateau) = ((0..corners).collect(), vec![None; corners]);
        Self { cells, count, rates, part, plateau }
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

    /// Finds the corners on plateaus: a scattered sample has exactly the same value, as happens to no
    /// function that varies, or the value differs little from that of a plateau next to it.
    fn find_plateaus(&mut self, scattered: &[f64], negligible: f64) {
        let mut scattered = scattered.to_vec();
        scattered.sort_by(f64::total_cmp);
        let recurs = |rate: &f64| scattered.binary_search_by(|of| of.total_cmp(rate)).is_ok();
        self.plateau = self.rates.iter().map(|rate| rate.filter(recurs)).collect();
        let mut next: Vec<usize> =
            (0..self.plateau.len()).filter(|&corner| self.plateau[corner].is_some()).collect();
        while let Some(corner) = next.pop() {
            for beside in self.beside(corner) {
                let [own, value] = [self.plateau[corner], self.rates[beside]];
                let is_level = own.zip(value).is_some_and(|(a, b)| (b - a).abs() <= negligible);
                if is_level && self.plateau[beside].is_none() {
                    self.plateau[beside] = own;
                    next.push(beside);
                }
            }
        }
    }

    /// The corners next to one.
    fn beside(&self, corner: usize) -> impl Iterator<Item = usize> + use<> {
        let (at, count) = (self.corner(corner), self.count);
        let strides = [count[1] * count[2], count[2], 1];
        (0..3).flat_map(move |axis| {
            let below = (at[axis] > 0).then(|| corner - strides[axis]);
            let above = (at[axis] + 1 < count[axis]).then(|| corner + strides[axis]);
            below.into_iter().chain(above)
        })
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

    /// Joins the corners between which G changes little or steadily. Returns all edges between others, and
    /// whether each is such a smooth one. Those between plateaus are none of them.
    fn join_smooth(&mut self, scattered: &[f64], negligible: f64) -> Vec<Edge> {
        self.find_plateaus(scattered, negligible);
        let mut edges = Vec::new();
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
                let is_smooth = match ends.map(|end| self.plateau[end]) {
                    [None, None] => {
                        difference <= negligible || self.is_slope(ends, [a, b], axis, negligible)
                    }
                    [Some(a), Some(b)] if (b - a).abs() <= negligible => true,
                    // A plateau has all values close to its own, and no others.
                    _ => continue,
                };
                let change = if difference > 0.0 { difference / (a.abs() + b.abs()) } else { 0.0 };
                edges.push(Edge { ends, rates: [a, b], change, is_smooth, is_jump: None });
            }
        }
        edges.sort_by(|a, b| a.change.total_cmp(&b.change).then(a.ends.cmp(&b.ends)));
        self.divide(&edges);
        edges
    }

    /// Divides the corners into parts, each connected by edges that do not jump, in ascending order of
    /// change. No part has both ends of an edge that jumps: where a jump fades out along a surface, the
    /// parts on its two sides meet, but remain two.
    fn divide(&mut self, edges: &[Edge]) {
        self.part = (0..self.part.len()).collect();
        let jumps: Vec<[usize; 2]> =
            edges.iter().filter(|of| of.is_jump == Some(true)).map(|of| of.ends).collect();
        let joins = |of: &&Edge| !of.is_jump.unwrap_or(!of.is_smooth);
        for edge in edges.iter().filter(joins) {
            let own = self.parts(edge.ends);
            let is_divided = |ends: &[usize; 2]| self.parts(*ends) == own;
            if own[0] != own[1] && !jumps.iter().any(is_divided) {
                self.join(own);
            }
        }
    }

    /// The parts of two corners, the smaller number first.
    fn parts(&self, ends: [usize; 2]) -> [usize; 2] {
        let [a, b] = ends.map(|end| self.find(end));
        [a.min(b), a.max(b)]
    }

    /// The next edges to be tested: those that join parts of few known jumps between them, and the steepest
    /// of those within a part, as long as these jump.
    fn next_tests(&self, edges: &[Edge]) -> Vec<usize> {
        let mut jumps: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        let mut smooth: BTreeMap<usize, usize> = BTreeMap::new();
        for edge in edges {
            let parts = self.parts(edge.ends);
            match edge.is_jump {
                Some(true) => *jumps.entry(parts).or_default() += 1,
                Some(false) if parts[0] == parts[1] => *smooth.entry(parts[0]).or_default() += 1,
                _ => {}
            }
        }
        let mut seen = FxHashSet::default();
        let mut tests = Vec::new();
        let is_open = |edge: &Edge| edge.is_jump.is_none() && !edge.is_smooth;
        for (number, edge) in edges.iter().enumerate().filter(|(_, edge)| is_open(edge)) {
            let parts = self.parts(edge.ends);
            let is_enough = jumps.get(&parts).is_some_and(|count| *count >= ENOUGH_JUMPS);
            if parts[0] != parts[1] && !is_enough && seen.insert(parts) {
                tests.push(number);
            }
        }
        tests.truncate(MOST_TESTS);
        let mut within: BTreeMap<usize, usize> = BTreeMap::new();
        for (number, edge) in edges.iter().enumerate().rev().filter(|(_, edge)| is_open(edge)) {
            let parts = self.parts(edge.ends);
            let tested = within.entry(parts[0]).or_default();
            let known = smooth.get(&parts[0]).copied().unwrap_or(0);
            if parts[0] == parts[1] && known < ENOUGH_WITHIN && *tested < TESTS_WITHIN {
                *tested += 1;
                tests.push(number);
            }
        }
        tests
    }
}

impl Search<'_> {
    /// Divides the first lattice into regions, and adds the samples of the lattice of the whole view, if that is
    /// another one, and the scattered ones.
    pub(super) async fn find_regions(
        &mut self,
        mut base: BaseLattice,
        whole: Option<&BaseLattice>,
        known: &[([f64; 3], f64)],
    ) -> Result<(), Failure> {
        let scattered: Vec<f64> = known.iter().map(|(_, rate)| *rate).collect();
        let mut edges = base.join_smooth(&scattered, self.samples.negligible);
        let mut found: Vec<([f64; 3], f64)> = Vec::new();
        for _ in 0..ROUNDS {
            let tests = base.next_tests(&edges);
            if tests.is_empty() {
                break;
            }
            let tested: Vec<Edge> = tests.iter().map(|&number| edges[number]).collect();
            let point = |number: usize| base.point(&self.grid, number);
            let pair = |edge: &Edge| [0, 1].map(|k| (point(edge.ends[k]), edge.rates[k]));
            let pairs = tested.iter().map(pair).collect();
            let are_jumps = self.are_jumps(pairs, &mut found).await?;
            for (number, is_jump) in tests.into_iter().zip(are_jumps) {
                edges[number].is_jump = Some(is_jump);
            }
            base.divide(&edges);
        }
        self.label_base(&base)?;
        for edge in edges.iter().filter(|edge| edge.is_jump == Some(true)) {
            let label = |end: usize| {
                let corner = base.cells.finest(&self.grid, base.corner(end));
                self.corners.get(&corner).map(|&i| self.samples.label(i))
            };
            if let [Some(a), Some(b)] = edge.ends.map(label) {
                self.samples.note_border(a, b, true);
            }
        }
        if let Some(whole) = whole {
            self.add_corners(whole)?;
        }
        for (at, rate) in found.iter().chain(known).copied() {
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
            return Err(Failure::TooManyRegions);
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
