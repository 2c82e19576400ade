//! Images larger than the memory: products of a view, from which the rows of an image follow one by one.
//!
//! A low-rank approximation of g is a function of the whole view, and its residuals at scattered points are its
//! error at any place. Neither depends on the number of pixels. The search for it takes an image of few pixels;
//! then the means over pixels of any size, and their errors, follow row by row, without an array of the size of
//! the image. Errors of small pixels may be larger than those of large ones: all rows are compared with the
//! tolerance before any of them is returned.

use crate::emission::Emission;
use crate::error::RenderError;
use crate::image::Image;
use crate::memory::{check_size, largest_that_fits};
use crate::meter::RowsWanted;
use crate::options::{Method, RenderOptions};
use crate::output::ProductRows;
use crate::parallel::prelude::*;
use crate::projection::Projection;
use crate::radiance::{PixelRows, rows_at_once};
use crate::rendering::RenderStats;
use crate::session::{Kept, Session};
use crate::tree::StopReason;
use crate::vol::VolOptions;
use core::ops::Range;
use std::sync::Arc;

/// The most pixels along a side of the image of the search. Its error is interpolated between eight cells along
/// each side, and an image of so many pixels shows it to a percent.
const SEARCH_PIXELS: usize = 512;
/// The tolerance of a second search over that of the first, if small pixels have larger errors.
const SECOND_TOLERANCE: f64 = 0.9;
/// Pixels of a block of rows: 32 MiB.
const BLOCK_PIXELS: usize = 1 << 22;

/// An image whose rows are made when they are asked for.
pub struct LargeImage<'a> {
    rows: PixelRows<'a>,
    products: Box<dyn ProductRows>,
    stats: RenderStats,
    range: [f64; 2],
    largest: f64,
    largest_error: f64,
}

/// The image of an emission from a camera, of `shape` = \[height, width\] pixels, whose rows are made one by one
/// from a low-rank approximation. Memory grows with the height and the width, and not with their product.
///
/// The guarantee is that of [`render`](crate::render()): each |error| is within the tolerance times the largest |pixel|. The
/// values are those of `render`, bit by bit, up to 512 × 512 pixels; beyond, the search for the approximation takes
/// fewer pixels, and may end a step earlier.
///
/// ```
/// use emitree::large::render_large;
/// use emitree::{Canonical, FromFn, RenderOptions, VolOptions};
///
/// let peak = |[x, y, z]: [f64; 3], _| (-30.0 * (x * x + y * y + z * z)).exp();
/// let options = RenderOptions::new(VolOptions::new(1e-3));
/// let image = render_large(&FromFn(peak), &Canonical, [2000, 3000], &options)?;
/// let rows = image.values(0..10);
/// assert_eq!((rows.height(), rows.width()), (10, 3000));
/// assert!(image.estimated_error() < 1e-3);
/// # Ok::<(), emitree::RenderError<std::convert::Infallible>>(())
/// ```
///
/// # Errors
///
/// [`RenderError::NotByRows`] if the view has limbs, faces of bounds or planes that divide it, if g has no
/// low-rank approximation to the tolerance, if the medium absorbs, with another method than
/// [`Method::Vol`], with errors by pixel, weights or sums. Others as [`render`](crate::render()).
pub fn render_large<'a, E: Emission>(
    emission: &E,
    projection: &'a dyn Projection,
    shape: [usize; 2],
    options: &RenderOptions<'_>,
) -> Result<LargeImage<'a>, RenderError<E::Error>> {
    let wanted = RowsWanted { shape, fits: largest_that_fits(shape, options) };
    let [height, width] = shape;
    if height == 0 || width == 0 {
        return Err(RenderError::EmptyImage { height, width });
    }
    if !projection.tiles().is_empty() {
        return Err(wanted.refused("its pixels are those of a sky of several tiles"));
    }
    let vol = check(emission.absorbs(), options, wanted)?;
    let rates = Arc::default();
    let mut tolerance = vol.tolerance;
    loop {
        let method = Method::Vol(VolOptions { tolerance, ..vol.clone() });
        let search = RenderOptions { method, frame: None, mesh_up_to: 0, ..options.clone() };
        let kept = Kept {
            rates: Some(Arc::clone(&rates)),
            images: false,
            repeats: false,
            rows: Some(wanted),
        };
        let of_search = shape.map(|pixels| pixels.min(SEARCH_PIXELS));
        let whole = emission.takes_whole_batches();
        let mut session: Session<'_> =
            Session::start(projection, of_search, None, &search, kept, whole)?;
        while !session.is_done() {
            session.evaluate(emission, options.progress)?;
        }
        let products = session.products();
        let stats = session.into_rendering()?.stats;
        let products = products.ok_or_else(|| wanted.refused("it has no products"))?;
        let mut image = LargeImage {
            rows: PixelRows { projection, shape },
            products: products.of_shape(shape),
            stats,
            range: [f64::INFINITY, f64::NEG_INFINITY],
            largest: 0.0,
            largest_error: 0.0,
        };
        image.measure()?;
        let is_within = image.estimated_error() <= vol.tolerance;
        if is_within || tolerance < vol.tolerance {
            if !is_within && image.stats.ending == StopReason::Complete {
                image.stats.ending = StopReason::Budget;
            }
            return Ok(image);
        }
        tolerance *= SECOND_TOLERANCE;
    }
}

