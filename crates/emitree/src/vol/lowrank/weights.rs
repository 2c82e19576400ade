//! The weights of errors during a search: they follow from the image, which becomes known with it.

use crate::image::Image;
use crate::vol::error_weights::{ErrorWeights, product};
use crate::vol::lowrank::Attempt;
use crate::vol::lowrank::maps::{Maps, shape_of};
use crate::vol::lowrank::search::Assessment;

impl Attempt<'_> {
    /// Weights the residuals for the present image. Before there is one, a rate of 0 has no meaning, and the
    /// weights are those that the options give.
    pub(super) fn weigh(&mut self) {
        if self.vol.is_uniform() {
            return;
        }
        let shape = self.part.footing.shape_of_image(&self.part.scale);
        let none = || Image::zeros(shape[0], shape[1]);
        let image =
            self.image(self.of_others.as_ref().map_or_else(none, |[image, _]| image.clone()));
        let error = self.error.take().unwrap_or_else(none);
        let weights = ErrorWeights::new(self.vol, &[[&image, &error]], self.outside);
        self.largest_weighed = Some(weights.largest);
        let maps = weights.maps.into_iter().flatten().next();
        self.search.weights = maps.map(|map| self.part.on_raster(&map).into_owned());
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

    /// The image of this part, added to that of others.
    fn image(&self, of_others: Image) -> Image {
        let mut image = of_others;
        if !self.search.interpolant.ranks().contains(&0) {
            let means = |shape| self.search.interpolant.means(shape);
            let (first_row, own) = self.part.footing.image(means, &self.part.scale);
            image.add_rows(first_row, &own, 1.0);
        }
        image
    }

    /// Image and error of this part on the pixels.
    pub(super) fn on_pixels(&self, maps: &Maps) -> [Image; 2] {
        let [height, width] = self.part.footing.shape_of_image(&self.part.scale);
        [self.image(Image::zeros(height, width)), self.part.footing.errors(maps.error.clone())]
    }

    /// Makes errors of weighted ones. Where the weight is 0, they are those of unweighted residuals.
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
            *error = if *weight > 0.0 { *error / weight } else { *plain };
        }
    }
}
