//! Borders between regions of which no jump is known: a region may have been found twice.
//!
//! A sample that fits no region nearby begins a new one, and two arms of one region may meet where no cell
//! has an edge between them. Where two regions are in one cell, the segment between two of their samples is
//! divided, and regions between which G does not jump become one.

use crate::projection::vector::{along, difference, norm};
use crate::vol::surfaces::octree::Label;
use crate::vol::surfaces::search::{Failure, OpenCell, Search};
use crate::vol::tuning::TUNING;
use std::collections::BTreeMap;

/// The most borders that are tested at once.
const MOST_TESTS: usize = 64;

/// Two samples of two regions in one cell.
#[derive(Clone, Copy, Debug)]
struct Pair {
    samples: [usize; 2],
    distance: f64,
}

impl Search<'_> {
    /// Tests the borders of which nothing is known, each between the nearest two samples in one cell.
    pub(super) async fn test_borders(&mut self, cells: &[OpenCell]) -> Result<(), Failure> {
        let mut nearest: BTreeMap<[Label; 2], Pair> = BTreeMap::new();
        for cell in cells {
            let samples: Vec<usize> = self.measured_samples(cell).copied().collect();
            for (k, &a) in samples.iter().enumerate() {
                for &b in &samples[k + 1..] {
                    let [from, to] = [a, b].map(|i| self.samples.label(i));
                    if !self.samples.is_unknown_border(from, to) {
                        continue;
                    }
                    let of = |i: usize| self.samples.get(i).at;
                    let pair = Pair { samples: [a, b], distance: norm(difference(of(a), of(b))) };
                    let known = nearest.entry([from.min(to), from.max(to)]).or_insert(pair);
                    if pair.distance < known.distance {
                        *known = pair;
                    }
                }
            }
        }
        let mut pairs: Vec<Pair> = nearest.into_values().collect();
        pairs.truncate(MOST_TESTS);
        let first: Vec<f64> = pairs.iter().map(|pair| self.change(*pair)).collect();
        for _ in 0..TUNING.surfaces.halvings {
            let middle = |pair: &Pair| {
                let [a, b] = pair.samples.map(|i| self.samples.get(i).at);
                along(a, 0.5, difference(b, a))
            };
            let points: Vec<[f64; 3]> = pairs.iter().map(middle).collect();
            let samples = self.sample(&points).await?;
            for (pair, sample) in pairs.iter_mut().zip(samples) {
                // The half with the larger change.
                let halves = [0, 1].map(|k| {
                    let mut half = *pair;
                    half.samples[1 - k] = sample;
                    half
                });
                *pair = halves[usize::from(self.change(halves[1]) > self.change(halves[0]))];
            }
        }
        for (pair, first) in pairs.into_iter().zip(first) {
            let [a, b] = pair.samples.map(|i| self.samples.label(i));
            let is_seen = !pair.samples.iter().any(|&i| self.samples.is_hidden(i));
            if a != b && is_seen {
                let least = TUNING.surfaces.slope_left * first;
                let is_jump = self.change(pair) > least.max(self.samples.negligible);
                self.samples.note_border(a, b, is_jump);
            }
        }
        Ok(())
    }

    fn change(&self, pair: Pair) -> f64 {
        let [a, b] = pair.samples.map(|i| self.samples.get(i).rate);
        (b - a).abs()
    }
}
