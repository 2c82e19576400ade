//! Functions on the unit interval by their values at Chebyshev places, which are nested.
//!
//! Level l has the 2^l + 1 extrema of a Chebyshev polynomial, xᵢ = sin²(π i / 2^(l+1)); each second one
//! is a place of level l − 1. The polynomial through the values there converges as fast as the function
//! is smooth (Trefethen 2013, Approximation Theory and Approximation Practice, chapters 2 to 8). With
//! s = 1 − 2x it is Σ cₖ Tₖ(s).

use core::f64::consts::PI;
use nalgebra::DMatrix;

/// The number of places of a level.
pub(super) fn places(level: u8) -> usize {
    (1 << level) + 1
}

/// Place `i` of a level, the same to the last bit on all levels that have it.
fn place(level: u8, i: usize) -> f64 {
    (PI * i as f64 / (2_u64 << level) as f64).sin().powi(2)
}

/// All places of a level.
pub(super) fn all_places(level: u8) -> Vec<f64> {
    (0..places(level)).map(|i| place(level, i)).collect()
}

/// What the value at each of all `places` of a level counts at `x`: the barycentric formula (Berrut
/// and Trefethen 2004, doi:10.1137/S0036144502417715).
pub(super) fn values_at(places: &[f64], x: f64, weights: &mut [f64]) {
    let last = places.len() - 1;
    let mut sum = 0.0;
    for (i, weight) in weights.iter_mut().enumerate() {
        let distance = x - places[i];
        if distance == 0.0 {
            weights.fill(0.0);
            weights[i] = 1.0;
            return;
        }
        let end = if i == 0 || i == last { 0.5 } else { 1.0 };
        let sign = if i.is_multiple_of(2) { end } else { -end };
        *weight = sign / distance;
        sum += *weight;
    }
    weights.iter_mut().for_each(|weight| *weight /= sum);
}

/// The coefficients of a function from its values at the places of `level`: one row for each
/// polynomial, one column for each place.
pub(super) fn analysis(level: u8) -> DMatrix<f64> {
    let last = places(level) - 1;
    let end = |i: usize| if i == 0 || i == last { 0.5 } else { 1.0 };
    DMatrix::from_fn(last + 1, last + 1, |k, i| {
        // Whole turns are taken off before the product is rounded.
        let turns = (k * i % (2 * last)) as f64 / last as f64;
        2.0 / last as f64 * end(k) * end(i) * (PI * turns).cos()
    })
}

/// The mean of each polynomial below `count` over each of `pixels` equal parts of the interval: one
/// row for each part.
pub(super) fn means(count: usize, pixels: usize) -> DMatrix<f64> {
    let borders: Vec<Vec<f64>> = (0..=pixels)
        .map(|border| antiderivatives(count, 1.0 - 2.0 * border as f64 / pixels as f64))
        .collect();
    // The parts have this length in s, and go towards smaller s.
    let length = 2.0 / pixels as f64;
    DMatrix::from_fn(pixels, count, |pixel, k| (borders[pixel][k] - borders[pixel + 1][k]) / length)
}

/// ∫ Tₖ ds at `s`, for k below `count`.
fn antiderivatives(count: usize, s: f64) -> Vec<f64> {
    let mut polynomials = vec![1.0, s];
    for k in 2..=count {
        polynomials.push(2.0 * s * polynomials[k - 1] - polynomials[k - 2]);
    }
    (0..count)
        .map(|k| match k {
            0 => s,
            1 => 0.5 * s * s,
            _ => {
                let k_f64 = k as f64;
                0.5 * (polynomials[k + 1] / (k_f64 + 1.0) - polynomials[k - 1] / (k_f64 - 1.0))
            }
        })
        .collect()
}

/// The share of the highest coefficients that tells whether there should be more of them.
const TAIL: usize = 6;
/// And their number, at the least: an even function has no odd ones.
const LEAST_TAIL: usize = 3;

/// How large the highest coefficients of a function are, given all of them.
pub(super) fn tail(coefficients: &[f64]) -> f64 {
    let length = (coefficients.len() / TAIL).max(LEAST_TAIL);
    let tail = &coefficients[coefficients.len() - length..];
    tail.iter().map(|coefficient| coefficient.abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    fn sampled(level: u8, f: impl Fn(f64) -> f64) -> DVector<f64> {
        DVector::from_fn(places(level), |i, _| f(place(level, i)))
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
        let values = sampled(3, f);
        let mut weights = vec![0.0; places(3)];
        for x in [0.0, 0.1, 0.5, 0.731, 1.0] {
            values_at(&all_places(3), x, &mut weights);
            let found: f64 = weights.iter().zip(values.iter()).map(|(w, v)| w * v).sum();
            assert!((found - f(x)).abs() < 1e-14, "{x}: {found}");
        }
        let found = means(places(3), 7) * analysis(3) * values;
        for (pixel, found) in found.iter().enumerate() {
            let exact = mean(pixel as f64 / 7.0, (pixel + 1) as f64 / 7.0);
            assert!((found - exact).abs() < 1e-14, "{pixel}: {found} {exact}");
        }
    }

    #[test]
    fn the_tail_tells_whether_a_function_is_resolved() {
        let bell = |x: f64| (-60.0 * (x - 0.4).powi(2)).exp();
        let tails =
            [3, 4, 5].map(|level| tail((analysis(level) * sampled(level, bell)).as_slice()));
        assert!(tails[0] > 0.05 && tails[1] > 0.01 && tails[2] < 1e-5, "{tails:?}");
        let step = |x: f64| if x < 0.37 { 0.0 } else { 1.0 };
        assert!(tail((analysis(7) * sampled(7, step)).as_slice()) > 1e-3);
    }
}
