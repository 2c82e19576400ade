//! Renderings in the shortest time: lines of sight on a lattice of pixels, and where there are none.

use emitree::projection::Ellipsoid;
use emitree::vol::Minimize;
use emitree::{
    Canonical, Equirectangular, FromFn, Image, Orthographic, Projection, RenderOptions, Rendering,
    Session, Viewpoint, VolOptions, render,
};
use emitree_problems::family::random_scene;
use emitree_problems::relative_error;
use emitree_problems::shapes::random_shape;
use std::time::{Duration, Instant};

type TestResult = Result<(), Box<dyn std::error::Error>>;

/// The rates that are timed first.
const FIRST_TIMES: u64 = 3 * 24 * 9;

fn options(minimize: Minimize) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(0.01).with_minimize(minimize))
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn in_time(rate: impl Fn([f64; 3]) -> f64 + Sync, shape: [usize; 2]) -> Rendering {
    let emission = FromFn(|position, _| rate(position));
    render(&emission, &Canonical, shape, &options(Minimize::Time)).unwrap()
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn in_evaluations(rate: impl Fn([f64; 3]) -> f64 + Sync, shape: [usize; 2]) -> Rendering {
    let emission = FromFn(|position, _| rate(position));
    render(&emission, &Canonical, shape, &options(Minimize::Evaluations)).unwrap()
}

fn bits(image: &Image) -> Vec<u64> {
    image.pixels().iter().map(|pixel| pixel.to_bits()).collect()
}

/// The time that a rate takes decides: these take a fiftieth of what is allowed.
#[test]
fn cheap_rates_are_integrated_along_lines_of_sight() -> TestResult {
    let mut evaluations = Vec::new();
    for seed in [0, 1, 2, 4, 5] {
        let scene = random_scene(seed);
        let exact = scene.reference_image([64, 80]).image;
        let found = in_time(|position| scene.rate(position), [64, 80]);
        let steps = found.stats.line_steps.ok_or("lines of sight")?;
        assert!(steps >= 9, "{seed}");
        evaluations.push(found.stats.evaluations);
        assert!(found.converged() && found.estimated_error() <= Some(0.01), "{seed}");
        let error = relative_error(&found.values, &exact);
        assert!(error <= 0.01, "{seed}: {error}");
    }
    assert_eq!(evaluations, [172_974, 52_104, 182_559, 84_216, 106_374]);
    Ok(())
}

#[test]
fn lines_of_sight_have_the_same_bits_for_any_number_of_threads() -> TestResult {
    let (smooth, shape) = (random_scene(1), random_shape(1));
    let rates: [&(dyn Fn([f64; 3]) -> f64 + Sync); 2] =
        [&|position| smooth.rate(position), &|position| shape.rate(position)];
    for rate in rates {
        let with_threads = |threads: usize| -> Result<_, Box<dyn std::error::Error>> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
            let found = pool.install(|| in_time(rate, [48, 48]));
            found.stats.line_steps.ok_or("lines of sight")?;
            let error = found.error.as_ref().ok_or("errors")?;
            Ok((bits(&found.values), bits(error), found.stats.evaluations))
        };
        let one = with_threads(1)?;
        assert!(with_threads(2)? == one && with_threads(5)? == one);
    }
    Ok(())
}

#[test]
fn slow_rates_have_the_image_of_fewest_evaluations() {
    let scene = random_scene(0);
    let slow = |position| {
        let started = Instant::now();
        while started.elapsed() < Duration::from_micros(20) {}
        scene.rate(position)
    };
    let found = in_time(slow, [48, 64]);
    let fewest = in_evaluations(|position| scene.rate(position), [48, 64]);
    assert_eq!(found.stats.line_steps, None);
    assert_eq!(found.stats.evaluations, fewest.stats.evaluations + FIRST_TIMES);
    assert_eq!(bits(&found.values), bits(&fewest.values));
}

/// Jumps along lines are bisected, and pixels that an edge of the image crosses have lines of their own.
#[test]
fn shapes_with_sharp_surfaces_are_integrated_along_lines_of_sight() -> TestResult {
    // A box, an ellipsoid, and a shell.
    for seed in [0, 1, 4] {
        let shape = random_shape(seed);
        let exact = shape.reference_image([32, 48]);
        let found = in_time(|position| shape.rate(position), [32, 48]);
        found.stats.line_steps.ok_or("lines of sight")?;
        assert!(found.converged() && found.surfaces.is_none(), "{seed}");
        let error = relative_error(&found.values, &exact.image);
        assert!(error <= 0.01 + exact.error, "{seed}: {error}");
    }
    Ok(())
}

/// The radius up to which the emission around a ball is larger, so that products do not serve it, and its factor there.
const BRIGHT: (f64, f64) = (0.35, 1.5);

/// exp(−r²/w²) times that factor, about the middle of the unit cube.
fn around_ball(position: [f64; 3], w: f64) -> f64 {
    let square: f64 = position.iter().map(|x| (x - 0.5).powi(2)).sum();
    (-square / (w * w)).exp() * if square < BRIGHT.0 * BRIGHT.0 { BRIGHT.1 } else { 1.0 }
}

