//! Probes: scattered points at which an interpolant is compared with G.
//!
//! The error of a line of sight is the integral of the residual of G along it, which is at most the
//! root mean square of the residual. The image plane is therefore divided into cells, and the root
//! mean square residual of the probes in a cell is the error estimate of its pixels.

use crate::vol::tuning::TUNING;
use core::ops::Range;

/// The number of cells along each axis of the image.
const CELLS: usize = 8;

/// The root mean square residual of the probes in each cell of the image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CellResiduals {
    cells: [[f64; CELLS]; CELLS],
}

impl CellResiduals {
    /// From the residual at each of the `points`.
    pub(super) fn new(points: &[[f64; 3]], residual: &[f64]) -> Self {
        let mut squares = [[0.0; CELLS]; CELLS];
        let mut counts = [[0_u32; CELLS]; CELLS];
        for (point, residual) in points.iter().zip(residual) {
            let [column, row] = [cell_of(point[0]), cell_of(point[1])];
            squares[row][column] += residual * residual;
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

    /// The error of each pixel of an image of `shape` = \[height, width\], in the unit of the mean
    /// irradiance density. It is the mean of a function that is bilinear between the corners of
    /// cells, and at each corner the largest of the cells around it.
    pub(super) fn errors(&self, shape: [usize; 2]) -> Errors {
        Errors { corners: self.corners(), parts: shape.map(Parts::new) }
    }

    /// The same times a factor.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.cells.iter_mut().flatten().for_each(|cell| *cell *= factor);
        self
    }

    /// The row and the column of the cell of a place.
    pub(super) fn cell([u, v]: [f64; 2]) -> [usize; 2] {
        [v, u].map(cell_of)
    }

    /// The error at a place of the image plane, as of a pixel that is a point.
    pub(super) fn error_at(&self, place: [f64; 2]) -> f64 {
        let corners = self.corners();
        let [row, column] = Self::cell(place);
        let [across, up] =
            [place[0] * CELLS as f64 - column as f64, place[1] * CELLS as f64 - row as f64];
        let along = |row: usize| between(corners[row][column], corners[row][column + 1], across);
        TUNING.lowrank.error_margin * between(along(row), along(row + 1), up)
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

/// The errors of pixels, computed row by row.
pub(super) struct Errors {
    corners: [[f64; CELLS + 1]; CELLS + 1],
    /// Parts of rows and of columns.
    parts: [Parts; 2],
}

impl Errors {
    /// The errors of row `row`.
    pub(super) fn row(&self, row: usize, errors: &mut [f64]) {
        let [rows, columns] = &self.parts;
        let along = rows.mean_of(row, &self.corners);
        if columns.of_pixel == 1 {
            return columns.values(&along, errors);
        }
        let mut of_parts = vec![0.0; columns.beyond.len()];
        columns.values(&along, &mut of_parts);
        for (error, parts) in errors.iter_mut().zip(of_parts.chunks_exact(columns.of_pixel)) {
            *error = parts.iter().sum::<f64>() / columns.of_pixel as f64;
        }
    }
}

/// The parts of pixels along one axis: each pixel has so many equal parts that none is longer than
/// half a cell.
struct Parts {
    /// The number of parts of one pixel.
    of_pixel: usize,
    /// For the centre of each part, its distance from the preceding corner, in cells.
    beyond: Vec<f64>,
    /// The parts that lie in each cell.
    of_cells: [Range<usize>; CELLS],
}

impl Parts {
    fn new(pixels: usize) -> Self {
        let of_pixel = (2 * CELLS).div_ceil(pixels);
        let number = of_pixel * pixels;
        let along: Vec<f64> =
            (0..number).map(|part| (part as f64 + 0.5) / number as f64 * CELLS as f64).collect();
        let first = |cell: usize| along.partition_point(|along| *along < cell as f64);
        let of_cells = core::array::from_fn(|cell| first(cell)..first(cell + 1));
        Self { of_pixel, beyond: along.iter().map(|along| along.fract()).collect(), of_cells }
    }

    /// The values at all parts of the function that is linear between its values at the corners.
    fn values(&self, at_corners: &[f64; CELLS + 1], values: &mut [f64]) {
        for (parts, ends) in self.of_cells.iter().zip(at_corners.windows(2)) {
            let values = values[parts.clone()].iter_mut().zip(&self.beyond[parts.clone()]);
            values.for_each(|(value, beyond)| *value = between(ends[0], ends[1], *beyond));
        }
    }

    /// The means over pixel `pixel` of several functions at once, given by a row of corners each.
    fn mean_of(&self, pixel: usize, corners: &[[f64; CELLS + 1]; CELLS + 1]) -> [f64; CELLS + 1] {
        let mut means = [0.0; CELLS + 1];
        for part in pixel * self.of_pixel..(pixel + 1) * self.of_pixel {
            let cell = self.of_cells.iter().position(|cell| cell.contains(&part)).unwrap_or(0);
            for (corner, mean) in means.iter_mut().enumerate() {
                let ends = [corners[cell][corner], corners[cell + 1][corner]];
                *mean += TUNING.lowrank.error_margin * between(ends[0], ends[1], self.beyond[part]);
            }
        }
        means.map(|sum| sum / self.of_pixel as f64)
    }
}

/// Linear interpolation: the value at `beyond` between `a` at 0 and `b` at 1.
fn between(a: f64, b: f64, beyond: f64) -> f64 {
    (1.0 - beyond) * a + beyond * b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::lattice::point;

    #[test]
    fn the_map_is_large_where_residuals_are() {
        let points: Vec<[f64; 3]> = (0..2048).map(point).collect();
        let residual: Vec<f64> =
            points.iter().map(|p| if p[0] < 0.25 { 0.1 } else { 0.01 }).collect();
        let cell_residuals = CellResiduals::new(&points, &residual);
        let errors = cell_residuals.errors([4, 8]);
        for number in 0..4 {
            let mut row = [0.0; 8];
            errors.row(number, &mut row);
            assert!((row[0] - 0.1 * TUNING.lowrank.error_margin).abs() < 1e-12);
            assert!((row[7] - 0.01 * TUNING.lowrank.error_margin).abs() < 1e-12);
            assert!(row.windows(2).all(|two| two[1] <= two[0] + 1e-12));
        }
        // At a place it is that of a pixel around it.
        let at = |x: f64| cell_residuals.error_at([x, 0.6]) / TUNING.lowrank.error_margin;
        assert!((at(0.2) - 0.1).abs() < 1e-12 && (at(0.9) - 0.01).abs() < 1e-12);
        assert!((at(0.3125) - 0.055).abs() < 1e-12, "{}", at(0.3125));
        let halved = cell_residuals.clone().scaled(0.5);
        assert!(
            (2.0 * halved.error_at([0.2, 0.6]) - cell_residuals.error_at([0.2, 0.6])).abs() < 1e-12
        );
        // The error of a pixel includes all of its cells: 0.1 up to the corner at a quarter, half
        // of the next cell in between, 0.01 in the others.
        let mut whole = [0.0];
        cell_residuals.errors([1, 1]).row(0, &mut whole);
        let mean = (2.0 * 0.1 + 0.5 * (0.1 + 0.01) + 5.0 * 0.01) / 8.0;
        assert!((whole[0] / TUNING.lowrank.error_margin / mean - 1.0).abs() < 1e-12, "{whole:?}");
    }
}
