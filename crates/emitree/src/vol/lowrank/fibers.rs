//! Fibers: G along one axis of the cube, and the functions that they span.
//!
//! Empirical interpolation (Barrault et al. 2004, doi:10.1016/j.crma.2004.08.006): each fiber
//! outside the span of the former ones adds a function, and the place of its largest residual as
//! the *pivot* of that function. A function in the span follows from its values at the pivots.

use crate::vol::lowrank::chebyshev::{Analysis, LANES, Series, all_places, means, places, sums_at};
use core::mem::replace;
use nalgebra::DMatrix;

/// The least level on which the product of a function and a smooth factor is represented: the factor, which may fall
/// by five decades and more, has a series of some 40 terms to rounding.
const LEAST_LEVEL_OF_PRODUCTS: u8 = 7;

/// The fibers along one axis, and the basis that they span.
#[derive(Clone, Debug)]
pub(super) struct Fibers {
    /// The level of the sampled places.
    pub(super) level: u8,
    /// Their coordinates.
    places: Vec<f64>,
    /// The coordinates of the fibers on the other two axes, in ascending order of the axes.
    pub(super) at: Vec<[f64; 2]>,
    /// G at each place of each fiber.
    pub(super) rates: Vec<Vec<f64>>,
    /// The fibers that added a function, in order.
    chosen: Vec<usize>,
    /// The numbers of the pivots among the places.
    pivots: Vec<usize>,
    /// The cardinal functions at the places, a column for each pivot: each is 1 at its pivot and 0
    /// at the others.
    cardinal: DMatrix<f64>,
    /// The cardinal functions as Chebyshev series.
    series: Series,
    /// The transform from values to series.
    analysis: Analysis,
}

impl Fibers {
    pub(super) fn new(level: u8) -> Self {
        Self {
            level,
            places: all_places(level),
            at: Vec::new(),
            rates: Vec::new(),
            chosen: Vec::new(),
            pivots: Vec::new(),
            cardinal: DMatrix::zeros(places(level), 0),
            series: Series::zeros(places(level), 0),
            analysis: Analysis::new(level),
        }
    }

    /// The same functions without the fibers: they are of another G.
    pub(super) fn functions(&self) -> Self {
        Self { at: Vec::new(), rates: Vec::new(), ..self.clone() }
    }

    /// The number of functions.
    pub(super) fn rank(&self) -> usize {
        self.pivots.len()
    }

    /// The coordinates of the pivots.
    pub(super) fn pivots(&self) -> Vec<f64> {
        self.pivots.iter().map(|&i| self.places[i]).collect()
    }

    /// The cardinal functions at all places, a column for each.
    pub(super) fn cardinal(&self) -> &DMatrix<f64> {
        &self.cardinal
    }

    /// The largest [tail](Analysis::tail) of a fiber.
    pub(super) fn tail(&self) -> f64 {
        self.largest_tail(self.level, &self.analysis)
    }

    /// The largest tail expected on the next level. It is extrapolated from the level before: the
    /// logarithm doubles with the number of places (Trefethen 2013, theorem 8.2).
    pub(super) fn next_tail(&self) -> f64 {
        let level_before = self.level - 1;
        let before = self.largest_tail(level_before, &Analysis::new(level_before));
        let now = self.tail();
        if before > 0.0 { now * (now / before).powi(2) } else { 0.0 }
    }

    /// The largest tail of a fiber by its values at the places of `level`.
    fn largest_tail(&self, level: u8, analysis: &Analysis) -> f64 {
        let step = 1 << (self.level - level);
        let of_fiber = |rates: &Vec<f64>| analysis.tail(rates.iter().step_by(step).copied());
        self.rates.iter().map(of_fiber).fold(0.0, f64::max)
    }

    /// Adds a fiber with its rates at all places.
    pub(super) fn add(&mut self, at: [f64; 2], rates: Vec<f64>) {
        self.at.push(at);
        self.rates.push(rates);
    }

    /// Adds a function from the last fiber if its largest residual in view is above `allowed`, given
    /// whether the place at a fiber's coordinates and along it is in view. Returns whether it was
    /// added.
    pub(super) fn extend_basis(
        &mut self,
        allowed: f64,
        is_in_view: impl Fn([f64; 2], f64) -> bool,
    ) -> bool {
        let Some(last) = self.rates.len().checked_sub(1) else { return false };
        let residual = self.unexplained(last);
        let pivot = largest(&residual, |place| is_in_view(self.at[last], self.places[place]));
        let Some(pivot) = pivot.filter(|pivot| residual[*pivot].abs() > allowed) else {
            return false;
        };
        self.push(last, pivot, &residual);
        true
    }

    /// Removes the last fiber, which is in the span of others.
    pub(super) fn drop_last(&mut self) {
        self.at.pop();
        self.rates.pop();
    }

