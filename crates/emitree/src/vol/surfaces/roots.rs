//! Points of surfaces: brackets of a change of region along an edge.

use crate::projection::vector::{along, difference, norm};
use crate::vol::surfaces::octree::Label;

/// The search for a change of region between two points.
///
/// Each evaluation divides the bracket into two parts that are equally probable. Where the change is expected at a place, it
/// has a Cauchy distribution about this place, as the distances of surfaces from patches have, otherwise a uniform one. If
/// that place is wrong, the distances of the evaluations from it double, since the distribution falls slowly.
#[derive(Clone, Debug)]
pub(super) struct RootSearch {
    from: [f64; 3],
    direction: [f64; 3],
    /// The end that is in the first region, and that which is not, as fractions of the edge.
    low: f64,
    high: f64,
    /// Half of the length of the bracket at which the search ends.
    width: f64,
    /// The place at which the change is expected, and the half width of the distribution.
    expected: Option<(f64, f64)>,
    first: Label,
    /// The samples at the ends.
    pub(super) samples: [usize; 2],
    /// Those at the ends of the edge.
    pub(super) ends: [usize; 2],
}

impl RootSearch {
    /// A search between samples at two points, in the region `first` at the first of them, to a
    /// bracket of length 2 `width`. A surface is expected at a fraction of the edge, to within a length.
    pub(super) fn new(
        [from, to]: [[f64; 3]; 2],
        samples: [usize; 2],
        first: Label,
        width: f64,
        expected: Option<(f64, f64)>,
    ) -> Self {
        let direction = difference(to, from);
        let length = norm(direction).max(f64::MIN_POSITIVE);
        let width = (width / length).max(1e-12);
        let expected = expected.map(|(at, scale)| (at, (scale / length).max(1e-12)));
        let (low, high) = (0.0, 1.0);
        Self { from, direction, low, high, width, expected, first, samples, ends: samples }
    }

    /// The next place; none at the end.
    fn next(&self) -> Option<f64> {
        let [low, high] = [self.low, self.high];
        if high - low <= 2.0 * self.width {
            return None;
        }
        // A little less than the length at which the search ends, so that rounding leaves no longer bracket.
        let last = 1.999 * self.width;
        let least = [low + last, high - last];
        // A place closer to an end than that would not end the search any earlier.
        let is_long = least[0] < least[1];
        Some(if is_long { self.median().clamp(least[0], least[1]) } else { 0.5 * (low + high) })
    }

    /// The place in the bracket at which the change is as likely before as beyond it.
    fn median(&self) -> f64 {
        let ends = [self.low, self.high];
        self.expected.map_or(0.5 * (ends[0] + ends[1]), |expected| median(ends, expected))
    }

    /// The next point; none at the end.
    pub(super) fn point(&self) -> Option<[f64; 3]> {
        self.next().map(|at| along(self.from, at, self.direction))
    }

    /// The width of the bracket, as a fraction of the edge.
    pub(super) fn width_share(&self) -> f64 {
        self.high - self.low
    }

    /// Takes the sample at that point, and its region.
    pub(super) fn update(&mut self, sample: usize, label: Label) {
        let Some(at) = self.next() else { return };
        if label == self.first {
            (self.low, self.samples[0]) = (at, sample);
        } else {
            (self.high, self.samples[1]) = (at, sample);
        }
    }

    /// The fraction of the edge, and the point, at which the change is as likely before as beyond it.
    pub(super) fn root(&self) -> (f64, [f64; 3]) {
        let at = self.median();
        (at, along(self.from, at, self.direction))
    }
}

/// The median of a Cauchy distribution in an interval: the tangent of the mean of two arc tangents.
fn median(ends: [f64; 2], (at, scale): (f64, f64)) -> f64 {
    let [(a, p), (b, q)] = ends.map(|end| {
        let tangent = (end - at) / scale;
        let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
        (cosine, tangent * cosine)
    });
    at + scale * (p + q) / (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The evaluations for a surface at `root`, with the place found.
    fn search(root: f64, expected: Option<(f64, f64)>) -> (usize, f64) {
        let ends = [[0.0, 0.0, 0.2], [0.0, 0.0, 1.2]];
        let mut search = RootSearch::new(ends, [0, 1], 0, 1e-4, expected);
        let mut count = 0;
        while let Some(point) = search.point() {
            count += 1;
            search.update(count, u16::from(point[2] > 0.2 + root));
        }
        (count, search.root().0)
    }

    #[test]
    fn a_good_expectation_takes_two_evaluations_and_a_bad_one_is_corrected() {
        for root in [0.013, 0.4, 0.77, 0.9999] {
            let (count, found) = search(root, None);
            assert!((found - root).abs() <= 1e-4 && count <= 14, "{root} {found} {count}");
            let (count, found) = search(root, Some((root, 1e-4)));
            assert!((found - root).abs() <= 1e-4 && count <= 2, "{root} {found} {count}");
            for wrong in [-0.3, -0.01, 0.002, 0.2] {
                let (count, found) = search(root, Some((root + wrong, 1e-3)));
                assert!((found - root).abs() <= 1e-4 && count <= 24, "{root} {wrong} {count}");
                // The patch passes through all of its points.
                let (count, found) = search(root, Some((root + wrong, 0.0)));
                assert!((found - root).abs() <= 1e-4 && count <= 24, "{root} {wrong} {count}");
            }
        }
    }

    #[test]
    fn the_median_halves_the_probability_of_a_bracket() {
        let (at, scale) = (0.3, 0.02);
        let probability = |place: f64| ((place - at) / scale).atan();
        for ends in [[0.0, 1.0], [0.29, 0.3], [0.5, 0.9], [0.0, 0.1]] {
            let middle = median(ends, (at, scale));
            let [low, high] = ends.map(probability);
            let halves = [probability(middle) - low, high - probability(middle)];
            assert!((halves[0] - halves[1]).abs() < 1e-14, "{ends:?} {middle} {halves:?}");
        }
    }

    /// The information is the entropy of the distribution less that of a uniform one in the last bracket: log₂(4π s / 2w).
    #[test]
    fn evaluations_are_hardly_more_than_the_information() {
        let (at, scale, count) = (0.4, 0.002, 64);
        let roots = (0..count).map(|k| {
            let probability = (f64::from(k) + 0.5) / f64::from(count) - 0.5;
            at + scale * (core::f64::consts::PI * probability).tan()
        });
        let evaluations: usize = roots.map(|root| search(root, Some((at, scale))).0).sum();
        let mean = evaluations as f64 / f64::from(count);
        let information = (4.0 * core::f64::consts::PI * scale / 2e-4).log2();
        assert!((information..information + 0.7).contains(&mean), "{mean} {information}");
    }
}
