//! Regions of an image: circles, ellipses and boxes, as the share of each pixel that they cover.

use crate::image::Image;

/// A circle, an ellipse or a box in pixels: x to the right from 0 to the width, y upwards from 0 to the
/// height. The pixel in row 0, column 0 is from 0 to 1 along both.
///
/// ```
/// use emitree::sums::Region;
///
/// let weights = Region::rectangle([0.5, 0.0], [2.0, 1.0]).weights([2, 3]);
/// assert_eq!(weights.pixels(), [0.5, 1.0, 0.0, 0.0, 0.0, 0.0]);
/// let disc = Region::circle([8.0, 8.0], 5.0).weights([16, 16]);
/// let area: f64 = disc.pixels().iter().sum();
/// assert!((area - 25.0 * std::f64::consts::PI).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Region {
    /// An ellipse with axes along x and y.
    Ellipse {
        /// The centre, x and y.
        center: [f64; 2],
        /// Half of the axes along x and y.
        radii: [f64; 2],
    },
    /// A box with edges along x and y.
    Rectangle {
        /// The corner at the lower left.
        min: [f64; 2],
        /// The corner at the upper right.
        max: [f64; 2],
    },
}

impl Region {
    /// A circle about `center`, x and y.
    pub fn circle(center: [f64; 2], radius: f64) -> Self {
        Self::ellipse(center, [radius; 2])
    }

    /// An ellipse about `center` with half axes `radii` along x and y.
    pub fn ellipse(center: [f64; 2], radii: [f64; 2]) -> Self {
        Self::Ellipse { center, radii }
    }

    /// A box from its lower left corner to its upper right one.
    pub fn rectangle(min: [f64; 2], max: [f64; 2]) -> Self {
        Self::Rectangle { min, max }
    }

    /// The share of each pixel that is in the region, exactly, for an image of `shape` = \[height, width\].
    pub fn weights(&self, [height, width]: [usize; 2]) -> Image {
        let share = |pixel: usize| {
            let from = [pixel % width, pixel / width].map(|along| along as f64);
            self.share_of(from, from.map(|along| along + 1.0))
        };
        Image::from_pixels(height, width, (0..height * width).map(share).collect())
    }

    /// The share of a box that is in the region.
    fn share_of(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let area = (to[0] - from[0]) * (to[1] - from[1]);
        let covered = match *self {
            Self::Rectangle { min, max } => {
                let along = |k: usize| (to[k].min(max[k]) - from[k].max(min[k])).max(0.0);
                along(0) * along(1)
            }
            Self::Ellipse { center, radii } => {
                let scaled = |at: [f64; 2], k: usize| (at[k] - center[k]) / radii[k];
                let [from, to] = [from, to].map(|at| [scaled(at, 0), scaled(at, 1)]);
                radii[0] * radii[1] * in_unit_circle(from, to)
            }
        };
        (covered / area).clamp(0.0, 1.0)
    }
}

/// The area of the part of a box inside the unit circle.
fn in_unit_circle([left, low]: [f64; 2], [right, high]: [f64; 2]) -> f64 {
    let half_chord = |x: f64| (1.0 - x * x).max(0.0).sqrt();
    // ∫ half_chord dx from 0.
    let integral = |x: f64| 0.5 * (x * half_chord(x) + x.asin());
    let (left, right) = (left.clamp(-1.0, 1.0), right.clamp(-1.0, 1.0));
    // Between these places, the ends of each chord are on the circle or on an edge of the box.
    let mut places = vec![left, right];
    for edge in [low, high].into_iter().filter(|edge| edge.abs() < 1.0) {
        let x = half_chord(edge);
        places.extend([-x, x].into_iter().filter(|x| (left..right).contains(x)));
    }
    places.sort_by(f64::total_cmp);
    let of_part = |ends: &[f64]| {
        let [from, to] = [ends[0], ends[1]];
        let chord = half_chord(0.5 * (from + to));
        if high.min(chord) <= low.max(-chord) {
            return 0.0;
        }
        let of_circle = integral(to) - integral(from);
        let above = if high < chord { high * (to - from) } else { of_circle };
        let below = if low > -chord { low * (to - from) } else { -of_circle };
        above - below
    };
    places.windows(2).map(of_part).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn shares_are_those_of_many_points(
            center in [-2.0..14.0_f64, -2.0..12.0],
            radii in [0.1..9.0_f64, 0.1..9.0],
        ) {
            let [height, width] = [10, 12];
            let weights = Region::ellipse(center, radii).weights([height, width]);
            const PARTS: usize = 40;
            for row in 0..height {
                for column in 0..width {
                    let at = |k: usize, first: usize| first as f64 + (k as f64 + 0.5) / PARTS as f64;
                    let is_inside = |k: &usize| {
                        let x = (at(k % PARTS, column) - center[0]) / radii[0];
                        let y = (at(k / PARTS, row) - center[1]) / radii[1];
                        x * x + y * y < 1.0
                    };
                    let share = (0..PARTS * PARTS).filter(is_inside).count() as f64
                        / (PARTS * PARTS) as f64;
                    // A border crosses up to three parts of each of 40 rows.
                    prop_assert!((weights[(row, column)] - share).abs() < 0.05);
                }
            }
        }
    }

    #[test]
    fn a_region_within_the_image_has_its_area() {
        for (center, radii) in
            [([5.0, 5.0], [4.0, 4.0]), ([5.3, 4.1], [0.3, 2.2]), ([5.0; 2], [0.1; 2])]
        {
            let area: f64 = Region::ellipse(center, radii).weights([10, 10]).pixels().iter().sum();
            assert!((area - PI * radii[0] * radii[1]).abs() < 1e-12, "{center:?} {area}");
        }
        let area: f64 =
            Region::rectangle([1.25, 2.5], [3.0, 7.75]).weights([10, 10]).pixels().iter().sum();
        assert!((area - 1.75 * 5.25).abs() < 1e-12);
    }
}
