//! The initial sampling, the image so far, and the rounds.

use super::{SHAPE, TILES, TOLERANCE, assert_plane, engine, plane, whole_view};
use crate::cube::Cube;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::dyadic::{Place, STEPS, unit};
use crate::vol::engine::Engine;
use crate::vol::line::node_lines::base_depths;
use crate::vol::seeds::Seed;
use crate::vol::testing::{answered, assert_close, meter};
use core::f64::consts::PI;

#[test]
fn the_initial_sampling_is_the_base_where_lines_are_polynomials() {
    let meter = meter(10_000);
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, None);
    assert_eq!(answered(&meter, plane, engine.sample_at_all_energies()), Ok(true));
    assert_eq!((meter.evaluations(), engine.sheets.len()), (729, 1));
    let scan = &engine.sheets[0].scan;
    for (node, line) in scan.tree.nodes().iter().zip(&scan.node_lines.lines) {
        let [x, y] = node.place.map(unit);
        assert_close(node.value, 1.5 + 2.0 * x - y, 1e-13);
        assert_close(line.integral, node.value, 1e-13);
    }
    assert_close(engine.brightest(), 3.5, 1e-12);
}

#[test]
fn an_initial_sampling_beyond_the_budget_makes_no_evaluation() {
    let meter = meter(728);
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, None);
    assert_eq!(answered(&meter, plane, engine.sample_at_all_energies()), Ok(false));
    assert_eq!(meter.evaluations(), 0);
}

/// A thin emitting sheet, brighter at larger x.
fn peak([x, _, z]: [f64; 3], _energy: f64) -> f64 {
    (1.0 + x) * (-((z - 0.45) / 0.04).powi(2)).exp()
}

fn of_peak(place: Place) -> f64 {
    (1.0 + unit(place[0])) * 0.04 * PI.sqrt()
}

#[test]
fn lines_of_the_base_are_refined_to_their_share_of_the_largest() {
    let meter = meter(100_000);
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, None);
    assert_eq!(answered(&meter, peak, engine.sample_at_all_energies()), Ok(true));
    let allowed = 0.2 * TOLERANCE * of_peak([STEPS, 0]);
    for (i, node) in engine.sheets[0].scan.tree.nodes().iter().enumerate() {
        let line = &engine.sheets[0].scan.node_lines.lines[i];
        assert!(line.error <= 1.01 * allowed && line.samples.len() > 9);
        assert_close(line.integral, of_peak(node.place), allowed);
    }
}

#[test]
fn later_energies_have_tolerances_of_their_own() {
    let samples = |tolerance: f64, pieces: usize| {
        let meter = meter(100_000);
        let parts = whole_view(pieces);
        let mut engine = engine(&meter, &TILES, &parts, 3, None);
        engine.add_sheets(None);
        assert_eq!(answered(&meter, peak, engine.sample_base(0, Some(&[tolerance]))), Ok(true));
        let lines = &engine.sheets[0].scan.node_lines.lines;
        assert!(lines.iter().all(|line| line.error <= tolerance / pieces as f64));
        meter.evaluations()
    };
    let [loose, strict, shared] = [(1e-3, 1), (1e-6, 1), (1e-3, 1000)].map(|(t, n)| samples(t, n));
    assert!(strict > loose);
    assert_eq!(shared, strict);
}

#[test]
fn depths_around_a_seed_are_sampled_on_the_lines_of_the_base() {
    let meter = meter(100_000);
    let parts = whole_view(1);
    let seeds = [Seed { position: [0.5, 0.5, 0.3], radius: 0.01 }];
    let vol = VolOptions::new(TOLERANCE).with_seeds(seeds);
    let mut engine = Engine { vol: &vol, ..engine(&meter, &TILES, &parts, 3, None) };
    assert_eq!(answered(&meter, plane, engine.sample_at_all_energies()), Ok(true));
    let scan = &engine.sheets[0].scan;
    let [seeded, other] = [[STEPS / 2, STEPS / 2], [0, 0]].map(|at| scan.tree.find(at).unwrap());
    let wanted = scan.seeds.depths([STEPS / 2, STEPS / 2]);
    assert!(wanted.len() > 8);
    assert!(wanted.iter().all(|depth| scan.node_lines.lines[seeded].has(*depth)));
    assert_eq!(scan.node_lines.lines[other].samples.len(), base_depths(3).len());
}

#[test]
fn the_image_so_far_has_no_error_where_a_tree_is_exact() {
    let meter = meter(10_000);
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, None);
    answered(&meter, plane, engine.sample_at_all_energies()).unwrap();
    let current = engine.assemble().unwrap();
    assert_plane(&current.maps[0][0], 1e-12);
    assert!(current.largest_error() < 1e-12);
    assert_close(current.largest_pixel(), 1.5 + 2.0 * 31.0 / 32.0 - 1.0 / 32.0, 1e-12);
    assert_eq!((current.errors(&parts.parts[0]).len(), current.guarded(0).len()), (1, 81));
}

