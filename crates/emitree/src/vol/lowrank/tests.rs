//! The search for an interpolant and what it decides, on products and on functions that are not separable.

use super::*;
use crate::projection::{Canonical, Ellipsoid};
use crate::vol::engine::base_evaluations;
use crate::vol::lattice::points_to_detect;
use crate::vol::lattice::{point, smallest_detected};
use crate::vol::lowrank::search::Assessment;
use crate::vol::seeds::Seed;
use crate::vol::testing::{PANE, Pane, answered, assert_close, meter, part_of};
use crate::vol::view::division::atlas;
use crate::vol::view::part::{Part, parts};
use crate::vol::view::scattered::WIDTH_OF_GAUSSIAN;
use crate::vol::{BASE_LEVELS, FeatureSize};
use crate::{Perspective, Viewpoint};
use std::sync::Arc;

/// One product of functions of x, y and z.
fn product([x, y, z]: [f64; 3]) -> f64 {
    (1.0 + x) * (-2.0 * y).exp() * (3.0 * z).cos()
}

/// Two of them.
fn products([x, y, z]: [f64; 3]) -> f64 {
    product([x, y, z]) + (1.0 - x * x) * y * (1.0 + z)
}

/// A step, which has no low-rank approximation.
fn step([x, y, z]: [f64; 3]) -> f64 {
    if x + 0.6 * y + 0.3 * z < 1.0 { 1.0 } else { 0.2 }
}

fn search<'a>(meter: &'a Meter, part: &'a Part<'a>) -> Search<'a> {
    Search::new(WeightedView::new(meter, part, 1), Some(0.01), false)
}

/// The largest |rate − interpolant| at points that the search has not sampled.
fn worst(search: &Search<'_>, rate: impl Fn([f64; 3]) -> f64) -> f64 {
    let points: Vec<[f64; 3]> = (5000..5200).map(point).collect();
    let values = search.interpolant.values(&points);
    points
        .iter()
        .zip(values.iter())
        .map(|(at, value)| (rate(*at) - value).abs())
        .fold(0.0, f64::max)
}

/// A search with probes that has grown so many times; the last assessment.
fn grown(
    search: &mut Search<'_>,
    meter: &Meter,
    rate: impl Fn([f64; 3]) -> f64 + Sync,
    times: usize,
) -> Result<Assessment, End> {
    let task = async {
        search.probe(1 << 20).await?;
        for _ in 0..times {
            let assessment = search.assess();
            search.grow(&assessment).await?;
        }
        Ok(search.assess())
    };
    answered(meter, |at, _| rate(at), task)
}

fn largest_left(assessment: &Assessment) -> f64 {
    let errors = assessment.cell_residuals.errors([8, 8]);
    let mut row = [0.0; 8];
    (0..8).fold(0.0, |largest, k| {
        errors.row(k, &mut row);
        row.iter().fold(largest, |largest: f64, error| largest.max(*error))
    })
}

#[test]
fn one_cross_represents_a_product() {
    for sign in [1.0, -1.0] {
        let meter = meter(100_000);
        let part = part_of(PANE);
        let mut search = search(&meter, &part);
        // Above 0 everywhere, or below.
        let rate = |[x, y, z]: [f64; 3]| sign * (1.0 + x) * (-2.0 * y).exp() * z.cos();
        let assessment = grown(&mut search, &meter, rate, 1).ok().unwrap();
        assert_eq!(search.interpolant.ranks(), [1; 3]);
        assert!(worst(&search, rate) < 1e-6);
        assert!(largest_left(&assessment) < 1e-6);
    }
}

#[test]
fn a_second_cross_reduces_the_residual_of_two_products() {
    let meter = meter(100_000);
    let part = part_of(PANE);
    let mut search = search(&meter, &part);
    let assessment = grown(&mut search, &meter, products, 1).ok().unwrap();
    assert!(largest_left(&assessment) > 1e-3);
    let grow = search.grow(&assessment);
    assert!(answered(&meter, |at, _| products(at), grow).is_ok());
    assert_eq!(search.interpolant.ranks(), [2; 3]);
    assert!(worst(&search, products) < 1e-3 * 4.0);
    assert!(largest_left(&search.assess()) < 0.1 * largest_left(&assessment));
}

