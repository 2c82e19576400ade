//! Images and cubes of interpolants row by row, for those that are larger than the memory.

use crate::output::{ProductRows, Products};
use crate::vol::lowrank::interpolant::{Interpolant, Pixels};
use crate::vol::lowrank::probes::{CellResiduals, Errors};
use std::sync::Arc;

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
    fn bands(&self) -> usize {
        1
    }

    fn means(&self, _: usize, row: usize, means: &mut [f64]) {
        self.pixels.row(row, means);
    }

    fn errors(&self, _: usize, row: usize, errors: &mut [f64]) {
        self.errors.row(row, errors);
    }

    fn unexplained(&self, _: usize) -> f64 {
        0.0
    }
}

/// The bands of a cube: weighted sums of the products of channels.
#[derive(Debug)]
pub(super) struct WeightedProducts {
    pub(super) channels: Vec<Arc<dyn Products>>,
    /// What the channels are multiplied with in each band.
    pub(super) weights: Vec<Vec<f64>>,
    /// The error of the radiances of each band that the energies of the channels leave.
    pub(super) unexplained: Vec<f64>,
}

/// The rows of the bands.
struct WeightedRows {
    channels: Vec<Box<dyn ProductRows>>,
    weights: Vec<Vec<f64>>,
    unexplained: Vec<f64>,
}

impl Products for WeightedProducts {
    fn of_shape(&self, shape: [usize; 2]) -> Box<dyn ProductRows> {
        let Self { channels, weights, unexplained } = self;
        let channels = channels.iter().map(|channel| channel.of_shape(shape)).collect();
        let (weights, unexplained) = (weights.clone(), unexplained.clone());
        Box::new(WeightedRows { channels, weights, unexplained })
    }
}

impl WeightedRows {
    /// The sum of the rows that `fill` makes of each channel, times these factors.
    fn sum(
        &self,
        factors: impl Iterator<Item = f64>,
        sums: &mut [f64],
        fill: impl Fn(&dyn ProductRows, &mut [f64]),
    ) {
        sums.fill(0.0);
        let mut row = vec![0.0; sums.len()];
        for (channel, factor) in self.channels.iter().zip(factors) {
            fill(&**channel, &mut row);
            sums.iter_mut().zip(&row).for_each(|(sum, value)| *sum += factor * value);
        }
    }
}

impl ProductRows for WeightedRows {
    fn bands(&self) -> usize {
        self.weights.len()
    }

    fn means(&self, band: usize, row: usize, means: &mut [f64]) {
        let factors = self.weights[band].iter().copied();
        self.sum(factors, means, |channel, means| channel.means(0, row, means));
    }

    fn errors(&self, band: usize, row: usize, errors: &mut [f64]) {
        let factors = self.weights[band].iter().map(|weight| weight.abs());
        self.sum(factors, errors, |channel, errors| channel.errors(0, row, errors));
    }

    fn unexplained(&self, band: usize) -> f64 {
        self.unexplained[band]
    }
}
