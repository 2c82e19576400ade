//! G on the whole cube from few fibers: a cross approximation in Tucker form.
//!
//! G(x, y, z) = Σ aᵢ(x) bⱼ(y) cₖ(z) G(xᵢ, yⱼ, zₖ), where a, b, c are the cardinal functions of the
//! fibers along each axis and (xᵢ, yⱼ, zₖ) the lattice of their pivots: G is stored on the crosses
//! and never on a grid (Oseledets, Savostianov and Tyrtyshnikov 2008, doi:10.1137/060655894). It is
//! exact where the functions of the fibers span those of G. Its integral along z is one sum for
//! each pair of pivots, Σₖ G(xᵢ, yⱼ, zₖ) ∫ cₖ dz.

use crate::output::Model;
use crate::parallel::prelude::*;
use crate::vol::lowrank::chebyshev::{LANES, places};
use crate::vol::lowrank::fibers::Fibers;
use crate::vol::lowrank::scaling::Scaling;
use crate::vol::view::products::RasterMeans;
use multiversion::multiversion;
use nalgebra::{DMatrix, DVector};

/// The smallest number of multiplications for a thread, which takes some ten microseconds to start.
const LEAST_WORK: usize = 100_000;

/// A function of (x, y, z) by its values on crosses of fibers.
#[derive(Clone, Debug)]
pub(super) struct Interpolant {
    /// The fibers along x, y and z.
    pub(super) axes: [Fibers; 3],
    /// G at all triples of pivots, the last axis fastest.
    core: Vec<f64>,
    /// The number of pivots on each axis that the core contains.
    filled: [usize; 3],
    /// What G is multiplied with to give the function that is interpolated.
    pub(super) scaling: Option<Scaling>,
}

impl RasterMeans for Interpolant {
    fn means(&self, shape: [usize; 2]) -> Vec<f64> {
        Self::means(self, shape)
    }
}

impl Model for Interpolant {
    fn values(&self, points: &[[f64; 3]]) -> Vec<f64> {
        self.unscaled_values(points)
    }
}

impl Interpolant {
    /// The interpolant 0 without fibers, on the places of `level`.
    pub(super) fn new(level: u8, scaling: Option<Scaling>) -> Self {
        let axes = [(); 3].map(|()| Fibers::new(level));
        Self { axes, core: Vec::new(), filled: [0; 3], scaling }
    }

    /// The same functions for another G, of which no value is known yet.
    pub(super) fn for_another(&self) -> Self {
        let axes = self.axes.each_ref().map(Fibers::functions);
        Self { axes, core: Vec::new(), filled: [0; 3], scaling: self.scaling }
    }

    /// The number of functions along each axis.
    pub(super) fn ranks(&self) -> [usize; 3] {
        self.axes.each_ref().map(Fibers::rank)
    }

    /// The finest level of an axis.
    pub(super) fn finest_level(&self) -> u8 {
        self.axes.iter().map(|fibers| fibers.level).max().unwrap_or(0)
    }

    /// The number of places of three fibers, one along each axis.
    pub(super) fn places(&self) -> usize {
        self.axes.iter().map(|fibers| places(fibers.level)).sum()
    }

    /// All triples of pivots, in the order of the core.
    pub(super) fn triples(&self) -> Vec<[f64; 3]> {
        let [x, y, z] = [0, 1, 2].map(|axis: usize| self.axes[axis].pivots());
        let of_xy = |x: f64, y: f64| z.iter().map(move |&z| [x, y, z]);
        x.iter().flat_map(|&x| y.iter().flat_map(move |&y| of_xy(x, y))).collect()
    }

    /// The same with other values at all triples of pivots.
    pub(super) fn with_core(&self, core: &[f64]) -> Self {
        Self { core: core.to_vec(), ..self.clone() }
    }

    /// The triples of pivots at which the core has no value yet.
    pub(super) fn missing(&self) -> Vec<[f64; 3]> {
        let [x, y, z] = [0, 1, 2].map(|axis: usize| self.axes[axis].pivots());
        let mut missing = Vec::new();
        for (i, &x) in x.iter().enumerate() {
            for (j, &y) in y.iter().enumerate() {
                for (k, &z) in z.iter().enumerate() {
                    if !self.has([i, j, k]) {
                        missing.push([x, y, z]);
                    }
                }
            }
        }
        missing
    }

