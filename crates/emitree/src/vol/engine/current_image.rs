//! The current image: the sum of the sheets of all parts and energies, with its estimated error.

use crate::cube::Cube;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::vol::engine::Engine;
use crate::vol::error_weights::{ErrorWeights, WeightsOfPart, product};
use crate::vol::view::part::Part;
use crate::vol::view::sheet::SheetState;
use std::borrow::Cow;
use std::sync::Arc;

/// The current image with its estimated error.
pub(crate) struct CurrentImage {
    /// Image and error of each energy bin.
    pub(crate) maps: Vec<[Image; 2]>,
    /// The state of each sheet.
    pub(crate) states: Vec<SheetState>,
    /// The weights of the errors of each bin.
    weights: ErrorWeights,
    /// The weighted errors of each bin; none if all weights are 1.
    weighted_errors: Vec<Image>,
    /// The weights on the raster of each part; none if all are 1.
    of_parts: Vec<WeightsOfPart>,
}

impl CurrentImage {
    /// The largest |pixel| of those that matter.
    pub(crate) fn largest_pixel(&self) -> f64 {
        self.weights.largest
    }

    /// The largest weighted error of a pixel.
    pub(crate) fn largest_error(&self) -> f64 {
        self.weights.largest_error(self.maps.iter().map(|[_, error]| error))
    }

