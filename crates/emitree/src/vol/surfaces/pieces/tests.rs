//! Polynomials in boxes, and their integrals along lines.

use super::*;
use crate::vol::lattice;

fn cubic([x, y, z]: [f64; 3]) -> f64 {
    1.0 + x - 2.0 * y * z + 3.0 * z * z * x - 0.5 * z * z * z
}

/// ∫ of [`cubic`] along z.
fn integral([x, y]: [f64; 2], ends: [f64; 2]) -> f64 {
    let below = |z: f64| (1.0 + x) * z - y * z * z + x * z.powi(3) - 0.125 * z.powi(4);
    below(ends[1]) - below(ends[0])
}

/// The polynomial in a box through values at many points.
fn fitted(low: [f64; 3], high: [f64; 3]) -> Polynomial {
    let points = (0..80)
        .map(lattice::point)
        .map(|u| core::array::from_fn(|k| low[k] + u[k] * (high[k] - low[k])));
    let samples: Vec<([f64; 3], f64)> = points.map(|at| (at, cubic(at))).collect();
    let mut found = Polynomial::fit(low, high, &samples, &[]);
    assert!(found.error < 1e-9, "{}", found.error);
    found.error = 0.01;
    found
}

#[test]
fn polynomials_are_reproduced_with_their_integrals_across_boxes() {
    let nodes = vec![
        Node::Halves { axis: 2, at: 0.5, below: 1, above: 2 },
        fitted([0.0; 3], [1.0, 1.0, 0.5]).into(),
        Node::Halves { axis: 0, at: 0.5, below: 3, above: 4 },
        fitted([0.0, 0.0, 0.5], [0.5, 1.0, 1.0]).into(),
        fitted([0.5, 0.0, 0.5], [1.0; 3]).into(),
    ];
    let pieces = Pieces { nodes };
    for k in 0..40 {
        let at = lattice::point(300 + k);
        assert!((pieces.value(at) - cubic(at)).abs() < 1e-9, "{at:?}");
        let [x, y, z] = at;
        let [found, error] = pieces.integral([x, y], [0.1 * z, 0.3 + 0.7 * z]);
        let exact = integral([x, y], [0.1 * z, 0.3 + 0.7 * z]);
        assert!((found - exact).abs() < 1e-9, "{at:?}: {found} {exact}");
        assert!((error - 0.01 * (0.3 + 0.6 * z)).abs() < 1e-12);
    }
}

#[test]
fn a_region_without_samples_is_dark() {
    assert!(Pieces { nodes: Vec::new() }.value([0.5; 3]).abs() < 1e-300);
}

/// Samples in one corner of a box: in the rest of it the error is larger.
#[test]
fn errors_are_those_at_the_places_where_a_polynomial_is_used() {
    let rate = |[x, y, z]: [f64; 3]| (-3.0 * (x + y + z)).exp();
    let samples: Vec<([f64; 3], f64)> = (0..60)
        .map(|k| lattice::point(k).map(|along| 0.3 * along))
        .map(|at| (at, rate(at)))
        .collect();
    let places = |size: f64| -> Vec<[f64; 3]> {
        (100..130).map(|k| lattice::point(k).map(|along| size * along)).collect()
    };
    let fit = |places: &[[f64; 3]]| Polynomial::fit([0.0; 3], [1.0; 3], &samples, places);
    let (near, far) = (places(0.3), places(1.0));
    let [inside, beyond] = [&near, &far].map(|places| fit(places));
    let worst = near.iter().map(|at| (inside.value(*at) - rate(*at)).abs()).fold(0.0, f64::max);
    assert!(worst < inside.error, "{worst} {}", inside.error);
    assert!(beyond.error > 10.0 * inside.error, "{} {}", inside.error, beyond.error);
}

#[test]
fn one_sample_is_no_known_value() {
    let found = Polynomial::fit([0.0; 3], [1.0; 3], &[([0.5; 3], 2.0)], &[]);
    assert!(found.error.is_infinite());
    assert!((found.value([0.1; 3]) - 2.0).abs() < 1e-15);
}
