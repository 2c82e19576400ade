//! Method `vol` against exact images, against itself, and at its limits.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::progress::Frame;
use emitree::vol::Seed;
use emitree::{
    Canonical, Equirectangular, FromFn, Image, Method, RenderError, RenderOptions, Rendering,
    StopReason, Viewpoint, VolOptions, render,
};
use emitree_problems::catalogue::{Problem, problem};
use emitree_problems::deep::random_deep;
use emitree_problems::relative_error;
use std::ops::ControlFlow;
use std::sync::Mutex;

const SHAPE: [usize; 2] = [64, 64];

fn vol(tolerance: f64) -> Method {
    Method::Vol(VolOptions::new(tolerance))
}

fn rendered(problem: &Problem, shape: [usize; 2], options: &RenderOptions<'_>) -> Rendering {
    render(&FromFn(|position, _| problem.rate(position)), &Canonical, shape, options).unwrap()
}

fn at_tolerance(name: &str, tolerance: f64) -> (Rendering, f64) {
    let problem = problem(name).unwrap();
    let rendering = rendered(&problem, SHAPE, &RenderOptions::new(vol(tolerance)));
    let error = relative_error(&rendering.values, &problem.exact_image(SHAPE));
    (rendering, error)
}

#[test]
fn tolerances_are_met_from_10_percent_to_1e_5() {
    for name in ["eq8", "beta", "gaussians", "shock"] {
        for tolerance in [0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-5] {
            let (rendering, error) = at_tolerance(name, tolerance);
            let estimate = rendering.estimated_error().unwrap();
            assert!(rendering.converged(), "{name} {tolerance}: {:?}", rendering.stats.ending);
            assert!(error <= tolerance && estimate <= tolerance, "{name} {tolerance}: {error}");
            // Where g jumps the largest estimate may fall a little short of the largest error.
            let covered = error <= estimate || name == "shock";
            assert!(covered, "{name} {tolerance}: true {error}, estimate {estimate}");
        }
    }
    for tolerance in [0.1, 0.01, 1e-3] {
        let (rendering, error) = at_tolerance("shell", tolerance);
        assert!(rendering.converged() && error <= tolerance, "shell {tolerance}: {error}");
    }
}

/// Where g jumps, the tolerance is met, or the rendering has not converged; and no pixel of g ≥ 0 is negative
/// beyond its estimate.
#[test]
fn jumps_are_met_or_reported() {
    for (name, tolerance) in [("shock", 1e-3), ("ball", 0.1), ("ball", 0.02), ("nebula", 0.1)] {
        let (rendering, error) = at_tolerance(name, tolerance);
        assert!(!rendering.converged() || error <= tolerance, "{name} {tolerance}: {error}");
        let estimates = rendering.error.as_ref().unwrap().pixels();
        for (pixel, estimate) in rendering.values.pixels().iter().zip(estimates) {
            assert!(*pixel >= -estimate, "{name} {tolerance}: {pixel} with estimate {estimate}");
        }
    }
}

#[test]
fn small_pixels_cost_no_evaluations() {
    let problem = problem("eq8").unwrap();
    let cost = |pixels| {
        rendered(&problem, [pixels; 2], &RenderOptions::new(vol(1e-3))).stats.evaluations as f64
    };
    let (few, many) = (cost(64), cost(4096));
    assert!(many <= 1.2 * few, "{few} for 64 x 64, {many} for 4096 x 4096");
}

#[test]
fn odd_shapes_meet_the_tolerance() {
    let problem = problem("gaussians").unwrap();
    for shape in [[1, 1], [1, 100], [77, 3], [33, 50]] {
        let rendering = rendered(&problem, shape, &RenderOptions::new(vol(0.01)));
        let error = relative_error(&rendering.values, &problem.exact_image(shape));
        assert!(rendering.converged() && error <= 0.01, "{shape:?}: {error}");
    }
}

#[test]
fn threads_and_batch_sizes_do_not_change_a_bit() {
    let problem = problem("beta").unwrap();
    let with_threads = |threads: usize, batch_size: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = RenderOptions::new(vol(0.01)).with_batch_size(batch_size);
        pool.install(|| rendered(&problem, SHAPE, &options))
    };
    let one = with_threads(1, u64::MAX);
    for (threads, batch_size) in [(2, u64::MAX), (3, 100), (1, 7)] {
        let other = with_threads(threads, batch_size);
        assert_eq!((&one.values, &one.error), (&other.values, &other.error));
        assert_eq!(one.stats.evaluations, other.stats.evaluations);
        assert!(other.stats.evaluations <= other.stats.batches.saturating_mul(batch_size));
    }
}

