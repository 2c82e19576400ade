//! Neighbouring lines: the depths that a new line starts with, and structure that is followed from
//! line to line.

use crate::parallel::prelude::*;
use crate::vol::dyadic::{Place, around, spacing};
use crate::vol::image::nearest::Nearest;
use crate::vol::image::tree::ImageTree;
use crate::vol::line::Sample;
use crate::vol::line::jumps::{are_matched, probes};
use crate::vol::line::node_lines::{LINES_ASSESSED, NodeLines, Wanted, base_depths};
use crate::vol::line::tracking::{Bracket, Neighbour, Predicted, predict};
use crate::vol::sampling::{Stop, View};
use crate::vol::tuning::TUNING;
use std::collections::BTreeMap;

/// A depth of one line that is to be sampled on its neighbours.
#[derive(Clone, Copy, Debug)]
struct Shared {
    depth: u32,
    /// The spacing of its level, in steps.
    length: u32,
    /// Whether a nearby jump is the only reason.
    of_jump: bool,
}

impl NodeLines {
    /// The depths that the new full lines `numbers` start with, given the full lines before node
    /// `before`. Stores where these lines are expected to have jumps.
    pub(crate) fn start(
        &mut self,
        tree: &ImageTree,
        numbers: &[usize],
        before: usize,
        tolerance: f64,
        base_level: u8,
    ) -> Wanted {
        let places: Vec<Place> = numbers.iter().map(|&i| tree.nodes()[i].place).collect();
        let tolerances: Vec<f64> =
            numbers.iter().map(|&i| self.tolerance_of(i, tolerance)).collect();
        let starts = self.starts(tree, &places, before, &tolerances, base_level);
        let of_line = |(&i, (depths, brackets))| {
            self.expect(i, brackets);
            (i, depths)
        };
        numbers.iter().zip(starts).map(of_line).collect()
    }

    /// The depths and the brackets of jumps of new lines at any `places`, each with a tolerance, given
    /// the full lines before node `before`.
    pub(crate) fn starts(
        &self,
        tree: &ImageTree,
        places: &[Place],
        before: usize,
        tolerances: &[f64],
        base_level: u8,
    ) -> Vec<(Vec<u32>, Vec<Bracket>)> {
        let full = self.nearest_full(tree, before);
        let of_line = |(&place, &tolerance): (&Place, &f64)| {
            let near = full.find(place, TUNING.jumps.most_neighbours);
            self.starting_depths(tree, place, &near, tolerance, base_level)
        };
        let lines = places.par_iter().zip(tolerances).with_min_len(LINES_ASSESSED);
        lines.map(of_line).collect()
    }

    /// The full lines before node `before`, for searches by place.
    pub(crate) fn nearest_full(&self, tree: &ImageTree, before: usize) -> Nearest {
        let full = (0..before).filter(|&i| self.is_full(i));
        let full: Vec<(Place, usize)> = full.map(|i| (tree.nodes()[i].place, i)).collect();
        Nearest::new(full.into_iter())
    }

    /// Stores where line `i` is expected to have jumps.
    pub(crate) fn expect(&mut self, i: usize, brackets: Vec<Bracket>) {
        self.brackets[i] = brackets;
    }

    /// The depths and the brackets of a new full line at `place`: those of the base level, those
    /// that were refined on the nearest of the full lines `near`, and brackets of the jumps.
    fn starting_depths(
        &self,
        tree: &ImageTree,
        place: Place,
        near: &[(u64, usize)],
        tolerance: f64,
        base_level: u8,
    ) -> (Vec<u32>, Vec<Bracket>) {
        let mut depths = base_depths(base_level);
        let neighbours =
            if self.tracks_jumps { self.neighbours(tree, place, near) } else { Vec::new() };
        // The two nearest lines, and those at the same distance as the second.
        let farthest = near.get(1).map_or(0, |(distance, _)| *distance);
        let nearest = near
            .iter()
            .take(TUNING.line.starting_lines)
            .filter(|(distance, _)| *distance <= farthest);
        let has_jumps =
            neighbours.iter().take(TUNING.line.starting_lines).any(|one| !one.jumps.is_empty());
        for line in nearest.map(|&(_, i)| &self.lines[i]) {
            let worthwhile = line.samples.iter().enumerate().filter(|(k, sample)| {
                if has_jumps {
                    let significant =
                        sample.significance > TUNING.line.starting_significance * tolerance;
                    return significant
                        && sample.level <= TUNING.line.starting_level
                        && !line.is_beside_jump(*k);
                }
                sample.opened
                    || (sample.level <= TUNING.line.shared_jump_level && line.is_near_jump(*k))
            });
            depths.extend(worthwhile.map(|(_, sample)| sample.depth));
        }
        let Predicted { brackets, probes } = predict(&neighbours, tolerance);
        depths.extend(brackets.iter().flat_map(|bracket| [bracket.low, bracket.high]));
        depths.extend(probes);
        depths.sort_unstable();
        depths.dedup();
        (depths, brackets)
    }

