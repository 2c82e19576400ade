//! Depth rules: a few depths with weights that integrate every line of a part of the image.
//!
//! Where G has a low numerical rank between the image plane and the depth, r depths zₖ with weights
//! wₖ give ∫ G dz = Σ wₖ G(x, y, zₖ) for all (x, y): empirical interpolation (Barrault et al. 2004,
//! doi:10.1016/j.crma.2004.08.006) and reduced quadrature. A rule is fitted to lines that were
//! integrated in full: depths by QR with column pivoting, weights by least squares, and the error
//! from leave-one-out residuals.

use crate::vol::line::profile::{DEPTHS, Profile, depth_of, level_of};
use crate::vol::tuning::TUNING;
use nalgebra::{DMatrix, DVector};

/// A column adds nothing if its part orthogonal to the chosen columns is below this share of it.
const INDEPENDENT: f64 = 1e-12;

/// Depths and weights that replace ∫ dz on some lines.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DepthRule {
    pub(crate) depths: Vec<u32>,
    weights: Vec<f64>,
    /// The weights of the least-squares fit without the last depth.
    shorter: Vec<f64>,
    /// The largest |error| on a line that was left out of the fit.
    pub(crate) error: f64,
    /// The largest change of an integral by the last depth, on the lines of the fit.
    usual_change: f64,
    /// The range of G at each depth, on the lines of the fit.
    ranges: Vec<(f64, f64)>,
}

impl DepthRule {
    /// The rule with the fewest depths, at most `most_depths`, whose leave-one-out errors on
    /// `lines` are within `tolerance`; `None` if there is none.
    pub(crate) fn fit(lines: &[&Profile], tolerance: f64, most_depths: usize) -> Option<Self> {
        if lines.len() < TUNING.rule.least_lines || lines.iter().any(|line| line.has_jump) {
            return None;
        }
        let sampled = |k: &usize| lines.iter().any(|line| line.sampled[*k]);
        let candidates: Vec<usize> = (0..DEPTHS).filter(sampled).collect();
        let rate = |i: usize, c: usize| lines[i].rates[candidates[c]];
        let rates = DMatrix::from_fn(lines.len(), candidates.len(), rate);
        let integrals = DVector::from_iterator(lines.len(), lines.iter().map(|line| line.integral));

        let most_depths =
            most_depths.min(lines.len() / TUNING.rule.lines_per_depth).min(candidates.len());
        let preference = |&k: &usize| TUNING.rule.finer_depth.powf(f64::from(level_of(k)));
        let preferences = candidates.iter().map(preference).collect();
        let mut factors = Factors::new(&rates, preferences, most_depths);
        let mut residuals = integrals.clone();
        let mut leverages = DVector::zeros(lines.len());
        while factors.chosen.len() < most_depths {
            let direction = factors.push()?;
            residuals.axpy(-residuals.dot(&direction), &direction, 1.0);
            leverages.cmpy(1.0, &direction, &direction, 1.0);
            let error = residuals.zip_fold(&leverages, 0.0, |largest: f64, residual, leverage| {
                largest.max(residual.abs() / (1.0 - leverage).max(TUNING.rule.least_independence))
            });
            if error <= tolerance {
                let [weights, shorter] = factors.solve(&integrals)?;
                if weights.lp_norm(1) < TUNING.rule.largest_weights {
                    let depths = factors.chosen.iter().map(|&c| depth_of(candidates[c])).collect();
                    let rates = rates.select_columns(&factors.chosen);
                    return Some(Self::new(depths, &rates, &weights, &shorter, error));
                }
            }
        }
        None
    }

    /// `rates` has a row for each line and a column for each of the `depths`.
    fn new(
        depths: Vec<u32>,
        rates: &DMatrix<f64>,
        weights: &DVector<f64>,
        shorter: &DVector<f64>,
        error: f64,
    ) -> Self {
        let mut rule = Self {
            depths,
            weights: weights.as_slice().to_vec(),
            shorter: shorter.as_slice().to_vec(),
            error,
            usual_change: 0.0,
            ranges: rates.column_iter().map(|column| (column.min(), column.max())).collect(),
        };
        let changes = rates.row_iter().map(|row| rule.change(row.transpose().as_slice()));
        rule.usual_change = changes.fold(0.0, f64::max);
        rule
    }

    /// The depths with their weights.
    pub(crate) fn weighted_depths(&self) -> Vec<(u32, f64)> {
        self.depths.iter().copied().zip(self.weights.iter().copied()).collect()
    }

