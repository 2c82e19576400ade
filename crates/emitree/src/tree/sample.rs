//! Sampling: the exact averages over pixels, or voxels, of what a tree represents.
//!
//! Up to the level whose cells are about the size of a pixel, cells are subdivided (the paper's
//! section 2.1); from there on the function is, in each leaf, the polynomial that prediction uses:
//! the one whose means over the stencil's cells are their averages. It conserves the averages of all
//! cells, so where pixels are unions of cells they are plain means, and for any number of them along
//! each axis their sum is the tree's integral to rounding.
//!
//! All goes axis by axis, so that it is the same for images and for cubes. "Pixels" are what borders
//! on all axes divide the unit cube into.

use super::SparseTree;
use super::level::{LEAF, Level};
use super::stencils::StencilBuffer;
use crate::cell::to_u32;
use crate::cube::Cube;
use crate::image::Image;
use crate::parallel::prelude::*;
use crate::prediction::{Stencil, part_weights};
use rustc_hash::FxHashMap;

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

/// The parts of cells along one axis, made once for all cells that share a position on it.
struct Cuts {
    axis: Axis,
    known: FxHashMap<u32, (Stencil, Vec<Part>)>,
}

impl Cuts {
    fn new(axis: Axis) -> Self {
        Self { axis, known: FxHashMap::default() }
    }

    /// Makes the parts of the cell at `position`, if they are not there.
    fn make(&mut self, position: u32) {
        self.known.entry(position).or_insert_with(|| self.axis.parts(position));
    }

    /// The parts of the cell at `position`, which must have been made.
    fn of(&self, position: u32) -> &(Stencil, Vec<Part>) {
        &self.known[&position]
    }
}

/// A mean for each pixel, axis 0 fastest.
struct Means<const D: usize> {
    pixels: [usize; D],
    values: Vec<f64>,
}

/// Working memory for the polynomial of one cell, kept from cell to cell.
struct Buffer {
    stencil: StencilBuffer,
    /// Values around the cell, of which axis after axis becomes that of its parts.
    values: Vec<f64>,
    narrowed: Vec<f64>,
}

impl SparseTree<2> {
    /// The image of `height` × `width` pixels: each pixel is the exact mean, over its rectangle, of
    /// the function that the tree represents; see [the orientation](crate::Image).
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
        Image::from_pixels(height, width, self.means([width, height]))
    }
}

impl SparseTree<3> {
    /// The cube of `bins` × `height` × `width` voxels of a tree in x, y and energy: each voxel is
    /// the exact mean, over its box, of the function that the tree represents; see [the axis
    /// order](crate::Cube).
    ///
    /// ```
    /// use emitree::quadrature::Pointwise;
    /// use emitree::tree::{BuildOptions, build};
    ///
    /// let ramp = Pointwise(|[x, y, u]: [f64; 3]| x + y + 10.0 * u);
    /// let cube = build(&ramp, [false; 3], &BuildOptions::default())?.tree.sample_cube(3, 10, 15);
    /// let expected = 14.5 / 15.0 + 0.5 / 10.0 + 10.0 * 2.5 / 3.0;
    /// assert!((cube.bands()[2][(0, 14)] - expected).abs() < 1e-13);
    /// # Ok::<(), emitree::tree::BuildError<std::convert::Infallible>>(())
    /// ```
    ///
    /// # Panics
    ///
    /// If the bins, the height or the width are 0 or above 2^24.
    pub fn sample_cube(&self, bins: usize, height: usize, width: usize) -> Cube {
        let voxels = self.means([width, height, bins]);
        let bands = voxels.chunks(width * height);
        let bands = bands.map(|band| Image::from_pixels(height, width, band.to_vec()));
        Cube::from_bands(bands.collect())
    }
}

impl<const D: usize> SparseTree<D> {
    /// The mean over each pixel, axis 0 fastest; there are `pixels` along the axes.
    fn means(&self, pixels: [usize; D]) -> Vec<f64> {
        assert!(pixels.iter().all(|along| (1..=1 << 24).contains(along)), "{pixels:?} pixels");
        let level = sampled_level(self.base_level(), &pixels);
        let mut means = Means { pixels, values: self.means_of_grid(level, pixels) };
        self.add_finer(level, &mut means);
        means.values
    }

