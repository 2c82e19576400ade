//! The quadrature of pixels in the charts of a view.
//!
//! A pixel is the mean over its lines of sight, weighted with the density of solid angle, and the
//! radiance of a line is the sum over its pieces, each at its place in a chart. So a pixel is a
//! weighted sum of values of the charts' functions at the nodes of its quadrature. Nothing of this
//! depends on g.

use crate::parallel::prelude::*;
use crate::projection::ViewGeometry;
use crate::projection::charts::chart::Window;
use crate::projection::charts::{Atlas, PieceOfLine};
use crate::tile::Tile;
use crate::vol::view::chart_nodes::ChartNodes;
use crate::vol::view::corner_rule::{LineAtCorner, nodes_of_corners};
use crate::vol::view::crossings::{Corner, CornersOfRows, Plane};
use crate::vol::view::line_scan::Places;
use crate::vol::view::pixel_rule::{Crossing, PixelRules, RuleNode};
use crate::vol::view::squares::{Square, squares_about_singularities};
use crate::vol::view::windows::{NaturalNode, PixelNodes, in_window, is_in, window};
use std::collections::BTreeSet;

/// The number of nodes along each side of an image with few pixels: those of a pixel follow from it, with a limit. A
/// pixel of a small image is a large part of the view, so that the quadrature of all pixels is compared with a finer
/// one.
const NODES_OF_SIDE: usize = 400;
const NODES_OF_PIXEL: usize = 16;
/// The pixels along the longer side of an image from which the nodes of a pixel are its corners, which four pixels
/// share, and its middle, and from which the middle alone suffices.
const SMALL: usize = 100;
const LARGE: usize = 1500;
/// The rows of pixels whose corners are shared.
const ROWS: usize = 16;

/// One chart in view: its number in the atlas, what is in view, and the nodes of pixels in it.
#[derive(Debug)]
pub(crate) struct ChartInView {
    pub(crate) chart: usize,
    pub(crate) window: Window,
    pub(crate) nodes: ChartNodes,
}

/// The nodes of a row of pixels.
struct Row {
    crossings: Vec<Crossing>,
    /// By chart.
    of_charts: Vec<Vec<NaturalNode>>,
    outside: Vec<usize>,
    most_pieces: usize,
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

    /// Height and width of the image: the tiles are above each other.
    pub(crate) fn shape(&self) -> [usize; 2] {
        [self.tile[0] * self.geometries.len(), self.tile[1]]
    }

    /// Successive rows of each tile in turn: those of the image, and their corners.
    fn corners_of(&self, block: usize) -> (usize, CornersOfRows) {
        let height = self.tile[0];
        let blocks = height.div_ceil(ROWS);
        let (tile, first) = (block / blocks, block % blocks * ROWS);
        let plane = Plane { atlas: self.atlas, geometry: self.geometries[tile], shape: self.tile };
        let rows = first..(first + ROWS).min(height);
        (tile * height, CornersOfRows::new(plane, rows))
    }

    /// The number of blocks of rows with corners of their own.
    fn blocks(&self) -> usize {
        self.tile[0].div_ceil(ROWS) * self.geometries.len()
    }

    /// Whether all pixels are so large that the variation of the radiance within each matters.
    pub(crate) fn has_large_pixels(&self) -> bool {
        self.tile[0].max(self.tile[1]) < SMALL
    }

    /// The nodes of all pixels in the charts of the atlas, in windows that contain them.
    pub(crate) fn charts_in_view(&self, atlas: &Atlas<'_>) -> ChartsInView {
        let rows = self.rows(atlas);
        let is_in_view = |chart: &usize| rows.iter().any(|row| !row.of_charts[*chart].is_empty());
        let of_chart = |chart: usize| {
            let nodes = rows.iter().flat_map(|row| &row.of_charts[chart]);
            let places = nodes.map(|node| node.place);
            (chart, window(atlas.natural_ends(chart), atlas.sector_rad(chart), places))
        };
        let windows: Vec<(usize, Window)> =
            (0..atlas.len()).filter(is_in_view).map(of_chart).collect();
        self.in_windows(rows, &windows)
    }

