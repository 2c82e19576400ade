//! What a rendering makes, whether it has energies or not: maps of one band or of many.

use super::counts::Counts;
use emitree::result::{RenderStats, RenderedTree};
use emitree::{Cube, Image, Rendering, StopReason};
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
    fn of_scene(scene: &Scene, bands: Cube) -> Self {
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
    fn whole_band(&self, scene: &Scene) -> Option<Self> {
        Some(scene.band_image(&self.bands).filter(|_| self.is_cube())?.into())
    }
}

/// A rendering of a scene, in its quantity, and its cost.
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
    /// The counts of the instrument of the scene, if it has one.
    pub(crate) counts: Option<Counts>,
    /// The cost of the rendering.
    pub(crate) stats: RenderStats,
    pub(crate) evaluations_per_pixel: Map,
    pub(crate) tree: Option<RenderedTree>,
}

impl Rendered {
    pub(crate) fn new(scene: &Scene, rendering: Rendering<Cube>, counts: Option<Counts>) -> Self {
        let map = |cube: &Cube| Map::of_scene(scene, scene.cube_in_quantity(cube));
        let (values, error) = (map(&rendering.values), rendering.error.as_ref().map(map));
        Self {
            band: values.whole_band(scene),
            band_error: error.as_ref().and_then(|error| error.whole_band(scene)),
            counts,
            map: values,
            error,
            evaluations_per_pixel: rendering.stats.evaluations_per_pixel.to_image().into(),
            stats: rendering.stats,
            tree: rendering.tree,
        }
    }

    /// How many energies were evaluated, if the method takes some.
    pub(crate) fn energies(&self) -> Option<usize> {
        Some(self.stats.energies.len()).filter(|&energies| energies > 0)
    }

    /// Whether the stopping criterion was met.
    pub(crate) fn converged(&self) -> bool {
        self.stats.ending == StopReason::Complete
    }

    /// The largest estimated error over the largest |value|.
    pub(crate) fn estimated_error(&self) -> Option<f64> {
        let error = self.error.as_ref()?.cube().largest();
        Some(if error > 0.0 { error / self.map.cube().largest() } else { 0.0 })
    }
}
