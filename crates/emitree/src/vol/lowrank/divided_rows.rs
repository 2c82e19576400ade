//! The image of interpolants on the charts of a view, row by row, for one that is larger than the memory.
//!
//! The charts and the functions on them are those of an image of few pixels. The quadrature of pixels is made for some
//! rows at a time, as a view of their own, and compared with a finer one like that of any other image.

use crate::image::Image;
use crate::output::{Bands, Products};
use crate::projection::ViewGeometry;
use crate::projection::charts::Atlas;
use crate::projection::charts::chart::Window;
use crate::projection::rows::RowsOfView;
use crate::radiance::PixelRows;
use crate::tile::Tile;
use crate::vol::lowrank::interpolant::Interpolant;
use crate::vol::view::division::Division;
use crate::vol::view::quadrature::Quadrature;
use crate::vol::view::raster::Raster;
use crate::vol::view::settle::{NodesInView, Settled};
use core::ops::Range;
use rustc_hash::FxHashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// The pixels whose quadrature is made at once: its nodes take some 100 bytes for each.
const PIXELS_AT_ONCE: usize = 1 << 18;

/// The products of the charts of a view.
#[derive(Debug)]
pub(super) struct DividedProducts {
    pub(super) division: Division,
    /// Height and width of the image for which the view was divided.
    pub(super) shape: [usize; 2],
    pub(super) charts: Arc<Vec<ProductsOfChart>>,
    /// The error of the quadrature that a pixel may have.
    pub(super) allowed: f64,
    /// A bound on the largest radiance.
    pub(super) largest: f64,
}

/// The products of a chart: its number in the atlas, and what is in view of it.
#[derive(Debug)]
pub(super) struct ProductsOfChart {
    pub(super) chart: usize,
    pub(super) window: Window,
    pub(super) interpolant: Arc<Interpolant>,
    /// The errors on a raster.
    pub(super) errors: Image,
}

/// The number of a function, and the rows and columns of a raster.
type RasterOf = (usize, [usize; 2]);

/// The image of the charts.
struct DividedImage<'a> {
    pixels: PixelRows<'a>,
    geometry: &'a dyn ViewGeometry,
    atlas: Atlas<'a>,
    charts: Arc<Vec<ProductsOfChart>>,
    allowed: f64,
    largest: f64,
    /// The means of the functions over rasters that were needed before.
    means: Mutex<FxHashMap<RasterOf, Arc<[f64]>>>,
}

impl Products for DividedProducts {
    fn bands<'a>(&self, pixels: PixelRows<'a>) -> Option<Box<dyn Bands + 'a>> {
        let tile = Tile { projection: pixels.projection, shape: self.shape, place: (0, 1) };
        let (geometry, atlas) = (pixels.projection.view_geometry()?, self.division.atlas(&[tile])?);
        let (charts, means) = (Arc::clone(&self.charts), Mutex::default());
        let Self { allowed, largest, .. } = *self;
        Some(Box::new(DividedImage { pixels, geometry, atlas, charts, allowed, largest, means }))
    }
}

impl DividedImage<'_> {
    /// The means of a function over a raster.
    fn means(&self, number: usize, shape: [usize; 2]) -> Vec<f64> {
        let known = || self.means.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(means) = known().get(&(number, shape)) {
            return means.to_vec();
        }
        // Without the lock, since it is computed in parallel.
        let means = self.charts[number].interpolant.means(shape);
        known().insert((number, shape), Arc::from(&means[..]));
        means
    }

    /// Values and errors of so many rows that their quadrature fits in the memory.
    fn maps_of_some(&self, rows: Range<usize>) -> [Image; 2] {
        let [height, width] = self.pixels.shape;
        let shape = [rows.len(), width];
        let y = [rows.start, rows.end].map(|row| row as f64 / height as f64);
        let view = RowsOfView::new(self.geometry, y);
        let tiles = [Tile { projection: &view, shape, place: (0, 1) }];
        let quadrature = Quadrature::new(Some(&self.atlas), &tiles);
        let windows: Vec<_> = self.charts.iter().map(|of| (of.chart, of.window)).collect();
        let (seen, elsewhere) = quadrature.charts_in_windows(&self.atlas, &windows);
        let charts = seen.charts.iter();
        let charts: Vec<NodesInView<'_>> = charts
            .map(|of| NodesInView { chart: of.chart, window: of.window, nodes: &of.nodes })
            .collect();
        let means = |number: usize, shape| self.means(number, shape);
        let Settled { nodes, error: mut errors } =
            quadrature.settle(&seen.crossings, &charts, &means, self.allowed, None);
        let mut values = Image::zeros(rows.len(), width);
        for (number, (mut nodes, of)) in nodes.into_iter().zip(&*self.charts).enumerate() {
            let raster = Raster::new(nodes.values_shape, self.means(number, nodes.values_shape));
            nodes.add_image(&raster, &mut values);
            nodes.errors_shape = [of.errors.height(), of.errors.width()];
            nodes.add_errors(&of.errors, &mut errors);
        }
        // What no pixel of the search sees is not known.
        for pixel in elsewhere {
            errors.pixels_mut()[pixel] += self.largest;
        }
        let mut maps = [values, errors];
        for map in &mut maps {
            seen.outside.iter().for_each(|&pixel| map.pixels_mut()[pixel] = f64::NAN);
        }
        let solid_angles = self.pixels.block(rows, |row, of| self.pixels.solid_angles(row, of));
        for (pixel, solid_angle) in solid_angles.pixels().iter().enumerate() {
            if *solid_angle <= 0.0 {
                maps.iter_mut().for_each(|map| map.pixels_mut()[pixel] = f64::NAN);
            }
        }
        maps
    }
}

impl Bands for DividedImage<'_> {
    fn number(&self) -> usize {
        1
    }

    fn values(&self, band: usize, rows: Range<usize>) -> Image {
        let [values, _] = self.maps(band, rows);
        values
    }

    fn errors(&self, band: usize, rows: Range<usize>) -> Image {
        let [_, errors] = self.maps(band, rows);
        errors
    }

    fn maps(&self, _: usize, rows: Range<usize>) -> [Image; 2] {
        let [height, width] = self.pixels.shape;
        assert!(rows.end <= height, "rows {rows:?} of an image of {height}");
        let at_once = (PIXELS_AT_ONCE / width).max(1);
        let mut maps = [(); 2].map(|()| Image::zeros(rows.len(), width));
        // The same blocks for any rows, so that their pixels have the same bits.
        for first in (rows.start / at_once * at_once..rows.end).step_by(at_once) {
            let last = (first + at_once).min(height);
            let some = self.maps_of_some(first..last);
            for row in first.max(rows.start)..last.min(rows.end) {
                for (map, some) in maps.iter_mut().zip(&some) {
                    map.row_mut(row - rows.start).copy_from_slice(some.row(row - first));
                }
            }
        }
        maps
    }
}
