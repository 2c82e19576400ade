//! Local least squares: the value at the origin of a quantity that is given at scattered places
//! around it.

use crate::vol::tuning::TUNING;
use nalgebra::{SMatrix, SVector};

/// A value at a place around the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DataPoint {
    /// The place, in units of the distance of the nearest one.
    pub(crate) place: [f64; 2],
    pub(crate) value: f64,
}

/// The estimated value at the origin, and its expected |error|.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// The fewest values for a constant: with one there is no residual.
const FOR_CONSTANT: usize = 2;
/// The fewest values for a plane: two more than it has coefficients.
const FOR_PLANE: usize = 5;
/// The fewest values for a paraboloid: three more than it has coefficients.
const FOR_PARABOLOID: usize = 9;
/// The most values of a fit: those further away would smooth it.
pub(crate) const MOST_VALUES: usize = 14;
/// The value added to the diagonal, relative to the sum of the weights: places on a straight line
/// do not determine a plane.
const REGULARIZATION: f64 = 1e-9;
/// The numbers of coefficients of a constant, a plane and a paraboloid.
const CONSTANT: usize = 1;
const PLANE: usize = 3;
const PARABOLOID: usize = 6;

/// The value at the origin of the constant, plane or paraboloid, depending on the number of values,
/// that fits the nearest values by weighted least squares; `None` if there are too few.
///
/// The error is the largest leave-one-out residual, less for values far away, times the ratio of
/// the uncertainty at the origin to that of the values.
pub(crate) fn estimate(known: &[DataPoint]) -> Option<Estimate> {
    let known = &known[..known.len().min(MOST_VALUES)];
    match known.len() {
        ..FOR_CONSTANT => None,
        FOR_CONSTANT..FOR_PLANE => fitted::<CONSTANT>(known),
        FOR_PLANE..FOR_PARABOLOID => fitted::<PLANE>(known),
        FOR_PARABOLOID.. => fitted::<PARABOLOID>(known),
    }
}

/// The value at the origin, and its error, of a polynomial with `TERMS` terms.
fn fitted<const TERMS: usize>(known: &[DataPoint]) -> Option<Estimate> {
    let mut normal = SMatrix::<f64, TERMS, TERMS>::zeros();
    let mut right = SVector::<f64, TERMS>::zeros();
    for one in known {
        let (weight, basis) = (weight(one.place), basis::<TERMS>(one.place));
        normal.ger(weight, &basis, &basis, 1.0);
        right.axpy(weight * one.value, &basis, 1.0);
    }
    normal += SMatrix::from_diagonal_element(REGULARIZATION * normal[0]);
    let inverse = normal.cholesky()?.inverse();
    let coefficients = inverse * right;
    let largest_weight = known.iter().map(|one| weight(one.place)).fold(0.0, f64::max);
    let left_out = known.iter().map(|one| {
        let (weight, basis) = (weight(one.place), basis::<TERMS>(one.place));
        let leverage = weight * basis.dot(&(inverse * basis));
        let independence = (1.0 - leverage).max(TUNING.view.fit_least_independence);
        let residual = one.value - basis.dot(&coefficients);
        residual.abs() / independence * (weight / largest_weight).sqrt()
    });
    let leverage = (largest_weight * inverse[0]).sqrt().max(TUNING.view.fit_least_leverage);
    Some(Estimate { value: coefficients[0], error: left_out.fold(0.0, f64::max) * leverage })
}

fn weight([x, y]: [f64; 2]) -> f64 {
    1.0 / (1.0 + (x * x + y * y) / TUNING.view.fit_quarter_weight).powi(2)
}

/// The first terms of a quadratic polynomial, the constant first.
fn basis<const TERMS: usize>([x, y]: [f64; 2]) -> SVector<f64, TERMS> {
    SVector::from_column_slice(&[1.0, x, y, x * x, x * y, y * y][..TERMS])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(count: u32, value: impl Fn(f64, f64) -> f64) -> Vec<DataPoint> {
        let known = |k: u32| {
            let (angle, distance) = (2.4 * f64::from(k), 1.0 + 0.2 * f64::from(k));
            let (x, y) = (distance * angle.cos(), distance * angle.sin());
            DataPoint { place: [x, y], value: value(x, y) }
        };
        (0..count).map(known).collect()
    }

    #[test]
    fn paraboloids_and_planes_are_reproduced() {
        let paraboloid = |x: f64, y: f64| 0.3 + x - 2.0 * y + 0.5 * x * y - x * x + 0.1 * y * y;
        let found = estimate(&around(9, paraboloid)).unwrap();
        assert!((found.value - 0.3).abs() < 1e-6 && found.error < 1e-6, "{found:?}");
        let found = estimate(&around(5, |x, y| 0.3 + x - 2.0 * y)).unwrap();
        assert!((found.value - 0.3).abs() < 1e-6 && found.error < 1e-6, "{found:?}");
        let found = estimate(&around(2, |_, _| 0.3)).unwrap();
        assert!((found.value - 0.3).abs() < 1e-8 && found.error < 1e-8, "{found:?}");
        assert_eq!(estimate(&around(1, |_, _| 0.3)), None);
    }

    #[test]
    fn places_on_a_line_are_fitted_along_it() {
        for count in [5, 9] {
            let along = (1..=count).map(|k| f64::from(k) * if k % 2 == 0 { 0.5 } else { -1.0 });
            let known = along.map(|x| DataPoint { place: [x, 2.0 * x], value: 0.3 + x });
            let found = estimate(&known.collect::<Vec<_>>()).unwrap();
            assert!((found.value - 0.3).abs() < 1e-6 && found.error < 1e-5, "{found:?}");
        }
    }

    #[test]
    fn the_error_covers_what_the_fit_cannot_follow() {
        for count in [2, 4, 6, 9, 14, 20] {
            for bend in [0.01, 0.1, 0.3] {
                let bent = |x: f64, y: f64| (bend * (x + 0.7 * y) + 0.4).sin();
                let found = estimate(&around(count, bent)).unwrap();
                let wrong = (found.value - 0.4_f64.sin()).abs();
                assert!(wrong <= found.error, "{count} {bend}: {wrong} {found:?}");
            }
        }
    }
}
