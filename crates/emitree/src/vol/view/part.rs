//! The parts of a view, each with a chart of its own, whose images add up.
//!
//! Without opaque bodies and limbs of bounds there is one part for each tile, the image plane, or one for each layer
//! between planes at which g jumps or has a kink. With them the parts are the charts of the atlas that some pixels
//! see.

use crate::image::Image;
use crate::projection::Chart;
use crate::projection::charts::Atlas;
use crate::projection::charts::FittedDepth;
use crate::projection::charts::chart::Window;
use crate::projection::charts::depth::Weights;
use crate::projection::charts::layer::{Layer, layers};
use crate::projection::charts::remapped::{Remap, Remapped};
use crate::projection::charts::stretch::{Stretch, StretchTable};
use crate::radiance::radiance_per_density;
use crate::tile::Tile;
use crate::vol::tuning::TUNING;
use crate::vol::view::chart_nodes::ChartNodes;
use crate::vol::view::division::{Division, atlas_of_box};
use crate::vol::view::pixel_rule::{Crossing, RuleNode};
use crate::vol::view::products::{FrozenProducts, RasterMeans};
use crate::vol::view::quadrature::{ChartInView, ChartsInView, Quadrature};
use crate::vol::view::raster::{Raster, cell_at};
use crate::vol::view::settle::{MeansOfPart, NodesInView, Settled};
use crate::vol::view::windows::NaturalNode;
use std::borrow::Cow;
use std::sync::Arc;

/// A part of a view: a chart, and the image of a function on it.
pub(crate) struct Part<'a> {
    pub(crate) chart: Box<dyn Chart + 'a>,
    pub(crate) footing: Arc<Footing>,
    /// For each cell of the raster of the part, the ratio of a pixel to the mean of the function,
    /// and 0 in cells without a pixel.
    pub(crate) scale: Arc<Image>,
    /// The share of the pixels that it is in.
    pub(crate) share: f64,
    /// By how many levels its base lattice is coarser than that of a whole view.
    pub(crate) coarser: u8,
    /// The largest number of parts in which a line of sight is: the errors of their lines add up.
    pub(crate) pieces_of_line: usize,
    /// The edge of a feature in the part as a share of that in the view's cube, where the samples of
    /// the part are least dense: features of all depths have to be detected.
    pub(crate) least_feature: f64,
}

/// Where the function of a part is in the image.
#[derive(Debug)]
pub(crate) enum Footing {
    /// The raster is the pixels of one tile.
    Pixels {
        /// The first row of the tile in the image.
        first_row: usize,
        /// The quadrature of pixels that a rim crosses.
        rim: Option<ChartNodes>,
    },
    /// Pixels are sums over nodes in the chart.
    Nodes {
        /// The number of the chart in the atlas, and what is in view of it.
        chart: usize,
        window: Window,
        nodes: ChartNodes,
    },
}

/// The parts of a view.
pub(crate) struct Parts<'a> {
    pub(crate) parts: Vec<Part<'a>>,
    /// What the parts follow from.
    pub(crate) division: Division,
    /// The numbers of the pixels that belong to no image.
    pub(crate) outside: Vec<usize>,
    quadrature: Quadrature<'a>,
    /// Whether edges cross the pixels, if there is an atlas or a rim.
    crossings: Vec<Crossing>,
    /// Whether the depth of the image plane is stretched.
    is_stretched: bool,
    /// Whether the view could be divided by the faces of a box, and is not.
    pub(crate) has_box: bool,
}

/// The image of products on the rasters of one part.
#[derive(Clone, Debug)]
pub(crate) struct ProductImage {
    /// The sum of the products.
    pub(crate) function: Arc<dyn RasterMeans>,
    /// The errors on the raster of errors.
    pub(crate) errors: Image,
    /// The products themselves, if a frozen quadrature is made.
    pub(crate) frozen: Option<FrozenProducts>,
}