    /// The jumps of full lines near `place`; none if the nearest lines have none.
    fn neighbours(&self, tree: &ImageTree, place: Place, near: &[(u64, usize)]) -> Vec<Neighbour> {
        let unit_distance =
            near.first().map_or(1.0, |(square, _)| (*square as f64).sqrt().max(1.0));
        let neighbour = |&(_, i): &(u64, usize)| {
            let from = tree.nodes()[i].place;
            let along =
                |axis: usize| (f64::from(from[axis]) - f64::from(place[axis])) / unit_distance;
            Neighbour { place: [along(0), along(1)], jumps: self.jumps(i).to_vec() }
        };
        let mut neighbours: Vec<Neighbour> =
            near.iter().take(TUNING.line.starting_lines).map(neighbour).collect();
        if neighbours.iter().any(|one| !one.jumps.is_empty()) {
            neighbours.extend(near.iter().skip(TUNING.line.starting_lines).map(neighbour));
        }
        neighbours
    }

    /// Samples structure of the lines `found` on neighbouring full lines, and from there on theirs.
    pub(crate) async fn follow(
        &mut self,
        view: &View<'_>,
        tree: &ImageTree,
        found: &[usize],
        tolerance: f64,
        base_level: u8,
    ) -> Result<(), Stop> {
        let mut found = found.to_vec();
        for _ in 0..TUNING.line.most_hops {
            let mut wanted: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
            let missing = |&i: &usize| self.missing_on_neighbours(tree, i, tolerance, base_level);
            let found_lines = found.par_iter().with_min_len(LINES_ASSESSED);
            let of_lines: Vec<Wanted> = found_lines.map(missing).collect();
            for (k, depths) in of_lines.into_iter().flatten() {
                wanted.entry(k).or_default().extend(depths);
            }
            for depths in wanted.values_mut() {
                depths.sort_unstable();
                depths.dedup();
            }
            found = wanted.keys().copied().collect();
            if found.is_empty() {
                break;
            }
            let wanted = wanted.into_iter().collect();
            self.refine(view, tree, wanted, tolerance, base_level).await?;
        }
        Ok(())
    }

    /// The depths of line `i` that are missing on neighbouring full lines.
    fn missing_on_neighbours(
        &self,
        tree: &ImageTree,
        i: usize,
        tolerance: f64,
        base_level: u8,
    ) -> Wanted {
        let node = &tree.nodes()[i];
        let step = spacing(node.level.max(base_level));
        let depths = self.shared_depths(i, self.tolerance_of(i, tolerance), base_level);
        let own = if self.tracks_jumps { self.jumps(i) } else { &[] };
        if own.is_empty() && depths.is_empty() {
            return Vec::new();
        }
        let of_neighbour = |(_, _, neighbour)| {
            let k = tree.find(neighbour).filter(|&k| self.is_full(k))?;
            let line = &self.lines[k];
            let theirs = if own.is_empty() { &[] } else { self.jumps(k) };
            let is_missing = |shared: &&Shared| {
                let is_theirs = shared.of_jump && are_matched(own, theirs, shared.depth);
                !is_theirs && self.is_coarse(k, shared.depth, shared.length)
            };
            let mut missing = probes(own, theirs, line);
            missing.extend(depths.iter().filter(is_missing).map(|shared| shared.depth));
            (!missing.is_empty()).then_some((k, missing))
        };
        around(node.place, step, 1).filter_map(of_neighbour).collect()
    }

    /// The depths of line `i` that are to be sampled on its neighbours.
    fn shared_depths(&self, i: usize, tolerance: f64, base_level: u8) -> Vec<Shared> {
        let line = &self.lines[i];
        let of_sample = |(k, sample): (usize, &Sample)| {
            let significant = sample.opened
                && sample.level >= base_level
                && sample.significance > TUNING.line.shared_significance * tolerance;
            let beside_jump = sample.level <= TUNING.line.shared_jump_level
                && sample.level > base_level
                && line.is_near_jump(k);
            (significant || beside_jump).then(|| Shared {
                depth: sample.depth,
                length: spacing(sample.level),
                of_jump: !significant,
            })
        };
        line.samples.iter().enumerate().filter_map(of_sample).collect()
    }

    /// Whether line `k` has no sample at `depth` and a long interval there, compared with `length`.
    fn is_coarse(&self, k: usize, depth: u32, length: u32) -> bool {
        let line = &self.lines[k];
        match line.find(depth) {
            Ok(_) => false,
            Err(0) => true,
            Err(after) if after == line.samples.len() => true,
            Err(after) => {
                let interval = line.samples[after].depth - line.samples[after - 1].depth;
                interval >= TUNING.line.coarse_ratio * length
            }
        }
    }
}