/// Whether [`render`](crate::render()) could make an image of `shape` = \[height, width\] in the memory allowed.
pub fn fits_in_memory(shape: [usize; 2], options: &RenderOptions<'_>) -> bool {
    check_size::<core::convert::Infallible>(shape, None, options).is_ok()
}

/// The error of a view whose image can't be made row by row, for a reason that only the caller knows.
pub fn refused<E>(reason: &str, shape: [usize; 2], options: &RenderOptions<'_>) -> RenderError<E> {
    RowsWanted { shape, fits: largest_that_fits(shape, options) }.refused(reason)
}

/// The options of `vol`, if an image can be made row by row with them.
fn check<'o, E>(
    absorbs: bool,
    options: &'o RenderOptions<'_>,
    wanted: RowsWanted,
) -> Result<&'o VolOptions, RenderError<E>> {
    let vol = match &options.method {
        Method::Vol(vol) => vol,
        other => {
            return Err(wanted.refused(format!("the method `{}` has no products", other.name())));
        }
    };
    let reasons = [
        (absorbs, "its medium absorbs"),
        (!vol.is_uniform(), "the error allowed is not the same in all pixels"),
        (!vol.sums.is_empty(), "sums over regions are asked for"),
        (options.start.is_some(), "it begins with a mesh"),
    ];
    match reasons.into_iter().find(|(is_so, _)| *is_so) {
        Some((_, reason)) => Err(wanted.refused(reason)),
        None => Ok(vol),
    }
}

impl LargeImage<'_> {
    /// Height and width in pixels.
    pub fn shape(&self) -> [usize; 2] {
        self.rows.shape
    }

    /// The cost of the search, and why it ended.
    pub fn stats(&self) -> &RenderStats {
        &self.stats
    }

    /// Whether the tolerance is met in all pixels.
    pub fn converged(&self) -> bool {
        self.stats.ending == StopReason::Complete
    }

    /// The largest estimated |error| of a pixel over the largest |pixel|.
    pub fn estimated_error(&self) -> f64 {
        if self.largest_error > 0.0 { self.largest_error / self.largest } else { 0.0 }
    }

    /// The smallest and the largest pixel.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// The radiances of the pixels of some rows, as [`Rendering::values`](crate::Rendering::values) has them.
    ///
    /// # Panics
    ///
    /// If a row is not one of the image.
    pub fn values(&self, rows: Range<usize>) -> Image {
        self.block(rows, |row, values| self.products.means(row, values))
    }

    /// Their estimated |errors|.
    ///
    /// # Panics
    ///
    /// If a row is not one of the image.
    pub fn errors(&self, rows: Range<usize>) -> Image {
        self.block(rows, |row, values| self.products.errors(row, values))
    }

    /// The solid angles of the pixels of some rows \[sr\].
    pub fn solid_angles(&self, rows: Range<usize>) -> Image {
        self.filled(rows, |row, angles| self.rows.solid_angles(row, angles))
    }

    /// The rows of the image in blocks that take some ten MiB each, in their order.
    pub fn blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let [height, width] = self.rows.shape;
        let rows = (BLOCK_PIXELS / width).clamp(1, height);
        (0..height).step_by(rows).map(move |first| first..(first + rows).min(height))
    }

    /// Rows of means over pixels as radiances; NaN where the projection has no image.
    fn block(&self, rows: Range<usize>, fill: impl Fn(usize, &mut [f64]) + Sync) -> Image {
        let width = self.rows.shape[1];
        self.filled(rows, |row, values| {
            let mut scale = vec![0.0; width];
            self.rows.radiances_per_density(row, &mut scale);
            fill(row, values);
            for (value, scale) in values.iter_mut().zip(scale) {
                *value = if scale == 0.0 { f64::NAN } else { *value * scale };
            }
        })
    }

    fn filled(&self, rows: Range<usize>, fill: impl Fn(usize, &mut [f64]) + Sync) -> Image {
        let [height, width] = self.rows.shape;
        assert!(rows.end <= height, "rows {rows:?} of an image of {height}");
        let mut block = Image::zeros(rows.len(), width);
        let of_rows = block.pixels_mut().par_chunks_mut(width).enumerate();
        let of_rows = of_rows.with_min_len(rows_at_once(width));
        of_rows.for_each(|(number, values)| fill(rows.start + number, values));
        block
    }

    /// Finds the largest pixel and the largest error.
    fn measure<E>(&mut self) -> Result<(), RenderError<E>> {
        for rows in self.blocks() {
            let values = self.values(rows.clone());
            for (number, &value) in values.pixels().iter().enumerate() {
                if value.is_infinite() {
                    let width = self.rows.shape[1];
                    let (row, column) = (rows.start + number / width, number % width);
                    return Err(RenderError::ImageNotFinite { row, column, value });
                }
                self.largest = self.largest.max(value.abs());
                self.range = [self.range[0].min(value), self.range[1].max(value)];
            }
            let errors = self.errors(rows);
            let of_block = errors.pixels().iter().copied().fold(0.0, f64::max);
            self.largest_error = self.largest_error.max(of_block);
        }
        Ok(())
    }
}

impl core::fmt::Debug for LargeImage<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("LargeImage")
            .field("shape", &self.rows.shape)
            .field("stats", &self.stats)
            .field("estimated_error", &self.estimated_error())
            .finish_non_exhaustive()
    }
}