    /// The nodes of all pixels in these windows of charts of the atlas, and the numbers of the pixels with nodes in
    /// other charts, or outside the windows.
    pub(crate) fn charts_in_windows(
        &self,
        atlas: &Atlas<'_>,
        windows: &[(usize, Window)],
    ) -> (ChartsInView, BTreeSet<usize>) {
        let rows = self.rows(atlas);
        let is_elsewhere = |node: &&NaturalNode| {
            let window = windows.iter().find(|(chart, _)| *chart == node.chart);
            window.is_none_or(|(_, window)| !is_in(window, node))
        };
        let nodes = rows.par_iter().flat_map_iter(|row| row.of_charts.iter().flatten());
        let elsewhere = nodes.filter(is_elsewhere).map(|node| node.pixel).collect();
        (self.in_windows(rows, windows), elsewhere)
    }

    /// The nodes of all rows of pixels.
    fn rows(&self, atlas: &Atlas<'_>) -> Vec<Row> {
        let of_block = |block| self.nodes_of_rows(block, atlas);
        let blocks: Vec<Vec<Row>> = (0..self.blocks()).into_par_iter().map(of_block).collect();
        blocks.into_iter().flatten().collect()
    }

    fn in_windows(&self, rows: Vec<Row>, windows: &[(usize, Window)]) -> ChartsInView {
        let shape = self.shape();
        let charts = windows.iter().map(|&(chart, window)| {
            let nodes = rows.par_iter().flat_map_iter(|row| &row.of_charts[chart]);
            let nodes = nodes.map(|node| in_window(&window, node)).collect();
            ChartInView { chart, window, nodes: ChartNodes::new(shape, nodes) }
        });
        let charts = charts.collect();
        let most_pieces = rows.iter().map(|row| row.most_pieces).max().unwrap_or(1);
        let outside = rows.iter().flat_map(|row| row.outside.iter().copied()).collect();
        let crossings = rows.into_iter().flat_map(|row| row.crossings).collect();
        ChartsInView { charts, most_pieces, outside, crossings }
    }

    /// The nodes of the rows of pixels of a block.
    fn nodes_of_rows(&self, block: usize, atlas: &Atlas<'_>) -> Vec<Row> {
        let (before, corners) = self.corners_of(block);
        let shares_corners = self.shares_corners() && !atlas.has_singularities();
        let lines = |corners: &Vec<Corner>| -> Vec<LineAtCorner> {
            let line = |corner: &Corner| LineAtCorner::new(corner, atlas);
            if shares_corners { corners.iter().map(line).collect() } else { Vec::new() }
        };
        let borders: Vec<Vec<LineAtCorner>> = corners.borders.iter().map(lines).collect();
        let of_row = |(k, row): (usize, usize)| {
            let crossings = corners.crossings(row);
            let middles = lines(&corners.middles[k]);
            let mut of_charts = vec![Vec::new(); atlas.len()];
            let (mut outside, mut most_pieces) = (Vec::new(), 1);
            for (column, crossing) in crossings.iter().enumerate() {
                let pixel = (before + row) * self.tile[1] + column;
                let of_pixel = match crossing {
                    Crossing::None if shares_corners => {
                        let [below, above] = [k, k + 1].map(|k| &borders[k][column..column + 2]);
                        nodes_of_corners(pixel, [below, above], &middles[column])
                    }
                    _ => self.nodes_of_pixel(pixel, *crossing, 0),
                };
                most_pieces = most_pieces.max(of_pixel.most_pieces);
                if of_pixel.is_outside {
                    outside.push(pixel);
                }
                for node in of_pixel.nodes {
                    of_charts[node.chart].push(node);
                }
            }
            Row { crossings, of_charts, outside, most_pieces }
        };
        corners.rows.clone().enumerate().map(of_row).collect()
    }

