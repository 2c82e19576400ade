//! The lines of nodes, and the depths taken from neighbours, with known integrals.

use crate::meter::Meter;
use crate::vol::dyadic::{Place, STEPS, spacing, unit};
use crate::vol::image::block::Block;
use crate::vol::image::tree::ImageTree;
use crate::vol::line::node_lines::{LineSource, NodeLines, base_depths};
use crate::vol::sampling::Stop;
use crate::vol::testing::{
    PANE, answered, assert_close, at, lattice, line_of, lines_of, meter, view,
};
use core::f64::consts::PI;

fn tree(places: &[Place]) -> ImageTree {
    let mut tree = ImageTree::default();
    places.iter().for_each(|&place| tree.add(place));
    tree
}

fn lines(number: usize) -> NodeLines {
    let mut node_lines = NodeLines::default();
    node_lines.grow(number);
    node_lines
}

fn gaussian(z: f64, middle: f64, width: f64) -> f64 {
    (-((z - middle) / width).powi(2)).exp()
}

#[test]
fn each_missing_depth_is_sampled_once() {
    let (meter, tree, mut node_lines) = (meter(100), tree(&lattice(0)), lines(4));
    node_lines.lines[1].add([(0, 7.0)]);
    let wanted = vec![(1, vec![STEPS, 0]), (3, vec![5, 5, 9]), (1, vec![STEPS, STEPS / 2])];
    let rate = |[x, y, z]: [f64; 3], _| 100.0 * x + 10.0 * y + z;
    let view = view(&meter, &PANE);
    answered(&meter, rate, node_lines.sample(&view, &tree, &wanted)).unwrap();
    assert_eq!((meter.evaluations(), meter.batches()), (4, 1));
    let samples = |i: usize| {
        let samples = node_lines.lines[i].samples.iter();
        samples.map(|sample| (sample.depth, sample.rate)).collect::<Vec<_>>()
    };
    assert_eq!(samples(0), []);
    assert_eq!(samples(1), [(0, 7.0), (STEPS / 2, 10.5), (STEPS, 11.0)]);
    assert_eq!(samples(3), [(5, 110.0 + unit(5)), (9, 110.0 + unit(9))]);
}

#[test]
fn a_batch_beyond_the_budget_changes_nothing() {
    let (meter, tree, mut node_lines) = (meter(2), tree(&lattice(0)), lines(4));
    let wanted = vec![(0, base_depths(1))];
    let view = view(&meter, &PANE);
    let sampled = answered(&meter, |_, _| 1.0, node_lines.sample(&view, &tree, &wanted));
    assert!(matches!(sampled, Err(Stop::Budget)));
    assert_eq!((meter.evaluations(), node_lines.lines[0].samples.len()), (0, 0));
}

#[test]
fn lines_are_refined_to_the_tolerance_each_by_itself() {
    let (meter, tree, mut node_lines) = (meter(10_000), tree(&lattice(0)), lines(4));
    // The width, and with it the integral, differs from line to line.
    let width = |x: f64, y: f64| 0.03 + 0.02 * x + 0.05 * y;
    let rate = |[x, y, z]: [f64; 3], _| gaussian(z, 0.5, width(x, y));
    let wanted = (0..4).map(|i| (i, base_depths(3))).collect();
    let (view, tolerance) = (view(&meter, &PANE), 1e-5);
    answered(&meter, rate, node_lines.refine(&view, &tree, wanted, tolerance, 3)).unwrap();
    for (node, line) in tree.nodes().iter().zip(&node_lines.lines) {
        let [x, y] = node.place.map(unit);
        assert_close(line.integral, width(x, y) * PI.sqrt(), tolerance);
        assert!(line.error <= tolerance);
    }
    let samples = |i: usize| node_lines.lines[i].samples.len();
    assert!(samples(0) > samples(3), "the narrowest one needs more");
}

#[test]
fn the_error_of_a_line_depends_on_its_source() {
    let mut node_lines = lines(3);
    let rule = LineSource::Rule { block: Block::around([0, 0], 1), error: 0.25, rule: 0 };
    node_lines.sources = vec![LineSource::Full, rule, LineSource::Unknown];
    node_lines.lines.iter_mut().for_each(|line| line.error = 0.5);
    let errors: Vec<f64> = (0..3).map(|i| node_lines.error(i)).collect();
    assert_eq!(errors, [0.5, 0.25, f64::INFINITY]);
    assert_eq!((0..3).filter(|&i| node_lines.is_full(i)).collect::<Vec<_>>(), [0]);
}

#[test]
fn a_snapshot_restores_the_rules_of_lines() {
    let mut node_lines = lines(3);
    let rule = LineSource::Rule { block: Block::around([0, 0], 1), error: 0.25, rule: 0 };
    node_lines.sources = vec![LineSource::Full, rule, LineSource::Unknown];
    node_lines.lines[1].integral = 2.0;
    let snapshot = node_lines.snapshot();
    node_lines.lines.iter_mut().for_each(|line| line.integral = 3.0);
    node_lines.sources.fill(LineSource::Full);
    node_lines.restore(&snapshot);
    assert_eq!(node_lines.sources, [LineSource::Full, rule, LineSource::Unknown]);
    let integrals = node_lines.lines.iter().map(|line| line.integral);
    assert_eq!(integrals.collect::<Vec<_>>(), [3.0, 2.0, 0.0]);
}

