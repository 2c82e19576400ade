//! Probes: scattered points at which an approximation is compared with G.
//!
//! The error of a line of sight is the integral of what is left of G along it, which is no larger than
//! the root of the mean square. So the image plane is divided into cells, and what the probes of a cell
//! have left, squared and averaged, tells the error of its pixels.

use crate::image::Image;

/// Cells along each axis of the image.
const CELLS: usize = 8;
/// The error of a pixel over the root of the mean square that is left around it, at the most:
/// somewhere in a cell more is left than on the average.
const MARGIN: f64 = 3.0;

/// The generator of a lattice sequence in three dimensions: the root of ρ⁴ = ρ + 1, whose powers are
/// hard to approximate by fractions, as those of the golden ratio are in one.
const RATIO: f64 = 1.220_744_084_605_759_5;

/// Point `i` of a sequence that fills the cube evenly, however long it is.
pub(super) fn scattered(i: usize) -> [f64; 3] {
    let along = |power: i32| (0.5 + (i + 1) as f64 / RATIO.powi(power)).fract();
    [along(1), along(2), along(3)]
}

/// What is left in each cell of the image: the root of the mean square of the probes there.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Left {
    cells: [[f64; CELLS]; CELLS],
}

impl Left {
    /// From what is left at each of `points`.
    pub(super) fn new(points: &[[f64; 3]], rest: &[f64]) -> Self {
        let mut squares = [[0.0; CELLS]; CELLS];
        let mut counts = [[0_u32; CELLS]; CELLS];
        for (point, rest) in points.iter().zip(rest) {
            let [column, row] = [cell_of(point[0]), cell_of(point[1])];
            squares[row][column] += rest * rest;
            counts[row][column] += 1;
        }
        let mut cells = squares;
        for (cells, counts) in cells.iter_mut().zip(&counts) {
            for (cell, &count) in cells.iter_mut().zip(counts) {
                *cell = (*cell / f64::from(count.max(1))).sqrt();
            }
        }
        Self { cells }
    }

    /// The error of each pixel, as that of the image: the mean of a function that is linear between
    /// the corners of cells, and at each the largest of the cells around it.
    pub(super) fn error_map(&self, scale: &Image) -> Image {
        let [height, width] = [scale.height(), scale.width()];
        let corners = self.corners();
        let of_columns: Vec<Hats> = (0..width).map(|column| hats(column, width)).collect();
        let mut map = Image::zeros(height, width);
        for row in 0..height {
            let of_row = hats(row, height);
            let along: Hats = core::array::from_fn(|column| {
                of_row.iter().zip(&corners).map(|(weight, corners)| weight * corners[column]).sum()
            });
            let pixels = map.row_mut(row).iter_mut().zip(scale.row(row)).zip(&of_columns);
            for ((pixel, scale), weights) in pixels {
                let mean: f64 = weights.iter().zip(&along).map(|(w, corner)| w * corner).sum();
                *pixel = MARGIN * scale * mean;
            }
        }
        map
    }

    fn corners(&self) -> [[f64; CELLS + 1]; CELLS + 1] {
        let mut corners = [[0.0_f64; CELLS + 1]; CELLS + 1];
        for (row, cells) in self.cells.iter().enumerate() {
            for (column, &cell) in cells.iter().enumerate() {
                for corner in [[0, 0], [0, 1], [1, 0], [1, 1]] {
                    let corner = &mut corners[row + corner[0]][column + corner[1]];
                    *corner = corner.max(cell);
                }
            }
        }
        corners
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 or more, and few")]
fn cell_of(along: f64) -> usize {
    ((along * CELLS as f64) as usize).min(CELLS - 1)
}

/// What each corner counts along one axis.
type Hats = [f64; CELLS + 1];

/// What each corner counts in the mean over pixel `pixel` of `pixels`, of a function that is linear
/// between them: at the middles of so many parts of the pixel that none is longer than half a cell.
fn hats(pixel: usize, pixels: usize) -> Hats {
    let parts = (2 * CELLS).div_ceil(pixels);
    let mut weights = [0.0; CELLS + 1];
    for part in 0..parts {
        let along = (pixel as f64 + (part as f64 + 0.5) / parts as f64) / pixels as f64;
        let cell = cell_of(along);
        let beyond = along * CELLS as f64 - cell as f64;
        weights[cell] += (1.0 - beyond) / parts as f64;
        weights[cell + 1] += beyond / parts as f64;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_part_of_the_cube_has_its_share_of_the_sequence() {
        for (count, uneven) in [(512, 0.15), (1500, 0.08), (4096, 0.05)] {
            let points: Vec<[f64; 3]> = (0..count).map(scattered).collect();
            for octant in 0..8 {
                let is_inside = |point: &&[f64; 3]| {
                    (0..3).all(|axis| (point[axis] >= 0.5) == (octant >> axis & 1 == 1))
                };
                let share = 8.0 * points.iter().filter(is_inside).count() as f64 / count as f64;
                assert!((share - 1.0).abs() < uneven, "{octant}: {share}");
            }
        }
    }

    #[test]
    fn the_map_is_large_where_much_is_left() {
        let points: Vec<[f64; 3]> = (0..2000).map(scattered).collect();
        let rest: Vec<f64> = points.iter().map(|p| if p[0] < 0.25 { 0.1 } else { 0.01 }).collect();
        let left = Left::new(&points, &rest);
        let map = left.error_map(&Image::from_pixels(4, 8, vec![2.0; 32]));
        for row in map.rows() {
            assert!((row[0] - 0.1 * MARGIN * 2.0).abs() < 1e-12);
            assert!((row[7] - 0.01 * MARGIN * 2.0).abs() < 1e-12);
            assert!(row.windows(2).all(|two| two[1] <= two[0] + 1e-12));
        }
        // A pixel has what is left in all of its cells, wherever its middle is: 0.1 up to the corner
        // at a quarter, half of the next cell in between, 0.01 in the others.
        let whole = left.error_map(&Image::from_pixels(1, 1, vec![1.0]));
        let mean = (2.0 * 0.1 + 0.5 * (0.1 + 0.01) + 5.0 * 0.01) / 8.0;
        assert!((whole[(0, 0)] / MARGIN / mean - 1.0).abs() < 1e-12, "{whole:?}");
    }
}
