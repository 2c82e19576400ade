//! The output of a method: values, their errors, and why the method ended.

use crate::cube::Cube;
use crate::found_surfaces::FoundSurfaces;
use crate::image::Image;
use crate::line_values::LineValues;
use crate::mesh::frozen::Frozen;
use crate::projection::charts::stretch::Stretch;
use crate::radiance::PixelRows;
use crate::rendering::RenderedTree;
use crate::sums::RegionSum;
use crate::tree::StopReason;
use core::fmt::Debug;
use core::ops::Range;
use std::sync::Arc;

/// G · dΩ/(dx dy) at all points of the canonical cube, as an image is made of it.
pub(crate) trait Model: Send + Sync + Debug {
    fn values(&self, points: &[[f64; 3]]) -> Vec<f64>;
}

/// The products of a view as bands of any number of pixels.
pub(crate) trait Products: Send + Sync + Debug {
    /// The bands of an image of the same view, which are made row by row; `None` of another view.
    fn bands<'a>(&self, pixels: PixelRows<'a>) -> Option<Box<dyn Bands + 'a>>;
}

/// The bands of products: one of an image, and one for each bin of a cube.
pub(crate) trait Bands: Send + Sync {
    /// The number of bands.
    fn number(&self) -> usize;

    /// The radiances of the pixels of some rows of a band; NaN where the projection has no image.
    fn values(&self, band: usize, rows: Range<usize>) -> Image;

    /// Their estimated |errors|.
    fn errors(&self, band: usize, rows: Range<usize>) -> Image;

    /// Both.
    fn maps(&self, band: usize, rows: Range<usize>) -> [Image; 2] {
        [self.values(band, rows.clone()), self.errors(band, rows)]
    }
}

/// The result of a method.
#[derive(Clone, Debug)]
pub(crate) struct MethodOutput {
    /// One band for each energy bin, or one altogether.
    pub(crate) cube: Cube,
    /// The estimated |error|, if the method has one.
    pub(crate) error: Option<Cube>,
    pub(crate) ending: StopReason,
    pub(crate) base_level: Option<u8>,
    /// The energies at which lines were integrated, in the unit of the axis.
    pub(crate) energies: Vec<f64>,
    /// The smallest feature that would have been detected, as a fraction of the view's cube.
    pub(crate) smallest_feature: Option<f64>,
    /// The uniform steps of lines of sight on a lattice of pixels, if the image is made of such lines.
    pub(crate) line_steps: Option<usize>,
    /// The largest error of a value over the error allowed there, if the method has such.
    pub(crate) error_over_allowed: Option<f64>,
    /// The radiances of lines, if the options name some and the method has them.
    pub(crate) lines: Option<LineValues>,
    /// The sums over regions, in the order of the options.
    pub(crate) sums: Vec<RegionSum>,
    /// The tree that was built, if there is one, and one only.
    pub(crate) tree: Option<RenderedTree>,
    /// The surfaces that the image is made of, if they were found.
    pub(crate) surfaces: Option<Arc<FoundSurfaces>>,
    /// What the image has the means of, if there is such a function and sums are asked for.
    pub(crate) model: Option<Arc<dyn Model>>,
    /// The products that the bands are made of, if they are to be made row by row.
    pub(crate) products: Option<Arc<dyn Products>>,
    /// The stretch of the depths of that function.
    pub(crate) stretch: Option<Stretch>,
    /// The frozen quadrature, if it was asked for and there is one.
    pub(crate) frozen: Option<Arc<Frozen>>,
}

impl MethodOutput {
    pub(crate) fn new(cube: Cube, error: Option<Cube>, ending: StopReason) -> Self {
        Self {
            cube,
            error,
            ending,
            base_level: None,
            energies: Vec::new(),
            smallest_feature: None,
            line_steps: None,
            error_over_allowed: None,
            lines: None,
            sums: Vec::new(),
            tree: None,
            surfaces: None,
            model: None,
            products: None,
            stretch: None,
            frozen: None,
        }
    }

    /// The largest estimated error over the largest |value|; 0 without an estimate.
    pub(crate) fn estimated_error(&self) -> f64 {
        self.error.as_ref().map_or(0.0, |error| error.largest() / self.cube.largest())
    }

    /// One of those of all tiles, the lowest first.
    pub(crate) fn stacked(mut of_tiles: Vec<Self>) -> Self {
        if of_tiles.len() == 1 {
            return of_tiles.remove(0);
        }
        let cube = Cube::stacked(&of_tiles.iter().map(|made| &made.cube).collect::<Vec<_>>());
        let errors: Option<Vec<&Cube>> = of_tiles.iter().map(|made| made.error.as_ref()).collect();
        let errors = errors.map(|errors| Cube::stacked(&errors));
        let frozen: Option<Vec<Frozen>> =
            of_tiles.iter_mut().map(|made| Arc::into_inner(made.frozen.take()?)).collect();
        let endings = of_tiles.iter().map(|made| made.ending);
        let ending = endings.reduce(|a, b| if a == StopReason::Complete { b } else { a });
        let mut made = Self::new(cube, errors, ending.unwrap_or(StopReason::Complete));
        made.frozen = frozen.map(|frozen| Arc::new(Frozen::stacked(frozen)));
        if let Some(first) = of_tiles.first_mut() {
            made.base_level = first.base_level;
            made.energies = core::mem::take(&mut first.energies);
        }
        made
    }
}
