//! Means over pixels from values in the middles of blocks of pixels, and the errors of these means.
//!
//! Along each axis the value is a polynomial of degree 4 through the five blocks around; its mean over a pixel is
//! exact. The error is a small share of fourth differences where the image is smooth. At a kink or a jump fourth
//! differences are some three times the second ones, and the mean may be anywhere between the values around it.

use crate::image::Image;
use crate::radiance::map_of_rows;

/// Blocks from which a value is computed along each axis.
const STENCIL: usize = 5;
/// The error of a mean in units of fourth differences: fifth ones are at most twice as large, and their share in a
/// pixel is below 0.012.
const OF_FOURTH: f64 = 0.03;
/// The same in the outermost blocks, where the polynomial is extrapolated.
const OF_FOURTH_AT_BORDER: f64 = 0.25;
/// The error of a mean in units of second differences where the image is not smooth.
const OF_SECOND: f64 = 0.5;
/// Fourth differences over second ones at a kink.
const AT_A_KINK: f64 = 3.0;
/// How the error falls with that ratio where the image is smoother.
const EXPONENT: f64 = 1.5;

/// Values in the middles of square blocks of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct LatticeImage<'a> {
    /// Row by row.
    pub(super) values: &'a [f64],
    /// Rows and columns of blocks, each at least 5.
    pub(super) shape: [usize; 2],
    /// The pixels along each side of a block.
    pub(super) block: usize,
}

/// The blocks from which a mean is computed along one axis, and their weights.
#[derive(Clone, Copy, Debug)]
struct Weights {
    first: usize,
    of_blocks: [f64; STENCIL],
}

impl Weights {
    /// The weights of the mean from `low` to `high`, in blocks from the lower border of the image, of `count` blocks.
    fn of_mean([low, high]: [f64; 2], count: usize) -> Self {
        // Gauss's rule of three points is exact for degree 5.
        const NODES: [(f64, f64); 3] = [
            (0.112_701_665_379_258_31, 5.0 / 18.0),
            (0.5, 4.0 / 9.0),
            (0.887_298_334_620_741_7, 5.0 / 18.0),
        ];
        let middle = crate::cell::whole(0.5 * (low + high)).min(count - 1);
        let first = middle.saturating_sub(STENCIL / 2).min(count - STENCIL);
        let mut of_blocks = [0.0; STENCIL];
        for (node, weight) in NODES {
            let at = low + node * (high - low) - 0.5 - first as f64;
            for (block, of_block) in of_blocks.iter_mut().enumerate() {
                let others = (0..STENCIL).filter(|other| *other != block);
                let basis = others.map(|other| (at - other as f64) / (block as f64 - other as f64));
                *of_block += weight * basis.product::<f64>();
            }
        }
        Self { first, of_blocks }
    }
}

impl LatticeImage<'_> {
    fn value(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.shape[1] + column]
    }

    /// Height and width in pixels.
    fn pixels(&self) -> [usize; 2] {
        self.shape.map(|blocks| blocks * self.block)
    }

    fn interpolated(&self, of_row: &Weights, of_column: &Weights) -> f64 {
        let in_row = |row: usize| -> f64 {
            let weights = of_column.of_blocks.iter().enumerate();
            weights.map(|(k, weight)| weight * self.value(row, of_column.first + k)).sum()
        };
        let weights = of_row.of_blocks.iter().enumerate();
        weights.map(|(k, weight)| weight * in_row(of_row.first + k)).sum()
    }

    /// The means over all pixels.
    pub(super) fn means(&self) -> Image {
        let shape = self.pixels();
        let side = 1.0 / self.block as f64;
        let weights = |count: usize| -> Vec<Weights> {
            let borders = |pixel: usize| [pixel, pixel + 1].map(|border| side * border as f64);
            let pixels = 0..count * self.block;
            pixels.map(|pixel| Weights::of_mean(borders(pixel), count)).collect()
        };
        let [of_rows, of_columns] = self.shape.map(weights);
        map_of_rows(shape, |row, pixels| {
            for (pixel, of_column) in pixels.iter_mut().zip(&of_columns) {
                *pixel = self.interpolated(&of_rows[row], of_column);
            }
        })
    }

    /// The value at a place of the image, from 0 to 1 along each axis, and the number of its block.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> (f64, usize) {
        let [rows, columns] = self.shape;
        let [y, x] = [y * rows as f64, x * columns as f64];
        let value =
            self.interpolated(&Weights::of_mean([y, y], rows), &Weights::of_mean([x, x], columns));
        let block = |at: f64, count: usize| crate::cell::whole(at.max(0.0)).min(count - 1);
        (value, block(y, rows) * columns + block(x, columns))
    }

    /// A map of the blocks.
    pub(super) fn map(&self, of: impl Fn(usize, usize) -> f64 + Sync) -> Image {
        map_of_rows(self.shape, |row, blocks| {
            blocks.iter_mut().enumerate().for_each(|(column, block)| *block = of(row, column));
        })
    }

    /// The sum of |second differences| of a block, or of the nearest inner one, and that of |fourth differences|.
    fn differences(&self, row: usize, column: usize) -> [f64; 2] {
        const SECOND: [f64; 5] = [0.0, 1.0, -2.0, 1.0, 0.0];
        const FOURTH: [f64; 5] = [1.0, -4.0, 6.0, -4.0, 1.0];
        let [rows, columns] = self.shape;
        let [of_row, of_column] =
            [(row, rows), (column, columns)].map(|(at, count)| at.clamp(2, count - 3) - 2);
        let difference = |weights: &[f64; 5]| {
            let sum = |value: &dyn Fn(usize) -> f64| -> f64 {
                weights.iter().enumerate().map(|(k, weight)| weight * value(k)).sum()
            };
            sum(&|k| self.value(row, of_column + k)).abs()
                + sum(&|k| self.value(of_row + k, column)).abs()
        };
        [difference(&SECOND), difference(&FOURTH)]
    }

    /// For each block the estimated error of the means over its pixels, and the largest sum of |second differences| of
    /// it and the blocks around.
    pub(super) fn errors(&self) -> [Image; 2] {
        let [rows, columns] = self.shape;
        let [second, fourth] = [0, 1].map(|which: usize| {
            largest_around(&self.map(|row, column| self.differences(row, column)[which]))
        });
        let errors = self.map(|row, column| {
            let (second, fourth) = (second.row(row)[column], fourth.row(row)[column]);
            let is_border = row == 0 || column == 0 || row + 1 == rows || column + 1 == columns;
            let of_fourth = if is_border { OF_FOURTH_AT_BORDER } else { OF_FOURTH };
            let ratio = if second > 0.0 { fourth / (AT_A_KINK * second) } else { 0.0 };
            f64::max(of_fourth * fourth, OF_SECOND * second * ratio.min(1.0).powf(EXPONENT))
        });
        [errors, second]
    }
}

