//! Lines of a pixel without regard to edges: four of Gauss's rule, and Fibonacci lattices of any number.

use crate::vol::view::pixel_rule::RuleNode;

/// The places of two Gauss nodes.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// The product of two Gauss nodes along each axis: exact for polynomials of degree 3.
pub(crate) fn gauss_nodes() -> [RuleNode; 4] {
    core::array::from_fn(|k| ([GAUSS[k % 2], GAUSS[k / 2]], 0.25))
}

/// The points of the Fibonacci lattice of `count` points, with equal weights.
pub(crate) fn lattice_nodes(count: usize) -> Vec<RuleNode> {
    (0..count).map(|k| (fibonacci(k, count), 1.0 / count as f64)).collect()
}

/// Point `k` of the Fibonacci lattice of `count` points, in the middle of its shares.
pub(crate) fn fibonacci(k: usize, count: usize) -> [f64; 2] {
    // The Fibonacci number before `count`.
    let (mut before, mut number) = (1, 1);
    while number < count {
        (before, number) = (number, before + number);
    }
    let u = (k as f64 + 0.5) / count as f64;
    let v = ((k * before % count) as f64 + 0.5) / count as f64;
    [u, v]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_of_a_lattice_has_its_own_row_and_column() {
        for count in [5, 34, 89, 144, 233, 377, 610, 987] {
            let mut seen = vec![[false; 2]; count];
            for k in 0..count {
                for (axis, along) in fibonacci(k, count).into_iter().enumerate() {
                    let place = along * count as f64 - 0.5;
                    assert!((place - place.round()).abs() < 1e-9);
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "0 or more"
                    )]
                    let place = place.round() as usize;
                    assert!(!core::mem::replace(&mut seen[place][axis], true));
                }
            }
        }
    }

    #[test]
    fn a_limb_in_a_pixel_is_resolved() {
        // √x is the chord beside a limb.
        let mean = |count: usize| {
            (0..count).map(|k| fibonacci(k, count)[0].sqrt()).sum::<f64>() / count as f64
        };
        assert!((mean(89) - 2.0 / 3.0).abs() < 3e-4);
        assert!((mean(610) - 2.0 / 3.0).abs() < 2e-5);
    }
}
