//! Jumps between samples of one region, and slopes that are none.

use super::*;
use crate::vol::lattice;
use crate::vol::lowrank::WeightedView;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::octree::{Grid, Label};
use crate::vol::surfaces::samples::Samples;
use crate::vol::testing::{PANE, answered, meter, part_of, uniform};
use crate::vol::tuning::TUNING;

/// Whether G jumps between 60 samples of a box that is the whole view, and the number of evaluations that show it.
fn jumps(rate: impl Fn([f64; 3]) -> f64 + Sync, leaf: impl Fn(Label) -> Leaf) -> (bool, u64) {
    let meter = meter(1000);
    let part = part_of(PANE);
    let view = WeightedView::new(&meter, &part, 1);
    let scale = uniform([4, 4], 1.0);
    let aim = Aim { target: 0.01, scale: &scale, visible: None, sky: None, plane: None };
    let grid = Grid { edges: [1.0; 3], base: [1; 3], finest: 0 };
    let mut samples = Samples::new(0.25, 1e-4);
    let label = samples.new_label();
    let all = (0..60).map(lattice::point).map(|at| samples.add(at, rate(at), label)).collect();
    let mut search = Search::new(&view, grid, aim, 0.01, samples, 1000);
    let tree = Octree::new(grid, vec![((0, [0; 3]), leaf(label))]);
    let (low, high) = ([0.0; 3], [1.0; 3]);
    let whole = OpenBox { node: 0, low, high, level: 0, samples: all, leaves: vec![0] };
    let found = answered(&meter, |at, _| rate(at), search.jumps_within(&tree, &[whole], &[0.1]));
    (found.unwrap(), meter.evaluations())
}

#[test]
fn a_cavity_jumps_and_a_steep_slope_does_not() {
    let square =
        |at: [f64; 3]| (at[0] - 0.4).powi(2) + (at[1] - 0.6).powi(2) + (at[2] - 0.5).powi(2);
    let halvings = TUNING.surfaces.halvings as u64;
    let gas = |at: [f64; 3]| (-2.0 * square(at)).exp();
    let cavity = |at: [f64; 3]| if square(at) < 0.04 { 0.0 } else { gas(at) };
    assert_eq!(jumps(cavity, Leaf::Uncut), (true, halvings));
    assert_eq!(jumps(|at| 1.0 / (1.0 + square(at) / 0.01), Leaf::Uncut), (false, halvings));
    assert_eq!(jumps(gas, Leaf::Uncut), (false, halvings));
    // Where patches are known, their own checks decide.
    assert_eq!(jumps(cavity, |_| Leaf::Cut(Vec::new())), (false, 0));
}

#[test]
fn a_region_is_searched_again_when_it_has_twice_as_many_nodes() {
    let due = |tolerance: f64| -> Vec<usize> {
        let mut schedule = Schedule::new(tolerance);
        (0..2000).filter(|nodes| schedule.is_due(*nodes)).collect()
    };
    assert_eq!(due(1e-2), [151, 303, 607, 1215]);
    assert!(due(1e-3)[0] > 2 * due(1e-2)[0]);
}
