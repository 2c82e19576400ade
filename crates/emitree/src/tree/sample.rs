//! Sampling: the exact pixel averages of what a two-dimensional tree represents.
//!
//! Up to the level whose cells are about the size of a pixel, cells are subdivided (the paper's
//! section 2.1); from there on the function is, in each leaf, the polynomial that prediction uses:
//! the one whose means over the stencil's cells are their averages. It conserves the averages of all
//! cells, so where pixels are unions of cells they are plain means, and for any width and height
//! the sum over the pixels is the tree's integral to rounding.

use super::SparseTree;
use super::ghosts::StencilBuffer;
use super::level::LEAF;
use crate::cell::to_u32;
use crate::image::Image;
use crate::prediction::{Stencil, part_weights};
use rayon::prelude::*;

/// How cells along one axis make pixels: for each pixel the cells that it takes from.
struct Axis {
    pixels: u32,
    level: u8,
    order: usize,
    periodic: bool,
}

/// A part of one pixel: the share of the pixel that lies in one cell, and the weights with which
/// the averages of the cell's stencil make the mean over that part times that share.
struct Part {
    pixel: usize,
    weights: Vec<f64>,
}

#[expect(clippy::cast_possible_truncation, reason = "there are at most 2^24 along an axis")]
fn pixel_index(pixel: u64) -> usize {
    pixel as usize
}

impl Axis {
    /// The parts into which pixels cut the cell at `position`, and the stencil of its weights.
    fn parts(&self, position: u32) -> (Stencil, Vec<Part>) {
        let (pixels, cells) = (u64::from(self.pixels), 1_u64 << self.level);
        // In units of 1 / (pixels · cells) all borders are integers: nothing is lost at a border
        // that pixels and cells share.
        let (low, high) = (u64::from(position) * pixels, u64::from(position + 1) * pixels);
        let (first, last) = (low / cells, (high - 1) / cells);
        if first == last {
            // The whole cell is in one pixel: its average is all that counts.
            let stencil = Stencil { start: position, order: 1, offset: 0 };
            let weights = vec![pixels as f64 / cells as f64];
            return (stencil, vec![Part { pixel: pixel_index(first), weights }]);
        }
        let stencil = Stencil::around(position, self.level, self.order, self.periodic);
        let part = |pixel: u64| {
            let (from, to) = (low.max(pixel * cells) - low, high.min((pixel + 1) * cells) - low);
            let share = (to - from) as f64 / cells as f64;
            let (from, to) = (from as f64 / pixels as f64, to as f64 / pixels as f64);
            let weights = part_weights(stencil.order, stencil.offset, from, to);
            Part { pixel: pixel_index(pixel), weights: weights.iter().map(|w| w * share).collect() }
        };
        (stencil, (first..=last).map(part).collect())
    }

    /// For each pixel, the cells of the whole axis that it is made of and their weights.
    fn pixel_rows(&self) -> Vec<Vec<(usize, f64)>> {
        let cells = 1_u32 << self.level;
        let mut rows = vec![Vec::new(); self.pixels as usize];
        for position in 0..cells {
            let (stencil, parts) = self.parts(position);
            for Part { pixel, weights } in parts {
                for (k, weight) in weights.into_iter().enumerate() {
                    let cell = (stencil.start + to_u32(k)) % cells;
                    rows[pixel].push((cell as usize, weight));
                }
            }
        }
        rows
    }
}

impl SparseTree<2> {
    /// The image of `height` × `width` pixels: each pixel is the exact mean, over its rectangle, of
    /// the function that the tree represents; see [the orientation](crate::image).
    ///
    /// ```
    /// use emitree::quadrature::Pointwise;
    /// use emitree::tree::{BuildOptions, build};
    ///
    /// let plane = build(&Pointwise(|[x, y]: [f64; 2]| x + y), [false; 2], &BuildOptions::default())?;
    /// let image = plane.tree.sample(10, 15);
    /// assert!((image[(0, 14)] - (0.5 / 10.0 + 14.5 / 15.0)).abs() < 1e-14);
    /// # Ok::<(), emitree::tree::BuildError<std::convert::Infallible>>(())
    /// ```
    ///
    /// # Panics
    ///
    /// If the height or the width is 0 or above 2^24.
    pub fn sample(&self, height: usize, width: usize) -> Image {
        assert!((1..=1 << 24).contains(&height) && (1..=1 << 24).contains(&width));
        let narrow = height.min(width).next_power_of_two().trailing_zeros();
        let level = self.base_level().max(u8::try_from(narrow).unwrap_or(u8::MAX));
        let mut image = self.sample_grid(level, height, width);
        self.add_finer(level, &mut image);
        image
    }

