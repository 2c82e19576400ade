//! Errors by pixel: relative and absolute tolerances, weights and bands, against exact images.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::vol::PixelTolerance;
use emitree::{
    Canonical, FromFn, FromSpectralFn, Image, RenderOptions, Rendering, VolOptions, render,
    render_cube,
};
use emitree_problems::corona::Corona;
use emitree_problems::cubes::problem;
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

/// Its image: a product of three integrals, each by Simpson's rule.
fn image_of_gaussian() -> Image {
    let root = 30.0_f64.sqrt();
    let integral = |from: f64, to: f64, at: f64| {
        // Composite Simpson's rule with 64 intervals: an error of 1e-9 for this width.
        let step = (to - from) / 64.0;
        let value = |k: usize| (-(root * (from + k as f64 * step - at)).powi(2)).exp();
        let weight = |k: usize| if k == 0 || k == 64 { 1.0 } else { 2.0 * (1 + k % 2) as f64 };
        (0..=64).map(|k| weight(k) * value(k)).sum::<f64>() * step / 3.0
    };
    let [height, width] = SHAPE;
    let mean = |pixel: usize, pixels: usize, at: f64| {
        let edge = |k: usize| k as f64 / pixels as f64;
        integral(edge(pixel), edge(pixel + 1), at) * pixels as f64
    };
    let along_z = integral(0.0, 1.0, 0.5);
    let value = |pixel: usize| mean(pixel % width, width, 0.3) * mean(pixel / width, height, 0.4);
    let pixels = (0..height * width).map(|pixel| along_z * value(pixel)).collect();
    Image::from_pixels(height, width, pixels)
}

#[test]
fn an_absolute_tolerance_is_in_the_unit_of_the_image() {
    let exact = image_of_gaussian();
    for atol in [1e-2, 1e-3, 1e-4] {
        let options = VolOptions::default().with_pixel_tolerance(PixelTolerance::absolute(atol));
        let found = rendering(gaussian, options);
        let ratio = worst(&found.values, &exact, 0.0, |_| atol);
        assert!(found.converged() && ratio <= 1.0, "{atol}: {ratio}");
        assert!(found.stats.error_over_allowed.unwrap() <= 1.0);
    }
}

/// The brightness of the left half of the image.
fn left(x: f64) -> f64 {
    50.0 / (1.0 + (60.0 * (x - 0.4)).exp())
}

/// The phase of ripples at depth 0; it grows by 18 y z.
fn phase(x: f64, y: f64) -> f64 {
    60.0 * x + 40.0 * y * y
}

/// Steep ripples there, and a smooth glow everywhere.
fn halves([x, y, z]: [f64; 3]) -> f64 {
    left(x) * (1.0 + (phase(x, y) + 18.0 * y * z).sin()) + (-3.0 * z).exp() * (1.0 + y)
}

/// The image of [`halves`]: ∫ dz in closed form, and the mean over a pixel from 12 × 12 midpoints, whose
/// error in the right half, where the ripples are below 0.3, is some 1e-5.
fn image_of_halves() -> Image {
    const PARTS: usize = 12;
    let [height, width] = SHAPE;
    let along = |pixel: usize, part: usize, pixels: usize| {
        (pixel as f64 + (part as f64 + 0.5) / PARTS as f64) / pixels as f64
    };
    let value = |pixel: usize| {
        let mut sum = 0.0;
        for (i, j) in (0..PARTS * PARTS).map(|k| (k / PARTS, k % PARTS)) {
            let (x, y) = (along(pixel % width, i, width), along(pixel / width, j, height));
            let [from, to] = [phase(x, y), phase(x, y) + 18.0 * y].map(f64::cos);
            let ripples = (from - to) / (18.0 * y);
            sum += left(x) * (1.0 + ripples) + (1.0 - (-3.0_f64).exp()) / 3.0 * (1.0 + y);
        }
        sum / (PARTS * PARTS) as f64
    };
    Image::from_pixels(height, width, (0..height * width).map(value).collect())
}