    /// Whether G is known at all triples of pivots.
    pub(super) fn is_filled(&self) -> bool {
        self.filled == self.ranks()
    }

    fn has(&self, at: [usize; 3]) -> bool {
        at.iter().zip(self.filled).all(|(&at, rank)| at < rank)
    }

    /// Stores G at the triples of pivots that were [missing](Self::missing).
    pub(super) fn fill(&mut self, rates: &[f64]) {
        let ranks = self.ranks();
        let mut core = Vec::with_capacity(ranks.iter().product());
        let mut new = rates.iter();
        for i in 0..ranks[0] {
            for j in 0..ranks[1] {
                for k in 0..ranks[2] {
                    let known = self.has([i, j, k]).then(|| self.core[self.index(i, j) + k]);
                    core.extend(known.as_ref().or_else(|| new.next()));
                }
            }
        }
        self.core = core;
        self.filled = ranks;
    }

    fn index(&self, i: usize, j: usize) -> usize {
        (i * self.filled[1] + j) * self.filled[2]
    }

    /// The values of G at the points.
    pub(super) fn unscaled_values(&self, points: &[[f64; 3]]) -> Vec<f64> {
        let mut values = self.values(points);
        if let Some(scaling) = &self.scaling {
            let both = values.iter_mut().zip(points);
            both.for_each(|(value, [u, v, _])| *value /= scaling.at([*u, *v]));
        }
        values
    }

    /// The values of the function that is interpolated at the points.
    pub(super) fn values(&self, points: &[[f64; 3]]) -> Vec<f64> {
        let mut values = vec![0.0; points.len()];
        let groups = points.par_chunks(LANES).zip(values.par_chunks_mut(LANES));
        groups.with_min_len(self.groups_at_once()).for_each_init(
            || self.room(),
            |room, (points, values)| {
                let found = self.values_of_group(room, points);
                values.copy_from_slice(&found[..points.len()]);
            },
        );
        values
    }

    /// The smallest number of groups of points for a thread.
    fn groups_at_once(&self) -> usize {
        let of_axis = |fibers: &Fibers| places(fibers.level) * (fibers.rank() + 1);
        let work = self.axes.iter().map(of_axis).sum::<usize>() + self.core.len();
        (LEAST_WORK / (LANES * work)).max(1)
    }

    fn room(&self) -> [Vec<[f64; LANES]>; 3] {
        self.filled.map(|rank| vec![[0.0; LANES]; rank])
    }

    /// The values at a group of points; lanes without a point have arbitrary values.
    fn values_of_group(
        &self,
        functions: &mut [Vec<[f64; LANES]>; 3],
        points: &[[f64; 3]],
    ) -> [f64; LANES] {
        for (axis, (fibers, functions)) in self.axes.iter().zip(&mut *functions).enumerate() {
            let x = core::array::from_fn(|lane| points.get(lane).map_or(0.0, |point| point[axis]));
            fibers.functions_at(&x, functions);
        }
        let [x, y, z] = functions;
        let mut values = [0.0; LANES];
        for (i, x) in x.iter().enumerate() {
            let of_x = sum_of_products(&self.core[self.index(i, 0)..], y, z);
            add_product(&mut values, 1.0, x, &of_x);
        }
        values
    }

    /// The values at all places of the fibers along `axis` at the coordinates `at` of the other two.
    pub(super) fn along(&self, axis: usize, at: &[[f64; 2]]) -> Vec<DVector<f64>> {
        let groups = at.par_chunks(LANES).with_min_len(self.groups_at_once());
        groups.flat_map_iter(|group| self.along_group(axis, group)).collect()
    }