    /// The integral of a line with these `rates` at the depths of the rule.
    pub(crate) fn integral(&self, rates: &[f64]) -> f64 {
        dot(&self.weights, rates)
    }

    /// The |change| of the integral by the last depth.
    fn change(&self, rates: &[f64]) -> f64 {
        (self.integral(rates) - dot(&self.shorter, &rates[..self.shorter.len()])).abs()
    }

    /// Whether a line with these `rates` is unlike the lines of the fit.
    pub(crate) fn is_outlier(&self, rates: &[f64], tolerance: f64) -> bool {
        if self.change(rates)
            > TUNING.rule.outlier_change * self.usual_change
                + TUNING.rule.outlier_tolerance * tolerance
        {
            return true;
        }
        let outside = |((&rate, &(low, high)), &weight): ((&f64, &(f64, f64)), &f64)| {
            let beyond = (rate - rate.clamp(low, high)).abs();
            beyond > TUNING.rule.outlier_range * (high - low)
                && beyond * weight.abs() > TUNING.rule.outlier_tolerance * tolerance
        };
        rates.iter().zip(&self.ranges).zip(&self.weights).any(outside)
    }
}

/// The QR factors of some columns of a matrix, each the one with the largest remainder after
/// projection on the former ones, whose square is multiplied by the preference for the column.
///
/// They are computed one by one, since few are needed: nalgebra's `ColPivQR` factors all columns
/// and pivots by their largest entry.
struct Factors<'a> {
    matrix: &'a DMatrix<f64>,
    preferences: Vec<f64>,
    /// The matrix less its projection on the chosen columns.
    remainder: DMatrix<f64>,
    chosen: Vec<usize>,
    /// The orthonormal columns, with space for more.
    q: DMatrix<f64>,
}

impl<'a> Factors<'a> {
    fn new(matrix: &'a DMatrix<f64>, preferences: Vec<f64>, most: usize) -> Self {
        let q = DMatrix::zeros(matrix.nrows(), most);
        Self { matrix, preferences, remainder: matrix.clone(), chosen: Vec::new(), q }
    }

    /// Adds a column and returns its direction; `None` if all other columns depend on the chosen
    /// ones.
    fn push(&mut self) -> Option<DVector<f64>> {
        let columns = self.remainder.column_iter().zip(&self.preferences);
        let squares = columns.map(|(column, preference)| preference * column.norm_squared());
        let pivot = DVector::from_iterator(self.remainder.ncols(), squares).argmax().0;
        let mut direction = self.remainder.column(pivot).into_owned();
        // A second orthogonalisation: two suffice for orthogonality to rounding (Giraud et al.
        // 2005).
        let q = self.q.columns(0, self.chosen.len());
        direction -= q * q.tr_mul(&direction);
        if direction.normalize_mut() <= INDEPENDENT * self.matrix.column(pivot).norm() {
            return None;
        }
        let along = self.remainder.tr_mul(&direction);
        self.remainder.ger(-1.0, &direction, &along, 1.0);
        self.q.set_column(self.chosen.len(), &direction);
        self.chosen.push(pivot);
        Some(direction)
    }

