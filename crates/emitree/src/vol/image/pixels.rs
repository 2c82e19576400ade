//! Pixels: the means of the function of an image tree over each of them.
//!
//! A mean over a pixel is a weighted sum of the values on a lattice. The weights along x are the
//! same for all rows, those along y for all columns. On the finest lattice they are the integrals
//! of the local quintics; those of a coarser one follow by transposed subdivision. The means are
//! exact for the whole tree although no lattice finer than the pixels is filled: a finer node adds
//! its detail times the weights of its own level.

use crate::parallel::prelude::*;
use crate::vol::dyadic::{GAUSS, STENCIL, STEPS, midpoint_weights, polynomial_weights, spacing};
use crate::vol::image::tree::{ImageTree, Node};
use core::ops::Range;

/// Weights of the means over the pixels along one axis, on the lattice of one level.
#[derive(Clone, Debug)]
pub(crate) struct AxisWeights {
    intervals: usize,
    pixels: Vec<PixelWeights>,
}

/// The weights of one pixel: its mean is Σ `weights`\[k\] · value\[`first` + k\].
#[derive(Clone, Debug)]
struct PixelWeights {
    first: usize,
    weights: Vec<f64>,
}

impl AxisWeights {
    /// The weights on a lattice of 2^`level` intervals, 8 or more: integrals of the local quintics.
    pub(crate) fn finest(level: u8, pixels: usize) -> Self {
        let intervals = 1_usize << level;
        Self { intervals, pixels: (0..pixels).map(|p| quintic(intervals, p, pixels)).collect() }
    }

    /// The weights of the values of the same function on the next coarser lattice.
    pub(crate) fn coarser(&self, order: usize) -> Self {
        let intervals = self.intervals / 2;
        Self {
            intervals,
            pixels: self.pixels.iter().map(|p| p.coarser(order, intervals)).collect(),
        }
    }

    /// The pixels in which the value at `index` may have a weight other than 0.
    pub(crate) fn around(&self, index: usize) -> Range<usize> {
        // A fundamental function of subdivision extends over at most five intervals on either side.
        let from = index.saturating_sub(STENCIL) * self.pixels.len() / self.intervals;
        let to = ((index + STENCIL) * self.pixels.len()).div_ceil(self.intervals);
        from..to.min(self.pixels.len())
    }

    /// The weight of the value at `index` in the mean over a pixel.
    pub(crate) fn weight(&self, pixel: usize, index: usize) -> f64 {
        self.pixels[pixel].at(index)
    }
}

impl PixelWeights {
    fn coarser(&self, order: usize, intervals: usize) -> Self {
        let last = self.first + self.weights.len() - 1;
        let first = (self.first / 2).saturating_sub(STENCIL - 1);
        let end = (last / 2 + STENCIL + 1).min(intervals + 1);
        let mut weights = vec![0.0; end - first];
        for (k, &weight) in self.weights.iter().enumerate() {
            let index = self.first + k;
            if index.is_multiple_of(2) {
                weights[index / 2 - first] += weight;
            } else {
                let (start, prediction) = midpoint_weights(order, intervals, index / 2);
                for (j, share) in prediction.iter().enumerate() {
                    weights[start + j - first] += weight * share;
                }
            }
        }
        let leading = weights.iter().take_while(|w| **w == 0.0).count().min(weights.len() - 1);
        weights.drain(..leading);
        while weights.len() > 1 && weights.last() == Some(&0.0) {
            weights.pop();
        }
        Self { first: first + leading, weights }
    }

    fn at(&self, index: usize) -> f64 {
        let inside = index.checked_sub(self.first).and_then(|k| self.weights.get(k));
        inside.copied().unwrap_or(0.0)
    }
}

