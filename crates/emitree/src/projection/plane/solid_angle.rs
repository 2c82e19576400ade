//! Solid angles by quadrature, where there is no closed form.

use bilby::GaussLegendre;
use std::sync::OnceLock;

/// Nodes and weights on [0, 1].
type Rule = Vec<(f64, f64)>;

/// Gauss–Legendre rules for small, middling and large pixels: degree 5 of an analytic density on a
/// hundredth of the image is exact to rounding.
const SIZES: [(f64, usize); 3] = [(0.02, 4), (0.25, 8), (f64::INFINITY, 24)];

fn rule(size: f64) -> &'static Rule {
    static RULES: OnceLock<[Rule; 3]> = OnceLock::new();
    let rules = RULES.get_or_init(|| {
        SIZES.map(|(_, nodes)| match GaussLegendre::new(nodes) {
            Ok(rule) => {
                let pairs = rule.nodes().iter().zip(rule.weights());
                pairs.map(|(node, weight)| (0.5 + 0.5 * node, 0.5 * weight)).collect()
            }
            // Zero nodes are the only error that there is.
            Err(_) => Vec::new(),
        })
    });
    let class = SIZES.iter().position(|(largest, _)| size <= *largest).unwrap_or(SIZES.len() - 1);
    &rules[class]
}

/// ∫ `f` from `low` to `high`.
pub(super) fn integral(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let length = high - low;
    let nodes = rule(length).iter();
    length * nodes.map(|(t, weight)| weight * f(low + t * length)).sum::<f64>()
}

/// The same by the two nodes of Gauss and Legendre, for parts so small that no more are needed.
pub(super) fn integral_of_small(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let node = half / 3.0_f64.sqrt();
    half * (f(middle - node) + f(middle + node))
}
