//! Gauss–Legendre rules on any interval; nodes and weights come from the crate `bilby`.

use bilby::GaussLegendre;

/// A Gauss–Legendre rule, held on \[−1, 1\].
#[derive(Clone, Debug)]
pub(crate) struct Gauss {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

impl Gauss {
    /// The rule with `count` nodes, exact for polynomials of degree 2 `count` − 1; a rule without
    /// nodes integrates everything to 0.
    pub(crate) fn new(count: usize) -> Self {
        let tables =
            GaussLegendre::new(count).map(|rule| (rule.nodes().to_vec(), rule.weights().to_vec()));
        let (nodes, weights) = tables.unwrap_or_default();
        Self { nodes, weights }
    }

    /// Nodes in \[−1, 1\], in increasing order.
    pub(crate) fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// Weights of the nodes; their sum is 2.
    pub(crate) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Calls `f` with each node of the rule on \[`from`, `to`\] and its weight.
    pub(crate) fn weigh(&self, from: f64, to: f64, mut f: impl FnMut(f64, f64)) {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        for (node, weight) in self.nodes.iter().zip(&self.weights) {
            f(middle + half * node, half * weight);
        }
    }

    /// ∫ f over \[`from`, `to`\].
    pub(crate) fn integrate(&self, from: f64, to: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let nodes = self.nodes.iter().zip(&self.weights);
        half * nodes.map(|(node, weight)| weight * f(middle + half * node)).sum::<f64>()
    }

    /// ∫ f over \[`from`, `to`\], cut into `panels` equal parts.
    pub(crate) fn integrate_panels(
        &self,
        [from, to]: [f64; 2],
        panels: usize,
        mut f: impl FnMut(f64) -> f64,
    ) -> f64 {
        let border = |i: usize| from + (to - from) * i as f64 / panels as f64;
        (0..panels).map(|i| self.integrate(border(i), border(i + 1), &mut f)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_is_exact_up_to_its_degree() {
        let rule = Gauss::new(4);
        let power = |n: i32| rule.integrate_panels([1.0, 3.0], 2, |t| t.powi(n));
        assert!((power(7) - (3_f64.powi(8) - 1.0) / 8.0).abs() < 1e-11);
        assert!((power(8) - (3_f64.powi(9) - 1.0) / 9.0).abs() > 1e-6);
    }
}