/// The weights of pixel `pixel` of `pixels` on a lattice of `intervals`: the mean of the quintics
/// through the six values around each interval.
fn quintic(intervals: usize, pixel: usize, pixels: usize) -> PixelWeights {
    // Borders in units of 1 / (intervals · pixels): integers that neighbouring pixels share.
    let (from, to) = (pixel * intervals, (pixel + 1) * intervals);
    let first_interval = from / pixels;
    let last_interval = (to - 1) / pixels;
    let start = |interval: usize| interval.saturating_sub(2).min(intervals + 1 - STENCIL);
    let first = start(first_interval);
    let mut weights = vec![0.0; start(last_interval) + STENCIL - first];
    for interval in first_interval..=last_interval {
        let low = from.max(interval * pixels) - interval * pixels;
        let high = to.min((interval + 1) * pixels) - interval * pixels;
        let (low, high) = (low as f64 / pixels as f64, high as f64 / pixels as f64);
        let share = (high - low) * pixels as f64 / intervals as f64;
        let offset = (interval - start(interval)) as f64;
        for (t, gauss) in GAUSS {
            let values = polynomial_weights(offset + low + t * (high - low));
            for (k, value) in values.iter().enumerate() {
                weights[start(interval) + k - first] += share * gauss * value;
            }
        }
    }
    PixelWeights { first, weights }
}

/// The mean of the tree's function over each of `height` × `width` pixels, row by row.
pub(crate) fn pixel_means(tree: &ImageTree, [height, width]: [usize; 2]) -> Vec<f64> {
    let finest = tree.finest_level().max(3);
    // The filled lattice is not finer than the longer side of a pixel.
    let of_pixels = height.min(width).next_power_of_two().trailing_zeros();
    let filled = finest.min(u8::try_from(of_pixels).unwrap_or(u8::MAX).max(3));
    let mut means = vec![0.0; height * width];
    let (mut x, mut y) = (AxisWeights::finest(finest, width), AxisWeights::finest(finest, height));
    for level in (filled + 1..=finest).rev() {
        let nodes = tree.nodes().iter().filter(|node| node.level == level);
        nodes.for_each(|node| add_detail(&mut means, node, &x, &y));
        (x, y) = (x.coarser(tree.order()), y.coarser(tree.order()));
    }
    let lattice = fill(tree, filled);
    let points = (1_usize << filled) + 1;
    // Columns first: the means over columns of pixels, for each row of the lattice.
    let mut rows = vec![0.0; points * width];
    rows.par_chunks_mut(width).zip(lattice.par_chunks(points)).for_each(|(row, values)| {
        for (mean, pixel) in row.iter_mut().zip(&x.pixels) {
            let values = &values[pixel.first..];
            *mean = pixel.weights.iter().zip(values).map(|(weight, value)| weight * value).sum();
        }
    });
    means.par_chunks_mut(width).zip(&y.pixels).for_each(|(means, pixel)| {
        for (k, weight) in pixel.weights.iter().enumerate() {
            let row = &rows[(pixel.first + k) * width..][..width];
            for (mean, value) in means.iter_mut().zip(row) {
                *mean += weight * value;
            }
        }
    });
    means
}

/// Adds the contribution of the detail of one node to each pixel.
fn add_detail(means: &mut [f64], node: &Node, x: &AxisWeights, y: &AxisWeights) {
    let step = spacing(node.level);
    let [i, j] = node.place.map(|along| (along / step) as usize);
    let width = x.pixels.len();
    for row in y.around(j) {
        let weight = node.detail * y.pixels[row].at(j);
        if weight != 0.0 {
            for column in x.around(i) {
                means[row * width + column] += weight * x.pixels[column].at(i);
            }
        }
    }
}

/// The values of the tree's function on the lattice of `level`, row by row of equal y.
fn fill(tree: &ImageTree, level: u8) -> Vec<f64> {
    let mut by_level: Vec<Vec<&Node>> = vec![Vec::new(); usize::from(level) + 1];
    for node in tree.nodes().iter().filter(|node| node.level <= level) {
        by_level[usize::from(node.level)].push(node);
    }
    let mut values = vec![0.0; 4];
    for (depth, nodes) in by_level.iter().enumerate() {
        let intervals = 1_usize << depth;
        if depth > 0 {
            values = subdivide(tree.order(), &values, intervals / 2);
        }
        for node in nodes {
            let [i, j] = node.place.map(|along| along as usize * intervals / STEPS as usize);
            values[j * (intervals + 1) + i] = node.value;
        }
    }
    values
}

