//! Method `vol` on the random family: how often tolerances are met, and at what cost.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::{Canonical, FromFn, Image, RenderOptions, Rendering, VolOptions, render};
use emitree_problems::family::{RandomScene, random_scene};
use emitree_problems::relative_error;
use rayon::prelude::*;
use std::sync::OnceLock;

const SHAPE: [usize; 2] = [64, 64];
/// Scenes of one test.
const PART: u64 = 30;

/// A scene, its exact image, and the error of that relative to its largest pixel.
struct Known {
    scene: RandomScene,
    exact: Image,
    image_error: f64,
}

/// The scenes of one part of the seeds, made once for all tests.
fn family(part: u8) -> &'static [Known] {
    static FAMILY: [OnceLock<Vec<Known>>; 16] = [const { OnceLock::new() }; 16];
    let known = |seed| {
        let scene = random_scene(seed);
        let reference = scene.reference_image(SHAPE);
        Known { scene, exact: reference.image, image_error: reference.error }
    };
    let first = u64::from(part) * PART;
    FAMILY[usize::from(part)]
        .get_or_init(|| (first..first + PART).into_par_iter().map(known).collect())
}

/// One rendering against the truth.
#[derive(Debug)]
struct Outcome {
    name: String,
    met: bool,
    evaluations: u64,
    /// The largest estimate over the largest true error.
    overestimate: f64,
    /// The share of the pixels within their own estimate.
    inside: f64,
}

fn outcome(known: &Known, tolerance: f64) -> Outcome {
    let rate = |position, _| known.scene.rate(position);
    let options = VolOptions::new(tolerance);
    let options = RenderOptions::new(options);
    let rendering: Rendering = render(&FromFn(rate), &Canonical, SHAPE, &options).unwrap();
    let error = relative_error(&rendering.values, &known.exact);
    let estimates = rendering.error.as_ref().unwrap();
    let (_, largest) = known.exact.min_max();
    let pixels = rendering.values.pixels().iter().zip(known.exact.pixels()).zip(estimates.pixels());
    let inside = pixels
        .filter(|((found, exact), estimate)| {
            (*found - *exact).abs() <= *estimate + known.image_error * largest
        })
        .count();
    Outcome {
        name: known.scene.name(),
        met: rendering.converged() && error <= tolerance + known.image_error,
        evaluations: rendering.stats.evaluations,
        overestimate: rendering.estimated_error().unwrap() / error,
        inside: inside as f64 / known.exact.pixels().len() as f64,
    }
}

/// One part of the scenes at one tolerance: how often it is met, and `evaluations` as their geometric
/// mean, rounded.
fn check(tolerance: f64, part: u8, met: usize, evaluations: &str) {
    let outcomes: Vec<Outcome> = family(part).par_iter().map(|k| outcome(k, tolerance)).collect();
    let count = outcomes.len() as f64;
    let missed: Vec<&str> = outcomes.iter().filter(|o| !o.met).map(|o| o.name.as_str()).collect();
    let inside = outcomes.iter().map(|o| o.inside).sum::<f64>() / count;
    let mut overestimates: Vec<f64> = outcomes.iter().map(|o| o.overestimate).collect();
    overestimates.sort_by(f64::total_cmp);
    let median = overestimates[outcomes.len() / 2];
    let logs: f64 = outcomes.iter().map(|o| (o.evaluations as f64).ln()).sum();
    let mean = (logs / count).exp();

    assert!(inside >= 0.99, "{inside} of the pixels are within their estimate");
    assert!((1.0..10.0).contains(&median), "estimates are {median} times the errors");
    assert_eq!(outcomes.len() - missed.len(), met, "missed: {missed:?}");
    assert_eq!(format!("{mean:.0}"), evaluations, "evaluations");
}

macro_rules! tolerances_met {
    ($($name:ident: $tolerance:expr, part $part:expr, $met:expr, $evaluations:expr;)*) => {$(
        #[test]
        fn $name() {
            check($tolerance, $part, $met, $evaluations);
        }
    )*};
}