    /// Pixel means of the function that is one polynomial in each cell of the grid of `level`.
    fn sample_grid(&self, level: u8, height: usize, width: usize) -> Image {
        let grid = self.reconstruct(level);
        let cells = 1_usize << level;
        let [columns, rows] = self.axes(level, height, width).map(|axis| axis.pixel_rows());

        let mut narrowed = vec![0.0; cells * width];
        narrowed.par_chunks_mut(width).zip(grid.par_chunks(cells)).for_each(|(to, from)| {
            for (pixel, parts) in to.iter_mut().zip(&columns) {
                *pixel = parts.iter().map(|&(cell, weight)| weight * from[cell]).sum();
            }
        });
        drop(grid);
        let mut image = Image::zeros(height, width);
        image.pixels_mut().par_chunks_mut(width).zip(&rows).for_each(|(to, parts)| {
            for &(cell, weight) in parts {
                let from = &narrowed[cell * width..][..width];
                for (pixel, value) in to.iter_mut().zip(from) {
                    *pixel += weight * value;
                }
            }
        });
        image
    }

    /// Adds what cells finer than `level` change in pixels whose borders cut their parents. In all
    /// others they change nothing: a parent is the mean of its children.
    fn add_finer(&self, level: u8, image: &mut Image) {
        let (height, width) = (image.height(), image.width());
        let first = usize::from(level - self.base_level());
        if first + 1 >= self.levels.len() {
            return;
        }
        let mut tree = self.clone();
        let mut buffer = StencilBuffer::new::<2>(self.order());
        for depth in first..self.levels.len() - 1 {
            let axes = self.axes(self.levels[depth].level, height, width);
            let finer_axes = self.axes(self.levels[depth + 1].level, height, width);
            let is_cut = |cell: usize| {
                let position = self.levels[depth].cell_position(cell);
                (0..2).any(|axis| axes[axis].cuts(position[axis]))
            };
            let children = &self.levels[depth].children;
            let cut: Vec<usize> =
                (0..children.len()).filter(|&c| children[c] != LEAF && is_cut(c)).collect();
            let child_position = |&cell: &usize| {
                let first = children[cell] as usize * 4;
                (first..first + 4).map(|child| self.levels[depth + 1].cell_position(child))
            };
            tree.complete(depth + 1, cut.iter().flat_map(child_position));
            for cell in &cut {
                let position = self.levels[depth].cell_position(*cell);
                tree.add_cell(depth, position, &axes, -1.0, &mut buffer, image);
                for child in child_position(cell) {
                    tree.add_cell(depth + 1, child, &finer_axes, 1.0, &mut buffer, image);
                }
            }
        }
    }

    /// Adds `sign` times the polynomial of one cell to the pixels that it touches.
    fn add_cell(
        &self,
        depth: usize,
        position: [u32; 2],
        axes: &[Axis; 2],
        sign: f64,
        buffer: &mut StencilBuffer,
        image: &mut Image,
    ) {
        let (order, offsets) = self.gather(depth, position, buffer);
        let [(x, columns), (y, rows)] = [0, 1].map(|axis| axes[axis].parts(position[axis]));
        // A stencil of one cell is that cell, wherever the gathered block has it.
        let from =
            |stencil: Stencil, axis: usize| if stencil.order == 1 { offsets[axis] } else { 0 };
        let (x, y) = (from(x, 0), from(y, 1));
        for row in &rows {
            for column in &columns {
                let mut mean = 0.0;
                for (j, v) in row.weights.iter().enumerate() {
                    let line = &buffer.block[(y + j) * order + x..];
                    let along: f64 = column.weights.iter().zip(line).map(|(u, a)| u * a).sum();
                    mean += v * along;
                }
                image[(row.pixel, column.pixel)] += sign * mean;
            }
        }
    }

    fn axes(&self, level: u8, height: usize, width: usize) -> [Axis; 2] {
        [(width, 0), (height, 1)].map(|(pixels, axis)| Axis {
            pixels: to_u32(pixels),
            level,
            order: self.order(),
            periodic: self.periodic[axis],
        })
    }
}

impl Axis {
    /// Whether a border between pixels runs through the cell at `position`.
    fn cuts(&self, position: u32) -> bool {
        let (pixels, cells) = (u64::from(self.pixels), 1_u64 << self.level);
        let (low, high) = (u64::from(position) * pixels, u64::from(position + 1) * pixels);
        low / cells != (high - 1) / cells
    }
}