#[test]
fn a_step_ends_the_search_at_its_first_fibers() {
    let meter = meter(100_000);
    let part = part_of(PANE);
    let mut search = search(&meter, &part);
    assert!(matches!(grown(&mut search, &meter, step, 1), Err(End::NotSeparable)));
    assert!(meter.evaluations() < 128 + 3 * 17 + 3 * 3 * 3 + 1, "{}", meter.evaluations());
}

#[test]
fn probes_are_doubled_and_are_those_of_one_sequence() {
    let meter = meter(100_000);
    let part = part_of(PANE);
    let mut search = search(&meter, &part);
    let first = TUNING.lowrank.first_probes;
    for expected in [first, 2 * first, 4 * first] {
        assert!(answered(&meter, |at, _| product(at), search.probe(1 << 20)).is_ok());
        assert_eq!((search.probes(), meter.evaluations()), (expected, expected as u64));
    }
    let samples = search.samples();
    assert_eq!(samples.number, 4 * first);
    for (k, (at, rate)) in samples.points.iter().zip(&samples.rates).enumerate() {
        assert_eq!(at.map(f64::to_bits), point(k).map(f64::to_bits));
        assert_close(*rate, product(*at), 1e-14);
    }
}

#[test]
fn samples_are_rates_without_the_solid_angle() {
    let meter = meter(100_000);
    let pane = Pane { density: |[x, _]| 2.0 + x, path: 3.0, ..PANE };
    let part = part_of(pane);
    let mut search = search(&meter, &part);
    let assessment = grown(&mut search, &meter, product, 1).ok().unwrap();
    // The interpolant has the solid angle in it, the samples have not.
    assert!(worst(&search, |at| 3.0 * (2.0 + at[0]) * product(at)) < 1e-4);
    assert!(largest_left(&assessment) < 1e-4);
    let samples = search.samples();
    for (at, rate) in samples.points.iter().zip(&samples.rates) {
        assert_close(*rate, 3.0 * product(*at), 1e-13);
    }
}