    /// Pixel means of the function that is one polynomial in each cell of the grid of `level`.
    fn means_of_grid(&self, level: u8, pixels: [usize; D]) -> Vec<f64> {
        let grid = self.reconstruct(level);
        let cells = 1_usize << level;
        let axes = self.axes(level, pixels).map(|axis| axis.pixel_rows());

        let width = pixels[0];
        let mut means = vec![0.0; grid.len() / cells * width];
        means.par_chunks_mut(width).zip(grid.par_chunks(cells)).for_each(|(to, from)| {
            for (pixel, parts) in to.iter_mut().zip(&axes[0]) {
                *pixel = parts.iter().map(|&(cell, weight)| weight * from[cell]).sum();
            }
        });
        drop(grid);
        // What lies side by side: the pixels of the axes that are done.
        let mut side_by_side = width;
        for rows in &axes[1..] {
            let cells_long = cells * side_by_side;
            let mut narrowed = vec![0.0; means.len() / cells * rows.len()];
            narrowed.par_chunks_mut(side_by_side).enumerate().for_each(|(at, to)| {
                let (slab, pixel) = (at / rows.len(), at % rows.len());
                let slab = &means[slab * cells_long..][..cells_long];
                for &(cell, weight) in &rows[pixel] {
                    let from = &slab[cell * side_by_side..][..side_by_side];
                    for (pixel, value) in to.iter_mut().zip(from) {
                        *pixel += weight * value;
                    }
                }
            });
            means = narrowed;
            side_by_side *= rows.len();
        }
        means
    }

    /// Adds what cells finer than `level` change in pixels whose borders cut their parents. In all
    /// others they change nothing: a parent is the mean of its children.
    fn add_finer(&self, level: u8, means: &mut Means<D>) {
        let first = usize::from(level - self.base_level());
        if first + 1 >= self.levels.len() {
            return;
        }
        let mut tree = self.clone();
        let mut buffer = Buffer {
            stencil: StencilBuffer::new::<D>(self.order()),
            values: Vec::new(),
            narrowed: Vec::new(),
        };
        for depth in first..self.levels.len() - 1 {
            let axes = self.axes(self.levels[depth].level, means.pixels);
            let is_cut = |cell: usize| {
                let position = self.levels[depth].cell_position(cell);
                (0..D).any(|axis| axes[axis].cuts(position[axis]))
            };
            let children = &self.levels[depth].children;
            let cut: Vec<usize> =
                (0..children.len()).filter(|&c| children[c] != LEAF && is_cut(c)).collect();
            let child_position = |&cell: &usize| {
                let first = children[cell] as usize * Level::<D>::SIBLINGS;
                (first..first + Level::<D>::SIBLINGS)
                    .map(|child| self.levels[depth + 1].cell_position(child))
            };
            let cells: Vec<[u32; D]> = cut.iter().flat_map(child_position).collect();
            tree.complete(depth + 1, &cells);
            let mut cuts = axes.map(Cuts::new);
            let finer = self.levels[depth + 1].level;
            let mut finer_cuts = self.axes(finer, means.pixels).map(Cuts::new);
            for cell in &cut {
                let position = self.levels[depth].cell_position(*cell);
                tree.add_cell(depth, position, &mut cuts, -1.0, &mut buffer, means);
                for child in child_position(cell) {
                    tree.add_cell(depth + 1, child, &mut finer_cuts, 1.0, &mut buffer, means);
                }
            }
        }
    }

