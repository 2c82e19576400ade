//! Orthonormal columns for least squares: Gram–Schmidt with a second pass where the first one cancels digits,
//! which avoids the loss of digits in normal equations, and residuals with the leverage of each value.

/// The share of a column that is left by a pass, from which no second one is needed (Daniel, Gragg, Kaufman and
/// Stewart 1976, doi:10.1090/S0025-5718-1976-0431641-8).
const NOT_CANCELLED: f64 = core::f64::consts::FRAC_1_SQRT_2;

/// Makes a column orthogonal to `others`, which are orthonormal, and of length 1. `on_common` receives,
/// once or twice for each of the others, its number and its component in the column. Returns the length of the
/// orthogonal part; `None` if that is not above the share `least` of the column, which then depends on
/// the others.
pub(crate) fn orthonormalise<'a>(
    column: &mut [f64],
    others: impl Iterator<Item = &'a [f64]> + Clone,
    least: f64,
    mut on_common: impl FnMut(usize, f64),
) -> Option<f64> {
    let size = norm(column);
    let (mut before, mut across) = (size, size);
    for pass in 0..2 {
        if pass > 0 && across > NOT_CANCELLED * before {
            break;
        }
        before = across;
        for (number, other) in others.clone().enumerate() {
            let common = dot(column, other);
            column.iter_mut().zip(other).for_each(|(a, b)| *a -= common * b);
            on_common(number, common);
        }
        across = norm(column);
    }
    if across <= least * size {
        return None;
    }
    column.iter_mut().for_each(|entry| *entry /= across);
    Some(across)
}

/// The residuals of values after a fit of orthonormal columns.
pub(crate) struct Residuals {
    pub(crate) values: Vec<f64>,
    /// 1 − the leverage of each value.
    pub(crate) independence: Vec<f64>,
}

impl Residuals {
    /// Of values before any fit.
    pub(crate) fn new(values: Vec<f64>) -> Self {
        let independence = vec![1.0; values.len()];
        Self { values, independence }
    }

    /// Fits one more column, and returns its component in the values.
    pub(crate) fn fit(&mut self, column: &[f64]) -> f64 {
        let component = dot(&self.values, column);
        for ((residual, independence), entry) in
            self.values.iter_mut().zip(&mut self.independence).zip(column)
        {
            *residual -= component * entry;
            *independence -= entry * entry;
        }
        component
    }

    /// The |difference| of value number `i` from the fit to all others; 1 − its leverage counts as
    /// `least_independence` at least.
    pub(crate) fn left_out(&self, i: usize, least_independence: f64) -> f64 {
        self.values[i].abs() / self.independence[i].max(least_independence)
    }
}

/// The scalar product, as several sums side by side: one alone waits for each addition.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 8;
    let (a, of_a) = a.as_chunks::<SUMS>();
    let (b, of_b) = b.as_chunks::<SUMS>();
    let mut sums = [0.0; SUMS];
    for (a, b) in a.iter().zip(b) {
        for k in 0..SUMS {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = of_a.iter().zip(of_b).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_become_orthonormal_and_dependent_ones_are_refused() {
        let first = [0.6, 0.8, 0.0];
        let others = || core::iter::once(first.as_slice());
        let mut column = vec![1.0, 1.0, 1.0];
        let mut common = 0.0;
        let across = orthonormalise(&mut column, others(), 1e-9, |_, part| common += part);
        assert!((common - 1.4).abs() < 1e-15);
        assert!((across.unwrap() - (3.0_f64 - 1.4 * 1.4).sqrt()).abs() < 1e-15);
        assert!(dot(&column, &first).abs() < 1e-15 && (norm(&column) - 1.0).abs() < 1e-15);
        assert_eq!(orthonormalise(&mut [3.0, 4.0, 0.0], others(), 1e-9, |_, _| ()), None);
        assert_eq!(orthonormalise(&mut [0.0; 3], others(), 1e-9, |_, _| ()), None);
    }

    #[test]
    fn residuals_are_orthogonal_to_the_columns() {
        let column = [0.5; 4];
        let mut residuals = Residuals::new(vec![1.0, 2.0, 3.0, 6.0]);
        assert!((residuals.fit(&column) - 6.0).abs() < 1e-15);
        assert_eq!(residuals.values, [-2.0, -1.0, 0.0, 3.0]);
        assert_eq!(residuals.independence, [0.75; 4]);
        // The mean of the other three values is 2.
        assert!((residuals.left_out(3, 0.05) - 4.0).abs() < 1e-15);
    }
}
