//! Means over pixels from values in their middles, and the errors of these means.
//!
//! A mean over a pixel differs from the value in the middle by a 24th of the second differences, and then by fourth
//! differences ([theory](https://en.wikipedia.org/wiki/Midpoint_method)): 17/5760 of them where the image is smooth. At a
//! kink or a jump fourth differences are some three times the second ones, and the mean may be anywhere between the
//! values around it.

use crate::image::Image;
use crate::radiance::map_of_rows;

/// The error of a mean in units of fourth differences, 10 times that of a smooth image.
const OF_FOURTH: f64 = 0.03;
/// The error of a mean in units of second differences where the image is not smooth.
const OF_SECOND: f64 = 0.5;
/// Fourth differences over second ones at a kink.
const AT_A_KINK: f64 = 3.0;
/// How the error falls with that ratio where the image is smoother.
const EXPONENT: f64 = 1.5;
/// At a border of the image second differences are extrapolated: the error in units of what they change.
const AT_BORDER: f64 = 1.0 / 6.0;
/// The mean less the value in the middle, in units of the sum of second differences.
const OF_MEAN: f64 = 1.0 / 24.0;
/// The fewest pixels along each side.
pub(super) const FEWEST: usize = 5;

/// Values in the middles of all pixels, row by row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Middles<'a> {
    pub(super) values: &'a [f64],
    /// Height and width, each at least [`FEWEST`].
    pub(super) shape: [usize; 2],
}

/// What follows from the differences of the values in the middles.
#[derive(Clone, Debug)]
pub(super) struct Means {
    /// The mean over each pixel, less the value in its middle.
    pub(super) corrections: Image,
    /// The estimated error of each mean.
    pub(super) errors: Image,
    /// The largest sum of |second differences| of a pixel and those beside it.
    pub(super) variation: Image,
}

/// Second differences along one axis, and the errors of those that are extrapolated to borders.
#[derive(Clone, Copy, Debug, Default)]
struct Second {
    difference: f64,
    error: f64,
}