    /// Adds `sign` times the polynomial of one cell to the pixels that it touches.
    fn add_cell(
        &self,
        depth: usize,
        position: [u32; D],
        cuts: &mut [Cuts; D],
        sign: f64,
        buffer: &mut Buffer,
        means: &mut Means<D>,
    ) {
        let (order, offsets) = self.stencils(depth).gather(position, &mut buffer.stencil);
        for (cuts, position) in cuts.iter_mut().zip(position) {
            cuts.make(position);
        }
        let cuts: [&(Stencil, Vec<Part>); D] =
            core::array::from_fn(|axis| cuts[axis].of(position[axis]));
        let orders = core::array::from_fn(|axis| cuts[axis].0.order);
        // A stencil of one cell is that cell, wherever the gathered block has it.
        let starts = core::array::from_fn(|axis| if orders[axis] == 1 { offsets[axis] } else { 0 });
        buffer.values.clear();
        for start in row_starts([order; D], starts, orders) {
            buffer.values.extend_from_slice(&buffer.stencil.block[start..][..orders[0]]);
        }
        let mut side_by_side = 1;
        for (_, parts) in cuts {
            take_parts(&buffer.values, side_by_side, parts, &mut buffer.narrowed);
            core::mem::swap(&mut buffer.values, &mut buffer.narrowed);
            side_by_side *= parts.len();
        }
        let pixels = core::array::from_fn(|axis| cuts[axis].1[0].pixel);
        let counts = core::array::from_fn(|axis| cuts[axis].1.len());
        let rows = row_starts(means.pixels, pixels, counts);
        for (start, values) in rows.zip(buffer.values.chunks_exact(counts[0])) {
            for (mean, value) in means.values[start..].iter_mut().zip(values) {
                *mean += sign * value;
            }
        }
    }

    fn axes(&self, level: u8, pixels: [usize; D]) -> [Axis; D] {
        core::array::from_fn(|axis| Axis {
            pixels: to_u32(pixels[axis]),
            level,
            order: self.order(),
            periodic: self.periodic[axis],
        })
    }
}

/// The level of the grid that pixels are sampled from: its cells are no larger than pixels along the
/// axis that has the fewest, so that the grid is no larger than what it is for.
pub(crate) fn sampled_level(base_level: u8, pixels: &[usize]) -> u8 {
    let fewest = pixels.iter().copied().min().unwrap_or(1);
    let level = fewest.next_power_of_two().trailing_zeros();
    base_level.max(u8::try_from(level).unwrap_or(u8::MAX))
}

/// Makes values of the parts of a cell from those of its stencil, along one axis; `side_by_side`
/// values of the axes that are done belong to each.
fn take_parts(from: &[f64], side_by_side: usize, parts: &[Part], to: &mut Vec<f64>) {
    let length = parts[0].weights.len() * side_by_side;
    to.clear();
    to.resize(from.len() / length * parts.len() * side_by_side, 0.0);
    let slabs =
        from.chunks_exact(length).flat_map(|slab| parts.iter().map(move |part| (slab, part)));
    for ((slab, part), to) in slabs.zip(to.chunks_exact_mut(side_by_side)) {
        for (weight, row) in part.weights.iter().zip(slab.chunks_exact(side_by_side)) {
            for (mean, value) in to.iter_mut().zip(row) {
                *mean += weight * value;
            }
        }
    }
}

/// Where the rows of a box begin, which has `lengths` from `first` on along the axes of an array of
/// these `extents`, axis 0 fastest.
fn row_starts<const D: usize>(
    extents: [usize; D],
    first: [usize; D],
    lengths: [usize; D],
) -> impl Iterator<Item = usize> {
    let rows: usize = lengths[1..].iter().product();
    (0..rows).map(move |mut row| {
        let (mut start, mut stride) = (first[0], 1);
        for axis in 1..D {
            stride *= extents[axis - 1];
            start += (first[axis] + row % lengths[axis]) * stride;
            row /= lengths[axis];
        }
        start
    })
}

impl Axis {
    /// Whether a border between pixels runs through the cell at `position`.
    fn cuts(&self, position: u32) -> bool {
        let (pixels, cells) = (u64::from(self.pixels), 1_u64 << self.level);
        let (low, high) = (u64::from(position) * pixels, u64::from(position + 1) * pixels);
        low / cells != (high - 1) / cells
    }
}
