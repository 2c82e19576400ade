//! Rates between known ones: an interpolant of the nearest known points.
//!
//! Cubic radial functions with a linear polynomial pass through the rates of the nearest points
//! (Wendland, *Scattered Data Approximation*, Cambridge 2005, chapter 8). The nearest points are taken from each
//! orthant around a place, since known points lie densely along lines. Rates that span orders of magnitude are better
//! interpolated in their logarithm; which of the two is better is tested on known points, each without itself.

use crate::exchange::Batch;
use crate::parallel::prelude::*;
use nalgebra::{DMatrix, DVector};

/// The nearest points of each orthant. Fewer make the interpolant less accurate; more take time, which grows with the
/// cube of their number.
const NEAREST: usize = 5;
/// The same with energies, where there are twice as many orthants.
const NEAREST_WITH_ENERGIES: usize = 3;
/// The fewest points that are interpolated; with fewer all rates are the same.
const FEWEST: usize = 16;
/// Known points by which logarithms are compared with numbers.
const COMPARED: usize = 64;
/// How far an interpolated rate may be beyond those of the nearest points, as a share of their range.
const BEYOND: f64 = 0.5;

/// A position, and the energy or 0.
type Place = [f64; 4];

/// Known rates, in the order in which they became known.
#[derive(Debug, Default)]
pub(super) struct Surrogate {
    places: Vec<Place>,
    rates: Vec<f64>,
    has_energies: bool,
}

impl Surrogate {
    /// Adds known rates.
    pub(super) fn add(&mut self, batch: &Batch) {
        self.has_energies |= !batch.energies.is_empty();
        self.places.extend((0..batch.len()).map(|i| place(batch, i)));
        self.rates.extend(&batch.rates);
    }

    /// The number of known rates.
    pub(super) fn len(&self) -> usize {
        self.rates.len()
    }

    /// The interpolant of all rates.
    pub(super) fn interpolant(&self) -> Interpolant<'_> {
        let extent = |axis: usize| {
            let along = || self.places.iter().map(|place| place[axis]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        let of_positions = (0..3).map(extent).fold(0.0, f64::max);
        let of_energies = extent(3);
        // A step along the whole energy axis is as long as one across all positions.
        let of_energy = if of_energies > 0.0 { of_positions / of_energies } else { 0.0 };
        let scaled = |&[x, y, z, energy]: &Place| [x, y, z, energy * of_energy];
        let mut interpolant = Interpolant {
            places: self.places.iter().map(scaled).collect(),
            rates: &self.rates,
            axes: if self.has_energies { 4 } else { 3 },
            of_energy,
            is_logarithmic: false,
        };
        interpolant.choose();
        interpolant
    }
}

fn place(batch: &Batch, i: usize) -> Place {
    let [x, y, z] = batch.positions[i];
    [x, y, z, batch.energies.get(i).copied().unwrap_or(0.0)]
}

/// An interpolant of known rates.
pub(super) struct Interpolant<'a> {
    places: Vec<Place>,
    rates: &'a [f64],
    axes: usize,
    /// The factor on energies.
    of_energy: f64,
    is_logarithmic: bool,
}

/// A rate interpolated as a number, and in its logarithm.
#[derive(Clone, Copy)]
struct Both {
    of_numbers: f64,
    of_logarithms: f64,
}

