//! What a rendering makes, whether it has energies or not: maps of one band or of many.

use super::counts::Counts;
use emitree::{Cube, CubeRendering, Ending, Image, RenderedTree, Rendering, irradiance_of};
use emitree_instrument::Channel;
use emitree_io::{FitsImage, Quantity, Scene};
use std::time::Duration;

/// An image, or a cube: a value for each pixel in one band or in more.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    bands: Cube,
    kind: Kind,
}

/// What the bands of a map are.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    /// The only one, of an image.
    Image,
    /// Means over the bins of the scene.
    Energies,
    /// Counts in channels, of which there may be as many as bins.
    Counts {
        channels: Vec<Channel>,
        /// Whether each is a bin of the scene.
        are_bins: bool,
    },
}

impl From<Image> for Map {
    fn from(image: Image) -> Self {
        Self { bands: Cube::from_bands(vec![image]), kind: Kind::Image }
    }
}

impl From<Cube> for Map {
    fn from(bands: Cube) -> Self {
        Self { bands, kind: Kind::Energies }
    }
}

impl Map {
    /// Counts in channels, each of which is a bin of the scene or not.
    pub(super) fn counts(bands: Cube, channels: Vec<Channel>, are_bins: bool) -> Self {
        Self { bands, kind: Kind::Counts { channels, are_bins } }
    }

    /// Whether there is a third axis, be it of one bin.
    pub(crate) fn is_cube(&self) -> bool {
        self.kind != Kind::Image
    }

    /// Whether the third axis is that of the energies of the scene.
    pub(super) fn has_energies(&self) -> bool {
        matches!(self.kind, Kind::Energies | Kind::Counts { are_bins: true, .. })
    }

    /// What the bands are.
    pub(super) fn kind(&self) -> &Kind {
        &self.kind
    }

    /// The bands, the lowest energies first; an image is one.
    pub(crate) fn bands(&self) -> &[Image] {
        self.bands.bands()
    }

    /// All bands, of an image too.
    pub(crate) fn cube(&self) -> &Cube {
        &self.bands
    }

    /// As an HDU of FITS.
    pub(super) fn fits<'a>(&'a self, name: &'a str, unit: Option<&'a str>) -> FitsImage<'a> {
        match (self.bands(), &self.kind) {
            ([image], Kind::Image) => FitsImage::new(name, image, unit),
            (_, Kind::Counts { channels, are_bins: false }) => {
                FitsImage::channels(name, &self.bands, channels, unit)
            }
            _ => FitsImage::cube(name, &self.bands, unit),
        }
    }

    /// In the quantity that the scene asks for.
    pub(super) fn in_quantity(mut self, scene: &Scene) -> Self {
        if scene.quantity == Quantity::Irradiance {
            for band in self.bands.bands_mut() {
                *band = irradiance_of(band, scene.camera.projection());
            }
        }
        self
    }

    /// The image of the whole energy band of a cube.
    fn whole_band(&self, scene: &Scene) -> Option<Self> {
        Some(scene.band_image(&self.bands).filter(|_| self.is_cube())?.into())
    }
}

/// A rendering of a scene, in its quantity, and its bill.
#[derive(Debug)]
pub(crate) struct Rendered {
    /// The image or the cube.
    pub(crate) map: Map,
    /// The estimated error of each value, if the method has one.
    pub(crate) error: Option<Map>,
    /// The image of the whole energy band, if there are energies.
    pub(crate) band: Option<Map>,
    /// A bound for the error of that image.
    pub(crate) band_error: Option<Map>,
    /// What the instrument of the scene counts, if it has one.
    pub(crate) counts: Option<Counts>,
    /// How many energies were evaluated, if the method takes some.
    pub(crate) energies: Option<usize>,
    pub(crate) evaluations: u64,
    pub(crate) evaluations_of_pixels: Map,
    pub(crate) batches: u64,
    pub(crate) ending: Ending,
    pub(crate) tree: Option<RenderedTree>,
    pub(crate) base_level: Option<u8>,
    /// The smallest feature that would have been seen, as a fraction of the view's cube, if the method
    /// tells.
    pub(crate) smallest_feature: Option<f64>,
    pub(crate) emission_time: Duration,
    pub(crate) total_time: Duration,
}

impl Rendered {
    pub(crate) fn image(scene: &Scene, rendering: Rendering) -> Self {
        Self {
            map: Map::from(rendering.image).in_quantity(scene),
            error: rendering.error.map(|error| Map::from(error).in_quantity(scene)),
            band: None,
            band_error: None,
            counts: None,
            energies: None,
            evaluations: rendering.evaluations,
            evaluations_of_pixels: rendering.evaluations_of_pixels.to_image().into(),
            batches: rendering.batches,
            ending: rendering.ending,
            tree: rendering.tree,
            base_level: rendering.base_level,
            smallest_feature: rendering.smallest_feature,
            emission_time: rendering.emission_time,
            total_time: rendering.total_time,
        }
    }

    pub(crate) fn cube(scene: &Scene, rendering: CubeRendering, counts: Option<Counts>) -> Self {
        let map = Map::from(rendering.cube).in_quantity(scene);
        let error = rendering.error.map(|error| Map::from(error).in_quantity(scene));
        Self {
            band: map.whole_band(scene),
            band_error: error.as_ref().and_then(|error| error.whole_band(scene)),
            counts,
            map,
            error,
            energies: Some(rendering.energies.len()).filter(|&energies| energies > 0),
            evaluations: rendering.evaluations,
            evaluations_of_pixels: rendering.evaluations_of_pixels.to_image().into(),
            batches: rendering.batches,
            ending: rendering.ending,
            tree: None,
            base_level: rendering.base_level,
            smallest_feature: rendering.smallest_feature,
            emission_time: rendering.emission_time,
            total_time: rendering.total_time,
        }
    }

    /// Whether the method did all it was asked for.
    pub(crate) fn converged(&self) -> bool {
        self.ending == Ending::Complete
    }

    /// The largest estimated error over the largest |value|.
    pub(crate) fn estimated_error(&self) -> Option<f64> {
        let error = self.error.as_ref()?.cube().largest();
        Some(if error > 0.0 { error / self.map.cube().largest() } else { 0.0 })
    }
}
