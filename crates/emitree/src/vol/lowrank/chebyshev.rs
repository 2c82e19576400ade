//! Functions on the unit interval by their values at nested Chebyshev places.
//!
//! Level l has the 2^l + 1 extrema of a Chebyshev polynomial, xᵢ = sin²(π i / 2^(l+1)); every
//! second one is a place of level l − 1. The polynomial through the values there converges at a
//! rate determined by the smoothness of the function (Trefethen 2013, Approximation Theory and
//! Approximation Practice, chapters 2 to 8). With s = 1 − 2x it is Σ cₖ Tₖ(s).

use crate::vol::tuning::TUNING;
use core::f64::consts::PI;
use core::ops::RangeInclusive;
use multiversion::multiversion;
use nalgebra::DMatrix;

/// The number of places of a level.
pub(super) fn places(level: u8) -> usize {
    (1 << level) + 1
}

/// Place `i` of a level, bit-identical on all levels that have it.
fn place(level: u8, i: usize) -> f64 {
    (PI * i as f64 / (2_u64 << level) as f64).sin().powi(2)
}

/// All places of a level.
pub(super) fn all_places(level: u8) -> Vec<f64> {
    (0..places(level)).map(|i| place(level, i)).collect()
}

/// The transform from values at the places of one level to coefficients.
#[derive(Clone, Debug)]
pub(super) struct Analysis {
    /// The number of the last place, and the degree of the last polynomial.
    last: usize,
    /// cos(π j / `last`) over one period.
    cosines: Vec<f64>,
}

impl Analysis {
    pub(super) fn new(level: u8) -> Self {
        let last = places(level) - 1;
        let cosine = |j: usize| (PI * (j as f64 / last as f64)).cos();
        Self { last, cosines: (0..2 * last).map(cosine).collect() }
    }

    /// The coefficient of Tₖ of the polynomial with these `values` at the places.
    fn coefficient(&self, k: usize, values: impl Iterator<Item = f64>) -> f64 {
        let end = |i: usize| if i == 0 || i == self.last { 0.5 } else { 1.0 };
        let (norm, around) = (2.0 / self.last as f64 * end(k), 2 * self.last - 1);
        // The number of cosines is a power of two, so that a mask reduces the index modulo the
        // period.
        let weight = |i: usize| norm * end(i) * self.cosines[(k * i) & around];
        values.enumerate().map(|(i, value)| weight(i) * value).sum()
    }

    /// All coefficients of the polynomial with these `values` at the places.
    pub(super) fn coefficients<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        (0..=self.last).map(|k| self.coefficient(k, values.iter().copied()))
    }

    /// The sum of the |coefficients| of the highest degrees.
    pub(super) fn tail(&self, values: impl Iterator<Item = f64> + Clone) -> f64 {
        self.highest().map(|k| self.coefficient(k, values.clone()).abs()).sum()
    }

    /// The highest degrees: they show whether a function is resolved.
    fn highest(&self) -> RangeInclusive<usize> {
        let length =
            ((self.last + 1) / TUNING.lowrank.tail_divisor).max(TUNING.lowrank.least_tail_length);
        self.last + 1 - length..=self.last
    }

    /// The integral over the unit interval of the function with these `values` at the places, and the
    /// error that the [tail](Self::tail) may stand for: the integral of Tₖ is below 1/k.
    pub(super) fn integral(&self, values: &[f64]) -> [f64; 2] {
        let of_degree =
            |(k, c): (usize, f64)| if k % 2 == 0 { c / (1.0 - (k * k) as f64) } else { 0.0 };
        let integral = self.coefficients(values).enumerate().map(of_degree).sum();
        let lowest = (*self.highest().start()).max(1) as f64;
        [integral, self.tail(values.iter().copied()) / lowest]
    }
}

/// Several sums Σ cₖ Tₖ, with a column of coefficients for each.
pub(super) type Series = DMatrix<f64>;

/// The number of coordinates at which sums are evaluated together.
pub(super) const LANES: usize = 32;
/// The coordinates and the sums of one recurrence: as many as fit in 16 registers of four numbers, and enough to hide
/// the latency of each step.
const COORDINATES: usize = 8;
const TOGETHER: usize = 3;

/// Writes each sum at the coordinates `x` to `sums`, with Clenshaw's recurrence.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(super) fn sums_at(series: &Series, x: &[f64; LANES], sums: &mut [[f64; LANES]]) {
    let (count, rows) = (sums.len().min(series.ncols()), series.nrows().max(1));
    let column = |k: usize| &series.as_slice()[k * rows..][..rows];
    for first in (0..count).step_by(TOGETHER) {
        // Where fewer are left, the last one is computed several times.
        let of_all: [&[f64]; TOGETHER] =
            core::array::from_fn(|k| column((first + k).min(count - 1)));
        for at in (0..LANES).step_by(COORDINATES) {
            let twice_s: [f64; COORDINATES] = core::array::from_fn(|lane| 2.0 - 4.0 * x[at + lane]);
            let mut now = [[0.0; COORDINATES]; TOGETHER];
            let mut before = [[0.0; COORDINATES]; TOGETHER];
            for row in (1..rows).rev() {
                for k in 0..TOGETHER {
                    let c = of_all[k][row];
                    for lane in 0..COORDINATES {
                        let next = c + twice_s[lane] * now[k][lane] - before[k][lane];
                        (before[k][lane], now[k][lane]) = (now[k][lane], next);
                    }
                }
            }
            for (k, sum) in sums[first..count].iter_mut().take(TOGETHER).enumerate() {
                for lane in 0..COORDINATES {
                    sum[at + lane] =
                        of_all[k][0] + 0.5 * twice_s[lane] * now[k][lane] - before[k][lane];
                }
            }
        }
    }
}

