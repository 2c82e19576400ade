//! Errors by pixel: relative and absolute tolerances, weights and bands, against exact images.

use emitree::vol::PixelTolerance;
use emitree::{Canonical, FromFn, Image, RenderOptions, Rendering, VolOptions, render};
use emitree_problems::family::random_scene;

const SHAPE: [usize; 2] = [64, 64];

fn rendering(rate: impl Fn([f64; 3]) -> f64 + Sync, options: VolOptions) -> Rendering {
    let emission = FromFn(|position, _| rate(position));
    render(&emission, &Canonical, SHAPE, &RenderOptions::new(options)).unwrap()
}

/// The largest error over the error allowed, an error of the reference left out.
fn worst(found: &Image, exact: &Image, of_reference: f64, allowed: impl Fn(f64) -> f64) -> f64 {
    let pixels = found.pixels().iter().zip(exact.pixels());
    let ratio =
        |(found, exact): (&f64, &f64)| ((found - exact).abs() - of_reference) / allowed(*exact);
    pixels.map(ratio).fold(0.0, f64::max)
}

fn largest(image: &Image) -> f64 {
    image.pixels().iter().fold(0.0, |most: f64, pixel| most.max(pixel.abs()))
}

#[test]
fn every_pixel_is_within_one_per_cent_of_itself() {
    let by_pixel = PixelTolerance::relative(0.01).with_floor(1e-3);
    let mut logs = [0.0; 2];
    for seed in [1, 4, 7, 8, 16, 20] {
        let scene = random_scene(seed);
        let reference = scene.reference_image(SHAPE);
        let options = VolOptions::default().with_pixel_tolerance(by_pixel);
        let found = rendering(|r| scene.rate(r), options);
        let brightest = largest(&reference.image);
        let of_reference = reference.error * brightest;
        let allowed = |pixel: f64| by_pixel.allowed(pixel, brightest);
        let ratio = worst(&found.values, &reference.image, of_reference, allowed);
        assert!(found.converged() && ratio <= 1.0, "{}: {ratio}", scene.name());
        assert!(found.stats.error_over_allowed.unwrap() <= 1.0);
        let uniform = rendering(|r| scene.rate(r), VolOptions::new(0.01));
        logs[0] += (found.stats.evaluations as f64).ln();
        logs[1] += (uniform.stats.evaluations as f64).ln();
    }
    let ratio = ((logs[0] - logs[1]) / 6.0).exp();
    assert!((1.0..3.0).contains(&ratio), "{ratio} times the evaluations");
}

/// A Gaussian whose image is exact, and dark in the corners.
fn gaussian([x, y, z]: [f64; 3]) -> f64 {
    (-30.0 * ((x - 0.3).powi(2) + (y - 0.4).powi(2) + (z - 0.5).powi(2))).exp()
}

#[test]
fn an_absolute_tolerance_is_in_the_unit_of_the_image() {
    let fine = rendering(gaussian, VolOptions::new(1e-6));
    for atol in [1e-2, 1e-3, 1e-4] {
        let options = VolOptions::default().with_pixel_tolerance(PixelTolerance::absolute(atol));
        let found = rendering(gaussian, options);
        let ratio = worst(&found.values, &fine.values, 1e-6, |_| atol);
        assert!(found.converged() && ratio <= 1.0, "{atol}: {ratio}");
        assert!(found.stats.error_over_allowed.unwrap() <= 1.0);
    }
}

/// Steep ripples in the left half of the image, and a smooth glow in the right one.
fn halves([x, y, z]: [f64; 3]) -> f64 {
    let ripples = 1.0 + (60.0 * (x + 0.3 * y * z) + 40.0 * y * y).sin();
    let left = 1.0 / (1.0 + (60.0 * (x - 0.4)).exp());
    left * 50.0 * ripples + (-3.0 * z).exp() * (1.0 + y)
}

#[test]
fn what_has_the_weight_0_costs_little_and_is_not_the_brightest() {
    let half = |column: usize| f64::from(u8::from(column >= SHAPE[1] / 2));
    let weights: Vec<f64> = (0..SHAPE[0] * SHAPE[1]).map(|i| half(i % SHAPE[1])).collect();
    let weights = Image::from_pixels(SHAPE[0], SHAPE[1], weights);
    let all = rendering(halves, VolOptions::new(0.01));
    let fine = rendering(halves, VolOptions::new(1e-4));
    let found = rendering(halves, VolOptions::new(0.01).with_weights(weights.clone()));
    let pixels = fine.values.pixels().iter().zip(weights.pixels());
    let brightest = pixels.map(|(pixel, weight)| pixel * weight).fold(0.0, f64::max);
    let differences = found.values.pixels().iter().zip(fine.values.pixels());
    let weighted = differences.zip(weights.pixels()).map(|((a, b), w)| (a - b).abs() * w);
    let error = weighted.fold(0.0, f64::max);
    assert!(brightest < 0.1 * largest(&fine.values));
    assert!(found.converged() && error <= 0.01 * brightest, "{error} of {brightest}");
    let cost = [found.stats.evaluations, all.stats.evaluations];
    assert!(2 * cost[0] < cost[1], "{cost:?}");
}
