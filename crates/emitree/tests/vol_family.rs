//! Method `vol` on the random family: whether promises are kept, and what they cost.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::{Canonical, FromFn, Image, Method, RenderOptions, Rendering, VolOptions, render};
use emitree_problems::family::{RandomScene, random_scene};
use emitree_problems::relative_error;
use rayon::prelude::*;
use std::sync::OnceLock;

const SHAPE: [usize; 2] = [64, 64];
const SCENES: u64 = 240;

/// A scene, its exact image, and the error of that relative to its largest pixel.
struct Known {
    scene: RandomScene,
    exact: Image,
    image_error: f64,
}

/// The scenes of seeds 0 to 239, made once for all tests.
fn family() -> &'static [Known] {
    static FAMILY: OnceLock<Vec<Known>> = OnceLock::new();
    FAMILY.get_or_init(|| {
        let known = |seed| {
            let scene = random_scene(seed);
            let reference = scene.reference_image(SHAPE);
            Known { scene, exact: reference.image, image_error: reference.error }
        };
        (0..SCENES).into_par_iter().map(known).collect()
    })
}

/// One rendering against the truth.
#[derive(Debug)]
struct Outcome {
    name: String,
    kept: bool,
    evaluations: u64,
    /// The largest estimate over the largest true error.
    overestimate: f64,
    /// The share of the pixels within their own estimate.
    inside: f64,
}

fn outcome(known: &Known, tolerance: f64) -> Outcome {
    let rate = |position, _| known.scene.rate(position);
    let options = VolOptions { tolerance, ..Default::default() };
    let options = RenderOptions::new(Method::Vol(options));
    let rendering: Rendering = render(&FromFn(rate), &Canonical, SHAPE, &options).unwrap();
    let error = relative_error(&rendering.image, &known.exact);
    let estimates = rendering.error.as_ref().unwrap();
    let (_, largest) = known.exact.min_max();
    let pixels = rendering.image.pixels().iter().zip(known.exact.pixels()).zip(estimates.pixels());
    let inside = pixels
        .filter(|((found, exact), estimate)| {
            (*found - *exact).abs() <= *estimate + known.image_error * largest
        })
        .count();
    Outcome {
        name: known.scene.name(),
        kept: rendering.converged() && error <= tolerance + known.image_error,
        evaluations: rendering.evaluations,
        overestimate: rendering.estimated_error().unwrap() / error,
        inside: inside as f64 / known.exact.pixels().len() as f64,
    }
}

/// All scenes at one tolerance: `kept` promises, and `evaluations` as their geometric mean.
fn check(tolerance: f64, kept: usize, evaluations: u64) {
    let outcomes: Vec<Outcome> = family().par_iter().map(|k| outcome(k, tolerance)).collect();
    let count = outcomes.len() as f64;
    let broken: Vec<&str> = outcomes.iter().filter(|o| !o.kept).map(|o| o.name.as_str()).collect();
    let inside = outcomes.iter().map(|o| o.inside).sum::<f64>() / count;
    let mut overestimates: Vec<f64> = outcomes.iter().map(|o| o.overestimate).collect();
    overestimates.sort_by(f64::total_cmp);
    let median = overestimates[outcomes.len() / 2];
    let logs: f64 = outcomes.iter().map(|o| (o.evaluations as f64).ln()).sum();
    let mean = (logs / count).exp().round();

    assert!(inside >= 0.99, "{inside} of the pixels are within their estimate");
    assert!((1.0..10.0).contains(&median), "estimates are {median} times the errors");
    assert_eq!(outcomes.len() - broken.len(), kept, "broken: {broken:?}");
    assert_eq!(mean, evaluations as f64, "evaluations");
}

// 99 % of 240 are 237.6. What is missed are cores and knots of a radius of 0.02 between lines that
// are 0.06 apart: the kind of structure that a seed is for.

#[test]
fn promises_of_10_percent_are_kept() {
    check(0.1, 239, 1);
}

#[test]
fn promises_of_1_percent_are_kept() {
    check(0.01, 239, 1);
}

#[test]
fn promises_of_a_tenth_of_a_percent_are_kept() {
    check(1e-3, 239, 1);
}

#[test]
fn promises_of_1e_4_are_kept() {
    check(1e-4, 239, 1);
}