#[test]
fn the_brightest_line_is_computed_from_the_present_samples() {
    let tree = tree(&lattice(0));
    let mut node_lines = lines_of(&tree, 1, |[x, y, _]| -1.0 - 2.0 * x - y);
    assert_close(node_lines.brightest(), 4.0, 1e-15);
    let i = tree.find([STEPS, STEPS]).unwrap();
    node_lines.sources[i] = LineSource::Unknown;
    assert_close(node_lines.brightest(), 3.0, 1e-15);
    // New samples change the result without an update.
    let meter = meter(100);
    let (view, wanted) = (view(&meter, &PANE), vec![(0, vec![STEPS / 4])]);
    answered(&meter, |_, _| 19.0, node_lines.sample(&view, &tree, &wanted)).unwrap();
    assert_close(node_lines.brightest(), 2.0 * 0.25 * (1.0 + 19.0) / 2.0 + 0.5, 1e-14);
    assert!(!node_lines.are_nowhere_negative());
    node_lines.truncate(0);
    assert!(node_lines.are_nowhere_negative());
}

/// Five lines at growing distances of the place (0, 0): 1, 2, 2, 3 and 4 spacings of level 4.
fn in_a_row() -> ImageTree {
    tree(&[at(4, 1, 0), at(4, 2, 0), at(4, 0, 2), at(4, 3, 0), at(4, 0, 4)])
}

/// A depth for each of them, on no lattice of few levels.
fn own_depth(i: usize) -> u32 {
    spacing(9) * u32::try_from(2 * i + 1).unwrap_or(0)
}

#[test]
fn a_new_line_starts_with_the_depths_refined_on_the_nearest_lines() {
    let tree = in_a_row();
    let mut node_lines = lines_of(&tree, 2, |_| 1.0);
    for (i, line) in node_lines.lines.iter_mut().enumerate() {
        line.add([(own_depth(i), 1.0), (own_depth(i) + 1, 1.0)]);
        line.samples.iter_mut().for_each(|sample| sample.opened = sample.depth == own_depth(i));
    }
    let starts = |node_lines: &NodeLines, before| {
        let starts = node_lines.starts(&tree, &[[0, 0]], before, &[1e-3], 2);
        assert!(starts[0].1.is_empty());
        starts[0].0.clone()
    };
    let with = |of: &[usize]| {
        let mut depths = base_depths(2);
        depths.extend(of.iter().map(|&i| own_depth(i)));
        depths.sort_unstable();
        depths
    };
    // Those as near as the second one.
    assert_eq!(starts(&node_lines, 5), with(&[0, 1, 2]));
    assert_eq!(starts(&node_lines, 2), with(&[0, 1]));
    assert_eq!(starts(&node_lines, 0), with(&[]));
    node_lines.sources[0] = LineSource::Unknown;
    assert_eq!(starts(&node_lines, 5), with(&[1, 2]));
}

#[test]
fn the_nearest_full_lines_are_those_before_a_node() {
    let tree = in_a_row();
    let mut node_lines = lines_of(&tree, 1, |_| 1.0);
    node_lines.sources[1] = LineSource::Unknown;
    let numbers = |before: usize| {
        let found = node_lines.nearest_full(&tree, before).find([0, 0], 9);
        found.into_iter().map(|(_, i)| i).collect::<Vec<_>>()
    };
    assert_eq!(numbers(5), [0, 2, 3, 4]);
    assert_eq!(numbers(3), [0, 2]);
}

/// Lines with a bracketed jump at a depth of 0.3 + 0.2 x.
fn stepped(tree: &ImageTree) -> NodeLines {
    let (meter, mut node_lines) = (meter(100_000), lines(tree.len()));
    let rate = |[x, _, z]: [f64; 3], _| if z < 0.3 + 0.2 * x { 0.0 } else { 1.0 };
    let wanted = (0..tree.len()).map(|i| (i, base_depths(3))).collect();
    let view = view(&meter, &PANE);
    assert!(answered(&meter, rate, node_lines.refine(&view, tree, wanted, 1e-4, 3)).is_ok());
    node_lines.sources.fill(LineSource::Full);
    node_lines.tracks_jumps = true;
    node_lines
}

#[test]
fn a_jump_on_a_plane_is_expected_where_the_plane_is() {
    let tree = tree(&lattice(2));
    let mut node_lines = stepped(&tree);
    let place = at(4, 7, 5);
    let depth = 0.3 + 0.2 * 7.0 / 16.0;
    let starts = node_lines.starts(&tree, &[place], tree.len(), &[1e-4], 3);
    let (depths, brackets) = &starts[0];
    assert_eq!(brackets.len(), 1);
    let [low, high] = [brackets[0].low, brackets[0].high];
    assert!(unit(low) <= depth && depth <= unit(high) && unit(high - low) < 1e-2);
    assert!([low, high].iter().all(|end| depths.contains(end)));
    // The depths that bracket the jumps of neighbours are not taken over.
    assert_eq!(depths.len(), base_depths(3).len() + 2);
    node_lines.tracks_jumps = false;
    assert!(node_lines.starts(&tree, &[place], tree.len(), &[1e-4], 3)[0].1.is_empty());
}