/// The parts of a view with this atlas; without one, the image plane of each tile, whatever limbs there are,
/// with this stretch of its depth.
pub(crate) fn parts<'a>(
    tiles: &[Tile<'a>],
    atlas: Option<&'a Atlas<'a>>,
    stretch: Option<Stretch>,
) -> Parts<'a> {
    if let Some(atlas) = atlas {
        return SeenCharts::new(tiles, atlas).parts(tiles, atlas);
    }
    let (scales, mut outside) = scales_and_outside(tiles);
    let quadrature = Quadrature::new(None, tiles);
    let of_tile = |(number, (tile, scale)): (usize, (&Tile<'a>, &Image))| {
        let first_row = number * tile.shape[0];
        let rim = Quadrature::new(None, core::slice::from_ref(tile)).rim_nodes();
        let rim = rim.map(|(nodes, beyond)| {
            outside.extend(beyond.into_iter().map(|pixel| first_row * tile.shape[1] + pixel));
            nodes
        });
        Part {
            chart: plane_chart(tile, number, stretch),
            footing: Arc::new(Footing::Pixels { first_row, rim }),
            scale: Arc::new(scale.clone()),
            share: 1.0 / tiles.len() as f64,
            // Each of several tiles is a small part of the view, so that its base lattice is finer
            // in the view.
            coarser: u8::from(tiles.len() > 1),
            pieces_of_line: 1,
            least_feature: stretch.map_or(1.0, |stretch| stretch.uniform.cbrt()),
        }
    };
    let parts = tiles.iter().zip(&scales).enumerate().map(of_tile).collect();
    let is_stretched = stretch.is_some();
    let has_box = atlas_of_box(tiles).is_some();
    let crossings = quadrature.crossings_of_rim();
    let division = Division::default();
    Parts { parts, division, outside, quadrature, crossings, is_stretched, has_box }
}

/// The image plane of a tile as a chart, with this stretch of its depth.
fn plane_chart<'a>(
    tile: &Tile<'a>,
    number: usize,
    stretch: Option<Stretch>,
) -> Box<dyn Chart + 'a> {
    let chart = tile.projection.chart(number);
    match stretch {
        Some(stretch) => {
            let remap = Remap::Stretch(StretchTable::new(stretch));
            Box::new(Remapped { chart, remap })
        }
        None => chart,
    }
}

/// The parts of the image plane of each tile in the layers between planes, with this stretch of its depth; `None` if
/// no plane divides the view. `least_cosine` is that of [`layers`].
pub(crate) fn layered_parts<'a>(
    tiles: &[Tile<'a>],
    stretch: Option<Stretch>,
    least_cosine: f64,
) -> Option<Parts<'a>> {
    let of_tile = |tile: &Tile<'a>| match tile.projection.view_geometry() {
        Some(geometry) => layers(geometry, least_cosine),
        None => Vec::new(),
    };
    let of_tiles: Vec<Vec<Layer>> = tiles.iter().map(of_tile).collect();
    let pieces_of_line = of_tiles.iter().map(Vec::len).max().filter(|most| *most > 0)?;
    let mut divided = parts(tiles, None, stretch);
    let whole = core::mem::take(&mut divided.parts).into_iter().zip(of_tiles);
    divided.parts = whole
        .zip(tiles)
        .enumerate()
        .flat_map(|(number, ((part, layers), tile))| {
            if layers.is_empty() {
                return vec![part];
            }
            let in_layer = |layer| {
                let chart = plane_chart(tile, number, stretch);
                let (footing, scale) = (Arc::clone(&part.footing), Arc::clone(&part.scale));
                let remap = Remap::Layer(layer);
                let chart: Box<dyn Chart + 'a> = Box::new(Remapped { chart, remap });
                Part { chart, footing, scale, pieces_of_line, ..part }
            };
            layers.into_iter().map(in_layer).collect::<Vec<_>>()
        })
        .collect();
    Some(divided)
}

