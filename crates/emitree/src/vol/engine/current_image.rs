//! The current image: the sum of the sheets of all parts and energies, with its estimated error.

use crate::cube::Cube;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::vol::engine::Engine;
use crate::vol::view::part::Part;
use crate::vol::view::sheet::SheetState;
use std::borrow::Cow;

/// The current image with its estimated error.
pub(crate) struct CurrentImage {
    /// Image and error of each energy bin.
    pub(crate) maps: Vec<[Image; 2]>,
    /// The state of each sheet.
    pub(crate) states: Vec<SheetState>,
}

impl CurrentImage {
    pub(crate) fn largest_pixel(&self) -> f64 {
        self.largest(0)
    }

    pub(crate) fn largest_error(&self) -> f64 {
        self.largest(1)
    }

    /// The error of each energy bin on the raster of a part.
    pub(crate) fn errors(&self, part: &Part<'_>) -> Vec<Cow<'_, Image>> {
        self.maps.iter().map(|[_, error]| part.on_raster(error)).collect()
    }

    /// The guarded details of the nodes of a sheet.
    pub(crate) fn guarded(&self, sheet: usize) -> &[f64] {
        &self.states[sheet].guarded
    }

    fn largest(&self, kind: usize) -> f64 {
        self.maps.iter().map(|maps| maps[kind].largest()).fold(0.0, f64::max)
    }
}

impl Engine<'_> {
    /// The image and its estimated error in each bin, from all samples so far.
    pub(crate) fn assemble(&self) -> Result<CurrentImage, MethodError> {
        let nodal = self.energies.nodal_weights();
        let unexplained = self.spectra.as_ref().map_or(&[0.0][..], |spectra| &spectra.unexplained);
        // The values of spectra that have not been sampled are not bounded by the sampled ones.
        let is_explained = self.spectra.as_ref().is_none_or(|spectra| spectra.are_explained);
        let least = if is_explained { 0.0 } else { self.brightest() };
        let [height, width] = self.shape();
        let empty = |&error: &f64| {
            let error = f64::max(error, least);
            let constant = Image::from_pixels(height, width, vec![error; height * width]);
            [Image::zeros(height, width), constant]
        };
        let mut maps: Vec<[Image; 2]> = unexplained.iter().map(empty).collect();
        // Products are made for images alone, which have one bin.
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
        Ok(CurrentImage { maps, states })
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