    fn along_group(&self, axis: usize, at: &[[f64; 2]]) -> Vec<DVector<f64>> {
        let mut functions = self.room();
        let others = [[1, 2], [0, 2], [0, 1]][axis];
        for (number, &other) in others.iter().enumerate() {
            let x = core::array::from_fn(|lane| at.get(lane).map_or(0.0, |at| at[number]));
            self.axes[other].functions_at(&x, &mut functions[other]);
        }
        let mut of_pivots = vec![[0.0; LANES]; self.filled[axis]];
        for i in 0..self.filled[0] {
            for j in 0..self.filled[1] {
                for k in 0..self.filled[2] {
                    let [a, b] = others.map(|other| &functions[other][[i, j, k][other]]);
                    let core = self.core[self.index(i, j) + k];
                    add_product(&mut of_pivots[[i, j, k][axis]], core, a, b);
                }
            }
        }
        let of_lane = |lane: usize| {
            let of_pivots = of_pivots.iter().map(|lanes| lanes[lane]);
            self.axes[axis].cardinal() * DVector::from_iterator(self.filled[axis], of_pivots)
        };
        (0..at.len()).map(of_lane).collect()
    }

    /// The means of the functions of an axis, each divided by its part of the scaling.
    fn means_of_axis(&self, axis: usize, pixels: usize) -> DMatrix<f64> {
        match &self.scaling {
            Some(of) if axis < 2 => self.axes[axis].means_times(&|x| of.inverse(axis, x), pixels),
            _ => self.axes[axis].means(pixels),
        }
    }

    /// The same means, row by row in one vector.
    pub(super) fn means(&self, shape @ [height, width]: [usize; 2]) -> Vec<f64> {
        let pixels = self.pixels(shape);
        let mut means = vec![0.0; height * width];
        let rows = means.par_chunks_mut(width.max(1)).enumerate();
        rows.for_each(|(row, means)| pixels.row(row, means));
        means
    }

    /// The means of ∫ dz over the pixels of an image of `shape` = \[height, width\], row by row.
    pub(super) fn pixels(&self, [height, width]: [usize; 2]) -> Pixels {
        let [x, y, z] = [(0, width), (1, height), (2, 1)];
        let [x, y, z] =
            [x, y, z].map(|(axis, pixels): (usize, usize)| self.means_of_axis(axis, pixels));
        let integral = |i: usize, j: usize| -> f64 {
            let core = &self.core[self.index(i, j)..][..self.filled[2]];
            core.iter().zip(z.iter()).map(|(core, z)| core * z).sum()
        };
        let lines = DMatrix::from_fn(self.filled[0], self.filled[1], integral);
        Pixels { along_x: x * lines, along_y: y.transpose() }
    }
}

/// Σ c(j, k) y(j) z(k) in each lane, with the last index of c fastest.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn sum_of_products(core: &[f64], y: &[[f64; LANES]], z: &[[f64; LANES]]) -> [f64; LANES] {
    let mut sum = [0.0; LANES];
    for (y, core) in y.iter().zip(core.chunks_exact(z.len().max(1))) {
        let mut of_y = [0.0; LANES];
        for (core, z) in core.iter().zip(z) {
            of_y.iter_mut().zip(z).for_each(|(of_y, z)| *of_y += core * z);
        }
        sum.iter_mut().zip(y.iter().zip(&of_y)).for_each(|(sum, (y, of_y))| *sum += y * of_y);
    }
    sum
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn add_product(sums: &mut [f64; LANES], factor: f64, a: &[f64; LANES], b: &[f64; LANES]) {
    sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += factor * a * b);
}

/// The pixels of an image as a sum of products of a function of the column and one of the row.
pub(super) struct Pixels {
    /// A column for each function, a row for each column of pixels.
    along_x: DMatrix<f64>,
    /// A row for each function, a column for each row of pixels.
    along_y: DMatrix<f64>,
}

