//! The weights of errors during a search: they follow from the image, which becomes known with it.

use crate::image::Image;
use crate::vol::error_weights::{ErrorWeights, product};
use crate::vol::lowrank::Attempt;
use crate::vol::lowrank::maps::{Maps, shape_of};
use crate::vol::lowrank::search::Assessment;
use std::sync::Arc;

impl Attempt<'_> {
    /// Weights the residuals for the present image. Before there is one, a rate of 0 has no meaning, and the
    /// weights are those that the options give.
    pub(super) fn weigh(&mut self) {
        if self.vol.is_uniform() {
            return;
        }
        let own = self.own_image();
        let mut image = own.clone();
        if let Some([of_others, _]) = &self.of_others {
            image.add_scaled(of_others, 1.0);
        }
        let error = self.error.take().unwrap_or_else(|| Image::zeros(own.height(), own.width()));
        let weights = ErrorWeights::new(self.vol, &[[&image, &error]], self.outside);
        self.largest_weighed = Some(weights.largest);
        let maps = weights.maps.into_iter().flatten().next();
        // The mean of its shares of the area and of the value: either alone would leave nothing to the brighter or the
        // larger part. Before others are known, half.
        let allowed = |pixel: usize, of_area: f64| {
            let [own, all] = [&own, &image].map(|of| of.pixels()[pixel].abs());
            let of_value = if own < all { own / all } else { 1.0 };
            if self.of_others.is_some() { 0.5 * (of_area + of_value) } else { 0.5 }
        };
        let on_raster = |map: Arc<Image>| self.part.weights_on_raster(&map, allowed);
        self.search.weights = maps.map(on_raster);
        self.search.forget_weighted();
        self.error = Some(error);
    }

    /// Keeps the error of the present image for the next weights.
    pub(super) fn keep_error(&mut self, assessment: &Assessment) {
        if self.vol.is_uniform() {
            return;
        }
        let [_, mut error] = self.on_pixels(&self.maps(assessment));
        if let Some([_, of_others]) = &self.of_others {
            error.add_scaled(of_others, 1.0);
        }
        self.error = Some(error);
    }

    /// The image of this part alone.
    fn own_image(&self) -> Image {
        let [height, width] = self.part.footing.shape_of_image(&self.part.scale);
        let mut image = Image::zeros(height, width);
        if !self.search.interpolant.ranks().contains(&0) {
            let means = |shape| self.search.interpolant.means(shape);
            let (first_row, own) = self.part.footing.image(means, &self.part.scale);
            image.add_rows(first_row, &own, 1.0);
        }
        image
    }

    /// Image and error of this part on the pixels.
    pub(super) fn on_pixels(&self, maps: &Maps) -> [Image; 2] {
        [self.own_image(), self.part.footing.errors(maps.error.clone())]
    }

    /// Makes errors of weighted ones. They are at most those of unweighted residuals: where the weight of a cell is
    /// smaller than those around it, weighted residuals say little.
    pub(super) fn remove_weights(&self, error: &mut Image, assessment: &Assessment) {
        let (Some(weights), Some(unweighted)) = (&self.search.weights, &assessment.unweighted)
        else {
            return;
        };
        let shape @ [height, width] = shape_of(error);
        let errors = unweighted.errors(shape);
        let mut plain = Image::zeros(height, width);
        for (row, values) in plain.pixels_mut().chunks_mut(width.max(1)).enumerate() {
            errors.row(row, values);
        }
        let plain = product(&plain, &self.part.scale);
        let weights = weights.pixels().iter().zip(plain.pixels());
        for (error, (weight, plain)) in error.pixels_mut().iter_mut().zip(weights) {
            *error = if *weight > 0.0 { (*error / weight).min(*plain) } else { *plain };
        }
    }
}