    /// Refines to the next level, given the rates of each fiber at its new places.
    pub(super) fn refine(&mut self, new_rates: &[Vec<f64>]) {
        for (rates, new) in self.rates.iter_mut().zip(new_rates) {
            let mut finer = Vec::with_capacity(rates.len() + new.len());
            for (rate, new) in rates.iter().zip(new) {
                finer.extend([*rate, *new]);
            }
            finer.extend(rates.last());
            *rates = finer;
        }
        self.level += 1;
        self.places = all_places(self.level);
        self.analysis = Analysis::new(self.level);
        // The functions at the new places follow from the same fibers and pivots.
        let chosen = core::mem::take(&mut self.chosen);
        let pivots = core::mem::take(&mut self.pivots);
        self.cardinal = DMatrix::zeros(places(self.level), 0);
        self.series = Series::zeros(places(self.level), 0);
        for (fiber, pivot) in chosen.into_iter().zip(pivots) {
            let residual = self.unexplained(fiber);
            self.push(fiber, 2 * pivot, &residual);
        }
    }

    /// The coordinates of all places.
    pub(super) fn places(&self) -> &[f64] {
        &self.places
    }

    /// The coordinates of the places that the next level adds.
    pub(super) fn new_places(&self) -> Vec<f64> {
        all_places(self.level + 1).into_iter().skip(1).step_by(2).collect()
    }

    /// The residual of a fiber: its values less their interpolant through the pivots.
    fn unexplained(&self, fiber: usize) -> Vec<f64> {
        let rates = &self.rates[fiber];
        let mut residual = rates.clone();
        for (k, &pivot) in self.pivots.iter().enumerate() {
            let function = self.cardinal.column(k);
            residual
                .iter_mut()
                .zip(function.iter())
                .for_each(|(residual, f)| *residual -= rates[pivot] * f);
        }
        // Rounding must not make an existing pivot the largest residual.
        self.pivots.iter().for_each(|&pivot| residual[pivot] = 0.0);
        residual
    }

    fn push(&mut self, fiber: usize, pivot: usize, residual: &[f64]) {
        let scale = 1.0 / residual[pivot];
        let new: Vec<f64> = residual.iter().map(|residual| residual * scale).collect();
        let there: Vec<f64> = self.cardinal.row(pivot).iter().copied().collect();
        let coefficients: Vec<f64> = self.analysis.coefficients(&new).collect();
        let none = || DMatrix::zeros(0, 0);
        let (cardinal, series) =
            (replace(&mut self.cardinal, none()), replace(&mut self.series, none()));
        self.cardinal = with_function(cardinal, &there, &new);
        self.series = with_function(series, &there, &coefficients);
        self.chosen.push(fiber);
        self.pivots.push(pivot);
    }

    /// The functions at the coordinates `x`.
    pub(super) fn functions_at(&self, x: &[f64; LANES], functions: &mut [[f64; LANES]]) {
        sums_at(&self.series, x, functions);
    }

    /// The means of the functions over `pixels` equal parts of the axis: a column for each.
    pub(super) fn means(&self, pixels: usize) -> DMatrix<f64> {
        means(&self.series, pixels)
    }

    /// The means of the products of each function with a smooth `factor`.
    pub(super) fn means_times(&self, factor: &dyn Fn(f64) -> f64, pixels: usize) -> DMatrix<f64> {
        let level = (self.level + 1).max(LEAST_LEVEL_OF_PRODUCTS);
        let (places, analysis) = (all_places(level), Analysis::new(level));
        let mut products = DMatrix::zeros(places.len(), self.rank());
        let mut functions = vec![[0.0; LANES]; self.rank()];
        for (number, group) in places.chunks(LANES).enumerate() {
            let x = core::array::from_fn(|lane| group.get(lane).copied().unwrap_or(0.0));
            self.functions_at(&x, &mut functions);
            for (lane, &x) in group.iter().enumerate() {
                let factor = factor(x);
                for (function, values) in functions.iter().enumerate() {
                    products[(number * LANES + lane, function)] = factor * values[lane];
                }
            }
        }
        let series = |values: &[f64]| analysis.coefficients(values).collect::<Vec<f64>>();
        let columns = products.as_slice().chunks_exact(places.len());
        let coefficients: Vec<f64> = columns.flat_map(series).collect();
        means(&Series::from_vec(places.len(), self.rank(), coefficients), pixels)
    }
}

/// The functions with the `new` one, and the former ones less it times their values `there`, at its
/// pivot.
fn with_function(mut functions: DMatrix<f64>, there: &[f64], new: &[f64]) -> DMatrix<f64> {
    for (mut function, there) in functions.column_iter_mut().zip(there) {
        function.iter_mut().zip(new).for_each(|(f, new)| *f -= there * new);
    }
    let number = functions.ncols();
    let mut functions = functions.insert_column(number, 0.0);
    functions.column_mut(number).copy_from_slice(new);
    functions
}

