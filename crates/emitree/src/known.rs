//! Stored rates: no point is evaluated twice in one session, nor among the first ones of a rendering.

use crate::exchange::Batch;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::hash_map::Entry;

/// Memory that a rate takes with its point: 64 bytes, in a hash table that has just grown.
pub(crate) const BYTES_PER_KNOWN_RATE: u64 = 160;

/// The bits of a point: position, direction, and energy if there is an axis.
pub(crate) type Point = [u64; 7];

/// The rates at all points that have been evaluated.
#[derive(Clone, Debug, Default)]
pub(crate) struct KnownRates(FxHashMap<Point, f64>);

/// The bits of a point at `position` with a direction, and an energy if there is an axis.
pub(crate) fn key([x, y, z]: [f64; 3], [dx, dy, dz]: [f64; 3], energy: Option<f64>) -> Point {
    [x, y, z, dx, dy, dz, energy.unwrap_or(f64::NAN)].map(f64::to_bits)
}

/// Point `i` of a batch.
pub(crate) fn point(batch: &Batch, i: usize) -> Point {
    key(batch.positions[i], batch.directions[i], batch.energies.get(i).copied())
}

impl KnownRates {
    /// The number of rates.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether each point of a batch has no stored rate and is not an earlier one of the batch.
    pub(crate) fn are_new(&self, batch: &Batch) -> Vec<bool> {
        let mut earlier = FxHashSet::default();
        let is_new = |i| {
            let point = point(batch, i);
            !self.0.contains_key(&point) && earlier.insert(point)
        };
        (0..batch.len()).map(is_new).collect()
    }

    /// The points of a batch without a stored rate.
    pub(crate) fn unknown(&self, batch: &Batch) -> Batch {
        Self::points_that(&self.are_new(batch), batch)
    }

    /// The points of a batch that are new.
    pub(crate) fn points_that(are_new: &[bool], batch: &Batch) -> Batch {
        let numbers = || (0..batch.len()).filter(|&i| are_new[i]);
        let positions: Vec<[f64; 3]> = numbers().map(|i| batch.positions[i]).collect();
        Batch {
            directions: numbers().map(|i| batch.directions[i]).collect(),
            energies: numbers().filter_map(|i| batch.energies.get(i).copied()).collect(),
            rates: vec![0.0; positions.len()],
            positions,
        }
    }

    /// Stores the rates of a batch.
    pub(crate) fn insert(&mut self, batch: &Batch) {
        self.0.extend((0..batch.len()).map(|i| (point(batch, i), batch.rates[i])));
    }

    /// Stores the rates of a batch at points without a stored rate, and returns these points.
    pub(crate) fn insert_new(&mut self, batch: &Batch) -> Vec<Point> {
        let mut new = Vec::new();
        for i in 0..batch.len() {
            if let Entry::Vacant(entry) = self.0.entry(point(batch, i)) {
                new.push(*entry.key());
                entry.insert(batch.rates[i]);
            }
        }
        new
    }

    /// Removes the rates at some points.
    pub(crate) fn remove(&mut self, points: &[Point]) {
        for point in points {
            self.0.remove(point);
        }
    }

    /// Fills in the rates of a batch, all of which are stored.
    pub(crate) fn fill(&self, batch: &mut Batch) {
        for i in 0..batch.len() {
            batch.rates[i] = self.0.get(&point(batch, i)).copied().unwrap_or(f64::NAN);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batch(along: &[f64], energies: &[f64]) -> Batch {
        Batch {
            positions: along.iter().map(|&x| [x, 0.0, 0.0]).collect(),
            directions: vec![[0.0, 0.0, 1.0]; along.len()],
            energies: energies.to_vec(),
            rates: along.to_vec(),
        }
    }

    #[test]
    fn stored_rates_are_not_requested_again() {
        let mut known = KnownRates::default();
        known.insert(&batch(&[1.0, 2.0], &[]));
        let mut wanted = batch(&[3.0, 2.0, 1.0], &[]);
        wanted.rates.fill(0.0);
        let unknown = known.unknown(&wanted);
        assert_eq!(unknown.positions, [[3.0, 0.0, 0.0]]);
        known.insert(&batch(&[3.0], &[]));
        known.fill(&mut wanted);
        assert_eq!(wanted.rates, [3.0, 2.0, 1.0]);
    }

    #[test]
    fn rates_that_were_new_can_be_removed() {
        let mut known = KnownRates::default();
        known.insert(&batch(&[1.0], &[]));
        let mut others = batch(&[1.0, 2.0], &[]);
        others.rates = vec![5.0, 6.0];
        let new = known.insert_new(&others);
        known.fill(&mut others);
        assert_eq!((new.len(), others.rates.as_slice()), (1, [1.0, 6.0].as_slice()));
        known.remove(&new);
        assert_eq!(known.unknown(&others).positions, [[2.0, 0.0, 0.0]]);
    }

    #[test]
    fn another_energy_is_another_point() {
        let mut known = KnownRates::default();
        known.insert(&batch(&[1.0], &[5.0]));
        let unknown = known.unknown(&batch(&[1.0, 1.0, 1.0], &[5.0, 6.0, 6.0]));
        assert_eq!(unknown.energies, [6.0]);
    }
}
