//! Parts of the base lattice.

use super::*;

const CELLS: CellBox = CellBox { level: 0, low: [0; 3], cells: [8; 3] };

fn lattice(rate: impl Fn([f64; 3]) -> f64) -> BaseLattice {
    let empty = BaseLattice::new(CELLS, vec![None; 9 * 9 * 9]);
    let rate = |k: usize| Some(rate(empty.corner(k).map(|k| k as f64 / 8.0)));
    BaseLattice::new(CELLS, (0..9 * 9 * 9).map(rate).collect())
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

/// Four steps along x predict each other, but each value recurs in a scattered sample.
#[test]
fn steps_between_plateaus_are_no_slope() {
    let steps = |[x, y, z]: [f64; 3]| (8.0 * x).round() + y + z;
    let mut smooth = lattice(steps);
    assert!(smooth.join_smooth(&[0.123], 1e-6).is_empty());
    assert_eq!(parts(&smooth), 1);
    let mut plateaus = lattice(steps);
    let scattered: Vec<f64> = plateaus.rates.iter().copied().flatten().collect();
    assert!(plateaus.join_smooth(&scattered, 1e-6).is_empty());
    assert_eq!(parts(&plateaus), plateaus.rates.len());
}
