//! Parts of the base lattice.

use super::*;

fn lattice(rate: impl Fn([f64; 3]) -> f64) -> BaseLattice {
    let empty = BaseLattice::new([8; 3], vec![0.0; 9 * 9 * 9]);
    let rates = (0..9 * 9 * 9).map(|k| rate(empty.corner(k).map(|k| k as f64 / 8.0))).collect();
    BaseLattice::new([8; 3], rates)
}

fn parts(lattice: &BaseLattice) -> usize {
    (0..lattice.rates.len()).filter(|&k| lattice.find(k) == k).count()
}

#[test]
fn numbers_and_corners_are_inverse() {
    let lattice = lattice(|_| 0.0);
    for number in 0..lattice.rates.len() {
        assert_eq!(lattice.number(lattice.corner(number)), number);
    }
}

#[test]
fn a_slope_is_one_part_and_a_step_is_two() {
    let mut slope = lattice(|[x, y, z]| 1.0 + x + 0.5 * y - 0.2 * z);
    assert!(slope.join_smooth(&[], 1e-6).is_empty());
    assert_eq!(parts(&slope), 1);
    let mut step = lattice(|[x, y, z]| if x < 0.45 { 1.0 + y } else { 0.1 + 0.1 * z });
    let edges = step.join_smooth(&[], 1e-6);
    assert_eq!((parts(&step), edges.len()), (2, 81));
}

#[test]
fn successive_steps_between_constant_parts_are_no_slope() {
    // The three steps of 0.5 predict each other.
    let step = |x: f64| if x < 0.45 { 0.0 } else { 0.5 };
    let mut steps = lattice(|[x, ..]| step(x) + step(x - 0.1) + step(x - 0.2));
    let edges = steps.join_smooth(&[], 1e-6);
    assert_eq!((parts(&steps), edges.len()), (4, 243));
}

#[test]
fn a_slope_along_one_axis_is_one_part() {
    let mut slope = lattice(|[_, y, _]| 1.0 + y);
    assert!(slope.join_smooth(&[], 1e-6).is_empty());
    assert_eq!(parts(&slope), 1);
}

/// A small cube of value 1 between others is no slope, however steady the steps are: each value recurs, in
/// many corners or in a scattered sample. A sphere's profile recurs only at mirror images.
#[test]
fn steps_between_plateaus_are_no_slope() {
    let outside = |[x, y, z]: [f64; 3]| if x + y + z < 1.0 { 0.0 } else { 2.0 };
    let cube = |at: [f64; 3]| if at.iter().all(|x| *x > 0.8) { 4.0 } else { outside(at) };
    let mut few = lattice(cube);
    few.join_smooth(&[], 1e-6);
    assert!(few.plateau.iter().zip(&few.rates).all(|(is, rate)| *is == (*rate < 3.0)));
    let mut steps = lattice(cube);
    let edges = steps.join_smooth(&[0.0, 4.0], 1e-6);
    assert!(edges.is_empty() && steps.plateau.iter().all(|is| *is));
    assert_eq!(parts(&steps), 3);
    let radius =
        |[x, y, z]: [f64; 3]| ((x - 0.5).powi(2) + (y - 0.5).powi(2) + (z - 0.5).powi(2)).sqrt();
    let mut profile = lattice(|at| (-radius(at)).exp());
    profile.join_smooth(&[0.123], 1e-9);
    assert!(profile.plateau.iter().all(|is| !is));
    let mut layers = lattice(|[x, _, _]| (-3.0 * x).exp());
    layers.join_smooth(&[], 1e-9);
    assert!(layers.plateau.iter().all(|is| !is));
}