#[test]
fn a_budget_is_kept_and_its_image_is_as_good_as_is_said() {
    let problem = problem("eq8").unwrap();
    let exact = problem.exact_image(SHAPE);
    let mut errors = Vec::new();
    for max_evaluations in [27, 100, 400, 800, 1500, 3000, 6000, 12_000] {
        let options = RenderOptions::new(vol(1e-15)).with_max_evaluations(max_evaluations);
        let rendering = rendered(&problem, SHAPE, &options);
        assert!(rendering.stats.evaluations <= max_evaluations);
        assert!(
            2 * rendering.stats.evaluations > max_evaluations,
            "{}",
            rendering.stats.evaluations
        );
        assert_eq!(rendering.stats.ending, StopReason::Budget);
        let (error, estimate) =
            (relative_error(&rendering.values, &exact), rendering.estimated_error().unwrap());
        // The first few samples miss the peak.
        assert!(
            max_evaluations < 800 || error <= estimate,
            "{max_evaluations}: {error} {estimate}"
        );
        errors.push(error);
    }
    assert!(errors[4] < 0.1 && errors[5] < 0.01 && errors[7] < 1e-3, "{errors:?}");

    let too_few = RenderOptions::new(vol(0.01)).with_max_evaluations(26);
    let emission = FromFn(|position, _| problem.rate(position));
    let error = render(&emission, &Canonical, SHAPE, &too_few).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`max_evaluations` allows 26 evaluations, but the initial sampling of 3 x 3 lines in 3 depths \
         needs 27"
    );
}

/// A budget that makes the base coarser omits requested samples: it never converges.
#[test]
fn a_coarser_base_is_named_and_not_called_converged() {
    let peak = FromFn(|[x, _, z]: [f64; 3], _| (-1e3 * (z - 0.44).powi(2)).exp() * (1.0 + x));
    for max_evaluations in [27, 64, 90, 124, 200, 700] {
        let options = RenderOptions::new(vol(0.01)).with_max_evaluations(max_evaluations);
        let rendering = render(&peak, &Canonical, [16, 16], &options).unwrap();
        assert_eq!(rendering.stats.ending, StopReason::Budget, "{max_evaluations}");
        assert_eq!(rendering.stats.base_level, Some(if max_evaluations < 125 { 1 } else { 2 }));
    }
    let enough = render(&peak, &Canonical, [16, 16], &RenderOptions::new(vol(0.01))).unwrap();
    assert_eq!((enough.stats.ending, enough.stats.base_level), (StopReason::Complete, Some(3)));
}

/// What cancels along each line leaves an image of rounding errors, which is good enough.
#[test]
fn an_image_that_cancels_to_nothing_ends() {
    let odd = FromFn(|[x, _, z]: [f64; 3], _| (z - 0.5).powi(3) * (3.0 * x).sin());
    let rendering = render(&odd, &Canonical, [9, 5], &RenderOptions::new(vol(0.01))).unwrap();
    assert!(rendering.converged());
    assert!(rendering.values.pixels().iter().all(|pixel| pixel.abs() < 1e-9));
}

/// A row of many pixels across an edge: memory and time follow the pixels, not their square.
#[test]
fn long_narrow_images_are_made() {
    let edge = FromFn(|[x, _, _]: [f64; 3], _| if x > 0.37 { 1.0 } else { 2.0 });
    for shape in [[1, 20_000], [20_000, 1]] {
        let options = RenderOptions::new(vol(0.01)).with_max_evaluations(20_000);
        let rendering = render(&edge, &Canonical, shape, &options).unwrap();
        let mean = rendering.values.pixels().iter().sum::<f64>() / 20_000.0;
        assert!((mean - 1.37).abs() < 1e-3, "{shape:?}: {mean}");
    }
}

/// A knot of radius 0.004, between the samples of the base lattice.
fn knot(position: [f64; 3], _: [f64; 3]) -> f64 {
    let centre = [0.3, 0.62, 0.4];
    let squares: f64 = (0..3).map(|i| (position[i] - centre[i]).powi(2)).sum();
    1.0 + 400.0 * (-squares / (2.0 * 0.004_f64.powi(2))).exp()
}

/// To 1 %, with seeds.
fn with_seeds(seeds: &[Seed]) -> Method {
    let seeds = seeds.to_vec();
    Method::Vol(VolOptions::new(0.01).with_seeds(seeds))
}

#[test]
fn a_seed_shows_a_knot_between_the_samples() {
    let seeds = [Seed { position: [0.301, 0.618, 0.4], radius: 0.004 }];
    let image = |seeds: &[Seed]| {
        let options = RenderOptions::new(with_seeds(seeds));
        render(&FromFn(knot), &Canonical, SHAPE, &options).unwrap().values
    };
    // The knot's integral over the cube: 400 (2 π)^(3/2) 0.004³.
    let exact = 1.0 + 400.0 * (2.0 * core::f64::consts::PI).powf(1.5) * 0.004_f64.powi(3);
    let mean = |image: &Image| image.pixels().iter().sum::<f64>() / 4096.0;
    assert!((mean(&image(&seeds)) - exact).abs() < 1e-5, "{}", mean(&image(&seeds)));
    assert!(image(&seeds).min_max().1 > 2.0, "{:?}", image(&seeds).min_max());
    assert!((mean(&image(&[])) - 1.0).abs() < 1e-12, "found without: choose a smaller knot");
}