/// The means of each sum over `pixels` equal parts of the interval: a column for each sum.
pub(super) fn means(series: &Series, pixels: usize) -> DMatrix<f64> {
    let mut means = DMatrix::zeros(pixels, series.ncols());
    // The borders of the parts in s, in descending order.
    let s: Vec<f64> =
        (0..=pixels).map(|border| 1.0 - 2.0 * border as f64 / pixels as f64).collect();
    let length = 2.0 / pixels as f64;
    let (mut before, mut polynomial, mut next) = (s.clone(), vec![1.0; pixels + 1], s.clone());
    let mut antiderivative = s.clone();
    for (k, coefficients) in series.row_iter().enumerate() {
        match k {
            0 => {}
            1 => antiderivative.iter_mut().zip(&s).for_each(|(a, s)| *a = 0.5 * s * s),
            _ => integrate(k as f64, &before, &next, &mut antiderivative),
        }
        for (mut means, c) in means.column_iter_mut().zip(coefficients.iter()) {
            add_differences(means.as_mut_slice(), c / length, &antiderivative);
        }
        // T_{k+2} replaces T_{k-1}, and the three vectors are renamed for the next k.
        ascend(&s, &polynomial, &next, &mut before);
        core::mem::swap(&mut before, &mut polynomial);
        core::mem::swap(&mut polynomial, &mut next);
    }
    means
}

/// The antiderivative of Tₖ in s for k ≥ 2, from T_{k-1} and T_{k+1}.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn integrate(k: f64, before: &[f64], next: &[f64], antiderivative: &mut [f64]) {
    let (of_next, of_before) = (0.5 / (k + 1.0), 0.5 / (k - 1.0));
    for (value, (next, before)) in antiderivative.iter_mut().zip(next.iter().zip(before)) {
        *value = of_next * next - of_before * before;
    }
}

/// The Chebyshev polynomial that follows `polynomial` and `next`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn ascend(s: &[f64], polynomial: &[f64], next: &[f64], after: &mut [f64]) {
    for (after, (s, (polynomial, next))) in
        after.iter_mut().zip(s.iter().zip(polynomial.iter().zip(next)))
    {
        *after = 2.0 * s * next - polynomial;
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn add_differences(sums: &mut [f64], weight: f64, values: &[f64]) {
    for (sum, (from, to)) in sums.iter_mut().zip(values.iter().zip(&values[1..])) {
        *sum += weight * (from - to);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    fn sampled(level: u8, f: impl Fn(f64) -> f64) -> Vec<f64> {
        all_places(level).into_iter().map(f).collect()
    }

    fn series(level: u8, f: impl Fn(f64) -> f64) -> DVector<f64> {
        let values = sampled(level, f);
        DVector::from_iterator(places(level), Analysis::new(level).coefficients(&values))
    }

    #[test]
    fn places_are_nested_to_the_last_bit() {
        for level in 1..9 {
            for i in 0..places(level) {
                assert_eq!(place(level, i).to_bits(), place(level + 1, 2 * i).to_bits());
            }
        }
        assert_eq!([place(4, 0), place(4, 16)].map(f64::to_bits), [0.0_f64, 1.0].map(f64::to_bits));
    }

    #[test]
    fn polynomials_are_exact_between_the_places_and_in_the_mean() {
        let f = |x: f64| 3.0 * x.powi(8) - x.powi(3) + 0.2;
        let mean = |from: f64, to: f64| {
            let integral = |x: f64| x.powi(9) / 3.0 - x.powi(4) / 4.0 + 0.2 * x;
            (integral(to) - integral(from)) / (to - from)
        };
        let series = Series::from_columns(&[series(3, f)]);
        let mut found = [[0.0; LANES]];
        let x = core::array::from_fn(|lane| lane as f64 / (LANES - 1) as f64);
        sums_at(&series, &x, &mut found);
        for (x, found) in x.into_iter().zip(found[0]) {
            assert!((found - f(x)).abs() < 1e-14, "{x}: {found}");
        }
        for (pixel, found) in means(&series, 7).iter().enumerate() {
            let exact = mean(pixel as f64 / 7.0, (pixel + 1) as f64 / 7.0);
            assert!((found - exact).abs() < 1e-14, "{pixel}: {found} {exact}");
        }
    }

    #[test]
    fn integrals_are_exact_for_polynomials_and_known_for_others() {
        let [integral, error] = Analysis::new(3).integral(&sampled(3, |x| 3.0 * x.powi(4) - x));
        assert!((integral - 0.1).abs() < 1e-14 && error < 1e-14, "{integral} {error}");
        let bell = |x: f64| (-60.0 * (x - 0.4).powi(2)).exp();
        // ∫ exp(-60 t²) dt over all t; the ends are 1e-5 of it away.
        let exact = (PI / 60.0).sqrt() - 1e-6;
        for level in 3..6 {
            let [integral, error] = Analysis::new(level).integral(&sampled(level, bell));
            assert!((integral - exact).abs() < error + 5e-6, "{level}: {integral} {exact} {error}");
        }
    }

    #[test]
    fn the_tail_shows_whether_a_function_is_resolved() {
        let bell = |x: f64| (-60.0 * (x - 0.4).powi(2)).exp();
        let tail = |level: u8, f: &dyn Fn(f64) -> f64| {
            Analysis::new(level).tail(sampled(level, f).into_iter())
        };
        let tails = [3, 4, 5].map(|level| tail(level, &bell));
        assert!(tails[0] > 0.05 && tails[1] > 0.01 && tails[2] < 1e-5, "{tails:?}");
        let step = |x: f64| if x < 0.37 { 0.0 } else { 1.0 };
        assert!(tail(7, &step) > 1e-3);
    }
}