    /// The weighted error of each energy bin on the raster of a part.
    pub(crate) fn errors(&self, part: &Part<'_>) -> Vec<Cow<'_, Image>> {
        if self.weighted_errors.is_empty() {
            return self.maps.iter().map(|[_, error]| part.on_raster(error)).collect();
        }
        self.weighted_errors.iter().map(|error| part.on_raster(error)).collect()
    }

    /// For each pixel the largest of its weights in the bins; `None` if all are 1.
    pub(crate) fn largest_weights(&self) -> Option<Image> {
        let mut maps = self.weights.maps.as_ref()?.iter();
        let first = Image::clone(maps.next()?);
        Some(maps.fold(first, |largest, map| largest_of(largest, map, 1.0)))
    }

    /// The factors from means of values to weighted pixels of part `number` in each bin; none if all weights
    /// are 1, or if there is one bin.
    pub(crate) fn weighted_scales(&self, number: usize, part: &Part<'_>) -> Vec<Image> {
        match self.of_parts.get(number) {
            Some(bins) if bins.len() > 1 => {
                bins.iter().map(|weights| product(&part.scale, weights)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The guarded details of the nodes of a sheet.
    pub(crate) fn guarded(&self, sheet: usize) -> &[f64] {
        &self.states[sheet].guarded
    }
}

/// The larger of two images, of which `factor` is multiplied with the second one, pixel by pixel.
fn largest_of(mut largest: Image, other: &Image, factor: f64) -> Image {
    let pixels = largest.pixels_mut().iter_mut().zip(other.pixels());
    pixels.for_each(|(largest, other)| *largest = largest.max(factor * other));
    largest
}

/// Each |number| in terms of the largest; 1 if all are 0.
fn relative(numbers: impl Iterator<Item = f64> + Clone) -> Vec<f64> {
    let largest = numbers.clone().fold(0.0, |most: f64, number| most.max(number.abs()));
    let share = |number: f64| if largest > 0.0 { number.abs() / largest } else { 1.0 };
    numbers.map(share).collect()
}

impl Engine<'_> {
    /// The image and its estimated error in each bin, from all samples so far.
    pub(crate) fn assemble(&mut self) -> Result<CurrentImage, MethodError> {
        let nodal = self.energies.nodal_weights();
        let unexplained = self.spectra.as_ref().map_or(&[0.0][..], |spectra| &spectra.unexplained);
        let is_uniform = self.vol.is_uniform();
        // The values of spectra that have not been sampled are not bounded by the sampled ones.
        let is_explained = self.spectra.as_ref().is_none_or(|spectra| spectra.are_explained);
        let least = if is_explained { 0.0 } else { self.brightest() };
        let [height, width] = self.shape();
        let empty = |&error: &f64| {
            // Weighted residuals are added as soon as there are weights.
            let error = f64::max(if is_uniform { error } else { 0.0 }, least);
            let constant = Image::from_pixels(height, width, vec![error; height * width]);
            [Image::zeros(height, width), constant]
        };
        let mut maps: Vec<[Image; 2]> = unexplained.iter().map(empty).collect();
        // Products beside trees are those of an image, which has one bin.
        if let (Some(done), [maps]) = (&self.done, &mut maps[..]) {
            maps.iter_mut().zip(done).for_each(|(map, done)| map.add_scaled(done, 1.0));
        }
        if let Some(of_quadrature) = &self.quadrature_error {
            maps.iter_mut().for_each(|[_, error]| error.add_scaled(of_quadrature, 1.0));
        }
        let mut states = Vec::with_capacity(self.sheets.len());
        for sheet in &self.sheets {
            let (of_sheet, state) = sheet.assemble();
            states.push(state);
            let first = of_sheet.first_row;
            let number = sheet.id.energy;
            let weights = &self.energies.selected[number].weights;
            for (([image, error], &weight), nodal) in maps.iter_mut().zip(weights).zip(&nodal) {
                // Later energies may be combined with this one in bins where its own weight is 0.
                if nodal[number] != 0.0 {
                    error.add_rows(first, &of_sheet.of_lines, nodal[number].abs());
                }
                if weight != 0.0 {
                    image.add_rows(first, &of_sheet.image, weight);
                    error.add_rows(first, &of_sheet.error, weight.abs());
                }
            }
        }
        // If no sample is negative, a negative pixel has at least the error of its size.
        if self.sheets.iter().all(|sheet| sheet.scan.node_lines.are_nowhere_negative()) {
            for [image, error] in &mut maps {
                let pixels = error.pixels_mut().iter_mut().zip(image.pixels());
                pixels.for_each(|(error, pixel)| *error = error.max(-pixel));
            }
        }
        for tile in self.tiles {
            let first_row = tile.place.0 * tile.shape[0];
            maps.iter().try_for_each(|[image, _]| tile.check_finite(image, first_row))?;
        }
        let bands: Vec<[&Image; 2]> = maps.iter().map(|[image, error]| [image, error]).collect();
        let weights = ErrorWeights::new(self.vol, &bands, &self.view.outside);
        let of_parts = self.weigh_sheets(&weights, &nodal);
        self.add_unexplained(&mut maps, &weights);
        self.add_of_exam(&mut maps, &weights);
        let errors = maps.iter().map(|[_, error]| error).enumerate();
        let weighted_errors = errors.map_while(|(bin, error)| weights.weighted(bin, error));
        let weighted_errors = weighted_errors.collect();
        Ok(CurrentImage { maps, states, weights, weighted_errors, of_parts })
    }

    /// Adds the residuals of spectra to the errors: the weighted residual of a pixel is taken to be no larger
    /// than those of the sampled spectra.
    fn add_unexplained(&mut self, bands: &mut [[Image; 2]], weights: &ErrorWeights) {
        let (Some(maps), Some(spectra)) = (&weights.maps, &mut self.spectra) else { return };
        spectra.weigh_residuals();
        for (([_, errors], map), unexplained) in
            bands.iter_mut().zip(maps).zip(&spectra.unexplained)
        {
            for (error, weight) in errors.pixels_mut().iter_mut().zip(map.pixels()) {
                if *weight > 0.0 {
                    *error += unexplained / weight;
                }
            }
        }
    }

    /// Adds what lines of the verification of a fixed mesh have shown, the same weighted error in all pixels.
    fn add_of_exam(&self, bands: &mut [[Image; 2]], weights: &ErrorWeights) {
        if self.of_exam == 0.0 {
            return;
        }
        for (bin, [_, errors]) in bands.iter_mut().enumerate() {
            let map = weights.maps.as_ref().map(|maps| maps[bin].pixels());
            for (pixel, error) in errors.pixels_mut().iter_mut().enumerate() {
                let weight = map.map_or(1.0, |map| map[pixel]);
                if weight > 0.0 {
                    *error += self.of_exam / weight;
                }
            }
        }
    }

    /// Sets the weights of the errors of all sheets and spectra, and returns those on the raster of each part.
    /// For each pixel of a sheet it is the largest of the bins that it is in, each times its weight there
    /// relative to the largest one.
    fn weigh_sheets(&mut self, weights: &ErrorWeights, nodal: &[Vec<f64>]) -> Vec<WeightsOfPart> {
        let Some(maps) = &weights.maps else { return Vec::new() };
        let on_raster = |part: &Part<'_>| {
            let on_raster = |map: &Arc<Image>| match part.on_raster(map) {
                Cow::Borrowed(_) => map.clone(),
                Cow::Owned(map) => Arc::new(map),
            };
            maps.iter().map(on_raster).collect()
        };
        let of_parts: Vec<WeightsOfPart> = self.parts.iter().map(on_raster).collect();
        for sheet in &mut self.sheets {
            let number = sheet.id.energy;
            let maps = &of_parts[sheet.id.part];
            let largest = |shares: Vec<f64>| {
                let zeros = Image::zeros(maps[0].height(), maps[0].width());
                let shares = maps.iter().zip(shares).filter(|(_, share)| *share > 0.0);
                shares.fold(zeros, |largest, (map, share)| largest_of(largest, map, share))
            };
            let of_image = relative(self.energies.selected[number].weights.iter().copied());
            // The lines are in the images of later energies, too.
            let of_lines = relative(nodal.iter().map(|of_bin| of_bin[number]));
            let (of_image, of_lines) = (largest(of_image), largest(of_lines));
            sheet.set_weights(&of_image, &of_lines);
        }
        if let Some(spectra) = &mut self.spectra {
            spectra.set_weights(of_parts.clone());
        }
        of_parts
    }

    /// The image and its error as one cube each, and NaN at pixels where the projection has no
    /// image.
    pub(crate) fn finished(&self, current: &CurrentImage) -> [Cube; 2] {
        let of_bin = |bin: usize, kind: usize| {
            let mut map = current.maps[bin][kind].clone();
            self.view.outside.iter().for_each(|&pixel| map.pixels_mut()[pixel] = f64::NAN);
            map
        };
        let bins = 0..current.maps.len();
        [0, 1].map(|kind| Cube::from_bands(bins.clone().map(|bin| of_bin(bin, kind)).collect()))
    }

    /// Passes the current image to the observer of the rendering, if there is one.
    pub(crate) fn show(&self, current: &CurrentImage) {
        if self.meter.keeps_images() {
            self.meter.show(self.finished(current));
        }
    }
}