/// The index of the largest |value| of those in view, the first of equal ones.
pub(super) fn largest(values: &[f64], is_in_view: impl Fn(usize) -> bool) -> Option<usize> {
    let better =
        |best: usize, i: usize| if values[i].abs() > values[best].abs() { i } else { best };
    (0..values.len()).filter(|i| is_in_view(*i)).reduce(better)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fiber(level: u8, f: impl Fn(f64) -> f64) -> Vec<f64> {
        all_places(level).into_iter().map(f).collect()
    }

    fn mixed(a: f64, b: f64) -> impl Fn(f64) -> f64 {
        move |x: f64| a * (3.0 * x).sin() + b * (-4.0 * x).exp()
    }

    #[test]
    fn what_is_in_the_span_follows_from_its_pivots() {
        let mut fibers = Fibers::new(4);
        for (a, b) in [(1.0, 0.0), (0.3, 1.0)] {
            fibers.add([a, b], fiber(4, mixed(a, b)));
            assert!(fibers.extend_basis(1e-10, |_, _| true));
        }
        fibers.add([0.5, 0.5], fiber(4, mixed(-0.2, 0.7)));
        assert!(!fibers.extend_basis(1e-10, |_, _| true));
        assert_eq!(fibers.rank(), 2);
        // The same holds on the next level, and between its places.
        let new = fibers.new_places();
        let rates: Vec<Vec<f64>> = [(1.0, 0.0), (0.3, 1.0), (-0.2, 0.7)]
            .map(|(a, b)| new.iter().map(|&x| mixed(a, b)(x)).collect())
            .into();
        fibers.refine(&rates);
        assert_eq!(fibers.rates[2], fiber(5, mixed(-0.2, 0.7)));
        let mut functions = [[0.0; LANES]; 2];
        let wanted = mixed(0.9, 0.4);
        let x = core::array::from_fn(|lane| lane as f64 / (LANES - 1) as f64);
        fibers.functions_at(&x, &mut functions);
        for (lane, x) in x.into_iter().enumerate() {
            let at_pivots = functions.iter().zip(fibers.pivots());
            let found: f64 = at_pivots.map(|(f, at)| f[lane] * wanted(at)).sum();
            assert!((found - wanted(x)).abs() < 1e-10, "{x}: {found}");
        }
    }

    #[test]
    fn means_of_products_with_a_factor_are_those_of_the_products() {
        let mut fibers = Fibers::new(4);
        let f = |x: f64| (-11.0 * x).exp() * (1.0 + 0.5 * (3.0 * x).sin());
        fibers.add([0.0; 2], fiber(4, |x| (11.0 * x).exp() * f(x)));
        assert!(fibers.extend_basis(1e-10, |_, _| true));
        let at = fibers.pivots()[0];
        let means = fibers.means_times(&|x| (-11.0 * x).exp(), 20);
        for pixel in 0..20 {
            let middle = |k: usize| (pixel as f64 + (k as f64 + 0.5) / 200.0) / 20.0;
            let exact = (0..200).map(|k| f(middle(k))).sum::<f64>() / 200.0;
            let found = means[(pixel, 0)] * (11.0 * at).exp() * f(at);
            // The midpoint rule is accurate to 1e-6, and fibers to as much in their own scale.
            assert!((found / exact - 1.0).abs() < 1e-4, "{pixel}: {found} {exact}");
        }
    }

    #[test]
    fn a_residual_out_of_view_adds_no_function() {
        let mut fibers = Fibers::new(4);
        fibers.add([0.0; 2], fiber(4, |x| 1.0 + x));
        assert!(fibers.extend_basis(1e-10, |_, along| along < 0.5));
        // The pivot is in view, although values beyond are larger.
        assert!(fibers.pivots()[0] < 0.5);
        let beyond = |x: f64| 1.0 + x + 5.0 * (x - 0.5).max(0.0);
        fibers.add([0.3, 0.7], fiber(4, beyond));
        assert!(!fibers.extend_basis(1e-10, |_, along| along < 0.5));
        assert!(!fibers.extend_basis(1e-10, |[a, b], _| a > b));
        assert_eq!(fibers.rank(), 1);
        assert!(fibers.extend_basis(1e-10, |[a, b], _| a < b));
        assert_eq!(fibers.rank(), 2);
        assert_eq!(largest(&[1.0, -3.0, 2.0, 3.0], |_| true), Some(1));
        assert_eq!(largest(&[1.0, -3.0, 2.0, 3.0], |i| i % 2 == 0), Some(2));
        assert_eq!(largest(&[1.0], |_| false), None);
    }

    #[test]
    fn a_step_is_never_resolved() {
        let mut fibers = Fibers::new(5);
        fibers.add([0.0; 2], fiber(5, |x| (2.0 * x).cos()));
        assert!(fibers.tail() < 1e-9 && fibers.next_tail() < 1e-9);
        fibers.add([0.0; 2], fiber(5, |x| if x < 0.4 { 1.0 } else { 0.0 }));
        assert!(fibers.tail() > 1e-2 && fibers.next_tail() > 1e-2);
    }

    #[test]
    fn the_tail_of_the_next_level_is_extrapolated() {
        let core = |x: f64| 1.0 / (1.0 + ((x - 0.43) / 0.1).powi(2));
        let tail_at = |level: u8| {
            let mut fibers = Fibers::new(level);
            fibers.add([0.0; 2], fiber(level, core));
            [fibers.tail(), fibers.next_tail()]
        };
        let ([_, expected], [found, _]) = (tail_at(5), tail_at(6));
        assert!((0.2..5.0).contains(&(found / expected)), "{found} {expected}");
    }
}
