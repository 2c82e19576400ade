//! The quadrature of pixels in the charts of a view.
//!
//! A pixel is the mean over its lines of sight, weighted with the density of solid angle, and the
//! radiance of a line is the sum over its pieces, each at its place in a chart. So a pixel is a
//! weighted sum of values of the charts' functions at the nodes of its quadrature. Nothing of this
//! depends on g.

use crate::image::Image;
use crate::parallel::prelude::*;
use crate::projection::ViewGeometry;
use crate::projection::charts::chart::Window;
use crate::projection::charts::{Atlas, PieceOfLine};
use crate::tile::Tile;
use crate::vol::view::pixel_rule::{Crossing, PixelRules};
use crate::vol::view::raster::{Place, cell_at};
use core::f64::consts::TAU;

/// The number of nodes along each side of an image: those of a pixel follow from it, within limits. A
/// pixel of a small image is a large part of the view.
const NODES_OF_SIDE: usize = 400;
const NODES_OF_PIXEL: [usize; 2] = [2, 16];
/// The pixels along the longer side of an image from which one node in the middle suffices.
const LARGE: usize = 1500;
/// The quadrature of all pixels of images with fewer pixels along their longer side is compared with a
/// finer one; in larger images only where edges are near.
const SMALL: usize = 100;
/// Elsewhere, too, where the values at the nodes of a pixel differ by so many times the error allowed.
const VARIATION: f64 = 20.0;
/// The share of a window that the nodes of a pixel extend over if there may be structure thinner than
/// the pixel: its quadrature has to agree with a finer one twice.
const THIN: f64 = 0.25;
/// The most times that the sides of a pixel are halved.
const FINEST_LEVEL: u8 = 5;
/// How far from a limb, in units of the variation of the distance from it over a pixel, the square
/// root of the radiance matters.
const BESIDE: f64 = 2.0;
/// A body has at least so many times the size of a part of a pixel.
const PARTS: f64 = 2.0;
/// The most parts along each side of a pixel.
const MOST_PARTS: usize = 16;
/// A window ends at a limb, or at the axis, if that is within this share of its width.
const SNAP: f64 = 0.02;
/// Elsewhere it extends beyond the nodes by this share.
const MARGIN: f64 = 0.01;
/// An azimuth is closed if the largest gap in view is smaller \[rad\].
const LEAST_GAP_RAD: f64 = 0.6;

/// A node of the quadrature of a pixel.
#[derive(Clone, Copy, Debug)]
struct ChartNode {
    pixel: u32,
    place: [f32; 2],
    weight: f64,
}

/// The nodes of all pixels in one chart, in the order of the pixels.
#[derive(Debug)]
pub(crate) struct ChartNodes {
    /// Height and width of the image.
    shape: [usize; 2],
    nodes: Vec<ChartNode>,
    /// The first node of each row of pixels, and the end.
    rows: Vec<usize>,
    /// The number of pixels with a node.
    pub(crate) pixels_in_view: usize,
    /// The raster from which values are computed.
    pub(crate) values_shape: [usize; 2],
    /// The raster of errors, with cells of about the size of a pixel.
    pub(crate) errors_shape: [usize; 2],
}

impl ChartNodes {
    fn new(shape: [usize; 2], nodes: Vec<ChartNode>) -> Self {
        let rows = rows_of(shape, &nodes);
        let mut pixels: Vec<u32> = nodes.iter().map(|node| node.pixel).collect();
        pixels.dedup();
        let side = (pixels.len() as f64).sqrt().ceil();
        let side = crate::cell::whole(side).next_power_of_two().clamp(FEWEST_CELLS, MOST_CELLS);
        let fine = (FINER_VALUES * side).clamp(FEWEST_VALUES, MOST_CELLS);
        let pixels_in_view = pixels.len();
        Self {
            shape,
            nodes,
            rows,
            pixels_in_view,
            values_shape: [fine; 2],
            errors_shape: [side; 2],
        }
    }

    fn of_row(&self, row: usize) -> &[ChartNode] {
        &self.nodes[self.rows[row]..self.rows[row + 1]]
    }

    fn of_pixel(&self, pixel: usize) -> impl Iterator<Item = &ChartNode> {
        let of_row = self.of_row(pixel / self.shape[1]);
        let first = of_row.partition_point(|node| (node.pixel as usize) < pixel);
        of_row[first..].iter().take_while(move |node| node.pixel as usize == pixel)
    }

