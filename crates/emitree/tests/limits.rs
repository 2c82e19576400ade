//! Limits end every rendering, with the best image so far.

use emitree::los::{LosOptions, Steps};
use emitree::projection::{Bounds, Ellipsoid, GeometryError};
use emitree::refinement::Threshold;
use emitree::tree::BuildOptions;
use emitree::{
    FromFn, Method, Perspective, RenderError, RenderOptions, StopReason, Viewpoint, VolOptions,
    render,
};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::sleep;
use std::time::Duration;

/// A sphere far from the middle of the view, so that most lines have no part in it.
fn camera(distance: f64, centre: [f64; 3]) -> Result<Perspective, GeometryError> {
    let viewpoint =
        Viewpoint { position: [0.0, -distance, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let camera = Perspective::new(viewpoint, [0.5, 0.5], [0.0, f64::INFINITY])?;
    Ok(camera.with_bounds(Bounds::Ellipsoid(Ellipsoid::sphere(centre, 1.0)?)))
}

#[test]
fn small_budgets_end_where_most_lines_see_nothing() {
    let emission = FromFn(|[x, y, z]: [f64; 3], _| (-(x * x + y * y + z * z)).exp());
    for (distance, centre) in [(100.0, [1.0, 0.0, 1.5]), (10.0, [0.0, -30.0, 0.0])] {
        let camera = camera(distance, centre).unwrap();
        for max_evaluations in [27, 200, 729, 1_000, 2_000, 5_000] {
            let method = Method::Vol(VolOptions::default());
            let options = RenderOptions::new(method).with_max_evaluations(max_evaluations);
            let rendering = render(&emission, &camera, [16, 16], &options).unwrap();
            assert!(rendering.stats.evaluations <= max_evaluations, "{max_evaluations}");
        }
    }
}

#[test]
fn the_time_ends_every_method_with_the_best_image_so_far() {
    // 50 microseconds and more for each evaluation: none of these would end in minutes.
    let slow = FromFn(|[x, y, z]: [f64; 3], _: [f64; 3]| {
        sleep(Duration::from_micros(50));
        if (20.0 * x).sin() * (17.0 * y).cos() > (9.0 * z).sin() { 1.0 } else { 0.0 }
    });
    let vol = VolOptions::new(1e-4);
    let paper = BuildOptions::new(Threshold::Relative(1e-6));
    let adaptive = LosOptions::new(1, Steps::Adaptive(1e-6));
    for method in [Method::Vol(vol), Method::Paper(paper), Method::Los(adaptive)] {
        let options = RenderOptions::new(method.clone()).with_max_seconds(0.5);
        let rendering = render(&slow, &emitree::Canonical, [4, 4], &options).unwrap();
        assert_eq!(rendering.stats.ending, StopReason::Time, "{}", method.name());
        assert!(!rendering.converged());
        assert!(
            rendering.stats.total_time < Duration::from_secs(4),
            "{:?}",
            rendering.stats.total_time
        );
        assert!(rendering.values.pixels().iter().all(|pixel| pixel.is_finite()));
        // A batch that was cut short is in no pixel.
        let of_pixels = rendering.stats.evaluations_per_pixel.to_image();
        let of_pixels: f64 = of_pixels.pixels().iter().sum();
        assert!(0.0 < of_pixels && of_pixels <= rendering.stats.evaluations as f64);
        assert!(rendering.values.max_difference(&emitree::Image::zeros(4, 4)) > 0.0);
    }
}

/// Ctrl-C ends a rendering also where no line of sight meets the bounds.
#[test]
fn a_view_of_nothing_can_be_ended() {
    let behind = camera(10.0, [0.0, -30.0, 0.0]).unwrap();
    let never = FromFn(|_: [f64; 3], _: [f64; 3]| -> f64 { unreachable!("nothing is in view") });
    let calls = AtomicU64::new(0);
    let stop = |evaluations: u64| {
        assert_eq!(evaluations, 0);
        calls.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Break(())
    };
    let los = Method::Los(LosOptions::new(1, Steps::Fixed(64)));
    for method in [los, Method::Paper(BuildOptions::default())] {
        let options = RenderOptions::new(method).with_progress(&stop);
        let ended = render(&never, &behind, [16, 16], &options);
        assert_eq!(ended.unwrap_err(), RenderError::Interrupted);
    }
    assert_eq!(calls.into_inner(), 2, "each ends at once");
}

#[test]
fn a_time_that_ends_before_there_is_an_image_is_an_error() {
    let slow = FromFn(|_: [f64; 3], _: [f64; 3]| {
        sleep(Duration::from_millis(20));
        1.0
    });
    let los = LosOptions::new(1, Steps::Fixed(1_000));
    let options = RenderOptions::new(los).with_max_seconds(0.05);
    let error = render(&slow, &emitree::Canonical, [64, 64], &options).unwrap_err();
    assert_eq!(error, RenderError::Time { seconds: 0.05 });
    assert_eq!(
        error.to_string(),
        "`max_seconds` is 0.05: the time ended before there was an image: expected more time, fewer pixels or \
         lines, or the method `vol`, which has a coarse image early"
    );
    let options = RenderOptions::new(los).with_max_seconds(0.0);
    let error = render(&slow, &emitree::Canonical, [4, 4], &options).unwrap_err();
    assert_eq!(error.to_string(), "`max_seconds` is 0: expected a time in seconds above 0");
}

fn largest_of(image: &emitree::Image) -> f64 {
    image.pixels().iter().fold(0.0, |largest: f64, pixel| largest.max(pixel.abs()))
}

/// A jagged emission in which every evaluation takes its time.
fn jagged(microseconds: u64) -> impl emitree::Emission<Error = std::convert::Infallible> {
    FromFn(move |[x, y, z]: [f64; 3], _: [f64; 3]| {
        sleep(Duration::from_micros(microseconds));
        if (20.0 * x).sin() * (17.0 * y).cos() > (9.0 * z).sin() { 1.0 } else { 0.0 }
    })
}

/// 27 evaluations make an image after the time has ended, with an error that is as large as the image.
#[test]
fn there_is_an_image_if_the_time_ends_before_the_first_lines() {
    // The base lattice of level 5 would take two seconds, the first samples of a search half of one.
    for (base_level, seconds) in [(3, 1e-6), (5, 1e-6), (5, 0.05), (5, 0.2)] {
        let vol = VolOptions::new(1e-3).with_base_level(base_level);
        let options = RenderOptions::new(vol).with_max_seconds(seconds);
        let found = render(&jagged(50), &emitree::Canonical, [4, 4], &options).unwrap();
        assert_eq!(found.stats.ending, StopReason::Time, "{seconds} s");
        assert!(found.stats.evaluations >= 27 && !found.converged());
        let error = found.error.as_ref().unwrap();
        let largest = largest_of(&found.values);
        let estimate = found.estimated_error().unwrap();
        assert!(largest > 0.0 && estimate > 0.1, "{seconds} s: {largest} {estimate}");
        if seconds < 1e-3 {
            assert_eq!((found.stats.base_level, found.stats.evaluations), (Some(1), 27));
            assert!(error.pixels().iter().all(|&error| error >= largest));
            assert!(found.stats.error_over_allowed.unwrap() >= 1_000.0);
        }
        assert!(found.stats.total_time < Duration::from_secs(3), "{:?}", found.stats.total_time);
    }
}

/// The same in charts, of which each has its own samples, with an axis of energies, and beside sums.
#[test]
fn there_is_an_image_in_charts_in_bins_and_beside_sums_too() {
    let short = |vol: VolOptions| RenderOptions::new(vol).with_max_seconds(1e-6);
    let planet = Ellipsoid::sphere([0.0; 3], 0.3).unwrap();
    let camera = camera(10.0, [0.0; 3]).unwrap().with_occulters(vec![planet]).unwrap();
    let found = render(&jagged(1), &camera, [8, 8], &short(VolOptions::new(0.01))).unwrap();
    assert_eq!(found.stats.ending, StopReason::Time);
    assert!(largest_of(&found.values) > 0.0);
    let axis = emitree::EnergyAxis::new(1.0, 2.0, 3, emitree::EnergyScale::Linear).unwrap();
    let options = short(VolOptions::new(0.01));
    let cube = emitree::render_cube(&jagged(1), &camera, [8, 8], &axis, &options).unwrap();
    assert_eq!((cube.stats.ending, cube.values.shape()), (StopReason::Time, [3, 8, 8]));
    assert!(cube.estimated_error().unwrap() >= 1.0);
    let everywhere = emitree::Image::from_pixels(8, 8, vec![1.0; 64]);
    let sums = vec![emitree::sums::Sum::new("all", everywhere)];
    let options = short(VolOptions::new(0.01).with_sums(sums));
    let found = render(&jagged(1), &camera, [8, 8], &options).unwrap();
    assert_eq!(found.stats.ending, StopReason::Time);
    let [sum] = &found.sums[..] else { panic!("a sum") };
    assert!(sum.error >= sum.value.abs() && sum.value > 0.0, "{sum:?}");
}

/// A limit that is far away changes no bit, also where a search for products ends in one chart.
#[test]
fn a_limit_that_is_not_reached_changes_nothing() {
    let camera = camera(10.0, [0.0; 3]).unwrap();
    let ridges = FromFn(|[x, y, z]: [f64; 3], _: [f64; 3]| {
        let wave = (9.0 * x * y + 7.0 * z * z - 8.0 * x * z).sin();
        1.0 + 0.9 * wave + 20.0 * (-300.0 * (x * x + (y - 0.2).powi(2) + z * z)).exp()
    });
    let options = RenderOptions::new(VolOptions::new(0.02));
    let free = render(&ridges, &camera, [24, 24], &options).unwrap();
    let limited = options.with_max_seconds(1e6);
    let limited = render(&ridges, &camera, [24, 24], &limited).unwrap();
    assert!(free.converged() && limited.converged(), "{:?}", limited.stats.ending);
    assert_eq!(free.stats.evaluations, limited.stats.evaluations);
    assert_eq!(free.values, limited.values);
}
