//! Method `vol` on the random family: whether promises are kept, and what they cost.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::{Canonical, FromFn, Image, Method, RenderOptions, Rendering, VolOptions, render};
use emitree_problems::family::{RandomScene, random_scene};
use emitree_problems::relative_error;
use rayon::prelude::*;
use std::sync::OnceLock;

const SHAPE: [usize; 2] = [64, 64];
/// Seeds of one part of the family…
const PART: u64 = 120;
/// …of which one test renders the first ones.
const SCENES: u64 = 30;

/// A scene, its exact image, and the error of that relative to its largest pixel.
struct Known {
    scene: RandomScene,
    exact: Image,
    image_error: f64,
}

/// The scenes of one part of the seeds, made once for all tests.
fn family(part: u8) -> &'static [Known] {
    static FAMILY: [OnceLock<Vec<Known>>; 4] = [const { OnceLock::new() }; 4];
    let known = |seed| {
        let scene = random_scene(seed);
        let reference = scene.reference_image(SHAPE);
        Known { scene, exact: reference.image, image_error: reference.error }
    };
    let first = u64::from(part) * PART;
    FAMILY[usize::from(part)]
        .get_or_init(|| (first..first + SCENES).into_par_iter().map(known).collect())
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

/// One part of the scenes at one tolerance: promises `kept`, and `evaluations` as their geometric
/// mean, rounded.
fn check(tolerance: f64, part: u8, kept: usize, evaluations: &str) {
    let outcomes: Vec<Outcome> = family(part).par_iter().map(|k| outcome(k, tolerance)).collect();
    let count = outcomes.len() as f64;
    let broken: Vec<&str> = outcomes.iter().filter(|o| !o.kept).map(|o| o.name.as_str()).collect();
    let inside = outcomes.iter().map(|o| o.inside).sum::<f64>() / count;
    let mut overestimates: Vec<f64> = outcomes.iter().map(|o| o.overestimate).collect();
    overestimates.sort_by(f64::total_cmp);
    let median = overestimates[outcomes.len() / 2];
    let logs: f64 = outcomes.iter().map(|o| (o.evaluations as f64).ln()).sum();
    let mean = (logs / count).exp();

    assert!(inside >= 0.99, "{inside} of the pixels are within their estimate");
    assert!((1.0..10.0).contains(&median), "estimates are {median} times the errors");
    assert_eq!(outcomes.len() - broken.len(), kept, "broken: {broken:?}");
    assert_eq!(format!("{mean:.0}"), evaluations, "evaluations");
}

macro_rules! promises {
    ($($name:ident: $tolerance:expr, part $part:expr, $kept:expr, $evaluations:expr;)*) => {$(
        #[test]
        fn $name() {
            check($tolerance, $part, $kept, $evaluations);
        }
    )*};
}

// `… --example engine -- family 0 480 1e-1,1e-2,1e-3,1e-4` renders all of them: docs/engine.md has what is
// kept. What is missed are mostly cores and knots of a radius of 0.02 between samples that are 0.06 apart
// and more, the kind of structure that a seed is for.
promises! {
    ten_percent_seeds_0: 0.1, part 0, 30, "5556";
    ten_percent_seeds_120: 0.1, part 1, 30, "5571";
    ten_percent_seeds_240: 0.1, part 2, 30, "5806";
    ten_percent_seeds_360: 0.1, part 3, 30, "8317";
    one_percent_seeds_0: 0.01, part 0, 30, "9584";
    one_percent_seeds_120: 0.01, part 1, 30, "9577";
    one_percent_seeds_240: 0.01, part 2, 30, "9704";
    one_percent_seeds_360: 0.01, part 3, 30, "13571";
    a_tenth_of_a_percent_seeds_0: 1e-3, part 0, 30, "17129";
    a_tenth_of_a_percent_seeds_120: 1e-3, part 1, 30, "16614";
    a_tenth_of_a_percent_seeds_240: 1e-3, part 2, 29, "18553";
    a_tenth_of_a_percent_seeds_360: 1e-3, part 3, 30, "26655";
    one_in_10_000_seeds_0: 1e-4, part 0, 30, "26225";
    one_in_10_000_seeds_120: 1e-4, part 1, 30, "29549";
}
