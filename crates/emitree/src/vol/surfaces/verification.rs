//! The verification: sides of surfaces and values of pieces on lines of sight that took no part.

use crate::vol::lattice;
use crate::vol::surfaces::model::Model;
use crate::vol::surfaces::octree::{Cell, HIDDEN, Leaf};
use crate::vol::surfaces::raster::Maps;
use crate::vol::surfaces::rays::Ray;
use crate::vol::surfaces::search::{Failure, Search};
use crate::vol::tuning::TUNING;

/// The number of the first line in the sequence of scattered points, far beyond those of samples.
const FIRST_LINE: usize = 1 << 26;

/// The outcome.
#[derive(Debug)]
pub(super) struct Verdict {
    /// Whether all samples agree with the model, or are in cells that remain unresolved.
    pub(super) has_passed: bool,
    /// The leaves around the others, as far as they can be divided.
    pub(super) wrong: Vec<Cell>,
}

/// A point with what the model has there.
struct Expected {
    at: [f64; 3],
    value: f64,
    /// The largest difference that is allowed.
    allowed: f64,
}

impl Search<'_> {
    /// Samples new lines of sight: number `round` of several such verifications.
    pub(super) async fn verify(
        &mut self,
        model: &Model,
        maps: &Maps,
        round: usize,
    ) -> Result<Verdict, Failure> {
        let count = TUNING.surfaces.lines;
        let first = FIRST_LINE + round * count;
        let mut places: Vec<[f64; 2]> =
            (first..first + count / 2).map(lattice::point).map(|[x, y, _]| [x, y]).collect();
        places.extend(self.worst_places(maps, count / 2, round));
        let mut expected = Vec::new();
        for (number, place) in places.into_iter().enumerate() {
            self.expect_on_line(model, place, number, &mut expected);
        }
        let points: Vec<[f64; 3]> = expected.iter().map(|of| of.at).collect();
        let samples = self.sample(&points).await?;
        let mut verdict = Verdict { has_passed: true, wrong: Vec::new() };
        let seen = |(_, sample): &(&Expected, usize)| !self.samples.is_hidden(*sample);
        for (of, sample) in expected.iter().zip(samples).filter(seen) {
            let (cell, leaf) = &model.tree.leaves[model.tree.find(of.at)];
            let unresolved = if let Leaf::Unresolved(_, jump) = leaf { *jump } else { 0.0 };
            let difference = (self.samples.get(sample).rate - of.value).abs();
            if difference <= of.allowed + unresolved {
                continue;
            }
            verdict.has_passed = false;
            if cell.0 < self.grid.finest {
                verdict.wrong.push(*cell);
            }
        }
        verdict.wrong.sort_unstable();
        verdict.wrong.dedup();
        Ok(verdict)
    }

    /// The points on both sides of the crossings of a line, and between them.
    fn expect_on_line(
        &self,
        model: &Model,
        place: [f64; 2],
        number: usize,
        expected: &mut Vec<Expected>,
    ) {
        let edges = self.grid.edges;
        let [x, y] = [place[0] * edges[0], place[1] * edges[1]];
        let of_line = self.aim.of_line(place);
        if !self.aim.is_in_view(place) {
            return;
        }
        let ray = Ray::new(&model.tree, [x, y], self.aim.ends_of_line(&self.grid, [x, y]));
        let mut add = |z: f64, error: f64| {
            let at = [x, y, z];
            let value = model.value(at);
            let pieces = TUNING.surfaces.piece_disagreement * of_line;
            expected.push(Expected { at, value, allowed: pieces + error });
        };
        for segment in ray.segments.iter().filter(|of| of.label != HIDDEN) {
            let [from, to] = segment.ends;
            // Not too close to the crossings at its ends.
            let near = |z: f64| {
                let crossings = ray.crossings.iter();
                crossings.filter(|of| (of[0] - z).abs() < 1e-9 * edges[2]).map(|of| of[2]).next()
            };
            let [low, high] = [near(from), near(to)]
                .map(|of| TUNING.surfaces.check_distance * of.unwrap_or(0.0) + 1e-9 * edges[2]);
            let [from, to] = [from + low, to - high];
            if from >= to {
                continue;
            }
            add(from, 0.0);
            add(to, 0.0);
            // Somewhere between, at another place on each line.
            let [_, _, share] = lattice::point(number);
            add(from + (to - from) * (0.1 + 0.8 * share), 0.0);
        }
    }

    /// The centres of pixels with large errors, at a distance from each other.
    fn worst_places(&self, maps: &Maps, count: usize, round: usize) -> Vec<[f64; 2]> {
        let [height, width] = [maps.error.height(), maps.error.width()];
        let mut order: Vec<usize> = (0..height * width).collect();
        let error = |pixel: usize| maps.error.pixels()[pixel];
        order.sort_by(|&a, &b| error(b).total_cmp(&error(a)).then(a.cmp(&b)));
        let mut places: Vec<[f64; 2]> = Vec::new();
        for pixel in order.into_iter().skip(round) {
            if places.len() == count {
                break;
            }
            let (place, _) = self.aim.line(pixel, [0.5; 2]);
            let is_near = |other: &[f64; 2]| {
                (0..2)
                    .all(|k| (other[k] - place[k]).abs() < TUNING.verification.worst_line_distance)
            };
            if !places.iter().any(is_near) {
                places.push(place);
            }
        }
        places
    }
}