#[test]
fn two_samples_beside_the_expected_jump_are_enough() {
    let mut tree = tree(&lattice(2));
    let mut node_lines = stepped(&tree);
    let first = tree.len();
    tree.add(at(4, 7, 5));
    node_lines.grow(tree.len());
    let wanted = node_lines.start(&tree, &[first], first, 1e-4, 3);
    let begun = wanted[0].1.len();
    let meter = meter(1000);
    let rate = |[x, _, z]: [f64; 3], _| if z < 0.3 + 0.2 * x { 0.0 } else { 1.0 };
    let view = view(&meter, &PANE);
    answered(&meter, rate, node_lines.refine(&view, &tree, wanted, 1e-2, 3)).unwrap();
    assert_eq!(node_lines.lines[first].samples.len(), begun);
    assert_close(node_lines.lines[first].integral, 0.7 - 0.2 * 7.0 / 16.0, 1e-2);
}

/// A thin emitting sheet at a depth of 0.3, between all depths of the base.
const THIN: f64 = 0.005;

fn thin([_, _, z]: [f64; 3], _energy: f64) -> f64 {
    gaussian(z, 0.3, THIN)
}

/// Samples the structure of the line `first` on the lines around it.
fn follow(
    node_lines: &mut NodeLines,
    meter: &Meter,
    tree: &ImageTree,
    first: usize,
    tolerance: f64,
    rate: impl Fn([f64; 3], f64) -> f64 + Sync,
) {
    let (view, found) = (view(meter, &PANE), [first]);
    let followed = node_lines.follow(&view, tree, &found, tolerance, 2);
    assert!(answered(meter, rate, followed).is_ok());
}

#[test]
fn structure_found_on_one_line_is_sampled_on_adjacent_ones_in_turn() {
    let tree = tree(&lattice(2));
    let mut node_lines = lines_of(&tree, 2, |at| thin(at, 0.0));
    let (first, closed) = (tree.find(at(2, 1, 1)).unwrap(), tree.find(at(2, 4, 0)).unwrap());
    node_lines.sources[closed] = LineSource::Unknown;
    let (meter, tolerance) = (meter(100_000), 1e-5);
    let view = view(&meter, &PANE);
    let wanted = vec![(first, base_depths(7))];
    answered(&meter, thin, node_lines.refine(&view, &tree, wanted, tolerance, 2)).unwrap();
    let alone = node_lines.lines.iter().filter(|line| line.integral > 1e-4).count();
    assert_eq!(alone, 1);
    follow(&mut node_lines, &meter, &tree, first, tolerance, thin);
    for (i, line) in node_lines.lines.iter().enumerate() {
        let expected = if i == closed { 0.0 } else { THIN * PI.sqrt() };
        assert_close(line.integral, expected, 2.0 * tolerance);
    }
    // All lines have these samples now.
    let before = meter.evaluations();
    follow(&mut node_lines, &meter, &tree, first, tolerance, thin);
    assert_eq!(meter.evaluations(), before);
}

#[test]
fn structure_is_searched_for_on_the_adjacent_lines_only() {
    let tree = tree(&lattice(2));
    let mut node_lines = lines_of(&tree, 2, |_| 0.0);
    let first = tree.find(at(2, 1, 1)).unwrap();
    node_lines.lines[first] = line_of(7, |z| thin([0.0, 0.0, z], 0.0));
    node_lines.lines[first].assess(1e-5, 2);
    let meter = meter(100_000);
    // The other lines are dark at that depth.
    follow(&mut node_lines, &meter, &tree, first, 1e-5, |_, _| 0.0);
    let base = base_depths(2).len();
    for (i, (node, line)) in tree.nodes().iter().zip(&node_lines.lines).enumerate() {
        let next = (0..2).all(|k| node.place[k].abs_diff(at(2, 1, 1)[k]) <= spacing(2));
        assert_eq!(line.samples.len() > base, next || i == first, "{node:?}");
    }
}

#[test]
fn structure_of_small_effect_is_not_searched_for_elsewhere() {
    let tree = tree(&lattice(2));
    let first = tree.find(at(2, 1, 1)).unwrap();
    let found = THIN * PI.sqrt();
    for (tolerance, is_small) in [(found, true), (0.1 * found, false)] {
        let mut node_lines = lines_of(&tree, 2, |_| 0.0);
        let meter = meter(100_000);
        let wanted = vec![(first, base_depths(7))];
        let view = view(&meter, &PANE);
        answered(&meter, thin, node_lines.refine(&view, &tree, wanted, 1e-6, 2)).unwrap();
        let before = meter.evaluations();
        follow(&mut node_lines, &meter, &tree, first, tolerance, |_, _| 0.0);
        assert_eq!(meter.evaluations() == before, is_small, "{tolerance}");
    }
}