    /// Whether the nodes of a pixel without edges are its corners and its middle.
    fn shares_corners(&self) -> bool {
        (SMALL..LARGE).contains(&self.tile[0].max(self.tile[1]))
    }

    /// Whether the rim of a disc crosses the pixels; nothing without a rim.
    pub(crate) fn crossings_of_rim(&self) -> Vec<Crossing> {
        let has_rim = self.geometries.iter().any(|geometry| geometry.has_rim());
        if has_rim { self.crossings() } else { Vec::new() }
    }

    /// Whether edges cross the pixels.
    pub(crate) fn crossings(&self) -> Vec<Crossing> {
        let of_block = |block| {
            let (_, corners) = self.corners_of(block);
            corners.rows.clone().flat_map(|row| corners.crossings(row)).collect()
        };
        let blocks: Vec<Vec<Crossing>> = (0..self.blocks()).into_par_iter().map(of_block).collect();
        blocks.into_iter().flatten().collect()
    }

    /// The nodes, on the image plane itself, of the pixels that the rim of a disc crosses, and the
    /// numbers of the pixels outside; `None` without a rim.
    pub(crate) fn rim_nodes(&self) -> Option<(ChartNodes, Vec<usize>)> {
        self.geometries.first().filter(|geometry| geometry.has_rim())?;
        let crossed = self.crossings_of_rim().into_iter().enumerate();
        let crossed: Vec<(usize, Crossing)> =
            crossed.filter(|(_, crossing)| *crossing != Crossing::None).collect();
        let nodes = |(pixel, crossing)| self.nodes_of_pixel(pixel, crossing, 0);
        let pixels: Vec<PixelNodes> = crossed.into_par_iter().map(nodes).collect();
        let (mut nodes, mut outside) = (Vec::new(), Vec::new());
        // The window is the image plane.
        let window = Window { c: [0.0, 1.0], azimuth_rad: [0.0, 1.0] };
        for of_pixel in pixels {
            if of_pixel.is_outside {
                outside.push(of_pixel.pixel);
            }
            nodes.extend(of_pixel.nodes.iter().map(|node| in_window(&window, node)));
        }
        Some((ChartNodes::new(self.shape(), nodes), outside))
    }

    /// The image plane of a pixel, and the canonical (x, y) of places in it, from 0 to 1.
    fn place_of_pixel(
        &self,
        pixel: usize,
    ) -> (&'a dyn ViewGeometry, impl Fn([f64; 2]) -> [f64; 2] + use<'a>) {
        let [height, width] = self.tile;
        let (row, column) = (pixel / width, pixel % width);
        let (geometry, row) = (self.geometries[row / height], row % height);
        let at = move |[x, y]: [f64; 2]| {
            [(column as f64 + x) / width as f64, (row as f64 + y) / height as f64]
        };
        (geometry, at)
    }

    /// The places in a pixel, from 0 to 1, at which lines of sight are taken, with their weights.
    pub(crate) fn places_in_pixel(
        &self,
        pixel: usize,
        crossing: Crossing,
        level: u8,
    ) -> Vec<RuleNode> {
        let (geometry, at) = self.place_of_pixel(pixel);
        let is_inside = |xy| !geometry.has_rim() || geometry.solid_angle_density(xy) > 0.0;
        let label = |place: [f64; 2]| {
            let xy = at(place);
            let Some(atlas) = self.atlas else { return is_inside(xy).then_some(0) };
            Some(atlas.zones(&geometry.line(xy).filter(|_| is_inside(xy))?))
        };
        let misses = |place: [f64; 2], misses: &mut Vec<f64>| {
            misses.clear();
            if let Some((atlas, line)) = self.atlas.zip(geometry.line(at(place))) {
                atlas.misses(&line, misses);
            }
        };
        let places = Places { label: &label, misses: &misses };
        if !self.atlas.is_some_and(Atlas::has_singularities) {
            return self.rules.nodes(crossing, level, places);
        }
        // Squares smaller than their distance from a singularity.
        let nearness = |place: [f64; 2]| self.atlas?.near_singularity(&geometry.line(at(place))?);
        let squares = squares_about_singularities(level, &nearness);
        if squares.iter().all(Square::is_whole_pixel) {
            return self.rules.nodes(crossing, level, places);
        }
        let nodes = |square| self.rules.nodes_of_square(square, crossing, places);
        squares.iter().flat_map(nodes).collect()
    }