/// The ratio of each pixel of the tiles to the mean over its density, and the numbers of the pixels without one.
fn scales_and_outside(tiles: &[Tile<'_>]) -> (Vec<Image>, Vec<usize>) {
    let scales: Vec<Image> =
        tiles.iter().map(|tile| radiance_per_density(tile.projection, tile.shape)).collect();
    let scale = scales.iter().flat_map(Image::pixels).enumerate();
    let without = scale.filter(|(_, scale)| **scale == 0.0).map(|(pixel, _)| pixel);
    let outside = without.collect();
    (scales, outside)
}

/// What pixels see of the charts of an atlas. The weights of the coordinates of depth change nothing of it.
pub(crate) struct SeenCharts {
    charts: Vec<SeenChart>,
    outside: Vec<usize>,
    crossings: Vec<Crossing>,
}

/// A [`Part`] without its coordinates of depth.
struct SeenChart {
    number: usize,
    window: Window,
    footing: Arc<Footing>,
    scale: Arc<Image>,
    share: f64,
    coarser: u8,
    pieces_of_line: usize,
}

impl SeenCharts {
    fn new<'a>(tiles: &[Tile<'a>], atlas: &'a Atlas<'a>) -> Self {
        let (_, mut outside) = scales_and_outside(tiles);
        let ChartsInView { charts, most_pieces, outside: beyond, crossings } =
            Quadrature::new(Some(atlas), tiles).charts_in_view(atlas);
        outside.extend(beyond);
        let pixels = tiles.iter().map(|tile| tile.shape[0] * tile.shape[1]).sum::<usize>();
        let charts = charts.into_iter().map(|ChartInView { chart: number, window, nodes }| {
            let share = nodes.pixels_in_view as f64 / pixels as f64;
            let is_small = share < TUNING.view.small_share || atlas.looks_dark(number);
            let scale = Arc::new(nodes.cells_in_view());
            let footing = Arc::new(Footing::Nodes { chart: number, window, nodes });
            let (coarser, pieces_of_line) = (u8::from(is_small), most_pieces);
            SeenChart { number, window, footing, scale, share, coarser, pieces_of_line }
        });
        Self { charts: charts.collect(), outside, crossings }
    }

    /// The parts of a view with the atlas, or with one that differs in the weights of depths alone.
    pub(crate) fn parts<'a>(self, tiles: &[Tile<'a>], atlas: &'a Atlas<'a>) -> Parts<'a> {
        let part = |of: SeenChart| Part {
            chart: atlas.chart(of.number, of.window),
            footing: of.footing,
            scale: of.scale,
            share: of.share,
            coarser: of.coarser,
            pieces_of_line: of.pieces_of_line,
            least_feature: 1.0,
        };
        let quadrature = Quadrature::new(Some(atlas), tiles);
        let (outside, crossings) = (self.outside, self.crossings);
        let parts = self.charts.into_iter().map(part).collect();
        let (is_stretched, has_box) = (false, false);
        let division = Division::default();
        Parts { parts, division, outside, quadrature, crossings, is_stretched, has_box }
    }
}