// Of 480 renderings at least 99 % meet each tolerance: 477, 477 and 480, and all of the 240 that are
// tried at 1e-4. Those that do not mostly miss cores and knots of a radius of 0.02 between samples that
// are 0.06 apart and more, the kind of structure that a seed is for.
tolerances_met! {
    ten_percent_seeds_0: 0.1, part 0, 30, "5194";
    ten_percent_seeds_30: 0.1, part 1, 29, "5073";
    ten_percent_seeds_60: 0.1, part 2, 30, "4477";
    ten_percent_seeds_90: 0.1, part 3, 30, "4942";
    ten_percent_seeds_120: 0.1, part 4, 30, "5376";
    ten_percent_seeds_150: 0.1, part 5, 29, "6034";
    ten_percent_seeds_180: 0.1, part 6, 30, "5374";
    ten_percent_seeds_210: 0.1, part 7, 30, "5803";
    ten_percent_seeds_240: 0.1, part 8, 30, "5511";
    ten_percent_seeds_270: 0.1, part 9, 29, "6554";
    ten_percent_seeds_300: 0.1, part 10, 30, "6375";
    ten_percent_seeds_330: 0.1, part 11, 30, "6491";
    ten_percent_seeds_360: 0.1, part 12, 30, "8133";
    ten_percent_seeds_390: 0.1, part 13, 30, "5672";
    ten_percent_seeds_420: 0.1, part 14, 30, "5307";
    ten_percent_seeds_450: 0.1, part 15, 30, "5814";
    one_percent_seeds_0: 0.01, part 0, 30, "9202";
    one_percent_seeds_30: 0.01, part 1, 29, "8318";
    one_percent_seeds_60: 0.01, part 2, 30, "7399";
    one_percent_seeds_90: 0.01, part 3, 30, "8225";
    one_percent_seeds_120: 0.01, part 4, 30, "9160";
    one_percent_seeds_150: 0.01, part 5, 30, "11018";
    one_percent_seeds_180: 0.01, part 6, 29, "9119";
    one_percent_seeds_210: 0.01, part 7, 30, "10198";
    one_percent_seeds_240: 0.01, part 8, 30, "9322";
    one_percent_seeds_270: 0.01, part 9, 30, "10355";
    one_percent_seeds_300: 0.01, part 10, 30, "10863";
    one_percent_seeds_330: 0.01, part 11, 30, "11230";
    one_percent_seeds_360: 0.01, part 12, 30, "13213";
    one_percent_seeds_390: 0.01, part 13, 30, "9654";
    one_percent_seeds_420: 0.01, part 14, 30, "9478";
    one_percent_seeds_450: 0.01, part 15, 30, "9749";
    a_tenth_of_a_percent_seeds_0: 1e-3, part 0, 30, "16300";
    a_tenth_of_a_percent_seeds_30: 1e-3, part 1, 30, "15470";
    a_tenth_of_a_percent_seeds_60: 1e-3, part 2, 30, "11713";
    a_tenth_of_a_percent_seeds_90: 1e-3, part 3, 30, "14482";
    a_tenth_of_a_percent_seeds_120: 1e-3, part 4, 30, "16491";
    a_tenth_of_a_percent_seeds_150: 1e-3, part 5, 30, "20445";
    a_tenth_of_a_percent_seeds_180: 1e-3, part 6, 30, "15021";
    a_tenth_of_a_percent_seeds_210: 1e-3, part 7, 30, "18892";
    a_tenth_of_a_percent_seeds_240: 1e-3, part 8, 30, "17536";
    a_tenth_of_a_percent_seeds_270: 1e-3, part 9, 30, "19742";
    a_tenth_of_a_percent_seeds_300: 1e-3, part 10, 30, "19949";
    a_tenth_of_a_percent_seeds_330: 1e-3, part 11, 30, "21578";
    a_tenth_of_a_percent_seeds_360: 1e-3, part 12, 30, "25313";
    a_tenth_of_a_percent_seeds_390: 1e-3, part 13, 30, "18440";
    a_tenth_of_a_percent_seeds_420: 1e-3, part 14, 30, "16347";
    a_tenth_of_a_percent_seeds_450: 1e-3, part 15, 30, "17183";
    one_in_10_000_seeds_0: 1e-4, part 0, 30, "26417";
    one_in_10_000_seeds_30: 1e-4, part 1, 30, "26252";
    one_in_10_000_seeds_60: 1e-4, part 2, 30, "16876";
    one_in_10_000_seeds_90: 1e-4, part 3, 30, "24430";
    one_in_10_000_seeds_120: 1e-4, part 4, 30, "26377";
    one_in_10_000_seeds_150: 1e-4, part 5, 30, "34214";
    one_in_10_000_seeds_180: 1e-4, part 6, 30, "26487";
    one_in_10_000_seeds_210: 1e-4, part 7, 30, "33921";
}
