//! The nodes of the quadrature of all pixels in one chart, and the sums over them.

use crate::image::Image;
use crate::parallel::prelude::*;
use crate::vol::view::raster::{Raster, cell_at};
use multiversion::multiversion;

/// The fewest and the most cells along each side of a raster of errors; and for values, how many
/// times as many, and the fewest.
const FEWEST_CELLS: usize = 16;
const MOST_CELLS: usize = 1024;
const FINER_VALUES: usize = 4;
const FEWEST_VALUES: usize = 256;
/// The share of a window that the nodes of a pixel extend over if there may be structure thinner than
/// the pixel: its quadrature has to agree with a finer one twice.
const THIN: f64 = 0.25;

/// A node of the quadrature of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChartNode {
    pub(crate) pixel: u32,
    /// The place in the window of the chart, from 0 to 1.
    pub(crate) place: [f32; 2],
    pub(crate) weight: f64,
}

/// The nodes of all pixels in one chart, in the order of the pixels.
#[derive(Debug)]
pub(crate) struct ChartNodes {
    /// Height and width of the image.
    shape: [usize; 2],
    pub(crate) nodes: Vec<ChartNode>,
    /// The first node of each row of pixels, and the end.
    rows: Vec<usize>,
    /// The number of pixels with a node.
    pub(crate) pixels_in_view: usize,
    /// The raster from which values are computed.
    pub(crate) values_shape: [usize; 2],
    /// The raster of errors, with cells of about the size of a pixel.
    pub(crate) errors_shape: [usize; 2],
}

/// Adds the weighted sums of `value` at nodes to their pixels, which are numbered from `first` on.
#[inline(always)]
fn add_row(
    nodes: &[ChartNode],
    first: usize,
    pixels: &mut [f64],
    value: impl Fn(&ChartNode) -> f64,
) {
    for node in nodes {
        pixels[node.pixel as usize - first] += node.weight * value(node);
    }
}

/// The same for the function of a raster, in the widest lanes of the processor: the same bits.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn add_row_of(raster: &Raster, nodes: &[ChartNode], first: usize, pixels: &mut [f64]) {
    add_row(nodes, first, pixels, |node| raster.value(node.place.map(f64::from)));
}

impl ChartNodes {
    pub(crate) fn new(shape: [usize; 2], nodes: Vec<ChartNode>) -> Self {
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

    /// The same with other nodes, in the order of the pixels, and another raster of values.
    pub(crate) fn with_nodes(&self, nodes: Vec<ChartNode>, values_shape: [usize; 2]) -> Self {
        Self { rows: rows_of(self.shape, &nodes), nodes, values_shape, ..*self }
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
    pub(crate) fn is_thin(&self, pixel: usize) -> bool {
        let along = self.of_pixel(pixel).map(|node| f64::from(node.place[0]));
        extent(along) > THIN
    }

    /// The value of a function at the node of a pixel with the largest weight, times the weights of all its nodes.
    pub(crate) fn by_heaviest(&self, pixel: usize, raster: &Raster) -> f64 {
        let heaviest = self.of_pixel(pixel).max_by(|a, b| a.weight.total_cmp(&b.weight));
        let weight: f64 = self.of_pixel(pixel).map(|node| node.weight).sum();
        heaviest.map_or(0.0, |node| weight * raster.value(node.place.map(f64::from)))
    }

    /// The image of a function.
    pub(crate) fn image(&self, raster: &Raster) -> Image {
        let [height, width] = self.shape;
        let mut image = Image::zeros(height, width);
        self.add_image(raster, &mut image);
        image
    }

    /// Calls a function with the nodes of each row, the number of its first pixel, and its pixels.
    fn for_rows(&self, image: &mut Image, of_row: impl Fn(&[ChartNode], usize, &mut [f64]) + Sync) {
        let width = self.shape[1];
        let rows = image.pixels_mut().par_chunks_mut(width.max(1)).enumerate();
        rows.for_each(|(row, pixels)| of_row(self.of_row(row), row * width, pixels));
    }

    /// Adds to each pixel the weighted sum of `value` at its nodes.
    fn add(&self, image: &mut Image, value: impl Fn(&ChartNode) -> f64 + Sync) {
        self.for_rows(image, |nodes, first, pixels| add_row(nodes, first, pixels, &value));
    }

    /// Adds the image of a function to `image`.
    pub(crate) fn add_image(&self, raster: &Raster, image: &mut Image) {
        self.for_rows(image, |nodes, first, pixels| add_row_of(raster, nodes, first, pixels));
    }

    /// The image of a function that has one value everywhere.
    pub(crate) fn image_of_constant(&self, value: f64) -> Image {
        let [height, width] = self.shape;
        let mut image = Image::zeros(height, width);
        self.add(&mut image, |_| value);
        image
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

    /// For each cell of the raster of errors the largest value of a pixel with a node in it, times the `factor` for
    /// the number of the pixel and its share that is in the chart.
    pub(crate) fn largest_of_pixels(
        &self,
        image: &Image,
        factor: impl Fn(usize, f64) -> f64,
    ) -> Image {
        let [rows, columns] = self.errors_shape;
        let mut largest = Image::zeros(rows, columns);
        let cells = largest.pixels_mut();
        for of_pixel in self.nodes.chunk_by(|a, b| a.pixel == b.pixel) {
            let share: f64 = of_pixel.iter().map(|node| node.weight).sum();
            let pixel = of_pixel[0].pixel as usize;
            let value = factor(pixel, share) * image.pixels()[pixel];
            for node in of_pixel {
                let cell = &mut cells[cell_at(node.place.map(f64::from), self.errors_shape)];
                *cell = cell.max(value);
            }
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