impl Part<'_> {
    /// What pixels see of its chart; `None` on the image plane.
    fn seen_chart(&self) -> Option<SeenChart> {
        let Footing::Nodes { chart: number, window, .. } = *self.footing else { return None };
        let (footing, scale) = (self.footing.clone(), self.scale.clone());
        let (share, coarser, pieces_of_line) = (self.share, self.coarser, self.pieces_of_line);
        Some(SeenChart { number, window, footing, scale, share, coarser, pieces_of_line })
    }

    /// The base level of the part if that of a whole view is `of_view`.
    pub(crate) fn base_level(&self, of_view: u8) -> u8 {
        of_view.saturating_sub(self.coarser).max(1)
    }

    /// Whether a place in the chart is in view, or near places that are.
    pub(crate) fn is_in_view(&self, uv: [f64; 2]) -> bool {
        let shape = [self.scale.height(), self.scale.width()];
        matches!(*self.footing, Footing::Pixels { .. })
            || self.scale.pixels()[cell_at(uv, shape)] > 0.0
    }

    /// Whether it is one of several tiles.
    pub(crate) fn is_tile_of_several(&self) -> bool {
        matches!(*self.footing, Footing::Pixels { .. }) && self.coarser > 0
    }

    /// The scale on a raster of another shape, none of whose sides is longer.
    pub(crate) fn scale_on(&self, shape @ [rows, columns]: [usize; 2]) -> Image {
        let own = [self.scale.height(), self.scale.width()];
        if shape == own {
            return (*self.scale).clone();
        }
        // The largest scale of the cells whose middle is in each of the coarser ones.
        let mut scale = Image::zeros(rows, columns);
        for (row, values) in self.scale.rows().enumerate() {
            let coarse = scale.row_mut((2 * row + 1) * rows / (2 * own[0]));
            for (column, value) in values.iter().enumerate() {
                let cell = &mut coarse[(2 * column + 1) * columns / (2 * own[1])];
                *cell = cell.max(*value);
            }
        }
        scale
    }

    /// The part of a map of the image that the raster of the part corresponds to: on the pixels of
    /// a tile itself, otherwise the largest of the pixels that have a node in each cell.
    pub(crate) fn on_raster<'m>(&self, map: &'m Image) -> Cow<'m, Image> {
        match &*self.footing {
            Footing::Pixels { first_row, .. } => {
                let [height, width] = [self.scale.height(), self.scale.width()];
                if map.height() == height {
                    return Cow::Borrowed(map);
                }
                let from = first_row * width;
                let pixels = map.pixels()[from..from + height * width].to_vec();
                Cow::Owned(Image::from_pixels(height, width, pixels))
            }
            Footing::Nodes { nodes, .. } => Cow::Owned(nodes.largest_of_pixels(map, |_, _| 1.0)),
        }
    }

    /// The weights of errors on the raster of the part, from those of pixels, and the share of the error allowed in a
    /// pixel that the part may have, given the number of the pixel and its share in the part: an error of the part has
    /// an effect in proportion to that.
    pub(crate) fn weights_on_raster(
        &self,
        weights: &Image,
        allowed: impl Fn(usize, f64) -> f64,
    ) -> Image {
        let factor = |pixel: usize, in_part: f64| (in_part / allowed(pixel, in_part)).min(1.0);
        match &*self.footing {
            Footing::Pixels { .. } => self.on_raster(weights).into_owned(),
            Footing::Nodes { nodes, .. } => nodes.largest_of_pixels(weights, factor),
        }
    }
}

