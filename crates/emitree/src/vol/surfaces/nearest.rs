//! The nearest of several, by their distances, and of many in buckets.

use crate::projection::vector::{difference, norm};
use rustc_hash::FxHashMap;

/// The number of sizes of buckets, each half as long as the one before: samples lie close together at surfaces.
const SIZES: usize = 4;
/// The most rings of buckets of a size around the bucket of a place.
const RINGS: i32 = 2;
/// The share of the wanted number in the bucket of a place with which this size is small enough: a sheet has three times
/// as many within a ring.
const ENOUGH: usize = 3;

/// Numbers of places, in buckets of several sizes.
#[derive(Debug)]
pub(super) struct Buckets {
    sizes: [FxHashMap<[i32; 3], Vec<u32>>; SIZES],
    /// The edge of the largest buckets.
    edge: f64,
}

impl Buckets {
    pub(super) fn new(edge: f64) -> Self {
        Self { sizes: Default::default(), edge }
    }

    /// The edge of the buckets of a size, and the bucket of a place.
    fn bucket(&self, size: usize, at: [f64; 3]) -> (f64, [i32; 3]) {
        let edge = self.edge / (1 << size) as f64;
        #[expect(clippy::cast_possible_truncation, reason = "a view has few buckets")]
        (edge, at.map(|along| (along / edge).floor() as i32))
    }

    /// Adds a number at a place.
    pub(super) fn add(&mut self, at: [f64; 3], number: usize) {
        let number = u32::try_from(number).unwrap_or(u32::MAX);
        for size in 0..SIZES {
            let (_, bucket) = self.bucket(size, at);
            self.sizes[size].entry(bucket).or_default().push(number);
        }
    }

    /// So many of the nearest numbers with their distances, the nearest first, given the place of each: all within as many
    /// rings of the largest buckets, if these are fewer.
    pub(super) fn nearest(
        &self,
        at: [f64; 3],
        count: usize,
        place: impl Fn(usize) -> [f64; 3],
    ) -> Vec<(f64, usize)> {
        let mut found: Vec<(f64, usize)> = Vec::new();
        for (size, buckets) in self.sizes.iter().enumerate().rev() {
            let (edge, middle) = self.bucket(size, at);
            if size > 0 && ENOUGH * buckets.get(&middle).map_or(0, Vec::len) < count {
                continue;
            }
            found.clear();
            for ring in 0..=RINGS {
                for step in ring_of_buckets(ring) {
                    let around = core::array::from_fn(|k| middle[k] + step[k]);
                    for &number in buckets.get(&around).into_iter().flatten() {
                        let number = number as usize;
                        found.push((norm(difference(place(number), at)), number));
                    }
                }
                let covered = f64::from(ring) * edge;
                if found.iter().filter(|(distance, _)| *distance <= covered).count() >= count {
                    keep_nearest(&mut found, count);
                    return found;
                }
            }
        }
        keep_nearest(&mut found, count);
        found
    }
}

/// The steps to the buckets of a ring.
fn ring_of_buckets(ring: i32) -> impl Iterator<Item = [i32; 3]> {
    let sides = move || -ring..=ring;
    let of_pair = move |(dx, dy): (i32, i32)| {
        let is_side = dx.abs() == ring || dy.abs() == ring;
        let step = if is_side { 1 } else { 2 * ring };
        (-ring..=ring)
            .step_by(usize::try_from(step).unwrap_or(1).max(1))
            .map(move |dz| [dx, dy, dz])
    };
    sides().flat_map(move |dx| sides().map(move |dy| (dx, dy))).flat_map(of_pair)
}

/// Keeps at most so many entries with the least distances, the nearest first; equal distances are in the
/// order of their numbers.
pub(super) fn keep_nearest(found: &mut Vec<(f64, usize)>, count: usize) {
    let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    if found.len() > count && count > 0 {
        found.select_nth_unstable_by(count - 1, order);
    }
    found.truncate(count);
    found.sort_unstable_by(order);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::lattice;

    #[test]
    fn the_nearest_in_buckets_are_those_of_all() {
        // Most places are in a small part.
        let place = |number: usize| {
            let u = lattice::point(number);
            if number.is_multiple_of(4) { u } else { u.map(|along| 0.3 + 0.05 * along) }
        };
        let mut buckets = Buckets::new(1.0);
        (0..2000).for_each(|number| buckets.add(place(number), number));
        for at in (5000..5040).map(place) {
            let distance = |number: usize| (norm(difference(place(number), at)), number);
            let all: Vec<(f64, usize)> = (0..2000).map(distance).collect();
            for count in [1, 7, 32, 300] {
                let mut expected = all.clone();
                keep_nearest(&mut expected, count);
                assert_eq!(buckets.nearest(at, count, place), expected);
            }
        }
    }

    #[test]
    fn rings_are_the_surface_of_a_cube() {
        for (ring, count) in [(0, 1), (1, 26), (2, 98)] {
            let mut steps: Vec<[i32; 3]> = ring_of_buckets(ring).collect();
            assert!(steps.iter().all(|step| step.iter().any(|along| along.abs() == ring)));
            steps.sort_unstable();
            steps.dedup();
            assert_eq!(steps.len(), count);
        }
    }

    #[test]
    fn the_first_entries_in_order_are_kept() {
        let all = [(0.5, 0), (0.2, 1), (0.7, 2), (0.2, 3), (0.1, 4)];
        let sorted = [(0.1, 4), (0.2, 1), (0.2, 3), (0.5, 0), (0.7, 2)];
        for count in 0..7 {
            let mut found = all.to_vec();
            keep_nearest(&mut found, count);
            assert_eq!(found, sorted[..count.min(5)]);
        }
    }
}