    /// Whether the nodes of a pixel are in a large part of the coordinate across limbs, so that
    /// structure may be thinner than the pixel.
    fn is_thin(&self, pixel: usize) -> bool {
        let along = self.of_pixel(pixel).map(|node| f64::from(node.place[0]));
        extent(along) > THIN
    }

    /// The weights of the nodes of a pixel and the values there, given the means over the raster.
    fn values(&self, pixel: usize, means: &[f64]) -> impl Iterator<Item = (f64, f64)> {
        self.of_pixel(pixel).map(move |node| {
            let place = Place::new(node.place.map(f64::from), self.values_shape);
            (node.weight, place.value(means, self.values_shape[1]))
        })
    }

    /// The weighted sum of the values at the nodes of a pixel.
    fn value(&self, pixel: usize, means: &[f64]) -> f64 {
        self.values(pixel, means).map(|(weight, value)| weight * value).sum()
    }

    /// The difference between the largest and the smallest value at the nodes of a pixel.
    fn range(&self, pixel: usize, means: &[f64]) -> f64 {
        extent(self.values(pixel, means).map(|(_, value)| value))
    }

    /// Adds to each pixel the weighted sum of `value` at its nodes.
    fn add(&self, image: &mut Image, value: impl Fn(&ChartNode) -> f64 + Sync) {
        let width = self.shape[1];
        let rows = image.pixels_mut().par_chunks_mut(width.max(1)).enumerate();
        rows.for_each(|(row, pixels)| {
            for node in self.of_row(row) {
                pixels[node.pixel as usize - row * width] += node.weight * value(node);
            }
        });
    }

    /// Adds the image of a function to `image`, from its `means` over the raster of values.
    pub(crate) fn add_image(&self, means: &[f64], image: &mut Image) {
        let shape @ [_, columns] = self.values_shape;
        self.add(image, |node| Place::new(node.place.map(f64::from), shape).value(means, columns));
    }

    /// Adds the means of errors over pixels to `image`, from those on the raster of errors.
    pub(crate) fn add_errors(&self, errors: &Image, image: &mut Image) {
        let cells = errors.pixels();
        self.add(image, |node| cells[cell_at(node.place.map(f64::from), self.errors_shape)]);
    }

    /// Height and width of the image.
    pub(crate) fn image_shape(&self) -> [usize; 2] {
        self.shape
    }

    /// Sets all pixels with nodes to 0.
    pub(crate) fn clear(&self, image: &mut Image) {
        self.nodes.iter().for_each(|node| image.pixels_mut()[node.pixel as usize] = 0.0);
    }

    /// 1 in each cell of the raster of errors that is in view, with those around it, and 0 in
    /// others.
    pub(crate) fn cells_in_view(&self) -> Image {
        let [rows, columns] = self.errors_shape;
        let mut cells = Image::zeros(rows, columns);
        for node in &self.nodes {
            let cell = cell_at(node.place.map(f64::from), self.errors_shape);
            let around = |k: usize, count: usize| k.saturating_sub(1)..(k + 2).min(count);
            for row in around(cell / columns, rows) {
                cells.row_mut(row)[around(cell % columns, columns)].fill(1.0);
            }
        }
        cells
    }

    /// For each cell of the raster of errors the largest value of a pixel with a node in it.
    pub(crate) fn largest_of_pixels(&self, image: &Image) -> Image {
        let [rows, columns] = self.errors_shape;
        let mut largest = Image::zeros(rows, columns);
        let cells = largest.pixels_mut();
        for node in &self.nodes {
            let cell = &mut cells[cell_at(node.place.map(f64::from), self.errors_shape)];
            *cell = cell.max(image.pixels()[node.pixel as usize]);
        }
        largest
    }
}

/// The difference between the largest and the smallest of some numbers; 0 without any.
fn extent(numbers: impl Iterator<Item = f64>) -> f64 {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = numbers.fold(none, |(low, high), x| (low.min(x), high.max(x)));
    (high - low).max(0.0)
}

/// The first node of each row of pixels, and the end.
fn rows_of([height, width]: [usize; 2], nodes: &[ChartNode]) -> Vec<usize> {
    let first = |row: usize| nodes.partition_point(|node| (node.pixel as usize) < row * width);
    (0..=height).map(first).collect()
}

/// The fewest and the most cells along each side of a raster of errors; and for values, how many
/// times as many, and the fewest.
const FEWEST_CELLS: usize = 16;
const MOST_CELLS: usize = 1024;
const FINER_VALUES: usize = 4;
const FEWEST_VALUES: usize = 256;

