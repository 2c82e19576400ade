use super::*;
use crate::{Canonical, FromFn, Method, RenderError, RenderOptions, Rendering, render};

fn los<F>(g: F, shape: [usize; 2], lines: usize, steps: Steps) -> Rendering
where
    F: Fn([f64; 3], [f64; 3]) -> f64 + Sync,
{
    let options = RenderOptions::new(LosOptions { lines, steps });
    render(&FromFn(g), &Canonical, shape, &options).unwrap()
}

#[test]
#[expect(clippy::float_cmp, reason = "dyadic positions are exact")]
fn lines_are_the_centres_of_the_parts_of_pixels() {
    let lines = Lines { height: 2, width: 4, per_side: 2 };
    assert_eq!(lines.count(), 32);
    assert_eq!(lines.position(0), [1.0 / 16.0, 1.0 / 8.0]);
    assert_eq!(lines.position(1), [3.0 / 16.0, 1.0 / 8.0]);
    assert_eq!(lines.position(31), [15.0 / 16.0, 7.0 / 8.0]);
}

#[test]
fn fixed_steps_are_the_midpoint_rule() {
    let rendering = los(|[x, y, z], _| x + 10.0 * y + z * z, [2, 3], 1, Steps::Fixed(4));
    assert_eq!(rendering.stats.evaluations, 2 * 3 * 4);
    let depth = [0.125_f64, 0.375, 0.625, 0.875].iter().map(|z| z * z / 4.0).sum::<f64>();
    let expected = 2.5 / 3.0 + 10.0 * 0.75 + depth;
    assert!((rendering.values[(1, 2)] - expected).abs() < 1e-14);
    assert!(rendering.error.is_none() && rendering.converged());
}

/// Batches that begin in the middle of a line, calls that end there, and lines of one pixel that are
/// counted one by one.
#[test]
fn batches_of_any_size_make_the_same_image_and_count() {
    let g = FromFn(|[x, y, z]: [f64; 3], _: [f64; 3]| (3.0 * x + y).sin() * z + y * z * z);
    let rendered = |batch_size: u64| {
        let los = LosOptions { lines: 3, steps: Steps::Fixed(13) };
        let options = RenderOptions { batch_size, ..RenderOptions::new(los) };
        render(&g, &Canonical, [5, 7], &options).unwrap()
    };
    let whole = rendered(u64::MAX);
    assert_eq!(whole.stats.evaluations, 5 * 7 * 9 * 13);
    for batch_size in [1, 5, 13, 100, 1000] {
        let parts = rendered(batch_size);
        assert_eq!(parts.values, whole.values, "batches of {batch_size}");
        assert_eq!(parts.stats.evaluations_per_pixel, whole.stats.evaluations_per_pixel);
    }
    let counts = whole.stats.evaluations_per_pixel.to_image();
    assert!(counts.pixels().iter().all(|count| (count - 117.0).abs() <= 0.0));
    // The lines and depths of the midpoint rule, in its order.
    let at = |part: usize, pixel: usize, pixels: usize| {
        (pixel as f64 + (part as f64 + 0.5) / 3.0) / pixels as f64
    };
    let line = |part: usize| {
        let [x, y] = [at(part % 3, 6, 7), at(part / 3, 4, 5)];
        let rates = (0..13).map(|k| (g.0)([x, y, (f64::from(k) + 0.5) / 13.0], [0.0; 3]));
        rates.sum::<f64>() / 13.0
    };
    assert!((whole.values[(4, 6)] - (0..9).map(line).sum::<f64>() / 9.0).abs() < 1e-15);
}

#[test]
fn more_lines_average_over_the_pixel() {
    let rendering = los(|[x, ..], _| x * x, [1, 1], 2, Steps::Fixed(1));
    assert!((rendering.values[(0, 0)] - 0.5 * (0.0625 + 0.5625)).abs() < 1e-15);
}

#[test]
fn adaptive_lines_keep_their_tolerance_on_peaks_and_jumps() {
    let peak = |[_, _, z]: [f64; 3], _: [f64; 3]| (-((z - 0.3) / 0.02).powi(2)).exp();
    let jump = |[x, _, z]: [f64; 3], _: [f64; 3]| f64::from(u8::from(z < 0.3 + 0.1 * x));
    for tolerance in [1e-2, 1e-4, 1e-6] {
        let steps = Steps::Adaptive(tolerance);
        let rendering = los(peak, [2, 2], 1, steps);
        let exact = 0.02 * core::f64::consts::PI.sqrt();
        for pixel in rendering.values.pixels() {
            assert!((pixel - exact).abs() <= tolerance * exact, "{pixel} {exact}");
        }
        let rendering = los(jump, [1, 4], 1, steps);
        for (column, pixel) in rendering.values.pixels().iter().enumerate() {
            let exact = 0.3 + 0.1 * (column as f64 + 0.5) / 4.0;
            assert!((pixel - exact).abs() <= tolerance * 0.4, "{pixel} {exact}");
        }
        assert!(rendering.converged() && rendering.estimated_error().unwrap() <= tolerance);
    }
}

/// Pinned: a change that costs more fails.
#[test]
fn adaptive_lines_cost_what_they_cost() {
    let peak = |[_, _, z]: [f64; 3], _: [f64; 3]| (-((z - 0.3) / 0.05).powi(2)).exp();
    let cost = |tolerance| los(peak, [1, 1], 1, Steps::Adaptive(tolerance)).stats.evaluations;
    assert_eq!([cost(1e-2), cost(1e-4), cost(1e-8)], [120, 120, 210]);
}

#[test]
fn an_adaptive_budget_ends_with_an_image_and_says_so() {
    let jump = |[_, _, z]: [f64; 3], _: [f64; 3]| f64::from(u8::from(z < 0.3));
    let method = Method::Los(LosOptions { lines: 1, steps: Steps::Adaptive(1e-9) });
    let options = RenderOptions { max_evaluations: 400, ..RenderOptions::new(method) };
    let rendering = render(&FromFn(jump), &Canonical, [1, 2], &options).unwrap();
    assert!(!rendering.converged() && rendering.stats.evaluations <= 400);
    assert!((rendering.values[(0, 0)] - 0.3).abs() < rendering.error.unwrap()[(0, 0)]);
}

#[test]
fn options_and_budgets_out_of_range_are_refused() {
    let refused = |lines, steps, max_evaluations| {
        let method = Method::Los(LosOptions { lines, steps });
        let options = RenderOptions { max_evaluations, ..RenderOptions::new(method) };
        let uniform = FromFn(|_, _| 1.0);
        let error: RenderError<_> = render(&uniform, &Canonical, [4, 4], &options).unwrap_err();
        error.to_string()
    };
    assert_eq!(
        refused(0, Steps::Fixed(1), 1),
        "`lines` is 0: expected 1 or more lines along each side of a pixel"
    );
    assert_eq!(
        refused(1, Steps::Fixed(0), 1),
        "`steps` is 0: expected 1 or more steps along each line"
    );
    assert_eq!(
        refused(1, Steps::Adaptive(-1.0), 1),
        "`tolerance` is -1: expected a number above 0"
    );
    assert_eq!(
        refused(2, Steps::Fixed(10), 100),
        "`max_evaluations` allows 100 evaluations, but 64 lines of 10 steps needs 640"
    );
}
