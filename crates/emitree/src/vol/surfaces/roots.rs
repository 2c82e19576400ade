//! Points of surfaces: brackets of a change of region along an edge.

use crate::projection::vector::{along, difference, norm};
use crate::vol::surfaces::octree::Label;

/// The search for a change of region between two points.
#[derive(Clone, Debug)]
pub(super) struct RootSearch {
    from: [f64; 3],
    direction: [f64; 3],
    /// The end that is in the first region, and that which is not, as fractions of the edge.
    low: f64,
    high: f64,
    /// The width at which the search ends.
    width: f64,
    /// The place at which the change is expected, and the half width of its bracket.
    guess: Option<(f64, f64)>,
    first: Label,
    /// The samples at the ends.
    pub(super) samples: [usize; 2],
    /// Those at the ends of the edge.
    pub(super) ends: [usize; 2],
}

/// A place at which G is to be evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Next {
    BelowGuess(f64),
    AboveGuess(f64),
    Middle(f64),
}

impl RootSearch {
    /// A search between samples at two points, in the region `first` at the first of them, to a
    /// bracket of length 2 `width`. A surface is expected at a fraction of the edge, within a length.
    pub(super) fn new(
        [from, to]: [[f64; 3]; 2],
        samples: [usize; 2],
        first: Label,
        width: f64,
        guess: Option<(f64, f64)>,
    ) -> Self {
        let direction = difference(to, from);
        let length = norm(direction).max(f64::MIN_POSITIVE);
        let width = (width / length).max(1e-12);
        let guess = guess.map(|(at, half)| (at, (half / length).min(0.3).max(width)));
        Self { from, direction, low: 0.0, high: 1.0, width, guess, first, samples, ends: samples }
    }

    fn next(&self) -> Option<Next> {
        if self.high - self.low <= 2.0 * self.width {
            return None;
        }
        if let Some((at, half)) = self.guess {
            if at - half > self.low {
                return Some(Next::BelowGuess((at - half).min(self.high)))
                    .filter(|_| at - half < self.high)
                    .or(Some(Next::Middle(0.5 * (self.low + self.high))));
            }
            if at + half < self.high {
                return Some(Next::AboveGuess(at + half));
            }
        }
        Some(Next::Middle(0.5 * (self.low + self.high)))
    }

    /// The next point; none at the end.
    pub(super) fn point(&self) -> Option<[f64; 3]> {
        self.next().map(|next| match next {
            Next::BelowGuess(at) | Next::AboveGuess(at) | Next::Middle(at) => {
                along(self.from, at, self.direction)
            }
        })
    }

    /// The width of the bracket, as a fraction of the edge.
    pub(super) fn width_share(&self) -> f64 {
        self.high - self.low
    }

    /// Takes the sample at that point, and its region.
    pub(super) fn update(&mut self, sample: usize, label: Label) {
        let Some(next) = self.next() else { return };
        let is_first = label == self.first;
        let (Next::BelowGuess(at) | Next::AboveGuess(at) | Next::Middle(at)) = next;
        if is_first {
            self.low = at;
            self.samples[0] = sample;
        } else {
            self.high = at;
            self.samples[1] = sample;
        }
        // A bracket that is missed is moved beyond the miss, and widened.
        if let Some((_, half)) = self.guess {
            let moved = match (next, is_first) {
                (Next::BelowGuess(_), false) => Some(at - 2.0 * half),
                (Next::AboveGuess(_), true) => Some(at + 2.0 * half),
                _ => None,
            };
            if let Some(moved) = moved {
                self.guess = Some((moved, 2.0 * half));
            }
            if matches!(next, Next::Middle(_)) {
                self.guess = None;
            }
        }
    }

    /// The fraction of the edge, and the point, in the middle of the bracket.
    pub(super) fn root(&self) -> (f64, [f64; 3]) {
        let middle = 0.5 * (self.low + self.high);
        (middle, along(self.from, middle, self.direction))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The evaluations for a surface at `root`, with the place found.
    fn search(root: f64, guess: Option<(f64, f64)>) -> (usize, f64) {
        let ends = [[0.0, 0.0, 0.2], [0.0, 0.0, 1.2]];
        let mut search = RootSearch::new(ends, [0, 1], 0, 1e-4, guess);
        let mut count = 0;
        while let Some(point) = search.point() {
            count += 1;
            search.update(count, u16::from(point[2] > 0.2 + root));
        }
        (count, search.root().0)
    }

    #[test]
    fn a_good_guess_takes_two_evaluations_and_a_bad_one_is_corrected() {
        for root in [0.013, 0.4, 0.77, 0.9999] {
            let (count, found) = search(root, None);
            assert!((found - root).abs() <= 1e-4 && count <= 14, "{root} {found} {count}");
            let (count, found) = search(root, Some((root, 1e-4)));
            assert!((found - root).abs() <= 1e-4 && count <= 2, "{root} {found} {count}");
            for wrong in [-0.3, -0.01, 0.002, 0.2] {
                let (count, found) = search(root, Some((root + wrong, 1e-3)));
                assert!((found - root).abs() <= 1e-4 && count <= 24, "{root} {wrong} {count}");
            }
        }
    }
}