impl Parts<'_> {
    /// The weights of the coordinates of depth in a chart.
    pub(crate) fn weights(&self, chart: usize) -> Option<Weights> {
        self.quadrature.atlas?.weights(chart)
    }

    /// Other weights of the coordinates of depth for a chart.
    pub(crate) fn fitted_depth(&self, chart: usize, weights: Weights) -> Option<FittedDepth> {
        self.quadrature.atlas?.fitted(chart, weights)
    }

    /// Whether the depth of a chart can be divided at the points nearest to a centre, and has not been.
    pub(crate) fn may_be_halved(&self, chart: usize) -> bool {
        let can_be = |atlas: &&Atlas<'_>| !atlas.has_halves() && atlas.can_be_halved(chart);
        self.quadrature.atlas.is_some_and(|atlas| can_be(&atlas))
    }

    /// Whether the depths of some charts or of the image plane have been fitted to samples.
    pub(crate) fn has_fitted_depths(&self) -> bool {
        self.is_stretched || self.quadrature.atlas.is_some_and(Atlas::has_fitted_depths)
    }

    /// Whether the rim of a disc crosses some pixels.
    pub(crate) fn has_rim(&self) -> bool {
        self.quadrature.atlas.is_none() && !self.crossings.is_empty()
    }

    /// The nodes of a line of sight at (x, y) of the first image plane, as those of a pixel with this number.
    pub(crate) fn nodes_of_line(&self, xy: [f64; 2], number: usize) -> Vec<NaturalNode> {
        self.quadrature.nodes_of_line(xy, number).unwrap_or_else(|| {
            let weight = |part: &Part<'_>| 1.0 / part.chart.density(xy);
            let weight = self.parts.first().map(weight).filter(|weight| weight.is_finite());
            let node = |weight| NaturalNode { chart: 0, pixel: number, place: xy, weight };
            weight.map(node).into_iter().collect()
        })
    }

    /// Whether the emission is singular somewhere in the charts.
    pub(crate) fn has_singularities(&self) -> bool {
        self.quadrature.atlas.is_some_and(Atlas::has_singularities)
    }

    /// Whether planes divide the charts.
    pub(crate) fn has_layers(&self) -> bool {
        self.quadrature.atlas.is_some_and(Atlas::has_layers)
    }

    /// Whether the second coordinate of charts is an azimuth, at which they may be cut.
    pub(crate) fn have_azimuths(&self) -> bool {
        self.quadrature.atlas.is_some_and(|atlas| atlas.has_shells(0))
    }

    /// What pixels see of the charts, for another atlas; `None` on the image plane.
    pub(crate) fn seen_charts(&self) -> Option<SeenCharts> {
        let charts = self.parts.iter().map(Part::seen_chart).collect::<Option<Vec<_>>>()?;
        let (outside, crossings) = (self.outside.clone(), self.crossings.clone());
        (!charts.is_empty()).then_some(SeenCharts { charts, outside, crossings })
    }

    /// The number of parts along each side of a pixel that a limb crosses; `None` for other pixels.
    pub(crate) fn parts_at_limb(&self, pixel: usize) -> Option<usize> {
        match self.crossings.get(pixel) {
            Some(Crossing::Crossed(parts)) => Some(*parts),
            _ => None,
        }
    }

    /// The places in a pixel that a limb crosses, from 0 to 1, with their weights in its mean, for so many
    /// parts along each side.
    pub(crate) fn nodes_at_limb(&self, pixel: usize, parts: usize) -> Vec<RuleNode> {
        self.quadrature.places_in_pixel(pixel, Crossing::Crossed(parts), 0)
    }

    /// Compares the quadrature of pixels in charts with a finer one, and replaces it where they
    /// differ by more than `allowed`, divided by the weight of each pixel's error; `means` are those of the
    /// function of a part, given its number, over a raster. Returns the footings of all parts and the error of
    /// each pixel; `None` without charts.
    pub(crate) fn settle(
        &self,
        means: &MeansOfPart<'_>,
        allowed: f64,
        weights: Option<&Image>,
    ) -> Option<(Vec<Arc<Footing>>, Image)> {
        let mut charts = Vec::new();
        for part in &self.parts {
            let Footing::Nodes { chart, window, nodes } = &*part.footing else { return None };
            charts.push(NodesInView { chart: *chart, window: *window, nodes });
        }
        if charts.is_empty() {
            return None;
        }
        let Settled { nodes, error } =
            self.quadrature.settle(&self.crossings, &charts, means, allowed, weights);
        let footing = |(nodes, of): (ChartNodes, &NodesInView<'_>)| {
            Arc::new(Footing::Nodes { chart: of.chart, window: of.window, nodes })
        };
        Some((nodes.into_iter().zip(&charts).map(footing).collect(), error))
    }

    /// The image of products of all parts, with its error, for a quadrature error of at most
    /// `allowed` in a pixel, divided by its weight, where that is possible, and the footings of the parts
    /// in it.
    pub(crate) fn image_of_products(
        &self,
        products: &[ProductImage],
        allowed: f64,
        weights: Option<&Image>,
    ) -> ([Image; 2], Vec<Arc<Footing>>) {
        let means = |part: usize, shape: [usize; 2]| products[part].function.means(shape);
        let own = || self.parts.iter().map(|part| part.footing.clone()).collect();
        let (footings, error) = match self.settle(&means, allowed, weights) {
            Some((footings, error)) => (footings, Some(error)),
            None => (own(), None),
        };
        let footings: Vec<Arc<Footing>> = footings;
        let mut maps: Option<[Image; 2]> = None;
        for ((footing, product), part) in footings.iter().zip(products).zip(&self.parts) {
            add(&mut maps, footing.maps_of_product(product, &part.scale));
        }
        let mut maps = maps.unwrap_or_else(|| [Image::zeros(0, 0), Image::zeros(0, 0)]);
        if let Some(error) = error {
            maps[1].add_scaled(&error, 1.0);
        }
        (maps, footings)
    }
}

