//! Least squares column by column, with the leave-one-out residuals of each number of columns.

use crate::vol::orthonormal::{Residuals, orthonormalise};

/// A column whose part orthogonal to the former ones is below this share of it depends on those.
const LEAST_INDEPENDENT_PART: f64 = 1e-8;
/// The least 1 − leverage of a value in its leave-one-out residual.
const LEAST_INDEPENDENCE: f64 = 0.05;

/// Orthonormal columns, and the residuals of values after them.
pub(super) struct Columns {
    /// All columns after each other.
    columns: Vec<f64>,
    /// For each column its combination of the orthonormal ones, after each other: one entry more for
    /// each.
    upper: Vec<f64>,
    /// The components of the values along the columns.
    components: Vec<f64>,
    residuals: Residuals,
}

impl Columns {
    /// No columns, with room for so many, for values that are weighted already.
    pub(super) fn new(values: Vec<f64>, most: usize) -> Self {
        let columns = Vec::with_capacity(most * values.len());
        let upper = Vec::with_capacity(most * (most + 1) / 2);
        let components = Vec::with_capacity(most);
        Self { columns, upper, components, residuals: Residuals::new(values) }
    }

    /// Adds a column. Returns whether it is independent of the former ones.
    pub(super) fn add(&mut self, column: impl Iterator<Item = f64>) -> bool {
        let (former, first) = (self.columns.len(), self.upper.len());
        self.columns.extend(column);
        self.upper.resize(first + self.components.len(), 0.0);
        let (others, column) = self.columns.split_at_mut(former);
        let of_column = &mut self.upper[first..];
        let others = others.chunks_exact(column.len().max(1));
        let across = orthonormalise(column, others, LEAST_INDEPENDENT_PART, |other, common| {
            of_column[other] += common;
        });
        let Some(across) = across else {
            self.columns.truncate(former);
            self.upper.truncate(first);
            return false;
        };
        self.upper.push(across);
        self.components.push(self.residuals.fit(column));
        true
    }

    /// The coefficients of the columns as they were added.
    pub(super) fn coefficients(&self) -> Vec<f64> {
        let mut coefficients = self.components.clone();
        let mut first = self.upper.len();
        for k in (0..coefficients.len()).rev() {
            first -= k + 1;
            let of_column = &self.upper[first..=first + k];
            coefficients[k] /= of_column[k];
            let own = coefficients[k];
            for (coefficient, of_column) in coefficients[..k].iter_mut().zip(of_column) {
                *coefficient -= own * of_column;
            }
        }
        coefficients
    }

    /// The components along the orthonormal columns of another row of entries, from those of the columns
    /// before `known`. The sum of their squares is the ratio of the variance of the fit there to that of a
    /// value.
    pub(super) fn extend_row(&self, row: &[f64], known: &mut Vec<f64>) {
        for k in known.len()..self.components.len() {
            let of_column = &self.upper[k * (k + 1) / 2..][..=k];
            let former: f64 = known.iter().zip(of_column).map(|(a, b)| a * b).sum();
            known.push((row[k] - former) / of_column[k]);
        }
    }

    /// The |difference| of value number `i` from the fit to all others.
    pub(super) fn left_out(&self, i: usize) -> f64 {
        self.residuals.left_out(i, LEAST_INDEPENDENCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_and_left_out_residuals_are_those_of_fits_without_a_value() {
        let x = [0.1, 0.3, 0.4, 0.8, 1.1];
        let y = [0.5, 0.1, 0.9, 0.3, 0.2];
        let fit = |skip: Option<usize>| {
            let kept: Vec<usize> = (0..5).filter(|&i| Some(i) != skip).collect();
            let mut columns = Columns::new(kept.iter().map(|&i| y[i]).collect(), 2);
            assert!(columns.add(kept.iter().map(|_| 1.0)));
            assert!(columns.add(kept.iter().map(|&i| x[i])));
            columns
        };
        let all = fit(None);
        for i in 0..5 {
            let [a, b] = fit(Some(i)).coefficients()[..] else { panic!("two columns") };
            assert!(((a + b * x[i] - y[i]).abs() - all.left_out(i)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_row_beyond_the_values_has_the_variance_of_the_extrapolation() {
        // The variance of a straight line at x is 1/n + (x − mean)²/Σ(x − mean)².
        let x = [0.0, 1.0, 2.0, 3.0];
        let mut columns = Columns::new(vec![1.0, 3.0, 2.0, 5.0], 2);
        let mut row = Vec::new();
        assert!(columns.add([1.0; 4].into_iter()));
        columns.extend_row(&[1.0, 7.5], &mut row);
        assert!(columns.add(x.into_iter()));
        columns.extend_row(&[1.0, 7.5], &mut row);
        let variance: f64 = row.iter().map(|of| of * of).sum();
        assert!((variance - (0.25 + 36.0 / 5.0)).abs() < 1e-12);
    }

    #[test]
    fn dependent_columns_are_refused() {
        let mut columns = Columns::new(vec![1.0, 2.0, 3.0], 2);
        assert!(columns.add([1.0; 3].into_iter()));
        assert!(!columns.add([2.0; 3].into_iter()));
    }
}
