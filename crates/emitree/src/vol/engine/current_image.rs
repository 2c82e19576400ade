//! The current image: the sum of the sheets of all layers and energies, with its estimated error.

use crate::cube::Cube;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::tile::Tile;
use crate::vol::engine::Engine;
use crate::vol::view::sheet::SheetState;

/// The current image with its estimated error.
pub(crate) struct CurrentImage {
    /// Image and error of each energy bin, for each tile.
    pub(crate) maps: Vec<Vec<[Image; 2]>>,
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

    /// The error of each energy bin of a tile.
    pub(crate) fn errors(&self, tile: usize) -> Vec<&Image> {
        self.maps[tile].iter().map(|[_, error]| error).collect()
    }

    /// The guarded details of the nodes of a sheet.
    pub(crate) fn guarded(&self, sheet: usize) -> &[f64] {
        &self.states[sheet].guarded
    }

    fn largest(&self, kind: usize) -> f64 {
        self.maps.iter().flatten().map(|maps| maps[kind].largest()).fold(0.0, f64::max)
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
        let empty = |tile: &Tile<'_>| {
            let [height, width] = tile.shape;
            let of_bin = |&error: &f64| {
                let error = f64::max(error, least);
                let constant = Image::from_pixels(height, width, vec![error; height * width]);
                [Image::zeros(height, width), constant]
            };
            unexplained.iter().map(of_bin).collect()
        };
        let mut maps: Vec<Vec<[Image; 2]>> = self.tiles.iter().map(empty).collect();
        let mut states = Vec::with_capacity(self.sheets.len());
        for sheet in &self.sheets {
            let (part, of_sheet) = sheet.assemble(&self.scales[sheet.tile], self.required_level);
            states.push(of_sheet);
            let number = sheet.id.energy;
            let weights = &self.energies.selected[number].weights;
            let bins = maps[sheet.tile].iter_mut().zip(weights).zip(&nodal);
            for (([image, error], &weight), nodal) in bins {
                // Later energies may be combined with this one in bins where its own weight is 0.
                if nodal[number] != 0.0 {
                    error.add_scaled(&part.of_lines, nodal[number].abs());
                }
                if weight != 0.0 {
                    image.add_scaled(&part.image, weight);
                    error.add_scaled(&part.error, weight.abs());
                }
            }
        }
        // If no sample is negative, a negative pixel has at least the error of its size.
        if self.sheets.iter().all(|sheet| sheet.scan.node_lines.are_nowhere_negative()) {
            for [image, error] in maps.iter_mut().flatten() {
                let pixels = error.pixels_mut().iter_mut().zip(image.pixels());
                pixels.for_each(|(error, pixel)| *error = error.max(-pixel));
            }
        }
        for (tile, maps) in self.tiles.iter().zip(&maps) {
            maps.iter().try_for_each(|[image, _]| tile.check_finite(image))?;
        }
        Ok(CurrentImage { maps, states })
    }

    /// The image and its error as one cube each, and NaN at pixels where the projection has no
    /// image.
    pub(crate) fn finished(&self, current: &CurrentImage) -> [Cube; 2] {
        let of_bin = |bin: usize, kind: usize| {
            let mut map = Image::stacked(current.maps.iter().map(|maps| &maps[bin][kind]));
            let scales = self.scales.iter().flat_map(Image::pixels);
            for (pixel, scale) in map.pixels_mut().iter_mut().zip(scales) {
                if *scale == 0.0 {
                    *pixel = f64::NAN;
                }
            }
            map
        };
        let bins = current.maps.first().map_or(0, Vec::len);
        [0, 1].map(|kind| Cube::from_bands((0..bins).map(|bin| of_bin(bin, kind)).collect()))
    }

    /// Passes the current image to the observer of the rendering, if there is one.
    pub(crate) fn show(&self, current: &CurrentImage) {
        if self.meter.keeps_images() {
            self.meter.show(self.finished(current));
        }
    }
}
