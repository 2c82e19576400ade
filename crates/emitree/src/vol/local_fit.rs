//! Local least squares: a quantity known at scattered places around the origin, expected at it.

/// A value at a place near the origin, where it is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Known {
    /// The place, in units of the distance of the nearest.
    pub(crate) place: [f64; 2],
    pub(crate) value: f64,
}

/// What is expected at the origin, and how wrong that may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Expected {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// Values for a constant, at the least: one can't be checked.
const FOR_CONSTANT: usize = 2;
/// Values for a plane, at the least: two more than it has coefficients.
const FOR_PLANE: usize = 5;
/// Values for a paraboloid, at the least: three more than it has coefficients.
const FOR_PARABOLOID: usize = 9;
/// More values than this, farther away, would only blur the fit.
pub(crate) const MOST_VALUES: usize = 14;
/// The square of the distance at which weights have fallen to a quarter.
const QUARTER_WEIGHT: f64 = 2.0;
/// Added to the diagonal, relative to the sum of the weights: places on a line fit no plane.
const REGULARIZATION: f64 = 1e-9;
/// A pivot below this, relative to the sum of the weights, is none.
const LEAST_PIVOT: f64 = 1e-14;
/// 1 − leverage, at the least: a value that a coefficient is all about can't be left out.
const LEAST_INDEPENDENCE: f64 = 0.1;
/// The origin is no better known than this, relative to the values: they are checked, it is not.
const LEAST_LEVERAGE: f64 = 0.5;
/// Coefficients of a paraboloid.
const MOST_TERMS: usize = 6;

type Matrix = [[f64; MOST_TERMS]; MOST_TERMS];

/// The value at the origin of the constant, plane or paraboloid, as many values as there are allow,
/// that fits those nearby by weighted least squares; `None` if there are too few, or all in one line.
///
/// The error is the largest residual of a value that is left out of the fit, less for values far
/// away, times how much farther from the values than they from each other the origin lies.
pub(crate) fn expected(known: &[Known]) -> Option<Expected> {
    let known = &known[..known.len().min(MOST_VALUES)];
    let terms = match known.len() {
        ..FOR_CONSTANT => return None,
        FOR_CONSTANT..FOR_PLANE => 1,
        FOR_PLANE..FOR_PARABOLOID => 3,
        FOR_PARABOLOID.. => MOST_TERMS,
    };
    let mut normal = Matrix::default();
    let mut right = [0.0; MOST_TERMS];
    for one in known {
        let (weight, basis) = (weight(one.place), basis(one.place));
        for i in 0..terms {
            right[i] += weight * basis[i] * one.value;
            for j in 0..terms {
                normal[i][j] += weight * basis[i] * basis[j];
            }
        }
    }
    let inverse = inverse(normal, terms)?;
    let product = |vector: &[f64; MOST_TERMS], i: usize| -> f64 {
        (0..terms).map(|j| inverse[i][j] * vector[j]).sum()
    };
    let coefficients: [f64; MOST_TERMS] =
        core::array::from_fn(|i| if i < terms { product(&right, i) } else { 0.0 });
    let largest_weight = known.iter().map(|one| weight(one.place)).fold(0.0, f64::max);
    let left_out = known.iter().map(|one| {
        let (weight, basis) = (weight(one.place), basis(one.place));
        let fitted: f64 = basis.iter().zip(&coefficients).map(|(b, c)| b * c).sum();
        let leverage = weight * (0..terms).map(|i| basis[i] * product(&basis, i)).sum::<f64>();
        let independence = (1.0 - leverage).max(LEAST_INDEPENDENCE);
        (one.value - fitted).abs() / independence * (weight / largest_weight).sqrt()
    });
    let leverage = (largest_weight * inverse[0][0]).sqrt().max(LEAST_LEVERAGE);
    Some(Expected { value: coefficients[0], error: left_out.fold(0.0, f64::max) * leverage })
}

fn weight([x, y]: [f64; 2]) -> f64 {
    1.0 / (1.0 + (x * x + y * y) / QUARTER_WEIGHT).powi(2)
}

fn basis([x, y]: [f64; 2]) -> [f64; MOST_TERMS] {
    [1.0, x, y, x * x, x * y, y * y]
}

/// The inverse of the leading `terms` × `terms` part, by Gauss and Jordan with row pivoting.
fn inverse(mut matrix: Matrix, terms: usize) -> Option<Matrix> {
    let scale = matrix[0][0];
    let mut inverse = Matrix::default();
    for i in 0..terms {
        matrix[i][i] += REGULARIZATION * scale;
        inverse[i][i] = 1.0;
    }
    for column in 0..terms {
        let size = |&i: &usize| matrix[i][column].abs();
        let pivot = (column..terms).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        matrix.swap(column, pivot);
        inverse.swap(column, pivot);
        let divisor = matrix[column][column];
        if divisor.abs() < LEAST_PIVOT * scale {
            return None;
        }
        matrix[column].iter_mut().chain(&mut inverse[column]).for_each(|entry| *entry /= divisor);
        let (pivot_row, pivot_inverse) = (matrix[column], inverse[column]);
        for i in (0..terms).filter(|&i| i != column) {
            let times = matrix[i][column];
            for j in 0..terms {
                matrix[i][j] -= times * pivot_row[j];
                inverse[i][j] -= times * pivot_inverse[j];
            }
        }
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(count: u32, value: impl Fn(f64, f64) -> f64) -> Vec<Known> {
        let known = |k: u32| {
            let (angle, distance) = (2.4 * f64::from(k), 1.0 + 0.2 * f64::from(k));
            let (x, y) = (distance * angle.cos(), distance * angle.sin());
            Known { place: [x, y], value: value(x, y) }
        };
        (0..count).map(known).collect()
    }

    #[test]
    fn paraboloids_and_planes_are_reproduced() {
        let paraboloid = |x: f64, y: f64| 0.3 + x - 2.0 * y + 0.5 * x * y - x * x + 0.1 * y * y;
        let found = expected(&around(9, paraboloid)).unwrap();
        assert!((found.value - 0.3).abs() < 1e-6 && found.error < 1e-6, "{found:?}");
        let found = expected(&around(5, |x, y| 0.3 + x - 2.0 * y)).unwrap();
        assert!((found.value - 0.3).abs() < 1e-6 && found.error < 1e-6, "{found:?}");
        let found = expected(&around(2, |_, _| 0.3)).unwrap();
        assert!((found.value - 0.3).abs() < 1e-8 && found.error < 1e-8, "{found:?}");
        assert_eq!(expected(&around(1, |_, _| 0.3)), None);
    }

    #[test]
    fn the_error_covers_what_the_fit_cannot_follow() {
        for count in [2, 4, 6, 9, 14, 20] {
            for bend in [0.01, 0.1, 0.3] {
                let bent = |x: f64, y: f64| (bend * (x + 0.7 * y) + 0.4).sin();
                let found = expected(&around(count, bent)).unwrap();
                let wrong = (found.value - 0.4_f64.sin()).abs();
                assert!(wrong <= found.error, "{count} {bend}: {wrong} {found:?}");
            }
        }
    }
}
