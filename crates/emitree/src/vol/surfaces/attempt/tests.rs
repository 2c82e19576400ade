//! Surfaces of balls: accuracy, cost, and limits.

use super::*;
use crate::vol::testing::{PANE, answered, meter, part_of, uniform};

const SHAPE: [usize; 2] = [32, 32];
const CENTRE: [f64; 3] = [0.51, 0.48, 0.5];

/// A ball of radius 0.3, bright by 1 more than the rest.
fn ball(at: [f64; 3], background: f64) -> f64 {
    let square = (0..3).map(|k| (at[k] - CENTRE[k]).powi(2)).sum::<f64>();
    background + if square < 0.09 { 1.0 } else { 0.0 }
}

/// The mean chord of a pixel.
fn exact(pixel: usize) -> f64 {
    const LINES: usize = 64;
    let [row, column] = [pixel / SHAPE[1], pixel % SHAPE[1]];
    let chord = |k: usize| {
        let place = |pixel: usize, k: usize| {
            (pixel as f64 + (k as f64 + 0.5) / LINES as f64) / SHAPE[0] as f64
        };
        let [x, y] = [place(column, k % LINES), place(row, k / LINES)];
        let square = 0.09 - (x - CENTRE[0]).powi(2) - (y - CENTRE[1]).powi(2);
        2.0 * square.max(0.0).sqrt()
    };
    (0..LINES * LINES).map(chord).sum::<f64>() / (LINES * LINES) as f64
}

fn found(rate: impl Fn([f64; 3]) -> f64 + Sync, tolerance: f64, most: u64) -> (Option<Found>, u64) {
    let meter = meter(10_000_000);
    let part = part_of(PANE);
    let view = WeightedView::new(&meter, &part, 1);
    let scale = uniform(SHAPE, 1.0);
    let (known, limbs) = (&[][..], None);
    let least_samples = 0;
    let request = Request {
        view: &view,
        scale: &scale,
        tolerance,
        most,
        known,
        hits: &[],
        least_samples,
        limbs,
        lines: None,
        sky: None,
        plane: None,
    };
    let (found, samples) = answered(&meter, |at, _| rate(at), attempt(&request)).unwrap();
    assert!(found.is_none() || samples.len() >= TUNING.surfaces.scattered);
    (found, meter.evaluations())
}

#[test]
fn a_ball_is_found_with_its_errors_and_at_this_cost() {
    let (found, evaluations) = found(|at| ball(at, 0.0), 0.01, u64::MAX);
    let found = found.unwrap();
    let (mut worst, mut largest): (f64, f64) = (0.0, 0.0);
    let mut within = 0;
    for (pixel, (value, error)) in found.image.pixels().iter().zip(found.error.pixels()).enumerate()
    {
        let difference = (value - exact(pixel)).abs();
        worst = worst.max(difference);
        largest = largest.max(exact(pixel));
        within += usize::from(difference <= error + 1e-3 * largest);
    }
    assert!(worst < 0.01 * largest, "{}", worst / largest);
    assert!(found.error.largest() > 0.5 * worst, "{}", found.error.largest());
    assert!(within as f64 > 0.98 * found.image.pixels().len() as f64, "{within}");
    assert!(evaluations < 9_000, "{evaluations}");
}

#[test]
fn results_have_the_same_bits_each_time() {
    let both = [(); 2].map(|()| found(|at| ball(at, 0.2 + 0.1 * at[0]), 0.02, u64::MAX));
    let [(Some(a), first), (Some(b), second)] = both else { panic!("surfaces are found") };
    assert_eq!((a.image, a.error, first), (b.image, b.error, second));
}

#[test]
fn a_search_takes_no_more_than_it_may() {
    for most in [100, 2_000, 4_000] {
        let (found, evaluations) = found(|at| ball(at, 0.0), 0.01, most);
        assert!(found.is_none() && evaluations <= most, "{most}: {evaluations}");
    }
}

#[test]
fn structure_that_is_no_region_is_left_to_the_tree() {
    let noise = |at: [f64; 3]| (at[0] * 311.7 + at[1] * 127.1 + at[2] * 74.7).sin() + 1.5;
    assert!(found(noise, 0.01, 50_000).0.is_none());
}

#[test]
fn cells_are_about_cubes() {
    let meter = meter(0);
    let part = part_of(PANE);
    let view = WeightedView::new(&meter, &part, 1);
    let grid = grid(&view, 0.01);
    assert_eq!((grid.base, grid.finest), ([8; 3], TUNING.surfaces.levels));
}