/// The largest of each pixel and those around it.
pub(super) fn largest_around(of: &Image) -> Image {
    let [height, width] = [of.height(), of.width()];
    map_of_rows([height, width], |row, pixels| {
        let rows = row.saturating_sub(1)..(row + 2).min(height);
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let columns = column.saturating_sub(1)..(column + 2).min(width);
            let values = rows.clone().flat_map(|row| &of.row(row)[columns.clone()]);
            *pixel = values.copied().fold(0.0, f64::max);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values in the middles of blocks of exp(a x + b y), and its means over pixels, which have a closed form.
    fn exponential(shape: [usize; 2], block: usize, [a, b]: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
        let at = |k: usize, [height, width]: [usize; 2]| {
            let x = ((k % width) as f64 + 0.5) / width as f64;
            let y = ((k / width) as f64 + 0.5) / height as f64;
            (a * x + b * y).exp()
        };
        let pixels @ [height, width] = shape.map(|count| count * block);
        let mean = |slope: f64| 2.0 * (0.5 * slope).sinh() / slope;
        let factor = mean(a / width as f64) * mean(b / height as f64);
        let values = (0..shape[0] * shape[1]).map(|k| at(k, shape)).collect();
        (values, (0..height * width).map(|k| factor * at(k, pixels)).collect())
    }

    #[test]
    fn means_of_a_smooth_image_are_within_their_errors() {
        for (shape, block) in [([16, 18], 1), ([16, 12], 2), ([10, 14], 4), ([12, 12], 8)] {
            let (values, exact) = exponential(shape, block, [3.0, -2.0]);
            let image = LatticeImage { values: &values, shape, block };
            let (found, [errors, _]) = (image.means(), image.errors());
            let width = shape[1] * block;
            for (k, exact) in exact.iter().enumerate() {
                let [row, column] = [k / width / block, k % width / block];
                let error = (found.pixels()[k] - exact).abs();
                let estimate = errors.row(row)[column];
                assert!(error <= estimate, "{shape:?} {block} {k}: {error} {estimate}");
                assert!(estimate < 0.01 * exact, "{shape:?} {block} {k}: {estimate}");
            }
        }
    }

    #[test]
    fn a_jump_has_the_error_of_half_of_it() {
        let shape = [8, 10];
        let values: Vec<f64> = (0..80).map(|k| if k % 10 < 5 { 0.0 } else { 1.0 }).collect();
        let [errors, _] = LatticeImage { values: &values, shape, block: 2 }.errors();
        for row in 0..8 {
            assert!(errors.row(row)[4] >= 0.5 && errors.row(row)[5] >= 0.5, "{row}");
            assert!(errors.row(row)[0].abs() < 1e-12, "{row}");
        }
    }

    #[test]
    fn polynomials_of_degree_4_are_reproduced() {
        let shape = [6, 7];
        let of = |x: f64, y: f64| 1.0 + x.powi(4) - 3.0 * x * y.powi(3) + y * y;
        let values: Vec<f64> = (0..42)
            .map(|k| of(((k % 7) as f64 + 0.5) / 7.0, ((k / 7) as f64 + 0.5) / 6.0))
            .collect();
        for [x, y] in [[0.5, 0.5], [0.01, 0.99], [0.3, 0.72]] {
            let (found, block) = LatticeImage { values: &values, shape, block: 1 }.at([x, y]);
            assert!((found - of(x, y)).abs() < 1e-12 && block < 42, "{x} {y}");
        }
    }
}