/// One chart in view: its number in the atlas, what is in view, and the nodes of pixels in it.
#[derive(Debug)]
pub(crate) struct ChartInView {
    pub(crate) chart: usize,
    pub(crate) window: Window,
    pub(crate) nodes: ChartNodes,
}

/// A node of a pixel before the windows are known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NaturalNode {
    pub(crate) chart: usize,
    pixel: usize,
    /// The coordinates (c, φ).
    place: [f64; 2],
    weight: f64,
}

/// The nodes of one pixel.
struct PixelNodes {
    /// Its number.
    pixel: usize,
    nodes: Vec<NaturalNode>,
    /// The largest number of pieces of a line.
    most_pieces: usize,
    is_outside: bool,
}

/// The charts that have nodes of pixels.
pub(crate) struct ChartsInView {
    pub(crate) charts: Vec<ChartInView>,
    /// The largest number of pieces of a line.
    pub(crate) most_pieces: usize,
    /// The numbers of the pixels without a node in the image.
    pub(crate) outside: Vec<usize>,
    /// Whether edges cross the pixels.
    pub(crate) crossings: Vec<Crossing>,
}

/// The quadrature of the pixels of an image.
pub(crate) struct Quadrature<'a> {
    /// The charts of the view; on the image plane itself without them.
    pub(crate) atlas: Option<&'a Atlas<'a>>,
    geometries: Vec<&'a dyn ViewGeometry>,
    /// Height and width of a tile.
    tile: [usize; 2],
    rules: PixelRules,
}

