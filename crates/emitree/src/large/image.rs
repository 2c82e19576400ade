//! A band whose rows are made when they are asked for.

use crate::error::RenderError;
use crate::image::Image;
use crate::output::Bands;
use crate::progress::Progress;
use crate::radiance::PixelRows;
use crate::rendering::RenderStats;
use crate::tree::StopReason;
use core::ops::Range;
use std::sync::Arc;

/// Pixels of a block of rows: 32 MiB.
const BLOCK_PIXELS: usize = 1 << 22;

/// An image, or a band of a cube, whose rows are made when they are asked for.
pub struct LargeImage<'a> {
    pub(super) rows: PixelRows<'a>,
    pub(super) bands: Arc<dyn Bands + 'a>,
    /// The number of the band.
    pub(super) band: usize,
    pub(super) stats: RenderStats,
    /// The smallest and the largest pixel, once all have been computed.
    pub(super) range: [f64; 2],
    pub(super) largest: f64,
    pub(super) largest_error: f64,
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

    /// Whether the tolerance is met in all pixels, of all bands.
    pub fn converged(&self) -> bool {
        self.stats.ending == StopReason::Complete
    }

    /// The largest estimated |error| of a pixel over the largest |pixel|; of a band, over its own.
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
        self.bands.values(self.band, rows)
    }

    /// Their estimated |errors|.
    ///
    /// # Panics
    ///
    /// If a row is not one of the image.
    pub fn errors(&self, rows: Range<usize>) -> Image {
        self.bands.errors(self.band, rows)
    }

    /// The solid angles of the pixels of some rows \[sr\].
    pub fn solid_angles(&self, rows: Range<usize>) -> Image {
        self.rows.block(rows, |row, angles| self.rows.solid_angles(row, angles))
    }

    /// The rows of the image in blocks that take some ten MiB each, in their order.
    pub fn blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let [height, width] = self.rows.shape;
        let rows = (BLOCK_PIXELS / width).clamp(1, height);
        (0..height).step_by(rows).map(move |first| first..(first + rows).min(height))
    }

    /// Finds the largest pixel and the largest error, unless `progress` ends it.
    pub(super) fn measure<E>(
        &mut self,
        progress: Option<&Progress<'_>>,
    ) -> Result<(), RenderError<E>> {
        for rows in self.blocks() {
            if progress.is_some_and(|progress| progress(self.stats.evaluations).is_break()) {
                return Err(RenderError::Interrupted);
            }
            let [values, errors] = self.bands.maps(self.band, rows.clone());
            for (number, &value) in values.pixels().iter().enumerate() {
                if value.is_infinite() {
                    let width = self.rows.shape[1];
                    let (row, column) = (rows.start + number / width, number % width);
                    return Err(RenderError::ImageNotFinite { row, column, value });
                }
                self.largest = self.largest.max(value.abs());
                self.range = [self.range[0].min(value), self.range[1].max(value)];
            }
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
            .field("band", &self.band)
            .field("stats", &self.stats)
            .field("estimated_error", &self.estimated_error())
            .finish_non_exhaustive()
    }
}
