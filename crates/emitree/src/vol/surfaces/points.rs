//! The points of surfaces by pairs of regions and by places.

use crate::projection::vector::{difference, norm};
use crate::vol::surfaces::nearest::keep_nearest;
use crate::vol::surfaces::octree::Label;
use crate::vol::surfaces::patch::FitPoint;
use crate::vol::surfaces::search::Search;
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
    pub(super) fn new(search: &Search<'_>, size: f64) -> Self {
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

    /// The numbers of so many points of a pair within some reaches of a place with their distances, the
    /// nearest first.
    fn numbers(
        &self,
        search: &Search<'_>,
        pair: (Label, Label),
        at: [f64; 3],
        reaches: i32,
        count: usize,
    ) -> Vec<(f64, usize)> {
        let Some(of_pair) = self.pairs.get(&pair) else { return Vec::new() };
        let middle = place(at, self.bucket);
        let mut near: Vec<(f64, usize)> = Vec::new();
        let side = 2 * reaches + 1;
        for turn in 0..side * side * side {
            let step = [turn % side, turn / side % side, turn / (side * side)];
            let around = core::array::from_fn(|k| middle[k] + step[k] - reaches);
            for &number in of_pair.buckets.get(&around).into_iter().flatten() {
                let distance = norm(difference(search.points[number].at, at));
                if distance <= f64::from(reaches) * self.bucket {
                    near.push((distance, number));
                }
            }
        }
        keep_nearest(&mut near, count);
        near
    }

    /// The points of a pair within some reaches of a place, the nearest first.
    pub(super) fn near(
        &self,
        search: &Search<'_>,
        pair: (Label, Label),
        at: [f64; 3],
        reaches: i32,
    ) -> Vec<FitPoint> {
        let point = |(distance, number): (f64, usize)| {
            let point = &search.points[number];
            let is_upward = search.samples.label(point.samples[1]) == pair.1;
            FitPoint { at: point.at, axis: point.axis, is_upward, distance }
        };
        let near = self.numbers(search, pair, at, reaches, TUNING.surfaces.most_points);
        near.into_iter().map(point).collect()
    }

    /// The mean jump, from the first to the second region of a pair, at the points nearest to a place;
    /// `None` without points.
    pub(super) fn jump(
        &self,
        search: &Search<'_>,
        pair: (Label, Label),
        at: [f64; 3],
    ) -> Option<f64> {
        let near = self.numbers(search, pair, at, 1, 4);
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
    pub(super) fn continued(
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
                    self.near(search, other, at, 1)
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