impl<'a> Quadrature<'a> {
    /// For an atlas and the tiles of an image.
    pub(crate) fn new(atlas: Option<&'a Atlas<'a>>, tiles: &[Tile<'a>]) -> Self {
        let geometries = tiles.iter().filter_map(|tile| tile.projection.view_geometry()).collect();
        let tile @ [height, width] = tiles.first().map_or([1; 2], |tile| tile.shape);
        let rules = PixelRules::new(nodes_of_pixel(height.max(width)));
        Self { atlas, geometries, tile, rules }
    }

    fn shape(&self) -> [usize; 2] {
        [self.tile[0] * self.geometries.len(), self.tile[1]]
    }

    /// Whether all pixels are so large that the variation of the radiance within each matters.
    pub(crate) fn has_large_pixels(&self) -> bool {
        self.tile[0].max(self.tile[1]) < SMALL
    }

    /// The nodes of all pixels in the charts of the atlas.
    pub(crate) fn charts_in_view(&self, atlas: &Atlas<'_>) -> ChartsInView {
        let shape @ [height, width] = self.shape();
        let of_row = |row: usize| -> Vec<(Crossing, PixelNodes)> {
            let pixels = self.crossings_of_row(row).into_iter().enumerate();
            let of_pixel = |(column, crossing)| {
                (crossing, self.nodes_of_pixel(row * width + column, crossing, 0))
            };
            pixels.map(of_pixel).collect()
        };
        let rows: Vec<_> = (0..height).into_par_iter().map(of_row).collect();
        let mut of_charts: Vec<Vec<NaturalNode>> = (0..atlas.len()).map(|_| Vec::new()).collect();
        let (mut outside, mut crossings, mut most_pieces) = (Vec::new(), Vec::new(), 1);
        for (pixel, (crossing, of_pixel)) in rows.into_iter().flatten().enumerate() {
            crossings.push(crossing);
            most_pieces = most_pieces.max(of_pixel.most_pieces);
            if of_pixel.is_outside {
                outside.push(pixel);
            }
            for node in of_pixel.nodes {
                of_charts[node.chart].push(node);
            }
        }
        let in_view = of_charts.into_iter().enumerate().filter(|(_, nodes)| !nodes.is_empty());
        let charts = in_view.map(|(chart, nodes)| {
            let window = window(atlas.natural_ends(chart), atlas.sector_rad(chart), &nodes);
            let nodes = nodes.iter().map(|node| in_window(&window, node)).collect();
            ChartInView { chart, window, nodes: ChartNodes::new(shape, nodes) }
        });
        ChartsInView { charts: charts.collect(), most_pieces, outside, crossings }
    }

    /// The nodes, on the image plane itself, of the pixels that the rim of a disc crosses, and the
    /// numbers of the pixels outside; `None` without a rim.
    pub(crate) fn rim_nodes(&self) -> Option<(ChartNodes, Vec<usize>)> {
        self.geometries.first().filter(|geometry| geometry.has_rim())?;
        let shape @ [height, width] = self.shape();
        let of_row = |row: usize| -> Vec<PixelNodes> {
            let crossings = self.crossings_of_row(row).into_iter().enumerate();
            let crossed = crossings.filter(|(_, crossing)| *crossing != Crossing::None);
            let nodes = |(column, crossing)| self.nodes_of_pixel(row * width + column, crossing, 0);
            crossed.map(nodes).collect()
        };
        let rows: Vec<Vec<PixelNodes>> = (0..height).into_par_iter().map(of_row).collect();
        let (mut nodes, mut outside) = (Vec::new(), Vec::new());
        // The window is the image plane.
        let window = Window { c: [0.0, 1.0], azimuth_rad: [0.0, 1.0] };
        for of_pixel in rows.into_iter().flatten() {
            if of_pixel.is_outside {
                outside.push(of_pixel.pixel);
            }
            nodes.extend(of_pixel.nodes.iter().map(|node| in_window(&window, node)));
        }
        Some((ChartNodes::new(shape, nodes), outside))
    }
}

fn in_window(window: &Window, node: &NaturalNode) -> ChartNode {
    #[expect(clippy::cast_possible_truncation, reason = "a place in single precision")]
    let place = window.unit(node.place).map(|along| along.clamp(0.0, 1.0) as f32);
    ChartNode { pixel: crate::cell::to_u32(node.pixel), place, weight: node.weight }
}

/// The part of a chart that nodes are in, within natural ends of c and a `sector` of azimuth.
fn window(ends: [f64; 2], sector: Option<[f64; 2]>, nodes: &[NaturalNode]) -> Window {
    let c = seen(ends, nodes.iter().map(|node| node.place[0]));
    if let Some(azimuth_rad @ [begin, width]) = sector {
        let sector = Window { c, azimuth_rad };
        let [low, high] = seen([0.0, 1.0], nodes.iter().map(|node| sector.unit(node.place)[1]));
        let [low, high] = [low.max(0.0), high.min(1.0)];
        return Window { c, azimuth_rad: [begin + low * width, (high - low) * width] };
    }
    let mut azimuths: Vec<f64> = nodes.iter().map(|node| node.place[1]).collect();
    azimuths.sort_unstable_by(f64::total_cmp);
    let ends = azimuths.last().map(|last| (*last, azimuths[0] + TAU));
    let gaps = azimuths.windows(2).map(|pair| (pair[0], pair[1])).chain(ends);
    let widest = gaps.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
    let azimuth_rad = match widest {
        Some((before, after)) if after - before >= LEAST_GAP_RAD => {
            let width = (TAU - (after - before)).max(1e-9);
            [(after - MARGIN * width).rem_euclid(TAU), (1.0 + 2.0 * MARGIN) * width]
        }
        _ => [0.0, TAU],
    };
    Window { c, azimuth_rad }
}

/// The part in view of a coordinate with natural ends.
fn seen([first, last]: [f64; 2], along: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let (mut low, mut high) =
        (along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max));
    let width = high - low;
    // Nodes that are added later may be farther out.
    low = if low - first < SNAP * width { first } else { low - MARGIN * width };
    high = if last - high < SNAP * width { last } else { high + MARGIN * width };
    if high <= low {
        // One line of sight: any width will do.
        high = low + 1e-9 * low.abs().max(1e-9);
    }
    [low, high]
}

/// The number of nodes along each axis of a pixel of an image with so many pixels along its longer
/// side.
pub(crate) fn nodes_of_pixel(pixels: usize) -> usize {
    let [fewest, most] = NODES_OF_PIXEL;
    if pixels >= LARGE { 1 } else { NODES_OF_SIDE.div_ceil(pixels).clamp(fewest, most) }
}

/// What is known of a place on the image plane.
#[derive(Clone, Debug, Default)]
struct Corner {
    /// The distances from the centres of limbs, in units of their radii.
    misses: Vec<f64>,
    /// The number of the sectors.
    sectors: u64,
    is_inside: bool,
}

