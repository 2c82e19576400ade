//! Radiances of requested lines beside an image, against closed forms.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::projection::Ellipsoid;
use emitree::{
    Canonical, FromFn, Perspective, Projection, RenderOptions, Rendering, Viewpoint, VolOptions,
    render,
};
use emitree_problems::planets::random_planet;
use emitree_problems::shapes::random_shape;

type Point = [f64; 3];

/// Places all over the image, and their number.
const LINES: usize = 3000;

fn places() -> Vec<[f64; 2]> {
    // Powers of the plastic number.
    let along = |k: usize, step: f64| (0.5 + k as f64 * step).fract();
    (0..LINES).map(|k| [along(k, 0.754_877_666), along(k, 0.569_840_291)]).collect()
}

fn rendered(
    rate: impl Fn(Point) -> f64 + Sync,
    camera: &dyn Projection,
    options: VolOptions,
) -> Rendering {
    let emission = FromFn(|at: Point, _: Point| rate(at));
    render(&emission, camera, [64, 64], &RenderOptions::new(options)).unwrap()
}

/// The shares of lines whose errors are estimated within the tolerance, and whose errors are within the estimates; and
/// the largest error of the first in terms of the tolerance.
fn shares(found: &Rendering, exact: impl Fn([f64; 2]) -> f64, tolerance: f64) -> [f64; 3] {
    let lines = found.lines.as_ref().unwrap();
    let exact: Vec<f64> = places().into_iter().map(exact).collect();
    let allowed = tolerance * exact.iter().fold(0.0, |most: f64, of| most.max(of.abs()));
    let (mut good, mut within, mut worst) = (0_u32, 0_u32, 0.0_f64);
    for ((value, error), exact) in lines.values.iter().zip(&lines.errors).zip(&exact) {
        let of_line = (value - exact).abs();
        within += u32::from(of_line <= error + 1e-9 * allowed);
        if *error <= allowed {
            good += 1;
            worst = worst.max(of_line / allowed);
        }
    }
    [f64::from(good) / LINES as f64, f64::from(within) / LINES as f64, worst]
}

fn assert_shares([good, within, worst]: [f64; 3], most_beyond: f64, name: &str) {
    assert!(good >= 0.999, "{name}: {good}");
    assert!(within >= 1.0 - most_beyond, "{name}: {within}");
    assert!(worst <= 1.0, "{name}: {worst}");
}

/// The constants were chosen on even seeds.
#[test]
fn lines_through_random_shapes_are_within_the_tolerance() {
    for seed in [21, 23] {
        let shape = random_shape(seed);
        let options = VolOptions::new(0.01);
        let alone = rendered(|r| shape.rate(r), &Canonical, options.clone());
        let found = rendered(|r| shape.rate(r), &Canonical, options.with_lines(places()));
        // The image is the same, and lines cost little.
        assert_eq!(found.values, alone.values);
        let [with, without] = [&found, &alone].map(|of| of.stats.evaluations);
        assert!(with >= without && (with as f64) < 1.25 * without as f64, "{with} {without}");
        let name = format!("{}-{seed}", shape.kind());
        assert_shares(shares(&found, |xy| shape.line_integral(xy), 0.01), 0.01, &name);
    }
}

#[test]
fn lines_that_end_at_a_planet_among_shapes_are_within_the_tolerance() {
    let scene = random_planet(21);
    let options = VolOptions::new(0.01).with_lines(places());
    let found = rendered(|r| scene.rate(r), &*scene.camera(), options);
    assert!(found.surfaces.is_some());
    // A part of the shape between the limb and a surface that ends there may be thinner than all samples.
    assert_shares(shares(&found, |xy| scene.line_integral(xy), 0.01), 0.02, &scene.name());
}

/// A corona 1 / r² around a body: ∫ ds / (b² + s²) is an angle over b, up to the limb.
#[test]
fn lines_beside_the_limb_of_a_body_follow_from_its_charts() {
    let position = [0.0, -6.0, 0.5];
    let viewpoint = Viewpoint { position, target: [0.1, 0.0, 0.0], up: [0.0, 0.0, 1.0] };
    let camera = Perspective::new(viewpoint, [0.5, 0.5], [0.0, f64::INFINITY]).unwrap();
    let body = Ellipsoid::new([0.0; 3], [0.8; 3]).unwrap();
    let camera = camera.with_occulters(vec![body]).unwrap();
    let square = |at: Point| at.iter().map(|along| along * along).sum::<f64>();
    let options = VolOptions::new(1e-3).with_lines(places());
    let found = rendered(|at| 1.0 / square(at), &camera, options);
    let exact = |xy: [f64; 2]| {
        let middle = camera.world_from_canonical([xy[0], xy[1], 0.3]);
        let towards = middle.direction.map(|along| -along);
        let along: f64 = (0..3).map(|k| position[k] * towards[k]).sum();
        let nearest = (square(position) - along * along).sqrt();
        let half = (0.64 - nearest * nearest).max(0.0).sqrt();
        let last = if half > 0.0 { (-half / nearest).atan() } else { 0.5 * core::f64::consts::PI };
        (last - (along / nearest).atan()) / nearest
    };
    assert!(found.surfaces.is_none());
    assert_shares(shares(&found, exact, 1e-3), 1e-3, "corona");
    let alone = rendered(|at| 1.0 / square(at), &camera, VolOptions::new(1e-3));
    assert_eq!(found.stats.evaluations, alone.stats.evaluations);
}

/// Places outside of the image, and those that are no numbers, have no radiance.
#[test]
fn lines_outside_of_the_image_are_not_known() {
    let places = [[0.5, 0.5], [1.5, 0.5], [f64::NAN, 0.2]];
    let options = VolOptions::new(0.01).with_lines(places);
    let found = rendered(|[x, y, z]| (-x * y * z).exp(), &Canonical, options);
    let lines = found.lines.unwrap();
    assert!(lines.errors[0] < 0.02 && lines.values[0] > 0.8);
    assert!(lines.errors[1..].iter().all(|error| error.is_infinite()));
    assert_eq!(lines.len(), 3);
}
