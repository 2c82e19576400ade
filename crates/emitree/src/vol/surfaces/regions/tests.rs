//! Parts of the base lattice.

use super::*;

const CELLS: CellBox = CellBox { level: 0, low: [0; 3], cells: [8; 3] };

fn lattice(rate: impl Fn([f64; 3]) -> f64) -> BaseLattice {
    let empty = BaseLattice::new(CELLS, vec![None; 9 * 9 * 9]);
    let rate = |k: usize| Some(rate(empty.corner(k).map(|k| k as f64 / 8.0)));
    BaseLattice::new(CELLS, (0..9 * 9 * 9).map(rate).collect())
}

/// The number of edges whose ends nothing joins.
fn open(edges: &[Edge]) -> usize {
    edges.iter().filter(|edge| !edge.is_smooth).count()
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
    assert_eq!(open(&slope.join_smooth(&[], 1e-6)), 0);
    assert_eq!(parts(&slope), 1);
    let mut step = lattice(|[x, y, z]| if x < 0.45 { 1.0 + y } else { 0.1 + 0.1 * z });
    let edges = step.join_smooth(&[], 1e-6);
    assert_eq!((parts(&step), open(&edges)), (2, 81));
}

#[test]
fn successive_steps_between_constant_parts_are_no_slope() {
    // The three steps of 0.5 predict each other.
    let step = |x: f64| if x < 0.45 { 0.0 } else { 0.5 };
    let mut steps = lattice(|[x, ..]| step(x) + step(x - 0.1) + step(x - 0.2));
    let edges = steps.join_smooth(&[], 1e-6);
    assert_eq!((parts(&steps), open(&edges)), (4, 243));
}

#[test]
fn a_slope_along_one_axis_is_one_part() {
    let mut slope = lattice(|[_, y, _]| 1.0 + y);
    assert_eq!(open(&slope.join_smooth(&[], 1e-6)), 0);
    assert_eq!(parts(&slope), 1);
}

/// Four steps along x predict each other, but each value recurs in a scattered sample.
#[test]
fn steps_between_plateaus_are_no_slope() {
    let steps = |[x, y, z]: [f64; 3]| (8.0 * x).round() + y + z;
    let mut smooth = lattice(steps);
    assert_eq!(open(&smooth.join_smooth(&[0.123], 1e-6)), 0);
    assert_eq!(parts(&smooth), 1);
    let mut plateaus = lattice(steps);
    let scattered: Vec<f64> = plateaus.rates.iter().copied().flatten().collect();
    assert_eq!(open(&plateaus.join_smooth(&scattered, 1e-6)), 0);
    assert_eq!(parts(&plateaus), plateaus.rates.len());
}

/// A jump at x = 0.45 that fades out towards y = 1: by the edges alone both sides are one part.
#[test]
fn a_part_has_no_jump_between_its_corners() {
    let mut fading = lattice(|[x, y, z]| {
        let jump = if x < 0.45 { 0.0 } else { (1.0 - y).powi(2) };
        1.0 + 0.2 * x + 0.1 * z + jump
    });
    let mut edges = fading.join_smooth(&[], 1e-6);
    let is_across = |lattice: &BaseLattice, edge: &Edge| {
        let [a, b] = edge.ends.map(|end| lattice.corner(end)[0]);
        [a.min(b), a.max(b)] == [3, 4]
    };
    edges.iter_mut().for_each(|edge| edge.is_smooth = true);
    fading.divide(&edges);
    assert_eq!(parts(&fading), 1);
    // The jumps that are at least a quarter are known.
    let is_known = |lattice: &BaseLattice, edge: &Edge| {
        is_across(lattice, edge) && lattice.corner(edge.ends[0])[1] <= 4
    };
    edges
        .iter_mut()
        .filter(|edge| is_known(&fading, edge))
        .for_each(|edge| edge.is_jump = Some(true));
    fading.divide(&edges);
    assert_eq!(parts(&fading), 2);
    for edge in edges.iter().filter(|edge| fading.corner(edge.ends[0])[1] < 4) {
        let [a, b] = fading.parts(edge.ends);
        assert_eq!(a != b, is_across(&fading, edge), "{edge:?}");
    }
}

#[test]
fn the_steepest_edges_within_a_part_are_tested_until_enough_do_not_jump() {
    let mut steep =
        lattice(|[x, y, z]| (-40.0 * ((x - 0.5).powi(2) + (y - 0.4).powi(2) + z * z)).exp());
    let mut edges = steep.join_smooth(&[], 1e-6);
    // All corners are one part, whatever the differences.
    let is_smooth: Vec<bool> = edges.iter().map(|edge| edge.is_smooth).collect();
    edges.iter_mut().for_each(|edge| edge.is_smooth = true);
    steep.divide(&edges);
    edges.iter_mut().zip(is_smooth).for_each(|(edge, is_smooth)| edge.is_smooth = is_smooth);
    assert_eq!(parts(&steep), 1);
    let tests = steep.next_tests(&edges);
    assert_eq!(tests.len(), TESTS_WITHIN);
    let open = || edges.iter().filter(|edge| !edge.is_smooth).map(|edge| edge.change);
    let least = tests.iter().map(|&k| edges[k].change).fold(f64::INFINITY, f64::min);
    assert!(open().filter(|change| *change > least).count() < TESTS_WITHIN);
    assert!(open().filter(|change| *change >= least).count() >= TESTS_WITHIN);
    tests.iter().for_each(|&k| edges[k].is_jump = Some(false));
    assert!(steep.next_tests(&edges).is_empty());
}