impl Quadrature<'_> {
    /// The nodes of a pixel whose sides are halved `level` times.
    fn nodes_of_pixel(&self, pixel: usize, crossing: Crossing, level: u8) -> PixelNodes {
        let [height, width] = self.tile;
        let (row, column) = (pixel / width, pixel % width);
        let (geometry, row) = (self.geometries[row / height], row % height);
        let at = |[x, y]: [f64; 2]| {
            [(column as f64 + x) / width as f64, (row as f64 + y) / height as f64]
        };
        let is_inside = |xy| !geometry.has_rim() || geometry.solid_angle_density(xy) > 0.0;
        let label = |place: [f64; 2]| {
            let xy = at(place);
            let Some(atlas) = self.atlas else { return is_inside(xy).then_some(0) };
            Some(atlas.zones(&geometry.line(xy).filter(|_| is_inside(xy))?))
        };
        let nodes = self.rules.nodes(crossing, level, &label);
        let density = |place: [f64; 2]| geometry.solid_angle_density(at(place));
        let whole: f64 = nodes.iter().map(|(place, weight)| weight * density(*place)).sum();
        let is_outside = whole.is_nan() || whole <= 0.0;
        let mut found = PixelNodes { pixel, nodes: Vec::new(), most_pieces: 0, is_outside };
        if is_outside {
            return found;
        }
        let mut pieces: Vec<PieceOfLine> = Vec::new();
        for (place, weight) in nodes {
            let xy = at(place);
            // Of the irradiance density on the image plane, of the radiance in a chart.
            let mut weight = weight / whole;
            if let Some((atlas, line)) = self.atlas.zip(geometry.line(xy)) {
                weight *= density(place);
                atlas.pieces(&line, &mut pieces);
            } else {
                pieces.clear();
                pieces.push(PieceOfLine { chart: 0, place: xy });
            }
            found.most_pieces = found.most_pieces.max(pieces.len());
            let natural = |&PieceOfLine { chart, place }: &PieceOfLine| NaturalNode {
                chart,
                pixel,
                place,
                weight,
            };
            found.nodes.extend(pieces.iter().map(natural).filter(|node| node.weight != 0.0));
        }
        found
    }

    /// Whether edges cross the pixels of a row.
    fn crossings_of_row(&self, row: usize) -> Vec<Crossing> {
        let [height, width] = self.tile;
        let (geometry, row) = (self.geometries[row / height], row % height);
        // Places are counted in halves of pixels.
        let corner = |twice_row: usize, twice_column: usize| {
            let xy =
                [twice_column as f64 / (2 * width) as f64, twice_row as f64 / (2 * height) as f64];
            let mut corner = Corner { misses: Vec::new(), sectors: 0, is_inside: true };
            if geometry.has_rim() {
                corner.is_inside = geometry.solid_angle_density(xy) > 0.0;
            }
            if let Some((atlas, line)) = self.atlas.zip(geometry.line(xy)) {
                atlas.misses(&line, &mut corner.misses);
                corner.sectors = atlas.sectors(&line);
            }
            corner
        };
        let border = |row: usize| (0..=width).map(|k| corner(2 * row, 2 * k)).collect::<Vec<_>>();
        let [below, above] = [row, row + 1].map(border);
        // A rim may pass between the corners of a pixel, but not between those of its neighbours.
        let beyond = [row.checked_sub(1), Some(row + 2).filter(|row| *row <= height)];
        let beyond = beyond.map(|row| row.filter(|_| geometry.has_rim()).map(border));
        let is_cut = |column: usize| {
            let rows = [Some(&below), Some(&above), beyond[0].as_ref(), beyond[1].as_ref()];
            let columns = column.saturating_sub(1)..(column + 3).min(width + 1);
            let mut corners = rows.into_iter().flatten().flat_map(|row| &row[columns.clone()]);
            let is_inside = below[column].is_inside;
            geometry.has_rim() && corners.any(|corner| corner.is_inside != is_inside)
        };
        let of_pixel = |column: usize| {
            let middle = corner(2 * row + 1, 2 * column + 1);
            let around =
                [&below[column], &below[column + 1], &above[column], &above[column + 1], &middle];
            let has_sectors = around.iter().any(|corner| corner.sectors != middle.sectors);
            let is_cut = is_cut(column) || has_sectors;
            let mut crossing = if is_cut { Crossing::Crossed(1) } else { Crossing::None };
            if crossing == Crossing::None && !(middle.is_inside && below[column].is_inside) {
                return Crossing::Crossed(1);
            }
            for limb in 0..middle.misses.len() {
                let of_limb = || around.iter().map(|corner| corner.misses[limb]);
                let [low, high] =
                    [of_limb().fold(f64::INFINITY, f64::min), of_limb().fold(0.0, f64::max)];
                let spread = high - low;
                let is_within =
                    |times: f64| low - times * spread < 1.0 && high + times * spread > 1.0;
                if is_within(1.0) {
                    let parts = crate::cell::whole((PARTS * spread).ceil()).clamp(1, MOST_PARTS);
                    let before = if let Crossing::Crossed(before) = crossing { before } else { 1 };
                    crossing = Crossing::Crossed(before.max(parts));
                } else if crossing == Crossing::None && is_within(1.0 + BESIDE) {
                    crossing = Crossing::Beside;
                }
            }
            crossing
        };
        (0..width).map(of_pixel).collect()
    }
}

