//! The integral over speed of a drifting Maxwellian of protons that exchange charge.
//!
//! Speeds are in units of the thermal speed w = √(2kT/m): x = v/w. The integral along a direction
//! depends on it by the drift along it alone, m = d·u/w:
//!
//! ∫₀^∞ σ(wx) x³ e^(−(x − m)²) dx = S(m) for m ≥ 0, e^(−m²) S(m) for m < 0,
//!
//! S(m) = ∫₀^∞ σ(wx) x³ e^(−(x − m)²) dx (m ≥ 0), ∫₀^∞ σ(wx) x³ e^(−x² − 2|m|x) dx (m < 0),
//!
//! where S varies by powers of m only. ln S is tabulated once for all m that the drift allows, as
//! Chebyshev polynomials in asinh m, so that a direction costs a polynomial and two functions.

use super::charge_exchange::cross_section_m2;
use crate::scalar::Scalar;
use core::f64::consts::PI;

/// The double-exponential rule (Takahasi and Mori 1974, doi:10.2977/prims/1195192451) for S: 161
/// nodes, t from −3.2 to 3.2. With them it is within 10⁻¹² of the same with five times as many, for
/// temperatures from 10³ to 10⁹ K and drifts up to 5.2·10⁶ m/s.
const RULE_NODES: u32 = 161;
const RULE_END: f64 = 3.2;

/// Where the exponentials are cut: e⁻⁴⁵ = 3·10⁻²⁰.
const CUT: f64 = 45.0;

/// The range of asinh |m| of one polynomial, and its number of coefficients: within
/// 3·10⁻¹² of ln S.
const PANEL_WIDTH: f64 = 0.5;
const COEFFICIENTS: usize = 17;

type Chebyshev<T> = [T; COEFFICIENTS];

/// ln S for all drifts up to a largest one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SpeedIntegral<T = f64> {
    /// Polynomials of asinh |m| from 0 upwards, for m ≥ 0 and for m < 0.
    sides: [Vec<Chebyshev<T>>; 2],
}

impl<T: Scalar> SpeedIntegral<T> {
    /// The table for the thermal speed w \[m/s\] and drifts m up to `largest_drift` either way.
    pub(super) fn new(thermal_speed_m_s: T, largest_drift: f64) -> Self {
        let rule = double_exponential_rule(RULE_NODES);
        let last = panel(largest_drift.asinh() / PANEL_WIDTH);
        let sides = [1.0, -1.0].map(|sign| {
            let ln_s = |scaled: f64| {
                let drift = sign * (PANEL_WIDTH * scaled).sinh();
                integral(&rule, thermal_speed_m_s, drift).ln()
            };
            (0..=last).map(|panel| interpolate(|place| ln_s(panel as f64 + place))).collect()
        });
        Self { sides }
    }

    /// ln S(m), S in m².
    pub(super) fn ln_at(&self, drift: T) -> T {
        let side = &self.sides[usize::from(drift.value() < 0.0)];
        let asinh = |m: f64| m.abs().asinh();
        let scaled = drift.map(asinh, |m, _| m.signum() / m.hypot(1.0)) / PANEL_WIDTH;
        // A direction may be longer than 1 by a rounding, and m beyond the last panel by as little.
        let panel = panel(scaled.value()).min(side.len() - 1);
        evaluate(&side[panel], scaled - panel as f64)
    }
}

/// The panel of a non-negative place, in units of panels.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounds down what is at least 0 and, as an asinh, at most some hundreds"
)]
fn panel(scaled: f64) -> usize {
    scaled as usize
}

/// Nodes on (0, 1) and weights: x = 1/(1 + e^(−π sinh t)) at uniform steps of t.
fn double_exponential_rule(nodes: u32) -> Vec<(f64, f64)> {
    let step = 2.0 * RULE_END / f64::from(nodes - 1);
    let node = |index: u32| {
        let t = f64::from(index) * step - RULE_END;
        let exponential = (-PI * t.sinh()).exp();
        let x = 1.0 / (1.0 + exponential);
        (x, step * PI * t.cosh() * x * (exponential * x))
    };
    (0..nodes).map(node).collect()
}

/// S(m) \[m²\] by the rule, on the x where the exponential is not negligible.
fn integral<T: Scalar>(rule: &[(f64, f64)], thermal_speed_m_s: T, drift: f64) -> T {
    let (from, to) = if drift >= 0.0 {
        ((drift - CUT.sqrt()).max(0.0), drift + CUT.sqrt())
    } else {
        // x² + 2|m|x = CUT
        (0.0, CUT / (drift.hypot(CUT.sqrt()) - drift))
    };
    let term = |&(node, weight): &(f64, f64)| {
        let x = from + (to - from) * node;
        let exponent =
            if drift >= 0.0 { -(x - drift) * (x - drift) } else { -x * (x - 2.0 * drift) };
        cross_section_m2(thermal_speed_m_s * x) * weight * x.powi(3) * exponent.exp()
    };
    rule.iter().map(term).fold(T::of(0.0), T::add) * (to - from)
}