/// The radiance of it at (x, y), about a ball of radius R and seen along z.
fn beside_ball([x, y]: [f64; 2], w: f64, radius: f64) -> f64 {
    let square = (x - 0.5).powi(2) + (y - 0.5).powi(2);
    let up_to = |depth: f64| 0.5 * core::f64::consts::PI.sqrt() * w * libm::erf(depth / w);
    let depth_in = |radius: f64| (radius * radius - square).max(0.0).sqrt();
    let half = |from: f64| {
        let bright = up_to(depth_in(BRIGHT.0)) - up_to(from);
        up_to(0.5) - up_to(from) + (BRIGHT.1 - 1.0) * bright
    };
    let seen = if square < radius * radius { half(depth_in(radius)) } else { 2.0 * half(0.0) };
    (-square / (w * w)).exp() * seen
}

/// The means of n × n of these radiances over each of 64 × 64 pixels.
fn means_beside_ball(n: usize, w: f64, radius: f64) -> Image {
    let side = 64 * n;
    let mut image = Image::zeros(64, 64);
    for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
        let at = |k: usize| (k as f64 + 0.5) / side as f64;
        image[(row / n, column / n)] +=
            beside_ball([at(column), at(row)], w, radius) / (n * n) as f64;
    }
    image
}

/// Limbs are known by geometry.
#[test]
fn views_with_bodies_are_integrated_along_lines_of_sight() -> TestResult {
    for (w, radius) in [(0.4, 0.2), (0.3, 0.013)] {
        let ball = Ellipsoid::sphere([0.5; 3], radius)?;
        let camera = Orthographic::of_unit_cube().with_occulters(vec![ball])?;
        let emission = FromFn(|position, _| around_ball(position, w));
        let found = render(&emission, &camera, [64, 64], &options(Minimize::Time))?;
        found.stats.line_steps.ok_or("lines of sight")?;
        let [exact, coarse] = [32, 16].map(|n| means_beside_ball(n, w, radius));
        let [error, of_exact] = [&found.values, &coarse].map(|image| relative_error(image, &exact));
        assert!(found.converged() && error <= 0.01 + of_exact, "{radius}: {error} {of_exact}");
        assert!(of_exact < 0.01, "{radius}: {of_exact}");
    }
    Ok(())
}

/// What lines that come to no end have evaluated changes nothing in the image of fewest evaluations.
#[test]
fn lines_that_are_given_up_do_not_change_the_image_of_fewest_evaluations() {
    let shape = random_shape(0);
    let emission = FromFn(|position, _| shape.rate(position));
    let options = |of| options(of).with_max_evaluations(300_000);
    let of = |of| render(&emission, &Canonical, [32, 32], &options(of)).unwrap();
    let (found, fewest) = (of(Minimize::Time), of(Minimize::Evaluations));
    assert_eq!(found.stats.line_steps, None);
    assert!(found.converged() && found.surfaces.is_some());
    assert!(found.stats.evaluations > fewest.stats.evaluations + FIRST_TIMES);
    assert!(found.stats.evaluations <= 300_000);
    assert_eq!(bits(&found.values), bits(&fewest.values));
}

/// Towards the poles of a whole sky the solid angles of pixels fall to 0.
#[test]
fn pixels_of_a_whole_sky_are_weighted_with_their_solid_angles() -> TestResult {
    let viewpoint = Viewpoint { position: [0.0; 3], target: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0] };
    let sky = Equirectangular::new(
        viewpoint,
        [core::f64::consts::TAU, core::f64::consts::PI],
        [0.0, 4.0],
    )?;
    let cloud =
        FromFn(|[x, y, z]: [f64; 3], _| (-((x - 0.3).powi(2) + y * y + (z - 0.8).powi(2))).exp());
    let found = render(&cloud, &sky, [128, 160], &options(Minimize::Time))?;
    found.stats.line_steps.ok_or("lines of sight")?;
    let exact = render(&cloud, &sky, [128, 160], &RenderOptions::new(VolOptions::new(1e-5)))?;
    let error = relative_error(&found.values, &exact.values);
    assert!(error < 0.01, "{error}");
    Ok(())
}

/// What is repeated can't depend on time.
#[test]
fn a_session_has_fewest_evaluations() -> TestResult {
    let scene = random_scene(1);
    let camera: &dyn Projection = &Canonical;
    let emission = FromFn(|position, _| scene.rate(position));
    let of = |minimize| -> Result<Rendering, Box<dyn std::error::Error>> {
        let mut session = Session::<Image>::new(camera, [32, 32], &options(minimize))?;
        while !session.is_done() {
            session.step(&emission)?;
        }
        Ok(session.rendering().ok_or("an image")?)
    };
    let (found, fewest) = (of(Minimize::Time)?, of(Minimize::Evaluations)?);
    assert_eq!(found.stats.evaluations, fewest.stats.evaluations);
    assert_eq!(bits(&found.values), bits(&fewest.values));
    Ok(())
}

#[test]
fn a_budget_below_that_of_the_lines_is_spent_on_few_evaluations() {
    let scene = random_scene(2);
    let emission = FromFn(|position, _| scene.rate(position));
    let options = |of| options(of).with_max_evaluations(40_000);
    let of = |of| render(&emission, &Canonical, [48, 48], &options(of)).unwrap();
    let (found, fewest) = (of(Minimize::Time), of(Minimize::Evaluations));
    assert_eq!(found.stats.line_steps, None);
    assert!(found.stats.evaluations <= 40_000);
    assert_eq!(bits(&found.values), bits(&fewest.values));
}
