//! Sums over regions: their values and errors against exact images.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::sums::{Region, Sum, SumKind};
use emitree::{
    Canonical, Cube, EnergyAxis, EnergyScale, FromFn, FromSpectralFn, Image, RenderOptions,
    Rendering, StopReason, VolOptions, render, render_cube,
};
use emitree_problems::family::random_scene;
use emitree_problems::views::random_view;

const SHAPE: [usize; 2] = [64, 64];

fn rendering(rate: impl Fn([f64; 3]) -> f64 + Sync, options: VolOptions) -> Rendering {
    let emission = FromFn(|position, _| rate(position));
    render(&emission, &Canonical, SHAPE, &RenderOptions::new(options)).unwrap()
}

/// Σ w · pixel over the pixels of an image, and Σ w.
fn weighted(weights: &Image, image: &Image) -> [f64; 2] {
    let pixels = weights.pixels().iter().zip(image.pixels());
    pixels
        .filter(|(_, pixel)| pixel.is_finite())
        .fold([0.0; 2], |[sum, area], (w, pixel)| [sum + w * pixel, area + w])
}

fn largest(image: &Image) -> f64 {
    let pixels = image.pixels().iter().filter(|pixel| pixel.is_finite());
    pixels.fold(0.0, |most: f64, pixel| most.max(pixel.abs()))
}

#[test]
fn sums_of_random_scenes_are_within_their_errors_and_tolerances() {
    let disc = Region::circle([30.0, 34.5], 12.3).weights(SHAPE);
    let part = Region::rectangle([20.2, 11.0], [41.7, 50.5]).weights(SHAPE);
    for seed in [2, 3, 6, 11, 16, 21] {
        let scene = random_scene(seed);
        let exact = scene.reference_image(SHAPE);
        let sums = [
            Sum::new("disc", disc.clone()).with_tolerance(2e-3),
            Sum::new("box", part.clone()).with_kind(SumKind::Mean).with_tolerance(2e-3),
        ];
        let found = rendering(|r| scene.rate(r), VolOptions::new(0.01).with_sums(sums));
        assert!(found.converged(), "{}", scene.name());
        for (weights, sum) in [&disc, &part].into_iter().zip(&found.sums) {
            let [value, area] = weighted(weights, &exact.image);
            let norm = if sum.kind == SumKind::Mean { area } else { 1.0 };
            let error = (sum.value - value / norm).abs();
            let of_reference = exact.error * largest(&exact.image) * area / norm;
            assert!(error <= sum.error + of_reference, "{}: {error} {sum:?}", scene.name());
            assert!(
                sum.is_within_tolerance() && sum.allowed.to_bits() == (2e-3 * sum.value).to_bits()
            );
            let of_pixels = weighted(weights, found.error.as_ref().unwrap())[0] / norm;
            // They may be the same sum in another order.
            assert!(sum.error <= of_pixels * (1.0 + 1e-12), "{sum:?} {of_pixels}");
        }
    }
}

/// Tolerances of sums against measured errors.
#[test]
fn errors_follow_the_tolerances_of_sums() {
    let scene = random_scene(8);
    let exact = scene.reference_image(SHAPE);
    let disc = Region::circle([32.0, 32.0], 14.0).weights(SHAPE);
    let value = weighted(&disc, &exact.image)[0];
    let mut evaluations = 0;
    for tolerance in [1e-2, 1e-3, 1e-4] {
        // The pixels alone may have 5 % of the largest one.
        let sum = Sum::new("disc", disc.clone()).with_tolerance(tolerance);
        let found = rendering(|r| scene.rate(r), VolOptions::new(1.0).with_sums([sum]));
        let error = (found.sums[0].value - value).abs();
        assert!(found.converged() && error <= tolerance * value, "{tolerance}: {error} of {value}");
        assert!(found.stats.evaluations >= evaluations);
        evaluations = found.stats.evaluations;
    }
    assert!(evaluations < 100_000, "{evaluations}");
}

#[test]
fn images_without_sums_are_those_of_before_and_a_sum_that_is_met_changes_no_pixel() {
    let scene = random_scene(4);
    let plain = rendering(|r| scene.rate(r), VolOptions::new(0.01));
    assert!(plain.sums.is_empty());
    let all = Image::from_pixels(SHAPE[0], SHAPE[1], vec![1.0; SHAPE[0] * SHAPE[1]]);
    let sum = Sum::new("all", all.clone()).with_tolerance(0.5);
    let found = rendering(|r| scene.rate(r), VolOptions::new(0.01).with_sums([sum]));
    assert_eq!(found.values, plain.values);
    assert_eq!(found.sums[0].samples, 0);
    assert!((found.sums[0].value - weighted(&all, &plain.values)[0]).abs() < 1e-12);
}

#[test]
fn a_difference_of_regions_has_an_absolute_tolerance() {
    let scene = random_scene(14);
    let exact = scene.reference_image(SHAPE);
    let [left, right] = [[0.0, 0.0], [32.0, 0.0]]
        .map(|corner| Region::rectangle(corner, [corner[0] + 32.0, 64.0]).weights(SHAPE));
    let difference = left.pixels().iter().zip(right.pixels()).map(|(a, b)| a - b).collect();
    let difference = Image::from_pixels(SHAPE[0], SHAPE[1], difference);
    let atol = 1e-3 * weighted(&left, &exact.image)[0];
    let sum = Sum::new("difference", difference.clone()).with_tolerance(0.0).with_atol(atol);
    let found = rendering(|r| scene.rate(r), VolOptions::new(0.01).with_sums([sum]));
    let error = (found.sums[0].value - weighted(&difference, &exact.image)[0]).abs();
    assert!(found.converged() && error <= found.sums[0].error && found.sums[0].error <= atol);
}