#[test]
fn the_error_of_the_worst_line_is_in_every_pixel() {
    let meter = meter(10_000);
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, None);
    answered(&meter, plane, engine.sample_at_all_energies()).unwrap();
    engine.sheets[0].scan.node_lines.lines[17].error = 0.25;
    let error = engine.assemble().unwrap().maps[0][1].clone();
    assert!(error.pixels().iter().all(|error| (error - 0.25).abs() < 1e-12));
}

#[test]
fn a_pixel_below_0_is_wrong_by_as_much_if_no_sample_is() {
    for (sample, expected) in [(0.0, 2.0), (-1e-9, 0.0)] {
        let meter = meter(10_000);
        let parts = whole_view(1);
        let mut engine = engine(&meter, &TILES, &parts, 3, None);
        answered(&meter, |_, _| 0.0, engine.sample_at_all_energies()).unwrap();
        let node_lines = &mut engine.sheets[0].scan.node_lines;
        node_lines.lines[5].add([(77, sample)]);
        node_lines.lines.iter_mut().for_each(|line| line.integral = -2.0);
        engine.set_values(0);
        let current = engine.assemble().unwrap();
        assert_close(current.maps[0][0][(3, 4)], -2.0, 1e-12);
        assert_close(current.largest_error(), expected, 1e-11);
    }
}

#[test]
fn a_pixel_outside_the_image_is_nan() {
    let meter = meter(10_000);
    let mut parts = whole_view(1);
    parts.outside = vec![2 * 16 + 3];
    let mut engine = engine(&meter, &TILES, &parts, 3, None);
    answered(&meter, plane, engine.sample_at_all_energies()).unwrap();
    let current = engine.assemble().unwrap();
    let [image, error]: [Cube; 2] = engine.finished(&current);
    for (map, is_error) in [(&image, false), (&error, true)] {
        let band = &map.bands()[0];
        assert!(band[(2, 3)].is_nan());
        assert_eq!(band.pixels().iter().filter(|pixel| pixel.is_nan()).count(), 1);
        assert_eq!(band[(8, 8)] < 1e-9, is_error);
    }
}

/// A bright column, whose image is a Gaussian, and the sum of all pixels.
fn column([x, y, _]: [f64; 3], _energy: f64) -> f64 {
    let square = (x - 0.52).powi(2) + (y - 0.47).powi(2);
    (-square / 0.0025).exp()
}

fn sum_of_column() -> f64 {
    256.0 * 0.0025 * PI
}

#[test]
fn rounds_continue_until_the_tolerance_is_met() {
    let meter = meter(1_000_000);
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, None);
    let (current, ending) = answered(&meter, column, engine.run_from_nothing()).unwrap();
    assert_eq!(ending, StopReason::Complete);
    assert!(current.largest_error() <= TOLERANCE * current.largest_pixel());
    let sum: f64 = current.maps[0][0].pixels().iter().sum();
    assert_close(sum / sum_of_column(), 1.0, TOLERANCE);
    assert!(engine.sheets[0].scan.tree.len() > 289);
}

#[test]
fn rounds_end_with_the_budget_and_keep_what_they_have() {
    let meter = meter(1500);
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, None);
    let (current, ending) = answered(&meter, column, engine.run_from_nothing()).unwrap();
    assert_eq!(ending, StopReason::Budget);
    assert!(meter.evaluations() <= 1500);
    let sum: f64 = current.maps[0][0].pixels().iter().sum();
    assert_close(sum / sum_of_column(), 1.0, 0.3);
}

#[test]
fn rounds_end_at_the_finest_level() {
    let meter = meter(1_000_000);
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 2, None);
    engine.finest_level = 3;
    let (_, ending) = answered(&meter, column, engine.run_from_nothing()).unwrap();
    assert_eq!(ending, StopReason::MaxLevel);
    assert!(engine.sheets[0].scan.tree.finest_level() <= 3);
}

#[test]
fn the_first_tolerance_is_met_before_the_last_one() {
    let meter = meter(1_000_000);
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, None);
    engine.tolerance = 0.05;
    let (current, ending) = answered(&meter, column, engine.run_from_nothing()).unwrap();
    assert_eq!(ending, StopReason::Complete);
    assert!(engine.tolerance < 0.05 && engine.tolerance >= TOLERANCE);
    assert!(current.largest_error() <= TOLERANCE * current.largest_pixel());
    assert_eq!(SHAPE, [current.maps[0][0].height(), current.maps[0][0].width()]);
}
