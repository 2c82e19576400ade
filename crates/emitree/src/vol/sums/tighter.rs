//! Options with smaller errors in the regions of sums.

use crate::image::Image;
use crate::output::MethodOutput;
use crate::vol::VolOptions;
use crate::vol::sums::functional::Functional;
use crate::vol::tuning::TUNING;
use std::sync::Arc;

/// The share of the image in regions from which on the whole image gets the smaller tolerance: with
/// weights there are no found surfaces, and products take finer fibers.
const MOST_OF_IMAGE: f64 = 0.5;

/// By how much errors in the region of each sum are divided.
pub(super) struct Tighter {
    factors: Vec<f64>,
}

impl Tighter {
    pub(super) fn new(vol: &VolOptions) -> Self {
        Self { factors: vec![1.0; vol.sums.len()] }
    }

    /// Divides the errors in the regions of sums that are not good enough.
    pub(super) fn tighten(&mut self, made: &MethodOutput) {
        for (factor, sum) in self.factors.iter_mut().zip(&made.sums) {
            if sum.error > sum.allowed {
                let wanted = sum.error / (TUNING.sums.goal * sum.allowed);
                *factor *= wanted.min(TUNING.sums.most_tightening);
            }
        }
    }

    /// The options; `is_uniform` if the same error has to be allowed everywhere.
    pub(super) fn options(
        &self,
        vol: &VolOptions,
        functionals: &[Functional<'_>],
        is_uniform: bool,
    ) -> VolOptions {
        let [height, width] = [functionals[0].of_pixels.height(), functionals[0].of_pixels.width()];
        let mut factors = Image::from_pixels(height, width, vec![1.0; height * width]);
        let mut in_regions = vec![false; height * width];
        for (functional, &of_sum) in functionals.iter().zip(&self.factors) {
            if of_sum > 1.0 {
                let pixels = functional.of_pixels.pixels().iter().enumerate();
                for (pixel, _) in pixels.filter(|(_, coefficient)| **coefficient != 0.0) {
                    in_regions[pixel] = true;
                    let factor = &mut factors.pixels_mut()[pixel];
                    *factor = factor.max(of_sum);
                }
            }
        }
        let share =
            in_regions.iter().filter(|inside| **inside).count() as f64 / in_regions.len() as f64;
        let mut options = vol.clone();
        options.tolerance = options.tolerance.min(TUNING.engine.loosest_tolerance);
        if is_uniform || share >= MOST_OF_IMAGE {
            let most = self.factors.iter().copied().fold(1.0, f64::max);
            options.tolerance /= most;
            if let Some(by_pixel) = &mut options.by_pixel {
                by_pixel.rtol /= most;
                by_pixel.atol /= most;
            }
            return options;
        }
        let weights = match &vol.weights {
            Some(weights) => crate::vol::error_weights::product(weights, &factors),
            None => factors,
        };
        options.weights = Some(Arc::new(weights));
        options
    }
}
