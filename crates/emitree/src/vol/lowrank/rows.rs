//! The image of an interpolant row by row, for images that are larger than the memory.

use crate::output::{ProductRows, Products};
use crate::vol::lowrank::interpolant::{Interpolant, Pixels};
use crate::vol::lowrank::probes::{CellResiduals, Errors};

/// An interpolant with the residuals that show its error.
#[derive(Debug)]
pub(super) struct Checked {
    pub(super) interpolant: Interpolant,
    pub(super) residuals: CellResiduals,
}

/// The rows of its image and of its error.
struct Rows {
    pixels: Pixels,
    errors: Errors,
}

impl Products for Checked {
    fn of_shape(&self, shape: [usize; 2]) -> Box<dyn ProductRows> {
        let pixels = self.interpolant.pixels(shape);
        Box::new(Rows { pixels, errors: self.residuals.errors(shape) })
    }
}

impl ProductRows for Rows {
    fn means(&self, row: usize, means: &mut [f64]) {
        self.pixels.row(row, means);
    }

    fn errors(&self, row: usize, errors: &mut [f64]) {
        self.errors.row(row, errors);
    }
}