/// The values on the next finer lattice, predicted with `order` from a lattice with `intervals`
/// intervals along each axis.
fn subdivide(order: usize, values: &[f64], intervals: usize) -> Vec<f64> {
    let (points, finer) = (intervals + 1, 2 * intervals + 1);
    let mut wide = vec![0.0; points * finer];
    wide.par_chunks_mut(finer).zip(values.par_chunks(points)).for_each(|(wide, values)| {
        for (i, value) in wide.iter_mut().enumerate() {
            *value = if i.is_multiple_of(2) {
                values[i / 2]
            } else {
                let (first, weights) = midpoint_weights(order, intervals, i / 2);
                weights.iter().zip(&values[first..]).map(|(w, v)| w * v).sum()
            };
        }
    });
    let mut fine = vec![0.0; finer * finer];
    fine.par_chunks_mut(finer).enumerate().for_each(|(j, fine)| {
        if j.is_multiple_of(2) {
            fine.copy_from_slice(&wide[j / 2 * finer..][..finer]);
            return;
        }
        let (first, weights) = midpoint_weights(order, intervals, j / 2);
        for (k, weight) in weights.iter().enumerate() {
            let row = &wide[(first + k) * finer..][..finer];
            for (fine, value) in fine.iter_mut().zip(row) {
                *fine += weight * value;
            }
        }
    });
    fine
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::dyadic::Place;
    use crate::vol::dyadic::unit;

    fn tree_of(places: impl IntoIterator<Item = Place>, f: impl Fn(f64, f64) -> f64) -> ImageTree {
        let mut tree = ImageTree::default();
        for place in places {
            if tree.find(place).is_none() {
                tree.add(place);
                tree.set(tree.len() - 1, f(unit(place[0]), unit(place[1])));
            }
        }
        tree.update_details();
        tree
    }

    fn lattice(level: u8) -> impl Iterator<Item = Place> {
        let step = spacing(level);
        let along = move || (0..=1_u32 << level).map(move |i| i * step);
        along().flat_map(move |x| along().map(move |y| [x, y]))
    }

    #[test]
    fn means_of_quintics_are_exact_for_any_number_of_pixels() {
        let power = |x: f64, n: i32| x.powi(n);
        let tree = tree_of(lattice(3), |x, y| power(x, 5) + 3.0 * power(y, 4) * x);
        for shape in [[1, 1], [7, 30], [64, 64], [100, 3]] {
            let [height, width] = shape;
            let means = pixel_means(&tree, shape);
            for row in 0..height {
                for column in 0..width {
                    let mean = |n: i32, pixel: usize, pixels: usize| {
                        let at =
                            |p: usize| power(p as f64 / pixels as f64, n + 1) / f64::from(n + 1);
                        (at(pixel + 1) - at(pixel)) * pixels as f64
                    };
                    let exact = mean(5, column, width)
                        + 3.0 * mean(4, row, height) * mean(1, column, width);
                    let found = means[row * width + column];
                    assert!(
                        (found - exact).abs() < 1e-13,
                        "{shape:?} {row} {column}: {found} {exact}"
                    );
                }
            }
        }
    }

    #[test]
    fn nodes_finer_than_the_pixels_count_as_on_the_filled_lattice() {
        let peak = |x: f64, y: f64| (-400.0 * ((x - 0.43).powi(2) + (y - 0.02).powi(2))).exp();
        let near = |[x, y]: &Place| unit(*x).hypot(unit(*y) - 0.2) < 0.7;
        let mut tree = tree_of(lattice(3).chain(lattice(7).filter(near)), peak);
        for order in [4, 6] {
            tree.set_order(order);
            tree.update_details();
            few_pixels_add_up(&tree);
        }
    }

    fn few_pixels_add_up(tree: &ImageTree) {
        // 8 pixels along an axis fill level 3 only; 128 pixels fill all levels.
        let (few, many) = (pixel_means(tree, [8, 8]), pixel_means(tree, [128, 128]));
        for (p, few) in few.iter().enumerate() {
            let rows = (p / 8) * 16..(p / 8 + 1) * 16;
            let columns = (p % 8) * 16..(p % 8 + 1) * 16;
            let part = |row: usize| columns.clone().map(move |column| row * 128 + column);
            let sum: f64 = rows.flat_map(part).map(|pixel| many[pixel]).sum();
            assert!((sum / 256.0 - few).abs() < 1e-14, "pixel {p}: {few} and {}", sum / 256.0);
        }
    }
}