impl Interpolant<'_> {
    /// The rates at the points of a batch.
    pub(super) fn rates(&self, batch: &Batch) -> Vec<f64> {
        let rate = |i: usize| {
            let [x, y, z, energy] = place(batch, i);
            let both = self.both([x, y, z, energy * self.of_energy], None);
            if self.is_logarithmic { both.of_logarithms } else { both.of_numbers }
        };
        (0..batch.len()).into_par_iter().map(rate).collect()
    }

    /// Tests on known points which of the two interpolants is better.
    fn choose(&mut self) {
        let step = (self.rates.len() / COMPARED).max(1);
        let mut squares = [0.0; 2];
        for left_out in (0..self.rates.len()).step_by(step) {
            let Both { of_numbers, of_logarithms } =
                self.both(self.places[left_out], Some(left_out));
            let errors = [of_numbers, of_logarithms].map(|rate| rate - self.rates[left_out]);
            squares.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error * error);
        }
        self.is_logarithmic = squares[1] < squares[0];
    }

    /// The rate at a place, without the known one that is left out.
    fn both(&self, at: Place, left_out: Option<usize>) -> Both {
        let same = |rate: f64| Both { of_numbers: rate, of_logarithms: rate };
        if self.rates.len() < FEWEST {
            return same(1.0);
        }
        let near = self.nearest(&at, left_out);
        let Some(&(nearest, first)) = near.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return same(1.0);
        };
        let Some(weights) = (nearest > 0.0).then(|| self.weights(&at, &near)).flatten() else {
            return same(self.rates[first]);
        };
        let rates = || near.iter().map(|(_, i)| self.rates[*i]);
        let (least, most) = rates()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), of| {
                (least.min(of), most.max(of))
            });
        let beyond = BEYOND * (most - least);
        let lowest = if least >= 0.0 { 0.0_f64.max(least - beyond) } else { least - beyond };
        let sum = |of: &dyn Fn(f64) -> f64| -> f64 {
            rates().zip(weights.iter()).map(|(rate, weight)| weight * of(rate)).sum()
        };
        let within =
            |rate: f64| if rate.is_finite() { rate.clamp(lowest, most + beyond) } else { least };
        let of_numbers = within(sum(&|rate| rate));
        let of_logarithms = if least > 0.0 { within(sum(&f64::ln).exp()) } else { of_numbers };
        Both { of_numbers, of_logarithms }
    }

    /// The nearest known points in each orthant around a place, with the squares of their distances.
    fn nearest(&self, at: &Place, left_out: Option<usize>) -> Vec<(f64, usize)> {
        let number = if self.axes == 3 { NEAREST } else { NEAREST_WITH_ENERGIES };
        let mut orthants = vec![Vec::with_capacity(number + 1); 1 << self.axes];
        for (i, place) in self.places.iter().enumerate() {
            let offset: Place = core::array::from_fn(|axis| place[axis] - at[axis]);
            let square: f64 = offset.iter().map(|of| of * of).sum();
            let orthant: usize =
                (0..self.axes).map(|axis| usize::from(offset[axis] > 0.0) << axis).sum();
            let near: &mut Vec<(f64, usize)> = &mut orthants[orthant];
            let is_near = near.len() < number || near.last().is_some_and(|last| square < last.0);
            if is_near && left_out != Some(i) {
                let rank = near.partition_point(|of| of.0 <= square);
                near.insert(rank, (square, i));
                near.truncate(number);
            }
        }
        orthants.concat()
    }

    /// The weights of the rates of some points in the interpolant at a place; `None` if they determine none.
    fn weights(&self, at: &Place, near: &[(f64, usize)]) -> Option<DVector<f64>> {
        let scale = near.iter().fold(0.0, |most: f64, of| most.max(of.0)).sqrt();
        let offset = |i: usize| -> Place {
            core::array::from_fn(|axis| (self.places[i][axis] - at[axis]) / scale)
        };
        let offsets: Vec<Place> = near.iter().map(|(_, i)| offset(*i)).collect();
        let (points, polynomials) = (near.len(), 1 + self.axes);
        let cube = |a: &Place, b: &Place| {
            let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
            square * square.sqrt()
        };
        let polynomial = |of: usize, place: &Place| if of == 0 { 1.0 } else { place[of - 1] };
        let entry = |row: usize, column: usize| match (row < points, column < points) {
            (true, true) => cube(&offsets[row], &offsets[column]),
            (true, false) => polynomial(column - points, &offsets[row]),
            (false, true) => polynomial(row - points, &offsets[column]),
            (false, false) => 0.0,
        };
        let size = points + polynomials;
        let system = DMatrix::from_fn(size, size, entry);
        let of_place = |row: usize| match row < points {
            true => cube(&offsets[row], &[0.0; 4]),
            false => polynomial(row - points, &[0.0; 4]),
        };
        system.lu().solve(&DVector::from_fn(size, |row, _| of_place(row)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::lattice;

    fn batch(points: core::ops::Range<usize>, g: impl Fn([f64; 3]) -> f64) -> Batch {
        let positions: Vec<[f64; 3]> = points.map(lattice::point).collect();
        Batch {
            directions: vec![[0.0, 0.0, 1.0]; positions.len()],
            rates: positions.iter().map(|position| g(*position)).collect(),
            positions,
            ..Batch::default()
        }
    }

    /// The largest difference from g at points that are not known.
    fn largest_error(g: impl Fn([f64; 3]) -> f64) -> f64 {
        let mut known = Surrogate::default();
        known.add(&batch(0..1000, &g));
        let others = batch(1000..1200, &g);
        let found = known.interpolant().rates(&others);
        found.iter().zip(&others.rates).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_linear_function_and_known_rates_are_exact() {
        assert!(largest_error(|[x, y, z]| 3.0 + x - 2.0 * y + 0.5 * z) < 1e-9);
        let mut known = Surrogate::default();
        let points = batch(0..100, |[x, y, z]| (9.0 * x * y * z).sin());
        known.add(&points);
        assert_eq!(known.interpolant().rates(&points), points.rates);
    }

    #[test]
    fn a_narrow_peak_is_interpolated_in_its_logarithm() {
        let peak = |[x, y, z]: [f64; 3]| {
            let square = (x - 0.4).powi(2) + (y - 0.5).powi(2) + (z - 0.6).powi(2);
            (-30.0 * square).exp()
        };
        let mut known = Surrogate::default();
        known.add(&batch(0..1000, peak));
        assert!(known.interpolant().is_logarithmic);
        assert!(largest_error(peak) < 0.03, "{}", largest_error(peak));
    }

    #[test]
    fn few_rates_are_not_interpolated() {
        let mut known = Surrogate::default();
        known.add(&batch(0..3, |_| 7.0));
        let found = known.interpolant().rates(&batch(5..7, |_| 0.0));
        assert_eq!(found, [1.0, 1.0]);
    }
}
