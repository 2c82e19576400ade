//! Images and cubes of interpolants on image planes row by row, for those that are larger than the memory.

use crate::image::Image;
use crate::output::{Bands, Products};
use crate::radiance::PixelRows;
use crate::vol::lowrank::interpolant::{Interpolant, Pixels};
use crate::vol::lowrank::probes::{CellResiduals, Errors};
use core::ops::Range;
use std::sync::Arc;

/// An interpolant with the residuals that show its error.
#[derive(Debug)]
pub(super) struct Checked {
    pub(super) interpolant: Arc<Interpolant>,
    pub(super) residuals: CellResiduals,
}

/// Bands that are weighted sums of products, each of them a function of the whole image plane: of the layers between
/// planes, and of the energies of a cube.
#[derive(Debug)]
pub(super) struct PlaneProducts {
    pub(super) products: Vec<Arc<Checked>>,
    /// What the products are multiplied with in each band.
    pub(super) weights: Vec<Vec<f64>>,
    /// The error of the radiances of each band that the energies of a cube leave.
    pub(super) unexplained: Vec<f64>,
}

/// The rows of the bands.
struct PlaneBands<'a> {
    pixels: PixelRows<'a>,
    products: Vec<(Pixels, Errors)>,
    weights: Vec<Vec<f64>>,
    unexplained: Vec<f64>,
}

impl PlaneProducts {
    /// The image of products that add up.
    pub(super) fn of_image(products: Vec<Arc<Checked>>) -> Self {
        let weights = vec![vec![1.0; products.len()]];
        Self { products, weights, unexplained: vec![0.0] }
    }
}

impl Products for PlaneProducts {
    fn bands<'a>(&self, pixels: PixelRows<'a>) -> Option<Box<dyn Bands + 'a>> {
        let shape = pixels.shape;
        let of_shape =
            |of: &Arc<Checked>| (of.interpolant.pixels(shape), of.residuals.errors(shape));
        let products = self.products.iter().map(of_shape).collect();
        let (weights, unexplained) = (self.weights.clone(), self.unexplained.clone());
        Some(Box::new(PlaneBands { pixels, products, weights, unexplained }))
    }
}

impl PlaneBands<'_> {
    /// Rows of radiances: of the sums of what `fill` makes of each product, times these factors, with `more` added to
    /// each.
    fn block(
        &self,
        rows: Range<usize>,
        factors: &[f64],
        more: f64,
        fill: impl Fn(&(Pixels, Errors), usize, &mut [f64]) + Sync,
    ) -> Image {
        let width = self.pixels.shape[1];
        self.pixels.block(rows, |row, sums| {
            let (mut scale, mut values) = (vec![0.0; width], vec![0.0; width]);
            self.pixels.radiances_per_density(row, &mut scale);
            sums.fill(0.0);
            for (product, factor) in self.products.iter().zip(factors) {
                fill(product, row, &mut values);
                sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += factor * value);
            }
            for (sum, scale) in sums.iter_mut().zip(scale) {
                *sum = if scale == 0.0 { f64::NAN } else { *sum * scale + more };
            }
        })
    }
}

impl Bands for PlaneBands<'_> {
    fn number(&self) -> usize {
        self.weights.len()
    }

    fn values(&self, band: usize, rows: Range<usize>) -> Image {
        self.block(rows, &self.weights[band], 0.0, |(pixels, _), row, means| {
            pixels.row(row, means);
        })
    }

    fn errors(&self, band: usize, rows: Range<usize>) -> Image {
        let factors: Vec<f64> = self.weights[band].iter().map(|weight| weight.abs()).collect();
        self.block(rows, &factors, self.unexplained[band], |(_, of), row, errors| {
            of.row(row, errors);
        })
    }
}
