//! P(3/2, x), the share of a Maxwellian's particles below the energy x.

use crate::scalar::Scalar;
use core::f64::consts::{FRAC_2_SQRT_PI, PI};

/// Below it the error function would cancel against the exponential.
const SERIES_LIMIT: f64 = 1.0;

/// The regularised lower incomplete gamma function P(3/2, x) = erf √x − 2 √(x/π) e⁻ˣ, x ≥ 0
/// (DLMF 8.4.7 and 8.8.5), to a few roundings of its value however small x is.
pub(super) fn p_three_halves<T: Scalar>(x: T) -> T {
    let value = |x: f64| if x < SERIES_LIMIT { series(x) } else { closed_form(x) };
    // x^(1/2) e⁻ˣ/Γ(3/2), DLMF 8.8.13.
    x.map(value, |x, _| FRAC_2_SQRT_PI * x.sqrt() * (-x).exp())
}

fn closed_form(x: f64) -> f64 {
    let root = x.sqrt();
    libm::erf(root) - FRAC_2_SQRT_PI * root * (-x).exp()
}

/// x^(3/2) e⁻ˣ Σ xᵏ/Γ(k + 5/2), DLMF 8.7.1; no term is negative.
fn series(x: f64) -> f64 {
    // 1/Γ(5/2)
    let mut term = 4.0 / (3.0 * PI.sqrt());
    let (mut sum, mut argument) = (0.0, 2.5);
    while term > f64::EPSILON * 0.1 * sum {
        sum += term;
        term *= x / argument;
        argument += 1.0;
    }
    x * x.sqrt() * (-x).exp() * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_mpmath() {
        // mpmath.gammainc(1.5, 0, x, regularized=True) with 30 digits.
        for (x, expected) in [
            (1e-12, 7.522_527_780_632_237e-19),
            (1e-3, 2.377_405_365_195_056_4e-5),
            (0.5, 0.198_748_043_098_799_2),
            (0.999_999, 0.427_592_880_421_519),
            (1.0, 0.427_593_295_529_120_2),
            (7.0, 0.997_094_847_225_732_6),
        ] {
            let error = p_three_halves(x) / expected - 1.0;
            assert!(error.abs() < 1e-14, "{x}: {error:e}");
        }
        assert!((p_three_halves(400.0_f64) - 1.0).abs() <= 0.0);
        assert!(p_three_halves(0.0_f64).abs() <= 0.0);
    }

    #[test]
    fn both_forms_agree_where_they_meet() {
        assert!((series(SERIES_LIMIT) / closed_form(SERIES_LIMIT) - 1.0).abs() < 1e-14);
    }
}