#[test]
fn seeds_of_any_size_do_no_harm() {
    let cost = |seeds: &[Seed]| {
        let options = RenderOptions::new(with_seeds(seeds));
        let peak = FromFn(|[x, y, z]: [f64; 3], _| (-30.0 * (x * x + y * y + z * z)).exp());
        let rendering = render(&peak, &Canonical, SHAPE, &options).unwrap();
        assert!(rendering.converged());
        rendering.stats.evaluations
    };
    let at = |position, radius| cost(&[Seed { position, radius }]);
    assert_eq!(at([0.5; 3], 1e6), cost(&[]), "nothing to look at more closely");
    assert_eq!(at([5.0; 3], 0.1), cost(&[]), "outside the view");
    assert!(at([0.3, 0.6, 0.4], 1e-9) < cost(&[]) + 20_000);

    let message = |seed| {
        let seeds = [seed];
        let options = RenderOptions::new(with_seeds(&seeds));
        render(&FromFn(|_, _| 1.0), &Canonical, [2, 2], &options).unwrap_err().to_string()
    };
    let flat = message(Seed { position: [0.5; 3], radius: 0.0 });
    assert!(flat.starts_with("`seed.radius` is") && flat.ends_with("a finite length above 0"));
    let nowhere = message(Seed { position: [0.5, f64::NAN, 0.5], radius: 1.0 });
    assert!(nowhere.starts_with("`seed.position` is"), "{nowhere}");
}

/// With a budget, what seeds have named comes first, and nothing converges without it.
#[test]
fn seeds_come_first_when_the_budget_is_short() {
    let seeds = [Seed { position: [0.3, 0.62, 0.4], radius: 0.004 }];
    for max_evaluations in [729, 1_000, 2_000] {
        let options = RenderOptions::new(with_seeds(&seeds)).with_max_evaluations(max_evaluations);
        let rendering = render(&FromFn(knot), &Canonical, SHAPE, &options).unwrap();
        assert_eq!(rendering.stats.ending, StopReason::Budget, "{max_evaluations}");
        assert!(
            rendering.stats.evaluations >= 729 && rendering.stats.evaluations <= max_evaluations
        );
    }
}

/// Nine depths step over a sheet so thin; scattered samples do not, whatever the base.
#[test]
fn a_thin_sheet_that_lines_step_over_is_detected() {
    let sheet =
        |[_, _, z]: [f64; 3], _: [f64; 3]| 1.0 + 20.0 * (-((z - 0.44) / 0.008_f64).powi(2)).exp();
    let exact = 1.0 + 20.0 * 0.008 * core::f64::consts::PI.sqrt();
    let pixel = |base_level| {
        let options = RenderOptions::new(VolOptions::new(0.01).with_base_level(base_level));
        render(&FromFn(sheet), &Canonical, [8, 8], &options).unwrap().values[(3, 3)]
    };
    for base_level in [3, 5] {
        let found = pixel(base_level);
        assert!((found - exact).abs() < 0.01 * exact, "{base_level}: {found}, expected {exact}");
    }
}

#[test]
fn a_small_bright_knot_that_one_sample_meets_is_followed_down() {
    // One base sample, (0.5, 0.25, 0.625), is 0.004 beside the middle of a knot of width 0.01.
    let knot = |[x, y, z]: [f64; 3], _: [f64; 3]| {
        let squares = (x - 0.503_f64).powi(2) + (y - 0.252_f64).powi(2) + (z - 0.626_f64).powi(2);
        0.1 + 20.0 * (-squares / (2.0 * 0.01_f64.powi(2))).exp()
    };
    let options = RenderOptions::new(vol(0.01));
    let rendering = render(&FromFn(knot), &Canonical, SHAPE, &options).unwrap();
    let exact = 0.1 + 20.0 * (2.0 * core::f64::consts::PI).powf(1.5) * 0.01_f64.powi(3);
    let mean = rendering.values.pixels().iter().sum::<f64>() / 4096.0;
    assert!((mean - exact).abs() < 1e-3 * exact, "{mean} {exact}");
    assert!(rendering.converged());
}