impl Pixels {
    /// Row `row` of the image.
    pub(super) fn row(&self, row: usize, pixels: &mut [f64]) {
        pixels.fill(0.0);
        let width = self.along_x.nrows().max(1);
        let functions = self.along_x.as_slice().chunks_exact(width);
        for (function, weight) in functions.zip(self.along_y.column(row).iter()) {
            add_times(pixels, *weight, function);
        }
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn add_times(sums: &mut [f64], weight: f64, values: &[f64]) {
    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    /// An interpolant with crosses through the given points.
    fn through(points: &[[f64; 3]], g: impl Fn([f64; 3]) -> f64) -> Interpolant {
        let mut interpolant = Interpolant::new(5, None);
        for &[x, y, z] in points {
            for (axis, at) in [[y, z], [x, z], [x, y]].into_iter().enumerate() {
                let [a, b] = at;
                let point = |t: f64| [[t, a, b], [a, t, b], [a, b, t]][axis];
                let fibers = &mut interpolant.axes[axis];
                let rates = fibers.places().iter().map(|&t| g(point(t))).collect();
                fibers.add(at, rates);
                fibers.extend_basis(1e-12, |_, _| true);
            }
            let rates: Vec<f64> = interpolant.missing().into_iter().map(&g).collect();
            interpolant.fill(&rates);
        }
        interpolant
    }

    fn bell(x: f64, at: f64) -> f64 {
        (-8.0 * (x - at).powi(2)).exp()
    }

    fn two_products([x, y, z]: [f64; 3]) -> f64 {
        bell(x, 0.3) * bell(y, 0.6) * bell(z, 0.5) + 0.5 * x * y * y * (3.0 * z).cos()
    }

    #[test]
    fn a_sum_of_two_products_is_exact_from_two_crosses() {
        let interpolant = through(&[[0.31, 0.62, 0.45], [0.9, 0.95, 0.05]], two_products);
        assert_eq!(interpolant.ranks(), [2; 3]);
        let points = [[0.0, 0.0, 0.0], [0.77, 0.2, 0.4], [0.1, 0.9, 0.99]];
        for (point, value) in points.iter().zip(interpolant.values(&points)) {
            assert!((value - two_products(*point)).abs() < 1e-9, "{point:?} {value}");
        }
        let along = interpolant.along(1, &[[0.3, 0.2], [0.77, 0.4]]);
        for (value, y) in along[1].iter().zip(interpolant.axes[1].places()) {
            assert!((value - two_products([0.77, *y, 0.4])).abs() < 1e-9);
        }
    }

    fn image_of(interpolant: &Interpolant, [height, width]: [usize; 2]) -> Image {
        let pixels = interpolant.pixels([height, width]);
        let mut image = Image::zeros(height, width);
        let rows = image.pixels_mut().chunks_mut(width).enumerate();
        rows.for_each(|(row, values)| pixels.row(row, values));
        image
    }

    /// The integral along z by the trapezoidal rule with the end correction of Euler and Maclaurin.
    fn line(g: impl Fn(f64) -> f64) -> f64 {
        let n = 2000;
        let h = 1.0 / f64::from(n);
        let inner: f64 = (1..n).map(|k| g(f64::from(k) * h)).sum();
        let slope = |z: f64, towards: f64| (g(z + towards * 1e-5) - g(z)) / (towards * 1e-5);
        h * (inner + 0.5 * (g(0.0) + g(1.0))) - h * h / 12.0 * (slope(1.0, -1.0) - slope(0.0, 1.0))
    }

    #[test]
    fn pixels_are_means_of_the_lines() {
        let interpolant = through(&[[0.31, 0.62, 0.45], [0.9, 0.95, 0.05]], two_products);
        let image = image_of(&interpolant, [300, 400]);
        for (row, column) in [(0, 0), (150, 77), (299, 399), (30, 300)] {
            // The pixels are so small that their centres represent them.
            let (x, y) = ((column as f64 + 0.5) / 400.0, (row as f64 + 0.5) / 300.0);
            let middle = line(|z| two_products([x, y, z]));
            assert!((image[(row, column)] - middle).abs() < 2e-5, "{row} {column}");
        }
        // The pixels of a coarse image are exactly the means of those of a fine one.
        let coarse = image_of(&interpolant, [3, 4]);
        let part = |row: usize, column: usize| -> f64 {
            let rows = row * 100..(row + 1) * 100;
            let columns = column * 100..(column + 1) * 100;
            let sum: f64 =
                rows.flat_map(|r| columns.clone().map(move |c| (r, c))).map(|at| image[at]).sum();
            sum / 1e4
        };
        for (row, column) in [(0, 0), (1, 2), (2, 3)] {
            assert!((coarse[(row, column)] - part(row, column)).abs() < 1e-12);
        }
    }
}