/// A part of which the half below x = 0.5 is in view.
fn half_in_view() -> Part<'static> {
    let viewpoint = Viewpoint { position: [0.0, -6.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let camera = Perspective::new(viewpoint, [0.6; 2], [0.0, 50.0]).unwrap();
    let body = Ellipsoid::sphere([0.0; 3], 1.0).unwrap();
    let camera = camera.with_occulters(vec![body]).unwrap();
    let tiles = [Tile { projection: &camera, shape: [8, 8], place: (0, 1) }];
    let atlas = atlas(&tiles, &[]).unwrap();
    let footing = parts(&tiles, Some(&atlas), None).parts[0].footing.clone();
    let scale = Arc::new(Image::from_pixels(1, 2, vec![1.0, 0.0]));
    Part { footing, scale, ..part_of(PANE) }
}

#[test]
fn a_residual_out_of_view_does_not_matter() {
    let beyond = |at @ [x, y, _]: [f64; 3]| product(at) + y * (-((x - 0.95) / 0.1).powi(2)).exp();
    for (part, is_whole) in [(half_in_view(), false), (part_of(PANE), true)] {
        assert!(part.is_in_view([0.3, 0.8]) && part.is_in_view([0.7, 0.8]) == is_whole);
        let meter = meter(100_000);
        let mut search = search(&meter, &part);
        let assessment = grown(&mut search, &meter, beyond, 1).ok().unwrap();
        assert_eq!(search.interpolant.ranks(), [1; 3]);
        let first = TUNING.lowrank.first_probes;
        let samples = search.samples();
        assert_eq!((search.probes(), samples.number), (first, first));
        let ascended = answered(&meter, |at, _| beyond(at), search.ascend(&assessment));
        let ascended = ascended.ok().unwrap();
        let left = [&assessment, &ascended].map(largest_left);
        let is_significant = ascended.is_significant_feature(10.0, first);
        let in_view = samples.points.len();
        if is_whole {
            assert!(in_view == first && is_significant, "{in_view}");
            assert!(left.iter().all(|left| *left > 0.1), "{left:?}");
        } else {
            assert!(in_view < 2 * first / 3 && !is_significant, "{in_view}");
            assert!(samples.points.iter().all(|at| at[0] < 0.5));
            assert!(left.iter().all(|left| *left < 1e-3), "{left:?}");
        }
    }
}

#[test]
fn an_ascent_from_the_largest_residual_finds_a_larger_one() {
    // A product with a knot beside a scattered point.
    let centre = point(57).map(|along| along + 0.03);
    let knotty = |at: [f64; 3]| {
        let square: f64 = (0..3).map(|k| (at[k] - centre[k]).powi(2)).sum();
        product(at) + 0.5 * (-square / 0.003).exp()
    };
    let meter = meter(100_000);
    let part = part_of(PANE);
    let mut search = search(&meter, &part);
    assert!(grown(&mut search, &meter, product, 1).is_ok());
    // The probes of another search contain the knot, its interpolant does not.
    let mut with_knot = self::search(&meter, &part);
    assert!(answered(&meter, |at, _| knotty(at), with_knot.probe(1 << 20)).is_ok());
    with_knot.interpolant = search.interpolant.clone();
    let assessment = with_knot.assess();
    let of_probe = knotty(point(57)) - product(point(57));
    assert_close(with_knot.last_followed(), of_probe, 1e-6);
    let ascended = answered(&meter, |at, _| knotty(at), with_knot.ascend(&assessment));
    let ascended = ascended.ok().unwrap();
    // What is left hides a feature if its effect in a pixel is beyond a share of the error allowed.
    let size = smallest_detected(1024, TUNING.verification.detection_share);
    let least =
        |rest: f64| TUNING.verification.sample_line_from / (rest * WIDTH_OF_GAUSSIAN * size);
    assert!(assessment.is_significant_feature(1.001 * least(of_probe), 1024));
    assert!(!assessment.is_significant_feature(0.999 * least(of_probe), 1024));
    assert!(ascended.is_significant_feature(0.9 * least(of_probe), 1024));
    assert!(!ascended.is_significant_feature(0.999 * least(0.5), 1024));
}

fn attempted(
    allowed: u64,
    rate: impl Fn([f64; 3]) -> f64 + Sync,
    vol: &VolOptions,
    tiles: usize,
) -> (Attempted, u64) {
    let meter = meter(allowed);
    let tile = |number| Tile { projection: &Canonical, shape: [16, 16], place: (number, tiles) };
    let tiles: Vec<Tile<'_>> = (0..tiles).map(tile).collect();
    let parts = parts(&tiles, None, None);
    let attempted = answered(
        &meter,
        |at, _| rate(at),
        attempt(&meter, &tiles, &parts, vol, None, Vec::new(), ImageOf::default()),
    );
    (attempted.unwrap_or_else(|_| Attempted::none(&parts)), meter.evaluations())
}

#[test]
fn a_product_is_an_image_and_its_samples_are_kept() {
    let (Attempted { found, known, .. }, evaluations) =
        attempted(1_000_000, product, &VolOptions::default(), 1);
    let (found, samples) = (found.unwrap(), &known.samples[0]);
    assert_eq!((found.ending, found.base_level), (StopReason::Complete, Some(3)));
    // As many probes as detect a Gaussian of a fortieth of the cube.
    assert_eq!(samples.number, points_to_detect(0.025, TUNING.lowrank.probe_detection_share));
    assert!(evaluations > samples.number as u64 && found.smallest_feature.is_some());
    let image = &found.cube.bands()[0];
    let [of_x, of_y, of_z]: [fn(f64) -> f64; 3] =
        [|x| x + 0.5 * x * x, |y| -0.5 * (-2.0 * y).exp(), |z| (3.0 * z).sin() / 3.0];
    let mean = |integral: fn(f64) -> f64, k: usize| {
        16.0 * (integral((k + 1) as f64 / 16.0) - integral(k as f64 / 16.0))
    };
    for (row, column) in [(0, 0), (3, 12), (15, 15)] {
        let expected = mean(of_x, column) * mean(of_y, row) * of_z(1.0);
        assert_close(image[(row, column)], expected, 1e-6);
    }
}

#[test]
fn there_is_no_attempt_with_seeds_or_tiles_or_a_short_budget() {
    let usual = VolOptions::default();
    let seeds = vec![Seed { position: [0.5; 3], radius: 0.01 }];
    let seeded = VolOptions { seeds, ..usual.clone() };
    let least = TUNING.lowrank.least_budget * 729;
    for (allowed, vol, tiles) in
        [(1_000_000, &seeded, 1), (1_000_000, &usual, 2), (least - 1, &usual, 1)]
    {
        let (attempted, evaluations) = attempted(allowed, product, vol, tiles);
        assert!(attempted.found.is_none() && evaluations == 0);
    }
    assert!(attempted(least, product, &usual, 1).1 > 0);
    // A seed as large as the cells of the base has no effect.
    let seeds = vec![Seed { position: [0.5; 3], radius: 0.2 }];
    let vol = VolOptions { seeds, ..usual };
    assert!(attempted(1_000_000, product, &vol, 1).0.found.is_some());
}

#[test]
fn a_step_leaves_the_image_to_the_tree() {
    let (attempted, evaluations) = attempted(1_000_000, step, &VolOptions::default(), 1);
    assert!(attempted.found.is_none() && evaluations < 729);
    assert_eq!(attempted.known.samples[0].number, TUNING.lowrank.first_probes);
}

#[test]
fn a_search_takes_a_quarter_of_the_budget_and_returns_its_image() {
    // A tilted sheet has a high rank.
    let sheet = |[x, y, z]: [f64; 3]| (-((x + 0.8 * y + 0.6 * z - 1.2) / 0.1).powi(2)).exp();
    let allowed = 4 * 729;
    let (attempted, evaluations) = attempted(allowed, sheet, &VolOptions::default(), 1);
    let ending = attempted.found.map(|made| made.ending);
    assert!(ending.is_none_or(|ending| ending == StopReason::Budget));
    assert!(evaluations <= allowed / 2, "{evaluations}");
}

#[test]
fn the_probes_needed_depend_on_tolerance_and_base_and_feature() {
    let meter = meter(0);
    let tiles = [Tile { projection: &Canonical, shape: [16, 16], place: (0, 1) }];
    let parts = parts(&tiles, None, None);
    let needed = |vol: &VolOptions, wanted: Option<f64>| {
        let attempt = Attempt {
            start: None,
            failed: None,
            meter: &meter,
            search: search(&meter, &parts.parts[0]),
            part: &parts.parts[0],
            parts: 1,
            sky_factor: 1,
            coarse_scale: Image::zeros(1, 1),
            coarse_largest: None,
            largest_of_others: 0.0,
            of_others: None,
            error: None,
            largest_weighed: None,
            outside: &[],
            pixel_share: 1.0,
            tolerance: vol.tolerance,
            most: 0.0,
            vol,
            wanted,
            smallest: None,
            before: 0,
        };
        attempt.probes_needed()
    };
    let of = |tolerance: f64| VolOptions { tolerance, ..VolOptions::default() };
    let at_tolerances =
        [0.01, 0.0299, 0.03, 0.1999, 0.2].map(|tolerance| needed(&of(tolerance), None));
    assert_eq!(at_tolerances, [1024, 1024, 512, 512, 256]);
    // As many as the points of a base finer than usual.
    for base_level in BASE_LEVELS {
        let vol = VolOptions { base_level, ..of(0.2) };
        let expected = if base_level > 3 { base_evaluations(base_level) } else { 256 };
        assert_eq!(needed(&vol, None) as u64, expected);
    }
    let of_feature = points_to_detect(0.01, TUNING.verification.detection_share);
    assert!(of_feature > 1024);
    assert_eq!(needed(&of(0.01), Some(0.01)), of_feature);
}

#[test]
fn a_feature_size_of_0_is_refused() {
    let meter = meter(1_000_000);
    let tiles = [Tile { projection: &Canonical, shape: [16, 16], place: (0, 1) }];
    let smallest_feature = Some(FeatureSize::Fraction(0.0));
    let vol = VolOptions { smallest_feature, ..VolOptions::default() };
    let parts = parts(&tiles, None, None);
    assert!(
        answered(
            &meter,
            |_, _| 1.0,
            attempt(&meter, &tiles, &parts, &vol, None, Vec::new(), ImageOf::default())
        )
        .is_err()
    );
}