#[test]
fn the_intermediate_images_get_better_and_end_at_the_last() {
    let problem = problem("gaussians").unwrap();
    let exact = problem.exact_image(SHAPE);
    let frames: Mutex<Vec<(u64, u64, Image)>> = Mutex::default();
    let keep = |frame: &Frame<'_>| {
        let mut frames = frames.lock().unwrap();
        frames.push((frame.evaluations, frame.batches, frame.image.clone()));
        ControlFlow::Continue(())
    };
    let options = RenderOptions::new(vol(1e-3)).with_frame(&keep);
    let rendering = rendered(&problem, SHAPE, &options);
    let frames = frames.into_inner().unwrap();
    let (first, last) = (&frames[0], &frames[frames.len() - 1]);
    assert_eq!(last.2, rendering.values);
    assert_eq!((last.0, last.1), (rendering.stats.evaluations, rendering.stats.batches));
    assert!(frames.is_sorted_by_key(|frame| frame.0));
    assert!(relative_error(&first.2, &exact) > 30.0 * relative_error(&last.2, &exact));

    let stop = |_: &Frame<'_>| ControlFlow::Break(());
    let options = RenderOptions::new(vol(1e-3)).with_frame(&stop);
    let emission = FromFn(|position, _| problem.rate(position));
    let error = render(&emission, &Canonical, SHAPE, &options).unwrap_err();
    assert_eq!(error, RenderError::Interrupted);
}

/// A uniform emission has the same radiance in each pixel of a wide camera: pixels are
/// means over solid angles, and those at the poles are small.
#[test]
fn a_uniform_glow_is_uniform_over_the_whole_sky() {
    let viewpoint = Viewpoint { position: [0.0; 3], target: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0] };
    let sky = [core::f64::consts::TAU, core::f64::consts::PI];
    let camera = Equirectangular::new(viewpoint, sky, [0.0, 2.0]).unwrap();
    let uniform = FromFn(|_, _| 3.0);
    let rendering = render(&uniform, &camera, [18, 40], &RenderOptions::new(vol(1e-3))).unwrap();
    let (low, high) = rendering.values.min_max();
    assert!((low - 6.0).abs() < 6e-3 && (high - 6.0).abs() < 6e-3, "{low} {high}");
}

#[test]
fn nothing_gives_an_image_of_nothing() {
    let dark = FromFn(|_, _| 0.0);
    let rendering = render(&dark, &Canonical, [5, 9], &RenderOptions::new(vol(1e-5))).unwrap();
    assert_eq!(rendering.values, Image::zeros(5, 9));
    assert!(rendering.converged());
    assert_eq!(rendering.estimated_error(), Some(0.0));
}

#[test]
fn options_out_of_range_are_named() {
    let message = |tolerance, base_level| {
        let method = Method::Vol(VolOptions::new(tolerance).with_base_level(base_level));
        let uniform = FromFn(|_, _| 1.0);
        render(&uniform, &Canonical, [2, 2], &RenderOptions::new(method)).unwrap_err().to_string()
    };
    let expected = "a fraction above 0 and below 1";
    assert_eq!(message(0.0, 3), format!("`tolerance` is 0: expected {expected}"));
    assert_eq!(message(1.0, 3), format!("`tolerance` is 1: expected {expected}"));
    assert_eq!(message(f64::NAN, 3), format!("`tolerance` is NaN: expected {expected}"));
    assert_eq!(message(0.1, 1), "`base_level` is 1: expected 2 to 7");
    assert_eq!(message(0.1, 8), "`base_level` is 8: expected 2 to 7");
}

/// A depth range ten times as long as the emission costs a few times what a short one does.
#[test]
fn long_depth_ranges_cost_what_they_cost() {
    let evaluations = |seed, factor| {
        let scene = random_deep(seed, factor);
        let emission = FromFn(|position, _| scene.rate(position));
        let options = RenderOptions::new(VolOptions::new(0.01));
        let rendering = render(&emission, &Canonical, [64, 64], &options).unwrap();
        let error = relative_error(&rendering.values, &scene.exact_image([64, 64]));
        assert!(rendering.converged() && error <= 0.01, "{seed}: {error}");
        rendering.stats.evaluations
    };
    let total = |factor| (0..12).map(|seed| evaluations(seed, factor)).sum::<u64>();
    assert_eq!([1.0, 10.0].map(total), [23_430, 89_320]);
}

/// Nothing is known of a view in which no sample has emission.
#[test]
fn a_dark_view_is_sampled_eight_times_as_finely() {
    let options = RenderOptions::new(VolOptions::new(0.01));
    let dark = render(&FromFn(|_, _| 0.0), &Canonical, [16, 16], &options).unwrap();
    assert!(dark.converged() && dark.stats.evaluations > 8192, "{}", dark.stats.evaluations);
    let uniform = render(&FromFn(|_, _| 1.0), &Canonical, [16, 16], &options).unwrap();
    assert!(uniform.converged() && uniform.stats.evaluations < 2048);
}
