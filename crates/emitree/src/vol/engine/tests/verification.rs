//! The final verification, of images that are exact, or wrong at a given place.

use super::{TILES, TOLERANCE, engine, plane, whole_view};
use crate::meter::Meter;
use crate::vol::dyadic::{from_unit, unit};
use crate::vol::engine::Engine;
use crate::vol::engine::coverage::Coverage;
use crate::vol::engine::verification::Verdict;
use crate::vol::lattice::{point, points_to_detect, smallest_detected};
use crate::vol::testing::{answered, assert_close, meter};
use crate::vol::tuning::TUNING;
use crate::vol::view::part::Parts;
use crate::vol::view::scattered::PartSamples;

/// The error allowed.
const TARGET: f64 = 0.035;

/// An engine with the nodes of all required levels, sampled on a plane.
fn prepared<'a>(meter: &'a Meter, view: &'a Parts<'a>) -> Engine<'a> {
    let mut engine = engine(meter, &TILES, view, 3, None);
    assert_eq!(answered(meter, plane, engine.sample_at_all_energies()), Ok(true));
    engine
}

fn verdict(
    engine: &mut Engine<'_>,
    meter: &Meter,
    rate: impl Fn([f64; 3], f64) -> f64 + Sync,
) -> Verdict {
    let current = engine.assemble().ok();
    let verify = async {
        match &current {
            Some(current) => engine.verify(current, TARGET).await.ok(),
            None => None,
        }
    };
    answered(meter, rate, verify).unwrap_or(Verdict::Unaffordable)
}

#[test]
fn a_requested_feature_size_has_to_be_covered() {
    for (wanted, smallest, expected) in [
        (None, None, true),
        (None, Some(0.5), true),
        (Some(0.1), None, true),
        (Some(0.1), Some(0.1), true),
        (Some(0.1), Some(0.11), false),
    ] {
        let mut coverage = Coverage::new(wanted, None, vec![PartSamples::default()]);
        coverage.smallest = smallest;
        assert_eq!(coverage.is_sufficient(), expected, "{wanted:?} {smallest:?}");
    }
}

#[test]
fn samples_that_agree_require_no_lines_and_are_reused() {
    let meter = meter(100_000);
    let parts = whole_view(1);
    let mut engine = prepared(&meter, &parts);
    let least = TUNING.verification.least_samples as u64;
    for _ in 0..2 {
        let lines = answered(&meter, plane, engine.verify_samples(TARGET)).unwrap();
        assert!(lines.iter().all(Vec::is_empty));
        assert_eq!(meter.evaluations(), 729 + least);
    }
    let size = engine.coverage.smallest.unwrap();
    // No smaller than the distance of the samples allows, and no larger than what is usual.
    assert!(size > 0.2 / 1024.0_f64.cbrt() && size < 2.0 * smallest_detected(1024, 0.1), "{size}");
}

#[test]
fn samples_of_a_search_are_not_evaluated_again() {
    let meter = meter(100_000);
    let parts = whole_view(1);
    let mut engine = prepared(&meter, &parts);
    let points: Vec<[f64; 3]> = (0..1000).map(point).collect();
    let rates: Vec<f64> = points.iter().map(|at| plane(*at, 0.0)).collect();
    engine.coverage = Coverage::new(
        None,
        None,
        vec![PartSamples::of_probes(points.len(), &points, &rates, |_| 1.0)],
    );
    answered(&meter, plane, engine.verify_samples(TARGET)).unwrap();
    assert_eq!(meter.evaluations(), 729 + 24);
}

#[test]
fn a_requested_feature_size_determines_the_number_of_samples() {
    let meter = meter(1_000_000);
    let parts = whole_view(1);
    let mut engine = prepared(&meter, &parts);
    let size = 0.016;
    let needed = points_to_detect(size, TUNING.verification.detection_share) as u64;
    assert!(needed > 1024);
    engine.coverage = Coverage::new(Some(size), None, vec![PartSamples::default()]);
    answered(&meter, plane, engine.verify_samples(TARGET)).unwrap();
    assert!(meter.evaluations() >= 729 + needed);
    assert!(engine.coverage.is_sufficient());
}

/// A plane with a knot around a scattered sample, between all lines.
fn knot(at: [f64; 3], _energy: f64) -> f64 {
    let centre = point(100);
    let square: f64 = (0..3).map(|k| (at[k] - centre[k]).powi(2)).sum();
    plane(at, 0.0) + 20.0 * (-square / 2e-4).exp()
}

