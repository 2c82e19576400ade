//! The optical depth along a part of a line: panels of the depth z with a polynomial in each.
//!
//! The coefficient times ds/dz is sampled at the 16 zeros of a Chebyshev polynomial, which are inside of a
//! panel, so that jumps at its borders and infinite ends are no concern. Its interpolant Σ cₖ Tₖ(s) has the
//! integral Σ aₖ Tₖ(s) with aₖ = (cₖ₋₁ − cₖ₊₁) / 2k (Trefethen 2013, Approximation Theory and Approximation
//! Practice, chapter 19).

use core::f64::consts::PI;

/// Samples of a panel.
pub(super) const NODES: usize = 16;
/// The highest coefficients, whose sum is the error of a panel.
const TAIL: usize = 3;
/// A panel of this length is not halved: a jump is resolved to rounding.
const SHORTEST: f64 = 1e-14;
/// The error of a panel that rounding explains, relative to the sum of its |coefficients|.
const ROUNDING: f64 = 1e-13;

/// The optical depth in a panel, from its beginning on.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    /// The z from which to which it is.
    pub(super) ends: [f64; 2],
    /// Coefficients aₖ.
    antiderivative: [f64; NODES + 1],
    /// Estimated from the highest cₖ.
    pub(super) error: f64,
    is_resolved_to_rounding: bool,
}

/// The rule of all panels.
#[derive(Clone, Debug)]
pub(super) struct Rule {
    /// The places of the samples in a panel, from 0 to 1.
    pub(super) nodes: [f64; NODES],
    /// The weight of each sample in each cₖ.
    analysis: [[f64; NODES]; NODES],
}

impl Rule {
    pub(super) fn new() -> Self {
        let angle = |i: usize| PI * (2 * i + 1) as f64 / (2 * NODES) as f64;
        let weight = |k: usize, i: usize| {
            let norm = if k == 0 { 1.0 } else { 2.0 };
            norm / NODES as f64 * (k as f64 * angle(i)).cos()
        };
        Self {
            nodes: core::array::from_fn(|i| 0.5 - 0.5 * angle(i).cos()),
            // In s = 1 − 2 · node.
            analysis: core::array::from_fn(|k| core::array::from_fn(|i| weight(k, i))),
        }
    }

    /// The panel with these values of the coefficient times ds/dz at the nodes.
    pub(super) fn panel(&self, ends: [f64; 2], values: &[f64]) -> Panel {
        let mut c = [0.0; NODES + 2];
        for (c, weights) in c.iter_mut().zip(&self.analysis) {
            *c = weights.iter().zip(values).map(|(weight, value)| weight * value).sum();
        }
        let half = 0.5 * (ends[1] - ends[0]);
        let size = |of: &[f64]| half * of.iter().map(|c| c.abs()).sum::<f64>();
        let (all, error) = (size(&c), size(&c[NODES - TAIL..NODES]));
        c[0] *= 2.0;
        let mut antiderivative = [0.0; NODES + 1];
        for k in 1..=NODES {
            // s decreases with z.
            antiderivative[k] = -half * (c[k - 1] - c[k + 1]) / (2 * k) as f64;
        }
        // 0 where z begins, at s = 1, where each Tₖ is 1.
        antiderivative[0] = -antiderivative[1..].iter().sum::<f64>();
        let is_resolved_to_rounding =
            error <= ROUNDING * all || 2.0 * half <= SHORTEST * ends[1].max(SHORTEST);
        Panel { ends, antiderivative, error, is_resolved_to_rounding }
    }
}

impl Panel {
    /// Whether its error is at most `allowed`, as far as it can be.
    pub(super) fn is_resolved(&self, allowed: f64) -> bool {
        self.error <= allowed || self.is_resolved_to_rounding
    }

    /// The optical depth of the whole panel.
    pub(super) fn total(&self) -> f64 {
        self.up_to(self.ends[1])
    }

    /// The optical depth up to `z` in the panel.
    pub(super) fn up_to(&self, z: f64) -> f64 {
        let [from, to] = self.ends;
        let s = 1.0 - 2.0 * ((z - from) / (to - from)).clamp(0.0, 1.0);
        let (mut now, mut before) = (0.0, 0.0);
        for a in self.antiderivative[1..].iter().rev() {
            (now, before) = (a + 2.0 * s * now - before, now);
        }
        self.antiderivative[0] + s * now - before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(ends: [f64; 2], f: impl Fn(f64) -> f64) -> Panel {
        let rule = Rule::new();
        let at = |node: &f64| f(ends[0] + node * (ends[1] - ends[0]));
        rule.panel(ends, &rule.nodes.iter().map(at).collect::<Vec<f64>>())
    }

    #[test]
    fn integrals_are_exact_for_polynomials_at_any_place() {
        let integral = |z: f64| z.powi(10) - 0.3 * z.powi(2) + 2.0 * z;
        let found = panel([0.2, 0.9], |z| 10.0 * z.powi(9) - 0.6 * z + 2.0);
        for z in [0.2, 0.21, 0.4, 0.55, 0.83, 0.9] {
            let exact = integral(z) - integral(0.2);
            assert!((found.up_to(z) - exact).abs() < 2e-15, "{z}: {} {exact}", found.up_to(z));
        }
        assert!((found.total() - (integral(0.9) - integral(0.2))).abs() < 2e-15);
        assert!(found.error < 1e-14 && found.is_resolved(0.0));
    }

    /// The largest error of the optical depth anywhere in a panel, over that estimated.
    fn error_ratio(f: &dyn Fn(f64) -> f64, integral: &dyn Fn(f64) -> f64) -> f64 {
        let found = panel([0.0, 1.0], f);
        let places = (0..=200).map(|i| f64::from(i) / 200.0);
        let errors = places.map(|z| (found.up_to(z) - integral(z)).abs());
        errors.fold(0.0, f64::max) / found.error
    }

    #[test]
    fn the_error_is_about_its_estimate_or_below_for_jumps_kinks_and_peaks() {
        for i in 0..40 {
            let at = 0.1 + 0.8 * f64::from(i) / 40.0;
            let jump = error_ratio(&|z| f64::from(u8::from(z > at)), &|z| (z - at).max(0.0));
            let kink =
                error_ratio(&|z| (z - at).abs(), &|z| 0.5 * ((z - at) * (z - at).abs() + at * at));
            let width = 0.08;
            let tail = |z: f64| width * ((z - at) / width).atan();
            let peak = error_ratio(&|z| 1.0 / (1.0 + ((z - at) / width).powi(2)), &|z| {
                tail(z) - tail(0.0)
            });
            assert!(jump < 1.0 && kink < 1.7 && peak < 1.0, "{at}: {jump} {kink} {peak}");
        }
    }

    #[test]
    fn what_rounding_leaves_is_resolved() {
        let found = panel([0.25, 0.5], |z| 1e9 * (1.0 + z));
        assert!(found.error > 0.0 && found.is_resolved(1e-12));
        let jump = panel([0.25, 0.25 + 1e-15], |z| if z > 0.25 + 5e-16 { 1e9 } else { 0.0 });
        assert!(jump.is_resolved(0.0));
    }
}
