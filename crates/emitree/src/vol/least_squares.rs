//! Local least squares: the value at the origin of a quantity that is given at scattered places
//! around it.

use crate::vol::orthonormal::{Residuals, orthonormalise};
use crate::vol::tuning::TUNING;

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
/// The most values of an estimate: those further away would smooth it.
pub(crate) const MOST_VALUES: usize = 14;
/// The numbers of coefficients of a constant, a plane and a paraboloid.
const CONSTANT: usize = 1;
const PLANE: usize = 3;
const PARABOLOID: usize = 6;
/// A column whose part orthogonal to the former columns is below this share of it depends on those:
/// the places do not determine the polynomial.
const LEAST_INDEPENDENT_PART: f64 = 1e-9;

/// The value at the origin of the constant, plane or paraboloid, depending on the number of values,
/// that fits the nearest values by weighted least squares; `None` if there are too few.
///
/// The error is the largest leave-one-out residual, less for values far away, times the ratio of
/// the uncertainty at the origin to that of the values.
pub(crate) fn estimate(known: &[DataPoint]) -> Option<Estimate> {
    let known = &known[..known.len().min(MOST_VALUES)];
    let terms = match known.len() {
        ..FOR_CONSTANT => return None,
        FOR_CONSTANT..FOR_PLANE => CONSTANT,
        FOR_PLANE..FOR_PARABOLOID => PLANE,
        FOR_PARABOLOID.. => PARABOLOID,
    };
    let weights = known.iter().map(|one| weight(one.place)).collect();
    let mut fit = Fit::new(known.to_vec(), weights);
    // Places on a straight line do not determine a plane: terms across the line are left out.
    for _ in 0..terms {
        fit.add_term();
    }
    let uncertainty = fit.uncertainty().max(TUNING.view.fit_least_leverage);
    let error = fit.largest_residual(TUNING.view.fit_least_independence) * uncertainty;
    Some(Estimate { value: fit.at_origin(), error })
}

fn weight([x, y]: [f64; 2]) -> f64 {
    1.0 / (1.0 + (x * x + y * y) / TUNING.view.fit_quarter_weight).powi(2)
}

/// Weighted least squares, term by term, with orthonormal columns of the design matrix.
struct Fit {
    known: Vec<DataPoint>,
    /// Roots of the weights, the largest of which is 1.
    roots: Vec<f64>,
    /// The number of terms so far, with those that the places do not determine.
    terms: usize,
    /// Orthonormal columns, and the value of each at the origin.
    columns: Vec<(Vec<f64>, f64)>,
    /// The residuals of the values, times the roots of the weights.
    residuals: Residuals,
}

impl Fit {
    /// A fit of no terms to values with these weights.
    fn new(known: Vec<DataPoint>, weights: Vec<f64>) -> Self {
        let largest = weights.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let roots: Vec<f64> = weights.iter().map(|weight| (weight / largest).sqrt()).collect();
        let weighted = known.iter().zip(&roots).map(|(one, root)| one.value * root).collect();
        let columns = Vec::with_capacity(PARABOLOID);
        Self { known, roots, terms: 0, columns, residuals: Residuals::new(weighted) }
    }

    /// Adds the next term, if the places determine it.
    fn add_term(&mut self) {
        let (i, j) = POWERS[self.terms];
        self.terms += 1;
        let of =
            |(one, root): (&DataPoint, &f64)| root * one.place[0].powi(i) * one.place[1].powi(j);
        let mut column: Vec<f64> = self.known.iter().zip(&self.roots).map(of).collect();
        let mut at_origin = if i + j == 0 { 1.0 } else { 0.0 };
        let others = self.columns.iter().map(|(other, _)| other.as_slice());
        let across =
            orthonormalise(&mut column, others, LEAST_INDEPENDENT_PART, |other, common| {
                at_origin -= common * self.columns[other].1;
            });
        let Some(across) = across else { return };
        self.residuals.fit(&column);
        self.columns.push((column, at_origin / across));
    }

    /// The value at the origin.
    fn at_origin(&self) -> f64 {
        self.weights().zip(&self.known).map(|(weight, one)| weight * one.value).sum()
    }

    /// The standard error of the value at the origin over that of the value with the largest weight.
    fn uncertainty(&self) -> f64 {
        self.columns.iter().map(|(_, at_origin)| at_origin * at_origin).sum::<f64>().sqrt()
    }

    /// The largest leave-one-out residual, less for values with small weights; 1 − the leverage of a
    /// value counts as `least_independence` at least.
    fn largest_residual(&self, least_independence: f64) -> f64 {
        let left_out =
            (0..self.known.len()).map(|i| self.residuals.left_out(i, least_independence));
        left_out.fold(0.0, f64::max)
    }

    /// The weight of each value in the value at the origin.
    fn weights(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.known.len()).map(|k| {
            let of_columns = self.columns.iter().map(|(column, at)| column[k] * at);
            self.roots[k] * of_columns.sum::<f64>()
        })
    }
}

/// The powers of x and y in all terms, the constant first.
const POWERS: [(i32, i32); PARABOLOID] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];

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