impl Middles<'_> {
    /// The second difference at a place of a line of `count` values, given that at inner places.
    fn along(at: usize, count: usize, inner: impl Fn(usize) -> f64) -> Second {
        let last = count - 1;
        if at != 0 && at != last {
            return Second { difference: inner(at), error: 0.0 };
        }
        let [beside, behind] = if at == 0 { [1, 2] } else { [last - 1, last - 2] };
        let [beside, behind] = [inner(beside), inner(behind)];
        let change = beside - behind;
        Second { difference: beside + change, error: AT_BORDER * change.abs() }
    }

    fn value(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.shape[1] + column]
    }

    /// The second differences along rows and along columns.
    fn second(&self, row: usize, column: usize) -> [Second; 2] {
        let [height, width] = self.shape;
        let across = |a: f64, b: f64, c: f64| a - 2.0 * b + c;
        let in_row = |at: usize| {
            across(self.value(row, at - 1), self.value(row, at), self.value(row, at + 1))
        };
        let in_column = |at: usize| {
            across(self.value(at - 1, column), self.value(at, column), self.value(at + 1, column))
        };
        [Self::along(column, width, in_row), Self::along(row, height, in_column)]
    }

    /// The sum of |fourth differences|; of the nearest inner pixel at borders.
    fn fourth(&self, row: usize, column: usize) -> f64 {
        let [height, width] = self.shape;
        let inner_row = row.clamp(1, height - 2);
        let inner_column = column.clamp(1, width - 2);
        let of_row = |at: usize| self.second(row, at)[0].difference;
        let of_column = |at: usize| self.second(at, column)[1].difference;
        let across = |a: f64, b: f64, c: f64| (a - 2.0 * b + c).abs();
        across(of_row(inner_column - 1), of_row(inner_column), of_row(inner_column + 1))
            + across(of_column(inner_row - 1), of_column(inner_row), of_column(inner_row + 1))
    }

    /// The means over pixels with their errors.
    pub(super) fn means(&self) -> Means {
        let [height, width] = self.shape;
        let map = |of: &(dyn Fn(usize, usize) -> f64 + Sync)| {
            map_of_rows(self.shape, |row, pixels| {
                pixels.iter_mut().enumerate().for_each(|(column, pixel)| *pixel = of(row, column));
            })
        };
        let second = map(&|row, column| {
            self.second(row, column).iter().map(|of| of.difference.abs()).sum()
        });
        let fourth = map(&|row, column| self.fourth(row, column));
        let around = |of: &Image, row: usize, column: usize| {
            let columns = column.saturating_sub(1)..(column + 2).min(width);
            let rows = row.saturating_sub(1)..(row + 2).min(height);
            let values = rows.flat_map(|row| &of.row(row)[columns.clone()]);
            values.copied().fold(0.0, f64::max)
        };
        let variation = map(&|row, column| around(&second, row, column));
        let errors = map(&|row, column| {
            let (second, fourth) = (variation.row(row)[column], around(&fourth, row, column));
            let at_border: f64 = self.second(row, column).iter().map(|of| of.error).sum();
            if second <= 0.0 {
                return at_border;
            }
            let smoothness = (fourth / (AT_A_KINK * second)).min(1.0).powf(EXPONENT);
            at_border + f64::max(OF_FOURTH * fourth, OF_SECOND * second * smoothness)
        });
        let corrections = map(&|row, column| {
            let sum: f64 = self.second(row, column).iter().map(|of| of.difference).sum();
            OF_MEAN * sum
        });
        Means { corrections, errors, variation }
    }

    /// The value at a place of the image, from 0 to 1 along each axis, by the parabolas through the nine values around it,
    /// and the pixel in the middle of these.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> (f64, usize) {
        let [height, width] = self.shape;
        let parabola = |along: f64, count: usize| {
            let at = along * count as f64 - 0.5;
            let middle = crate::cell::whole(at.round().max(0.0)).clamp(1, count - 2);
            let t = at - middle as f64;
            (middle, [0.5 * t * (t - 1.0), 1.0 - t * t, 0.5 * t * (t + 1.0)])
        };
        let ((column, of_columns), (row, of_rows)) = (parabola(x, width), parabola(y, height));
        let of_row = |k: usize| -> f64 {
            let weights = of_columns.iter().enumerate();
            weights.map(|(j, weight)| weight * self.value(row + k - 1, column + j - 1)).sum()
        };
        let value = of_rows.iter().enumerate().map(|(k, weight)| weight * of_row(k)).sum();
        (value, row * width + column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Middles and means of exp(a x + b y), whose mean has a closed form.
    fn exponential(shape: [usize; 2], [a, b]: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
        let [height, width] = shape;
        let mean = |slope: f64| 2.0 * (0.5 * slope).sinh() / slope;
        let middle = |k: usize| {
            let [x, y] = [(k % width) as f64 / width as f64, (k / width) as f64 / height as f64];
            (a * x + b * y).exp()
        };
        let middles: Vec<f64> = (0..height * width).map(middle).collect();
        let factor = mean(a / width as f64) * mean(b / height as f64);
        let means = middles.iter().map(|middle| factor * middle).collect();
        (middles, means)
    }

    #[test]
    fn means_of_a_smooth_image_are_within_their_errors() {
        for shape in [[5, 9], [16, 12], [40, 40]] {
            let (middles, exact) = exponential(shape, [3.0, -2.0]);
            let found = Middles { values: &middles, shape }.means();
            for (k, exact) in exact.iter().enumerate() {
                let error = (middles[k] + found.corrections.pixels()[k] - exact).abs();
                assert!(error <= found.errors.pixels()[k], "{shape:?} {k}");
                assert!(found.errors.pixels()[k] < 0.03 * exact, "{shape:?} {k}");
            }
        }
    }

    #[test]
    fn a_jump_has_the_error_of_half_of_it() {
        let shape = [8, 10];
        let values: Vec<f64> = (0..80).map(|k| if k % 10 < 5 { 0.0 } else { 1.0 }).collect();
        let found = Middles { values: &values, shape }.means();
        for row in 0..8 {
            assert!(found.errors.row(row)[4] >= 0.5 && found.errors.row(row)[5] >= 0.5, "{row}");
            assert!(found.errors.row(row)[1].abs() < 1e-12, "{row}");
        }
    }

    #[test]
    fn values_between_middles_are_those_of_parabolas() {
        let shape = [6, 7];
        let of = |x: f64, y: f64| 1.0 + x * x - 3.0 * x * y + y * y;
        let values: Vec<f64> = (0..42)
            .map(|k| of(((k % 7) as f64 + 0.5) / 7.0, ((k / 7) as f64 + 0.5) / 6.0))
            .collect();
        for [x, y] in [[0.5, 0.5], [0.01, 0.99], [0.3, 0.72]] {
            let (found, pixel) = Middles { values: &values, shape }.at([x, y]);
            assert!((found - of(x, y)).abs() < 1e-12 && pixel < 42, "{x} {y}");
        }
    }
}