    /// The nodes of a pixel whose sides are halved `level` times.
    pub(crate) fn nodes_of_pixel(&self, pixel: usize, crossing: Crossing, level: u8) -> PixelNodes {
        let (geometry, at) = self.place_of_pixel(pixel);
        let nodes = self.places_in_pixel(pixel, crossing, level);
        let density = |(place, _): &RuleNode| geometry.solid_angle_density(at(*place));
        let densities: Vec<f64> = nodes.iter().map(density).collect();
        let whole: f64 = nodes.iter().zip(&densities).map(|((_, weight), of)| weight * of).sum();
        let is_outside = whole.is_nan() || whole <= 0.0;
        let mut found = PixelNodes { pixel, nodes: Vec::new(), most_pieces: 0, is_outside };
        if is_outside {
            return found;
        }
        let mut pieces: Vec<PieceOfLine> = Vec::new();
        for ((place, weight), density) in nodes.into_iter().zip(densities) {
            let weights = [weight / whole, density];
            let nodes = self.nodes_on_line(geometry, at(place), pixel, weights, &mut pieces);
            found.nodes.extend(nodes);
            found.most_pieces = found.most_pieces.max(pieces.len());
        }
        found
    }

    /// The nodes of the pieces of a line at (x, y) of an image plane, given its weight in a pixel and its density of
    /// solid angle. `pieces` are those of the line then.
    fn nodes_on_line<'p>(
        &self,
        geometry: &dyn ViewGeometry,
        xy: [f64; 2],
        pixel: usize,
        [mut weight, density]: [f64; 2],
        pieces: &'p mut Vec<PieceOfLine>,
    ) -> impl Iterator<Item = NaturalNode> + use<'p> {
        // Of the irradiance density on the image plane, of the radiance in a chart.
        if let Some((atlas, line)) = self.atlas.zip(geometry.line(xy)) {
            weight *= density;
            atlas.pieces(&line, pieces);
        } else {
            pieces.clear();
            pieces.push(PieceOfLine { chart: 0, place: xy, density: 1.0 });
        }
        let of_piece = move |piece: &PieceOfLine| NaturalNode::of_piece(piece, pixel, weight);
        pieces.iter().map(of_piece).filter(|node| node.weight != 0.0)
    }

    /// The nodes of a line of sight alone, at (x, y) of the first image plane, as those of a pixel with this number;
    /// none where there is no image. `None` of a projection without lines of sight.
    pub(crate) fn nodes_of_line(&self, xy: [f64; 2], number: usize) -> Option<Vec<NaturalNode>> {
        let geometry = self.geometries.first()?;
        let density = geometry.solid_angle_density(xy);
        if density.is_nan() || density <= 0.0 {
            return Some(Vec::new());
        }
        let weights = [1.0 / density, density];
        Some(self.nodes_on_line(*geometry, xy, number, weights, &mut Vec::new()).collect())
    }
}

/// The number of nodes along each axis of a pixel of an image with so many pixels along its longer
/// side, where corners are not shared.
fn nodes_of_pixel(pixels: usize) -> usize {
    match pixels {
        LARGE.. => 1,
        SMALL.. => 2,
        _ => NODES_OF_SIDE.div_ceil(pixels.max(1)).min(NODES_OF_PIXEL),
    }
}