/// The error of the quadrature of pixels, after nodes have been added where it was large.
pub(crate) struct Settled {
    /// The nodes in each chart.
    pub(crate) nodes: Vec<ChartNodes>,
    /// The error of each pixel.
    pub(crate) error: Image,
}

/// The nodes of one pixel that replace others, and its remaining error.
struct SettledPixel {
    pixel: usize,
    replaced: Option<Vec<NaturalNode>>,
    error: f64,
}

impl Quadrature<'_> {
    /// Compares the quadrature of pixels with that of their quarters, and replaces it where they
    /// differ by more than `allowed`; `charts` have the numbers of charts, their windows and nodes,
    /// and the means of their functions over the rasters of values.
    pub(crate) fn settle(
        &self,
        crossings: &[Crossing],
        charts: &[(usize, Window, &ChartNodes, &[f64])],
        allowed: f64,
    ) -> Settled {
        let shape @ [height, width] = self.shape();
        let varies = |pixel: usize| {
            let mut range = charts.iter().map(|(_, _, nodes, means)| nodes.range(pixel, means));
            range.any(|range| range > VARIATION * allowed)
        };
        let is_checked = |pixel: &usize| {
            self.has_large_pixels() || crossings[*pixel] != Crossing::None || varies(*pixel)
        };
        let value_of = |node: &NaturalNode| {
            let of_chart = charts.iter().find(|(chart, ..)| *chart == node.chart);
            of_chart.map_or(0.0, |(_, window, nodes, means)| {
                let place = in_window(window, node).place.map(f64::from);
                let columns = nodes.values_shape[1];
                node.weight * Place::new(place, nodes.values_shape).value(means, columns)
            })
        };
        let settled = |pixel: usize| {
            let present = charts.iter().map(|(_, _, nodes, means)| nodes.value(pixel, means));
            let mut value: f64 = present.sum();
            let (mut replaced, mut error) = (None, 0.0);
            // Where a structure is thinner than a pixel, two rules may agree by accident.
            let is_thin = charts.iter().any(|(_, _, nodes, _)| nodes.is_thin(pixel));
            let wanted = if is_thin && varies(pixel) { 2 } else { 1 };
            let (mut agreed, mut before) = (0, 0.0);
            for level in 1..=FINEST_LEVEL {
                let finer = self.nodes_of_pixel(pixel, crossings[pixel], level).nodes;
                let of_finer: f64 = finer.iter().map(value_of).sum();
                let change = (of_finer - value).abs();
                error = f64::max(change, before);
                agreed = if change <= allowed { agreed + 1 } else { 0 };
                if agreed == wanted {
                    break;
                }
                before = if wanted > 1 { change } else { 0.0 };
                value = of_finer;
                if agreed == 0 {
                    replaced = Some(finer);
                }
            }
            SettledPixel { pixel, replaced, error }
        };
        let checked: Vec<usize> = (0..height * width).into_par_iter().filter(is_checked).collect();
        let pixels: Vec<SettledPixel> = checked.into_par_iter().map(settled).collect();
        let mut error = Image::zeros(height, width);
        for of_pixel in &pixels {
            error.pixels_mut()[of_pixel.pixel] = of_pixel.error;
        }
        let replaced: Vec<(u32, &Vec<NaturalNode>)> = pixels
            .iter()
            .filter_map(|of| Some((crate::cell::to_u32(of.pixel), of.replaced.as_ref()?)))
            .collect();
        let is_kept =
            |node: &&ChartNode| replaced.binary_search_by_key(&node.pixel, |of| of.0).is_err();
        let nodes = charts.iter().map(|(chart, window, nodes, _)| {
            let kept = nodes.nodes.iter().filter(is_kept).copied();
            let new = replaced.iter().flat_map(|(_, new)| new.iter());
            let new = new.filter(|node| node.chart == *chart).map(|node| in_window(window, node));
            let mut all: Vec<ChartNode> = kept.chain(new).collect();
            all.sort_by_key(|node| node.pixel);
            ChartNodes { rows: rows_of(shape, &all), nodes: all, ..**nodes }
        });
        Settled { nodes: nodes.collect(), error }
    }
}
