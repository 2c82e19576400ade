//! Points in buckets, to find the nearest ones.

use crate::projection::vector::{difference, norm};
use crate::vol::surfaces::nearest::keep_nearest;
use rustc_hash::FxHashMap;

/// The number of rings of buckets in which points are searched for.
const RINGS: i32 = 6;
/// How much smaller small buckets are, and how many times the points asked for a bucket has where they are used. Either
/// way the same points are found.
const SMALLER: f64 = 4.0;
const MANY: usize = 2;

/// Points with their numbers, in buckets.
#[derive(Debug)]
struct Buckets {
    edge: f64,
    points: FxHashMap<[i32; 3], Vec<([f64; 3], usize)>>,
}

impl Buckets {
    fn new(edge: f64) -> Self {
        Self { edge, points: FxHashMap::default() }
    }

    fn place(&self, at: [f64; 3]) -> [i32; 3] {
        #[expect(clippy::cast_possible_truncation, reason = "a view has few buckets")]
        at.map(|along| (along / self.edge).floor() as i32)
    }

    fn add(&mut self, at: [f64; 3], number: usize) {
        self.points.entry(self.place(at)).or_default().push((at, number));
    }

    /// The nearest points, and whether there are none as near beyond the rings of buckets.
    fn nearest(&self, at: [f64; 3], count: usize) -> (Vec<(f64, usize)>, bool) {
        let middle = self.place(at);
        let (mut found, mut are_all) = (Vec::new(), false);
        for ring in 0..=RINGS {
            for dx in -ring..=ring {
                for dy in -ring..=ring {
                    let is_side = dx.abs() == ring || dy.abs() == ring;
                    let step = if is_side || ring == 0 { 1 } else { 2 * ring };
                    let mut dz = -ring;
                    while dz <= ring {
                        let place = [middle[0] + dx, middle[1] + dy, middle[2] + dz];
                        for (point, number) in self.points.get(&place).into_iter().flatten() {
                            found.push((norm(difference(*point, at)), *number));
                        }
                        dz += step;
                    }
                }
            }
            let covered = f64::from(ring) * self.edge;
            are_all = found.iter().filter(|(distance, _)| *distance <= covered).count() >= count;
            if are_all {
                break;
            }
        }
        keep_nearest(&mut found, count);
        (found, are_all)
    }
}

/// Points in buckets and, to be found faster where they are many, in small ones.
#[derive(Debug)]
pub(super) struct PlacedPoints {
    usual: Buckets,
    small: Buckets,
}

impl PlacedPoints {
    /// No points; `edge` is that of a bucket.
    pub(super) fn new(edge: f64) -> Self {
        Self { usual: Buckets::new(edge), small: Buckets::new(edge / SMALLER) }
    }

    pub(super) fn add(&mut self, at: [f64; 3], number: usize) {
        self.usual.add(at, number);
        self.small.add(at, number);
    }

    /// The numbers of the nearest points with their distances, the nearest first.
    pub(super) fn nearest(&self, at: [f64; 3], count: usize) -> Vec<(f64, usize)> {
        let beside = self.usual.points.get(&self.usual.place(at)).map_or(0, Vec::len);
        if beside > MANY * count
            && let (found, true) = self.small.nearest(at, count)
        {
            return found;
        }
        self.usual.nearest(at, count).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::lattice;

    /// Half of the points are in one bucket.
    #[test]
    fn the_nearest_points_are_those_of_a_comparison_of_all() {
        let dense = |k: usize| if k.is_multiple_of(2) { 0.04 } else { 1.0 };
        let points: Vec<[f64; 3]> =
            (0..1000).map(|k| lattice::point(k).map(|along| dense(k) * along)).collect();
        let mut placed = PlacedPoints::new(0.05);
        points.iter().zip(0..).for_each(|(at, number)| placed.add(*at, number));
        for scale in [0.04, 0.06, 1.0] {
            for k in 0..20 {
                let at = lattice::point(2000 + k).map(|along| scale * along);
                let distance = |point: &[f64; 3]| norm(difference(*point, at));
                let mut all: Vec<(f64, usize)> = points.iter().map(distance).zip(0..).collect();
                keep_nearest(&mut all, 9);
                assert_eq!(placed.nearest(at, 9), all, "{at:?}");
            }
        }
    }
}
