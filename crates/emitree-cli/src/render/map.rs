//! Maps of one band, of the bins of a scene, or of channels.

use emitree::{Cube, Image};
use emitree_instrument::Channel;
use emitree_io::{Bands, ProductMap, Scene};

/// An image, or a cube: a value for each pixel in one band or in more.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    bands: Cube,
    kind: Kind,
}

/// What the bands of a map are.
#[derive(Clone, Debug, PartialEq)]
enum Kind {
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
    /// Values of a scene: an image, or a cube if it has energies.
    pub(super) fn of_scene(scene: &Scene, bands: Cube) -> Self {
        let kind = if scene.energy.is_some() { Kind::Energies } else { Kind::Image };
        Self { bands, kind }
    }

    /// Counts in channels, each of which is a bin of the scene or not.
    pub(super) fn counts(bands: Cube, channels: Vec<Channel>, are_bins: bool) -> Self {
        Self { bands, kind: Kind::Counts { channels, are_bins } }
    }

    /// Whether there is a third axis, be it of one bin.
    pub(crate) fn is_cube(&self) -> bool {
        self.kind != Kind::Image
    }

    /// The map as files have it: with the name of its HDU or column, and a unit, which may be empty.
    pub(super) fn named<'a>(&'a self, name: &'a str, unit: &'a str) -> ProductMap<'a> {
        let bands = match &self.kind {
            Kind::Image => Bands::Image,
            Kind::Energies => Bands::Energies,
            Kind::Counts { channels, are_bins } => Bands::Counts { channels, are_bins: *are_bins },
        };
        ProductMap { name, map: &self.bands, unit, bands }
    }

    /// The bands, the lowest energies first; an image is one.
    pub(crate) fn bands(&self) -> &[Image] {
        self.bands.bands()
    }

    /// All bands, of an image too.
    pub(crate) fn cube(&self) -> &Cube {
        &self.bands
    }

    /// The image of the whole energy band of a cube.
    pub(super) fn whole_band(&self, scene: &Scene) -> Option<Self> {
        Some(scene.band_image(&self.bands).filter(|_| self.is_cube())?.into())
    }
}