/// The polynomial through `f` at the Chebyshev points of \[0, 1\].
fn interpolate<T: Scalar>(f: impl Fn(f64) -> T) -> Chebyshev<T> {
    let count = COEFFICIENTS as f64;
    let angle = |point: usize| PI * (point as f64 + 0.5) / count;
    let values: Chebyshev<T> = core::array::from_fn(|point| f(0.5 * (1.0 + angle(point).cos())));
    core::array::from_fn(|degree| {
        let norm = if degree == 0 { 1.0 } else { 2.0 } / count;
        let terms = values.iter().enumerate();
        let terms = terms.map(|(point, v)| *v * (degree as f64 * angle(point)).cos());
        terms.fold(T::of(0.0), T::add) * norm
    })
}

/// The polynomial at a place in \[0, 1\], by Clenshaw's recurrence.
fn evaluate<T: Scalar>(polynomial: &Chebyshev<T>, place: T) -> T {
    let x = place * 2.0 - 1.0;
    let (mut next, mut after) = (T::of(0.0), T::of(0.0));
    for &coefficient in polynomial[1..].iter().rev() {
        (next, after) = (coefficient + x * 2.0 * next - after, next);
    }
    polynomial[0] + x * next - after
}

#[cfg(test)]
mod tests {
    use super::super::constants::{BOLTZMANN_CONSTANT, PROTON_MASS_KG};
    use super::*;

    /// Thermal speeds from the coldest to the hottest plasma that `ena` accepts.
    fn thermal_speeds_m_s() -> [f64; 5] {
        [1e3, 1e5, 1e6, 1e7, 1e9]
            .map(|temperature| f64::sqrt(2.0 * BOLTZMANN_CONSTANT * temperature / PROTON_MASS_KG))
    }

    /// The fastest drift that `ena` accepts.
    const LARGEST_DRIFT_M_S: f64 = 5.2e6;

    /// S by Simpson's rule in 20 000 steps of x, on the same range.
    fn simpson(thermal_speed_m_s: f64, drift: f64) -> f64 {
        let (from, to) = if drift >= 0.0 {
            ((drift - 7.0).max(0.0), drift + 7.0)
        } else {
            (0.0, 49.0 / (49.0 + drift * drift).sqrt().max(-2.0 * drift))
        };
        let steps = 20_000_u32;
        let width = (to - from) / f64::from(steps);
        let integrand = |index: u32| {
            let x = from + width * f64::from(index);
            if x <= 0.0 {
                return 0.0;
            }
            let exponent = (-(x - drift).powi(2)).min(0.0) + drift.min(0.0).powi(2);
            cross_section_m2(thermal_speed_m_s * x) * x.powi(3) * exponent.exp()
        };
        let weight = |index| if index % 2 == 0 { 2.0 } else { 4.0 };
        let inner: f64 = (1..steps).map(|index| weight(index) * integrand(index)).sum();
        width / 3.0 * (integrand(0) + inner + integrand(steps))
    }

    #[test]
    fn agrees_with_simpson() {
        for thermal_speed_m_s in thermal_speeds_m_s() {
            let largest = (LARGEST_DRIFT_M_S / thermal_speed_m_s).min(12.0);
            let table = SpeedIntegral::new(thermal_speed_m_s, largest);
            for share in [-1.0, -0.3, -0.06, -1e-9, 0.0, 0.02, 0.09, 0.33, 0.66, 1.0] {
                let drift = share * largest;
                let ratio = table.ln_at(drift).exp() / simpson(thermal_speed_m_s, drift);
                assert!((ratio - 1.0).abs() < 1e-10, "{thermal_speed_m_s}, {drift}: {ratio}");
            }
        }
    }

    #[test]
    fn the_rule_has_converged_and_the_table_interpolates_it() {
        let [rule, finer] = [RULE_NODES, 5 * RULE_NODES].map(double_exponential_rule);
        for thermal_speed_m_s in thermal_speeds_m_s() {
            let largest = LARGEST_DRIFT_M_S / thermal_speed_m_s;
            let table = SpeedIntegral::new(thermal_speed_m_s, largest);
            for index in -100_i32..=100 {
                let drift = (largest.asinh() * f64::from(index) / 100.0).sinh();
                let [coarse, fine] =
                    [&rule, &finer].map(|rule| integral(rule, thermal_speed_m_s, drift).ln());
                assert!((coarse - fine).abs() < 1e-12, "{thermal_speed_m_s}, {drift}");
                let interpolated = table.ln_at(drift);
                assert!((interpolated - coarse).abs() < 3e-12, "{thermal_speed_m_s}, {drift}");
            }
        }
    }

    #[test]
    fn is_continuous_where_the_sides_meet() {
        let table = SpeedIntegral::new(4e5, 1.0);
        assert!((table.ln_at(1e-12) - table.ln_at(-1e-12)).abs() < 1e-11);
    }
}
