//! A sum over a region as coefficients of the voxels.

use crate::cube::Cube;
use crate::energy::EnergyAxis;
use crate::error::OptionError;
use crate::image::Image;
use crate::sums::{Sum, SumKind};

/// A sum over a region: Σ `of_pixels` · `of_bands` · voxel.
pub(super) struct Functional<'s> {
    pub(super) sum: &'s Sum,
    /// The coefficient of each pixel; 0 where there is no image.
    pub(super) of_pixels: Image,
    /// The widths of the bins, or 1.
    pub(super) of_bands: Vec<f64>,
}

impl<'s> Functional<'s> {
    /// Sum `number` of the options.
    pub(super) fn new(
        number: usize,
        sum: &'s Sum,
        solid_angles: &Image,
        axis: Option<&EnergyAxis>,
    ) -> Result<Self, OptionError> {
        let pixels = || sum.weights.pixels().iter().zip(solid_angles.pixels());
        let in_image = || pixels().map(|(weight, angle)| if *angle > 0.0 { *weight } else { 0.0 });
        if in_image().all(|weight| weight == 0.0) {
            return Err(OptionError::EmptySum(number));
        }
        let of_pixels: Vec<f64> = match sum.kind {
            SumKind::Sum => in_image().collect(),
            SumKind::Flux => pixels()
                .map(|(weight, angle)| if *angle > 0.0 { weight * angle } else { 0.0 })
                .collect(),
            SumKind::Mean => {
                let of_all: f64 = in_image().sum();
                let largest = in_image().fold(0.0, |most: f64, weight| most.max(weight.abs()));
                if of_all.abs() <= largest * f64::EPSILON * solid_angles.pixels().len() as f64 {
                    return Err(OptionError::MeanOfNothing(number));
                }
                in_image().map(|weight| weight / of_all).collect()
            }
        };
        let of_pixels = Image::from_pixels(solid_angles.height(), solid_angles.width(), of_pixels);
        let of_bands = axis.map_or_else(
            || vec![1.0],
            |axis| (0..axis.bins()).map(|bin| axis.width(bin)).collect(),
        );
        Ok(Self { sum, of_pixels, of_bands })
    }

    /// Σ |coefficient| of all voxels.
    pub(super) fn total(&self) -> f64 {
        let pixels: f64 = self.of_pixels.pixels().iter().map(|of| of.abs()).sum();
        pixels * self.of_bands.iter().sum::<f64>()
    }

    /// The sum over one band, without its width.
    pub(super) fn of_band(&self, band: &Image) -> f64 {
        self.over(band, |coefficient| coefficient)
    }

    /// The sum of the |errors| of one band, without its width.
    pub(super) fn error_of_band(&self, errors: &Image) -> f64 {
        self.over(errors, f64::abs)
    }

    fn over(&self, map: &Image, of: impl Fn(f64) -> f64) -> f64 {
        let pixels = self.of_pixels.pixels().iter().zip(map.pixels());
        // Pixels without an image are NaN.
        pixels.filter(|(c, _)| **c != 0.0).map(|(c, pixel)| of(*c) * pixel).sum()
    }

    /// The sum over all bands.
    pub(super) fn value(&self, cube: &Cube) -> f64 {
        let bands = cube.bands().iter().zip(&self.of_bands);
        bands.map(|(band, width)| width * self.of_band(band)).sum()
    }

    /// The sum of all |errors|; infinite without errors.
    pub(super) fn sum_of_errors(&self, errors: Option<&Cube>) -> f64 {
        errors.map_or(f64::INFINITY, |errors| {
            let bands = errors.bands().iter().zip(&self.of_bands);
            bands.map(|(band, width)| width * self.error_of_band(band)).sum()
        })
    }
}

/// Returns an error if a sum can't be one of an image of `shape`.
pub(super) fn check(sums: &[Sum], shape: [usize; 2]) -> Result<(), OptionError> {
    for (number, sum) in sums.iter().enumerate() {
        if sum.name.is_empty() || sums[..number].iter().any(|other| other.name == sum.name) {
            return Err(OptionError::SumName(number));
        }
        let given = [sum.weights.height(), sum.weights.width()];
        if given != shape {
            return Err(OptionError::SumShape { sum: number, given, expected: shape });
        }
        let weights = sum.weights.pixels();
        if let Some(pixel) = weights.iter().position(|weight| !weight.is_finite()) {
            let [row, column] = [pixel / shape[1], pixel % shape[1]];
            let weight = weights[pixel];
            return Err(OptionError::SumWeight { sum: number, weight, row, column });
        }
        let (rtol, atol) = (sum.rtol, sum.atol);
        let is_possible = (0.0..1.0).contains(&rtol) && atol >= 0.0 && atol.is_finite();
        if !is_possible || rtol + atol <= 0.0 {
            return Err(OptionError::SumTolerance { sum: number, rtol, atol });
        }
    }
    Ok(())
}