/// Adds maps to others, if there are any.
pub(crate) fn add(sum: &mut Option<[Image; 2]>, maps: [Image; 2]) {
    match sum {
        None => *sum = Some(maps),
        Some(sum) => sum.iter_mut().zip(&maps).for_each(|(sum, map)| sum.add_scaled(map, 1.0)),
    }
}

impl Footing {
    /// Whether the raster is that of pixels.
    pub(crate) fn is_of_pixels(&self) -> bool {
        matches!(self, Self::Pixels { .. })
    }

    /// Whether pixels are the means over the raster of the part alone.
    pub(crate) fn is_raster_of_pixels(&self) -> bool {
        matches!(self, Self::Pixels { rim: None, .. })
    }

    /// The image of a function of which `means` gives the means over a raster of any shape: of the
    /// rows of the image that the part is in, the first of which is returned, too.
    pub(crate) fn image(
        &self,
        means: impl Fn([usize; 2]) -> Vec<f64>,
        scale: &Image,
    ) -> (usize, Image) {
        match self {
            Self::Pixels { first_row, rim } => {
                let shape @ [height, width] = [scale.height(), scale.width()];
                let mut pixels = means(shape);
                pixels.iter_mut().zip(scale.pixels()).for_each(|(pixel, scale)| *pixel *= scale);
                let mut image = Image::from_pixels(height, width, pixels);
                if let Some(rim) = rim {
                    rim.clear(&mut image);
                    let raster = Raster::new(rim.values_shape, means(rim.values_shape));
                    rim.add_image(&raster, &mut image);
                }
                (*first_row, image)
            }
            Self::Nodes { nodes, .. } => {
                (0, nodes.image(&Raster::new(nodes.values_shape, means(nodes.values_shape))))
            }
        }
    }

    /// Image and error of products, for a part in a chart.
    pub(crate) fn maps_of_product(&self, product: &ProductImage, scale: &Image) -> [Image; 2] {
        let (_, image) = self.image(|shape| product.function.means(shape), scale);
        [image, self.errors(product.errors.clone())]
    }

    /// Height and width of the rows of the image that the part is in, given its scale.
    pub(crate) fn shape_of_image(&self, scale: &Image) -> [usize; 2] {
        match self {
            Self::Pixels { .. } => [scale.height(), scale.width()],
            Self::Nodes { nodes, .. } => nodes.image_shape(),
        }
    }

    /// The errors of pixels from the same error everywhere on the raster of the part, of this shape.
    pub(crate) fn same_errors(&self, error: f64, [rows, columns]: [usize; 2]) -> Image {
        match self {
            Self::Pixels { .. } => Image::from_pixels(rows, columns, vec![error; rows * columns]),
            Self::Nodes { nodes, .. } => nodes.image_of_constant(error),
        }
    }

    /// The errors of pixels from those on the raster of the part.
    pub(crate) fn errors(&self, on_raster: Image) -> Image {
        match self {
            Self::Pixels { .. } => on_raster,
            Self::Nodes { nodes, .. } => {
                let [height, width] = nodes.image_shape();
                let mut errors = Image::zeros(height, width);
                nodes.add_errors(&on_raster, &mut errors);
                errors
            }
        }
    }
}
