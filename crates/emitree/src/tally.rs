//! The tally: how often g was evaluated on the lines of sight of each pixel.
//!
//! Few of the pixels of a large image have evaluations, so counts are stored in blocks that are allocated
//! at their first evaluation.

use crate::image::Image;
use core::sync::atomic::{AtomicU32, Ordering};
use std::sync::OnceLock;

/// Pixels of a block, one after the other in a row.
const BLOCK: usize = 256;

/// Counts, while several threads count.
#[derive(Debug)]
pub(crate) struct Tally {
    shape: [usize; 2],
    /// The blocks of each row.
    in_row: usize,
    blocks: Vec<OnceLock<Box<[AtomicU32]>>>,
}

impl Tally {
    /// No evaluations, for `shape` = \[height, width\].
    pub(crate) fn new(shape: [usize; 2]) -> Self {
        let in_row = shape[1].div_ceil(BLOCK);
        Self { shape, in_row, blocks: (0..shape[0] * in_row).map(|_| OnceLock::new()).collect() }
    }

    /// The number of the pixel that has the line of sight at canonical (x, y) of one of several tiles; a
    /// line on a border belongs to the pixel above or to the right of it.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the pixels"
    )]
    pub(crate) fn pixel(&self, xy: [f64; 2], (tile, tiles): (usize, usize)) -> [usize; 2] {
        let [height, width] = self.shape;
        // A division takes longer than all the rest.
        let rows = if tiles == 1 { height } else { height / tiles };
        let index = |along: f64, pixels: usize| {
            ((along * pixels as f64).max(0.0) as usize).min(pixels.saturating_sub(1))
        };
        [tile * rows + index(xy[1], rows), index(xy[0], width)]
    }

    /// Counts `evaluations` for the pixel in this row and column, if there are pixels.
    pub(crate) fn count(&self, [row, column]: [usize; 2], evaluations: usize) {
        if self.blocks.is_empty() || evaluations == 0 {
            return;
        }
        let block = self.blocks[row * self.in_row + column / BLOCK].get_or_init(new_block);
        let evaluations = u32::try_from(evaluations).unwrap_or(u32::MAX);
        block[column % BLOCK].fetch_add(evaluations, Ordering::Relaxed);
    }

    /// Counts from 0 again.
    pub(crate) fn restart(&self) {
        let counts = self.blocks.iter().filter_map(OnceLock::get).flat_map(|block| &block[..]);
        counts.for_each(|count| count.store(0, Ordering::Relaxed));
    }

    /// The counts so far.
    pub(crate) fn counts(&self) -> EvaluationCounts {
        let of_block = |block: &OnceLock<Box<[AtomicU32]>>| {
            let counts = block.get()?.iter();
            Some(counts.map(|count| count.load(Ordering::Relaxed)).collect())
        };
        let blocks = self.blocks.iter().map(of_block).collect();
        EvaluationCounts { shape: self.shape, in_row: self.in_row, blocks }
    }
}

fn new_block() -> Box<[AtomicU32]> {
    (0..BLOCK).map(|_| AtomicU32::new(0)).collect()
}

/// How often g was evaluated on the lines of sight of each pixel: a map that takes memory only where
/// there are evaluations.
///
/// ```
/// use emitree::{Canonical, FromFn, RenderOptions, VolOptions, render};
///
/// let glow = FromFn(|[x, y, _]: [f64; 3], _| (-30.0 * (x * x + y * y)).exp());
/// let options = RenderOptions::new(VolOptions::default());
/// let rendering = render(&glow, &Canonical, [48, 64], &options)?;
/// let map = rendering.stats.evaluations_per_pixel.to_image();
/// assert_eq!(map.pixels().iter().sum::<f64>(), rendering.stats.evaluations as f64);
/// # Ok::<(), emitree::RenderError<std::convert::Infallible>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EvaluationCounts {
    shape: [usize; 2],
    in_row: usize,
    blocks: Vec<Option<Box<[u32]>>>,
}

impl EvaluationCounts {
    /// The map, in [the orientation of all images](crate::Image).
    pub fn to_image(&self) -> Image {
        let [height, width] = self.shape;
        let mut image = Image::zeros(height, width);
        for (number, block) in self.blocks.iter().enumerate() {
            let (row, first) = (number / self.in_row, number % self.in_row * BLOCK);
            let pixels = &mut image.row_mut(row)[first..];
            for (pixel, &count) in pixels.iter_mut().zip(block.iter().flat_map(|block| &block[..]))
            {
                *pixel = f64::from(count);
            }
        }
        image
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pixel_has_its_own_count_and_only_blocks_with_counts_take_memory() {
        let shape = [2, 3 * BLOCK - 5];
        let tally = Tally::new(shape);
        let x = |column: usize| (column as f64 + 0.5) / shape[1] as f64;
        let counted = [(0, 0, 3), (0, BLOCK - 1, 1), (1, BLOCK, 7), (1, 3 * BLOCK - 6, 2)];
        for (row, column, evaluations) in counted {
            // The row as one tile of two.
            tally.count(tally.pixel([x(column), 0.5], (row, 2)), evaluations);
            tally.count(tally.pixel([x(column), 0.25 + 0.5 * row as f64], (0, 1)), 1);
        }
        let counts = tally.counts();
        assert_eq!(counts.blocks.iter().flatten().count(), 3);
        let image = counts.to_image();
        for (row, column, evaluations) in counted {
            assert!((image[(row, column)] - (evaluations + 1) as f64).abs() < 1e-12);
        }
        assert!((image.pixels().iter().sum::<f64>() - 17.0).abs() < 1e-12);
    }

    #[test]
    fn lines_on_and_beyond_the_borders_count_for_pixels_at_the_edge() {
        let tally = Tally::new([2, 2]);
        for xy in [[0.5, 0.5], [1.0, 1.0], [1.0 + 1e-9, 1.0], [-1e-9, 0.0]] {
            tally.count(tally.pixel(xy, (0, 1)), 1);
        }
        assert_eq!(tally.counts().to_image().pixels(), [1.0, 0.0, 0.0, 3.0]);
        let none = Tally::new([0, 0]);
        none.count(none.pixel([0.5; 2], (0, 1)), 1);
    }
}
