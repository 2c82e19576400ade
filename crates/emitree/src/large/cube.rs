//! A cube whose bands are made row by row.

use crate::error::RenderError;
use crate::large::image::LargeImage;
use crate::output::Bands;
use crate::progress::Progress;
use crate::radiance::PixelRows;
use crate::rendering::RenderStats;
use crate::tree::StopReason;
use std::sync::Arc;

/// A spectral cube whose rows are made when they are asked for.
#[derive(Debug)]
pub struct LargeCube<'a> {
    /// At least one.
    bands: Vec<LargeImage<'a>>,
}

impl<'a> LargeCube<'a> {
    /// The cube of these rows, with the largest value and the largest error of each band. `progress` may end it.
    pub(super) fn measured<E>(
        rows: PixelRows<'a>,
        bands: Box<dyn Bands + 'a>,
        stats: RenderStats,
        progress: Option<&Progress<'_>>,
    ) -> Result<Self, RenderError<E>> {
        let bands: Arc<dyn Bands + 'a> = bands.into();
        let measured = |band: usize| {
            let mut image = LargeImage {
                rows,
                bands: Arc::clone(&bands),
                band,
                stats: stats.clone(),
                range: [f64::INFINITY, f64::NEG_INFINITY],
                largest: 0.0,
                largest_error: 0.0,
            };
            image.measure(progress).map(|()| image)
        };
        Ok(Self { bands: (0..bands.number()).map(measured).collect::<Result<_, _>>()? })
    }

    /// The search was complete, and some small pixels have larger errors.
    pub(super) fn set_not_converged(&mut self) {
        for band in &mut self.bands {
            if band.stats.ending == StopReason::Complete {
                band.stats.ending = StopReason::Budget;
            }
        }
    }

    pub(super) fn into_first_band(mut self) -> LargeImage<'a> {
        self.bands.swap_remove(0)
    }

    /// The bands, the lowest energy first.
    pub fn bands(&self) -> &[LargeImage<'a>] {
        &self.bands
    }

    /// Bins, height and width.
    pub fn shape(&self) -> [usize; 3] {
        let [height, width] = self.bands[0].shape();
        [self.bands.len(), height, width]
    }

    /// The cost of the search, and why it ended.
    pub fn stats(&self) -> &RenderStats {
        self.bands[0].stats()
    }

    /// Whether the tolerance is met in all voxels.
    pub fn converged(&self) -> bool {
        self.bands[0].converged()
    }

    /// The largest estimated |error| of a voxel over the largest |voxel|.
    pub fn estimated_error(&self) -> f64 {
        let largest =
            |of: fn(&LargeImage<'a>) -> f64| self.bands.iter().map(of).fold(0.0, f64::max);
        match largest(|band| band.largest_error) {
            0.0 => 0.0,
            error => error / largest(|band| band.largest),
        }
    }

    /// The smallest and the largest voxel.
    pub fn range(&self) -> [f64; 2] {
        let wider = |[low, high]: [f64; 2], band: &LargeImage<'_>| {
            let [least, most] = band.range();
            [low.min(least), high.max(most)]
        };
        self.bands.iter().fold([f64::INFINITY, f64::NEG_INFINITY], wider)
    }
}