#[test]
fn a_budget_that_does_not_suffice_for_a_sum_is_no_convergence() {
    let scene = random_scene(16);
    let disc = Region::circle([32.0, 32.0], 10.0).weights(SHAPE);
    let sum = Sum::new("disc", disc).with_tolerance(1e-6);
    let emission = FromFn(|position, _| scene.rate(position));
    let options = RenderOptions::new(VolOptions::new(0.05).with_sums([sum]));
    let options = options.with_max_evaluations(20_000);
    let found = render(&emission, &Canonical, SHAPE, &options).unwrap();
    assert_eq!((found.converged(), found.stats.ending), (false, StopReason::Budget));
    assert!(!found.sums[0].is_within_tolerance() && found.stats.evaluations <= 20_000);
}

#[test]
fn views_with_bodies_have_sums_and_fluxes() {
    for seed in [1, 6] {
        let view = random_view(seed);
        let exact = view.reference();
        let [height, width] = view.shape();
        let center = [0.5 * width as f64, 0.5 * height as f64];
        let disc = Region::circle(center, 0.3 * width as f64).weights(view.shape());
        let sum = Sum::new("disc", disc.clone()).with_tolerance(5e-3);
        let emission = FromFn(|position, _| view.rate(position));
        let options = RenderOptions::new(VolOptions::new(0.02).with_sums([sum]));
        let found = render(&emission, view.camera(), view.shape(), &options).unwrap();
        let [value, area] = weighted(&disc, &exact.image);
        let error = (found.sums[0].value - value).abs();
        let of_reference = exact.error * largest(&exact.image) * area;
        assert!(found.converged(), "{} {:?}", view.name(), found.sums);
        assert!(error <= found.sums[0].error + of_reference, "{}: {error}", view.name());
    }
}

#[test]
fn a_cube_has_the_sum_of_all_bands_and_one_of_each() {
    let scene = random_scene(8);
    let exact = scene.reference_image([16, 16]);
    let axis = EnergyAxis::new(0.5, 2.5, 4, EnergyScale::Linear).unwrap();
    let emission = FromSpectralFn(|r: [f64; 3], _, energy: f64| scene.rate(r) * (-energy).exp());
    let disc = Region::circle([8.0, 8.0], 5.0).weights([16, 16]);
    let sum = Sum::new("disc", disc.clone()).with_tolerance(2e-3);
    let options = RenderOptions::new(VolOptions::new(0.01).with_sums([sum]));
    let found: Rendering<Cube> =
        render_cube(&emission, &Canonical, [16, 16], &axis, &options).unwrap();
    let of_image = weighted(&disc, &exact.image)[0];
    let sum = &found.sums[0];
    let value = of_image * ((-0.5_f64).exp() - (-2.5_f64).exp());
    assert!(found.converged() && (sum.value - value).abs() <= sum.error, "{sum:?} {value}");
    assert_eq!(sum.bands.len(), 4);
    for (bin, [of_band, error]) in sum.bands.iter().enumerate() {
        let [low, high] = [0.5 + 0.5 * bin as f64, 1.0 + 0.5 * bin as f64];
        let value = of_image * ((-low).exp() - (-high).exp()) / 0.5;
        assert!((of_band - value).abs() <= *error, "band {bin}: {of_band} {value} {error}");
    }
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let scene = random_scene(21);
    let disc = Region::circle([28.0, 30.0], 13.0).weights(SHAPE);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let sum = Sum::new("disc", disc.clone()).with_tolerance(1e-3);
        pool.install(|| rendering(|r| scene.rate(r), VolOptions::new(0.01).with_sums([sum])))
    };
    let [one, four] = [1, 4].map(with);
    assert_eq!(one.values, four.values);
    assert_eq!(one.sums, four.sums);
    assert_eq!(one.stats.evaluations, four.stats.evaluations);
}

#[test]
fn sums_that_can_not_be_are_refused() {
    let one = |weights: Vec<f64>| Sum::new("a", Image::from_pixels(2, 2, weights));
    let message = |sums: Vec<Sum>| {
        let emission = FromFn(|_: [f64; 3], _| 1.0);
        let options = RenderOptions::new(VolOptions::new(0.1).with_sums(sums));
        render(&emission, &Canonical, [2, 2], &options).unwrap_err().to_string()
    };
    let full = || one(vec![1.0; 4]);
    for (sums, expected) in [
        (vec![full(), full()], "`sums[1]` has no name of its own"),
        (vec![Sum::new("a", Image::zeros(1, 2))], "`sums[0]` has 1 rows of 2 weights"),
        (vec![one(vec![1.0, f64::NAN, 0.0, 0.0])], "the weight NaN in row 0, column 1"),
        (vec![one(vec![0.0; 4])], "`sums[0]` is empty"),
        (vec![one(vec![1.0, -1.0, 0.0, 0.0]).with_kind(SumKind::Mean)], "weights add up to 0"),
        (vec![full().with_tolerance(1.0)], "`sums[0]` has the tolerance 1"),
        (vec![full().with_tolerance(0.0)], "`sums[0]` has the tolerance 0"),
    ] {
        let found = message(sums);
        assert!(found.contains(expected), "{found}");
    }
}