#[test]
fn a_sample_in_a_knot_requires_a_line_through_it() {
    let meter = meter(100_000);
    let parts = whole_view(1);
    let mut engine = prepared(&meter, &parts);
    let lines = answered(&meter, knot, engine.verify_samples(TARGET)).unwrap();
    let centre = point(100);
    assert!(!lines[0].is_empty());
    for (place, depths) in &lines[0] {
        for axis in 0..2 {
            assert_close(unit(place[axis]), centre[axis], 0.03);
        }
        let depth = from_unit(centre[2]);
        assert!(depths.iter().any(|found| unit(found.abs_diff(depth)) < 0.03));
    }
}

#[test]
fn an_exact_image_passes_and_the_next_verification_has_more_lines() {
    let meter = meter(100_000);
    let parts = whole_view(1);
    let mut engine = prepared(&meter, &parts);
    let mut lines = Vec::new();
    for expected in [2, 4, 4] {
        assert_eq!(verdict(&mut engine, &meter, plane), Verdict::Passed);
        assert_eq!(engine.verification_lines, expected);
        lines.push(engine.sheets[0].verification.places.len());
    }
    // 12 scattered lines and 6 at the largest errors, and then as many again each time.
    let least = TUNING.verification.least_lines;
    assert!(lines[0] > least && lines[0] <= 2 * least, "{lines:?}");
    assert!(lines[1] - lines[0] > least && lines[2] - lines[1] > least, "{lines:?}");
}

/// A plane with a column around a scattered sample, the same at all depths.
fn column([x, y, z]: [f64; 3], _energy: f64) -> f64 {
    let centre = point(100);
    let square = (x - centre[0]).powi(2) + (y - centre[1]).powi(2);
    plane([x, y, z], 0.0) + 0.3 * (-square / 2e-4).exp()
}

#[test]
fn a_column_between_lines_fails_and_requires_nodes_around_it() {
    let meter = meter(100_000);
    let parts = whole_view(1);
    let mut engine = prepared(&meter, &parts);
    assert_eq!(verdict(&mut engine, &meter, column), Verdict::Failed);
    let [x, y, _] = point(100);
    let missing = engine.sheets[0].missing_seed_places();
    let is_near =
        |place: &[u32; 2]| (unit(place[0]) - x).abs() < 0.07 && (unit(place[1]) - y).abs() < 0.07;
    assert!(missing.iter().any(is_near));
    assert!(!engine.is_strict);
    assert_close(engine.line_share, 0.2, 1e-16);
}

#[test]
fn a_column_between_nodes_of_the_finest_level_is_reported_without_new_nodes() {
    let meter = meter(100_000);
    let parts = whole_view(1);
    let mut engine = prepared(&meter, &parts);
    engine.finest_level = 3;
    assert_eq!(verdict(&mut engine, &meter, column), Verdict::AtFinestLevel);
    assert!(engine.sheets[0].missing_seed_places().is_empty());
}

#[test]
fn a_verification_beyond_the_budget_is_unaffordable() {
    // Not enough for the samples, and not for the lines.
    for more in [1000, 1030] {
        let meter = meter(729 + more);
        let parts = whole_view(1);
        let mut engine = prepared(&meter, &parts);
        assert_eq!(verdict(&mut engine, &meter, plane), Verdict::Unaffordable);
    }
}

/// A plane with a thin emitting sheet, midway between the depths of the base.
fn thin([x, y, z]: [f64; 3], _energy: f64) -> f64 {
    plane([x, y, z], 0.0) + 10.0 * (-((z - 0.4375) / 0.015).powi(2)).exp()
}

#[test]
fn structure_that_all_lines_step_over_reduces_their_tolerance() {
    let meter = meter(1_000_000);
    let parts = whole_view(1);
    let mut engine = prepared(&meter, &parts);
    assert_eq!(verdict(&mut engine, &meter, thin), Verdict::Failed);
    assert!(engine.is_strict);
    assert_close(engine.line_share, 0.2 * TUNING.verification.stricter_factor, 1e-16);
    // If that does not help, depths are finer.
    assert_eq!(engine.sheets[0].scan.depth_level, 3);
    assert_eq!(verdict(&mut engine, &meter, thin), Verdict::Failed);
    let depth_level = engine.sheets[0].scan.depth_level;
    assert_eq!(depth_level, 3 + TUNING.verification.depth_levels_per_step);
    let integral = 10.0 * 0.015 * core::f64::consts::PI.sqrt();
    for (i, node) in engine.sheets[0].scan.tree.nodes().iter().enumerate() {
        let [x, y] = node.place.map(unit);
        let line = &engine.sheets[0].scan.node_lines.lines[i];
        assert_close(line.integral, 1.5 + 2.0 * x - y + integral, TOLERANCE * 3.5);
    }
}