#[test]
fn pixels_of_weight_0_are_not_among_the_brightest_and_do_not_count() {
    let half = |column: usize| f64::from(u8::from(column >= SHAPE[1] / 2));
    let weights: Vec<f64> = (0..SHAPE[0] * SHAPE[1]).map(|i| half(i % SHAPE[1])).collect();
    let weights = Image::from_pixels(SHAPE[0], SHAPE[1], weights);
    let exact = image_of_halves();
    let found = rendering(halves, VolOptions::new(0.01).with_weights(weights.clone()));
    let pixels = exact.pixels().iter().zip(weights.pixels());
    let brightest = pixels.map(|(pixel, weight)| pixel * weight).fold(0.0, f64::max);
    let differences = found.values.pixels().iter().zip(exact.pixels());
    let weighted = differences.zip(weights.pixels()).map(|((a, b), w)| (a - b).abs() * w);
    let error = weighted.fold(0.0, f64::max);
    assert!(brightest < 0.1 * largest(&exact));
    assert!(
        found.converged() && error <= 0.01 * brightest,
        "{error} of {brightest}: {:?} {:?} {}",
        found.stats.ending,
        found.stats.error_over_allowed,
        found.stats.evaluations
    );
}

/// The largest error of a voxel over the error allowed, and the evaluations of a cube in 32 bins.
fn cube(name: &str, vol: VolOptions, allowed: impl Fn(f64, f64, f64) -> f64) -> (f64, u64) {
    let problem = problem(name).unwrap();
    let axis = problem.default_axis(32).unwrap();
    let exact = problem.exact(SHAPE, &axis);
    let emission = FromSpectralFn(|position, _, energy| problem.rate(position, energy));
    let found = render_cube(&emission, &Canonical, SHAPE, &axis, &RenderOptions::new(vol)).unwrap();
    assert!(found.converged(), "{name}: {:?}", found.stats.ending);
    assert!(found.stats.error_over_allowed.unwrap() <= 1.0);
    let brightest = exact.largest();
    let of_reference = problem.cube_error * brightest;
    let bands = found.values.bands().iter().zip(exact.bands());
    let of_band = |(found, exact_band): (&Image, &Image)| {
        let of_band = largest(exact_band);
        worst(found, exact_band, of_reference, |voxel| allowed(voxel, of_band, brightest))
    };
    (bands.map(of_band).fold(0.0, f64::max), found.stats.evaluations)
}

#[test]
fn each_band_of_a_cube_is_within_one_per_cent_of_its_own_largest_voxel() {
    let evaluations = [
        ("separable", 7_258),
        ("mixture", 16_609),
        ("narrow-line", 16_791),
        ("edge", 15_332),
        ("bremsstrahlung", 16_569),
    ];
    for (name, expected) in evaluations {
        let vol = VolOptions::new(0.01).with_per_band(true);
        let allowed = |_, of_band: f64, largest: f64| 0.01 * of_band.max(1e-5 * largest);
        let (ratio, evaluations) = cube(name, vol, allowed);
        assert!(ratio <= 1.0, "{name}: {ratio}");
        assert_eq!(evaluations, expected, "{name}");
    }
}

#[test]
fn each_voxel_of_a_cube_is_within_one_per_cent_of_itself() {
    let by_pixel = PixelTolerance::relative(0.01).with_floor(1e-3);
    let evaluations = [("separable", 33_355), ("mixture", 88_436), ("edge", 64_677)];
    for (name, expected) in evaluations {
        let vol = VolOptions::default().with_pixel_tolerance(by_pixel);
        let allowed = |voxel: f64, _, largest: f64| by_pixel.allowed(voxel, largest);
        let (ratio, evaluations) = cube(name, vol, allowed);
        assert!(ratio <= 1.0, "{name}: {ratio}");
        assert_eq!(evaluations, expected, "{name}");
    }
}

/// The corona falls by a factor of 7,400 over the image; 1 % of the brightest pixel says nothing outside.
#[test]
fn the_corona_is_within_one_per_cent_of_each_pixel() {
    let corona = Corona::new(4.0);
    let (exact, of_reference) = corona.reference(40);
    assert!(of_reference < 3e-3, "{of_reference}");
    let by_pixel = PixelTolerance::relative(0.01);
    let emission = FromFn(|position, _| corona.rate(position));
    let options = RenderOptions::new(VolOptions::default().with_pixel_tolerance(by_pixel));
    let found = render(&emission, &corona.camera().unwrap(), [40, 40], &options).unwrap();
    let brightest = largest(&exact);
    let ratio = found.values.pixels().iter().zip(exact.pixels()).map(|(found, exact)| {
        ((found - exact).abs() - of_reference * exact) / by_pixel.allowed(*exact, brightest)
    });
    let ratio = ratio.fold(0.0, f64::max);
    assert!(found.converged() && ratio <= 1.0, "{ratio}, {} evaluations", found.stats.evaluations);
}
