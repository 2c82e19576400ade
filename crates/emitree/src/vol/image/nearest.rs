//! Search for the nearest of many places in the image plane, with buckets.

use crate::vol::dyadic::{DEEPEST_LEVEL, Place, spacing};

/// Places in square buckets, about two in each.
#[derive(Debug)]
pub(crate) struct Nearest {
    /// There are 2^`level` buckets along each axis.
    level: u8,
    /// The places with their numbers, by bucket, row by row.
    buckets: Vec<Vec<(Place, usize)>>,
}

/// The largest level of buckets.
const FINEST_BUCKETS: u32 = 10;

impl Nearest {
    pub(crate) fn new(places: impl ExactSizeIterator<Item = (Place, usize)>) -> Self {
        let level = ((places.len() / 2).max(1).ilog2() / 2).min(FINEST_BUCKETS);
        let level = u8::try_from(level).unwrap_or(0);
        let mut buckets = vec![Vec::new(); 1 << (2 * level)];
        for (place, number) in places {
            let [column, row] = bucket(place, level);
            buckets[(row << level) + column].push((place, number));
        }
        Self { level, buckets }
    }

    /// The squares of the distances and the numbers of the `count` places nearest to `place`, by
    /// distance and then by number.
    pub(crate) fn find(&self, place: Place, count: usize) -> Vec<(u64, usize)> {
        let mut nearest: Vec<(u64, usize)> = Vec::with_capacity(count + 1);
        let side = 1_usize << self.level;
        let centre = bucket(place, self.level);
        for ring in 0..side {
            // All places nearer than the inner border of the ring have been compared.
            let covered = (ring.saturating_sub(1) as u64) * u64::from(spacing(self.level));
            if nearest.len() == count && nearest[count - 1].0 < covered * covered {
                break;
            }
            for (column, row) in around(centre, ring, side) {
                for &(other, number) in &self.buckets[(row << self.level) + column] {
                    let along = |axis: usize| u64::from(other[axis].abs_diff(place[axis])).pow(2);
                    let entry = (along(0) + along(1), number);
                    if nearest.len() < count || entry < nearest[count - 1] {
                        let at = nearest.partition_point(|found| *found < entry);
                        nearest.insert(at, entry);
                        nearest.truncate(count);
                    }
                }
            }
        }
        nearest
    }
}

/// Column and row of the bucket of a place.
fn bucket(place: Place, level: u8) -> [usize; 2] {
    let last = (1_usize << level) - 1;
    place.map(|along| ((along >> (DEEPEST_LEVEL - level)) as usize).min(last))
}

/// Columns and rows of the buckets in a square ring.
fn around(
    [column, row]: [usize; 2],
    ring: usize,
    side: usize,
) -> impl Iterator<Item = (usize, usize)> {
    let along = move |middle: usize| middle.saturating_sub(ring)..(middle + ring + 1).min(side);
    along(row).flat_map(move |r| {
        let on_edge = r.abs_diff(row) == ring;
        along(column).filter(move |c| on_edge || c.abs_diff(column) == ring).map(move |c| (c, r))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::dyadic::STEPS;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_nearest_are_those_of_a_search_through_all(
            places in prop::collection::vec([0..=STEPS, 0..=STEPS], 1..400),
            narrow in prop::collection::vec([0..=STEPS / 50, 0..=STEPS], 0..100),
            place in [0..=STEPS, 0..=STEPS],
            count in 1..20_usize,
        ) {
            let places: Vec<Place> = places.into_iter().chain(narrow).collect();
            let mut all: Vec<(u64, usize)> = places
                .iter()
                .enumerate()
                .map(|(i, other)| {
                    let along = |a: usize| u64::from(other[a].abs_diff(place[a])).pow(2);
                    (along(0) + along(1), i)
                })
                .collect();
            all.sort_unstable();
            all.truncate(count);
            let numbered: Vec<(Place, usize)> = places.into_iter().zip(0..).collect();
            let nearest = Nearest::new(numbered.into_iter());
            prop_assert_eq!(nearest.find(place, count), all);
        }
    }
}