    /// The least-squares solutions for a right-hand side with all columns, and without the last
    /// one.
    fn solve(&self, values: &DVector<f64>) -> Option<[DVector<f64>; 2]> {
        let count = self.chosen.len();
        let q = self.q.columns(0, count);
        let r = q.tr_mul(&self.matrix.select_columns(&self.chosen));
        let along = q.tr_mul(values);
        let first = |k| r.view((0, 0), (k, k)).solve_upper_triangular(&along.rows(0, k));
        Some([first(count)?, first(count.checked_sub(1)?)?])
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::dyadic::spacing;
    use crate::vol::dyadic::unit;
    use crate::vol::line::Line;

    /// A line of `rate`, sampled on the lattice of `level`.
    fn profile(level: u8, rate: impl Fn(f64) -> f64) -> Profile {
        let mut line = Line::default();
        let depths = (0..=1_u32 << level).map(|k| k * spacing(level));
        line.add(depths.map(|depth| (depth, rate(unit(depth)))));
        line.integrate();
        Profile::new(&line)
    }

    fn at(rule: &DepthRule, rate: impl Fn(f64) -> f64) -> Vec<f64> {
        rule.depths.iter().map(|&depth| rate(unit(depth))).collect()
    }

    fn mixed(a: f64, b: f64) -> impl Fn(f64) -> f64 {
        move |z: f64| a * (3.0 * z).sin() + b * (-z).exp()
    }

    #[test]
    fn lines_of_rank_2_have_a_rule_of_2_depths() {
        let mix = |i: i32| mixed(f64::from(i).sin(), f64::from(i).cos() + 0.2);
        let profiles: Vec<Profile> = (0..20).map(|i| profile(5, mix(i))).collect();
        let lines: Vec<&Profile> = profiles.iter().collect();
        let rule = DepthRule::fit(&lines, 1e-9, 6).unwrap();
        assert_eq!(rule.depths.len(), 2);
        let exact = 0.4 * (1.0 - 3.0_f64.cos()) / 3.0 + 0.3 * (1.0 - (-1.0_f64).exp());
        let rates = at(&rule, mixed(0.4, 0.3));
        assert!((rule.integral(&rates) - exact).abs() < 1e-8);
        assert!(!rule.is_outlier(&rates, 1e-9));
    }

    #[test]
    fn lines_of_rank_1_have_a_rule_of_1_depth() {
        let profiles: Vec<Profile> =
            (1..=20).map(|i| profile(5, mixed(f64::from(i), 0.0))).collect();
        let lines: Vec<&Profile> = profiles.iter().collect();
        let rule = DepthRule::fit(&lines, 1e-9, 6).unwrap();
        assert_eq!((rule.depths.len(), rule.shorter.len()), (1, 0));
        assert!((rule.integral(&at(&rule, mixed(1.0, 0.0))) - lines[0].integral).abs() < 1e-12);
        // All other depths depend on this one.
        assert!(DepthRule::fit(&lines, -1.0, 6).is_none());
    }

    #[test]
    fn of_nearly_equal_depths_the_coarsest_one_is_chosen() {
        // Largest at 0.49, and nearly as large in the middle.
        let rate = |amplitude: f64| move |z: f64| amplitude * (-(z - 0.49).powi(2)).exp();
        let profiles: Vec<Profile> = (1..=20).map(|i| profile(7, rate(f64::from(i)))).collect();
        let lines: Vec<&Profile> = profiles.iter().collect();
        let rule = DepthRule::fit(&lines, 1e-9, 6).unwrap();
        assert_eq!(rule.depths, [depth_of(1 << 6)]);
    }

    #[test]
    fn factors_are_those_of_least_squares() {
        let entry = |i: usize, j: usize| 1.0 / (1.0 + i as f64 + 2.0 * j as f64);
        let matrix = DMatrix::from_fn(9, 6, entry);
        let mut factors = Factors::new(&matrix, vec![1.0; 6], 4);
        for _ in 0..4 {
            factors.push().unwrap();
        }
        assert_eq!(factors.chosen[0], 0);
        assert!((factors.q.tr_mul(&factors.q) - DMatrix::identity(4, 4)).amax() < 1e-15);
        let expected =
            [DVector::from_vec(vec![1.0, -2.0, 3.0, 0.5]), DVector::from_vec(vec![1.0, -2.0, 3.0])];
        let columns = matrix.select_columns(&factors.chosen);
        let [all, _] = factors.solve(&(&columns * &expected[0])).unwrap();
        assert!((all - &expected[0]).amax() < 1e-9);
        let [_, shorter] = factors.solve(&(columns.columns(0, 3) * &expected[1])).unwrap();
        assert!((shorter - &expected[1]).amax() < 1e-9);
    }

    #[test]
    fn a_line_unlike_the_others_is_an_outlier() {
        let profiles: Vec<Profile> =
            (0..20).map(|i| profile(5, mixed(f64::from(i).sin(), f64::from(i).cos()))).collect();
        let lines: Vec<&Profile> = profiles.iter().collect();
        let rule = DepthRule::fit(&lines, 1e-6, 6).unwrap();
        let knot =
            |z: f64| mixed(0.4, 0.3)(z) + 5.0 * (-(60.0 * (z - 0.5)).powi(2)).exp() + 4.0 * z;
        assert!(rule.is_outlier(&at(&rule, knot), 1e-6));
    }

    #[test]
    fn there_is_no_rule_for_few_lines_or_lines_with_jumps() {
        let profiles: Vec<Profile> = (0..20).map(|i| profile(5, |z| z + f64::from(i))).collect();
        let lines: Vec<&Profile> = profiles.iter().collect();
        assert!(DepthRule::fit(&lines, 1e-6, 6).is_some());
        assert!(DepthRule::fit(&lines[..TUNING.rule.least_lines - 1], 1e-6, 6).is_none());
        let mut with_jump = profiles.clone();
        with_jump[3].has_jump = true;
        let lines: Vec<&Profile> = with_jump.iter().collect();
        assert!(DepthRule::fit(&lines, 1e-6, 6).is_none());
    }
}
