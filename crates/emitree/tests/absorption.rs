//! Images of media that absorb, against closed forms: from inside and outside, by all methods.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::los::{LosOptions, Steps};
use emitree::projection::{Bounds, Edge, Ellipsoid};
use emitree::tree::BuildOptions;

use emitree::mesh::MeshError;
use emitree::{
    Absorbing, Canonical, Emission, Equirectangular, FromFn, Image, Method, Orthographic,
    Perspective, Projection, RenderOptions, Rendering, Viewpoint, VolOptions, render,
};
use emitree::{EnergyAxis, EnergyScale, FromSpectralFn, RenderError, Session, render_cube};
use emitree_problems::absorbing::random_medium;
use emitree_problems::relative_error;
use rayon::prelude::*;
use std::convert::Infallible;

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// An emission and an absorption coefficient that do not depend on the direction.
fn medium(
    rate: impl Fn(Vector) -> f64 + Sync,
    coefficient: impl Fn(Vector) -> f64 + Sync,
) -> impl Emission<Error = Infallible> {
    Absorbing {
        emission: FromFn(move |position, _| rate(position)),
        absorption: FromFn(move |position, _| coefficient(position)),
    }
}

fn vol(tolerance: f64) -> Method {
    VolOptions::new(tolerance).into()
}

fn adaptive(lines: usize, tolerance: f64) -> Method {
    LosOptions::new(lines, Steps::Adaptive(tolerance)).into()
}

fn rendered(
    emission: &impl Emission<Error = Infallible>,
    camera: &dyn Projection,
    shape: [usize; 2],
    method: Method,
) -> Rendering {
    render(emission, camera, shape, &RenderOptions::new(method)).unwrap()
}

/// The means over pixels of a function of lines, each from its first point along its direction, at `per_side`² midpoints.
fn means(
    camera: &dyn Projection,
    [height, width]: [usize; 2],
    per_side: usize,
    line: &dyn Fn(Vector, Vector) -> f64,
) -> Image {
    let at = |pixel: usize, part: usize, pixels: usize| {
        (pixel as f64 + (part as f64 + 0.5) / per_side as f64) / pixels as f64
    };
    let pixel = |row: usize, column: usize| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for part in 0..per_side * per_side {
            let xy = [at(column, part % per_side, width), at(row, part / per_side, height)];
            let point = camera.world_from_canonical([xy[0], xy[1], 0.0]);
            let weight = camera.solid_angle_density(xy);
            sum += weight * line(point.position, point.direction.map(|component| -component));
            weights += weight;
        }
        sum / weights
    };
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
    Image::from_pixels(height, width, pixels.map(|(row, column)| pixel(row, column)).collect())
}

/// The distances from `origin` at which a line enters and leaves a sphere about 0; equal if it misses.
fn chord(origin: Vector, direction: Vector, radius: f64) -> [f64; 2] {
    let nearest = -dot(origin, direction);
    let miss = dot(origin, origin) - nearest * nearest;
    let half = (radius * radius - miss).max(0.0).sqrt();
    [(nearest - half).max(0.0), (nearest + half).max(0.0)]
}

/// The radiance of a uniform ball about 0, on a line of sight.
fn of_ball(rate: f64, coefficient: f64, radius: f64) -> impl Fn(Vector, Vector) -> f64 {
    move |origin, direction| {
        let [enter, leave] = chord(origin, direction, radius);
        rate / coefficient * -(-coefficient * (leave - enter)).exp_m1()
    }
}

fn viewpoint(position: Vector) -> Viewpoint {
    Viewpoint { position, target: [0.0, 0.0, 0.1], up: [0.0, 1.0, 0.0] }
}

/// Whether a rendering meets its tolerance, and the error that it estimates is not below the true one.
fn check(name: &str, found: &Rendering, exact: &Image, tolerance: f64) {
    let error = relative_error(&found.values, exact);
    assert!(found.converged() && error <= tolerance, "{name}: {error} at {tolerance}");
    let share = found.stats.error_over_allowed;
    assert!(share.is_none_or(|share| share <= 1.0), "{name}: {share:?}");
}

/// A ball whose edge is known, and one whose edge is found by samples; from outside, from inside, and by parallel
/// lines.
#[test]
fn a_uniform_ball_has_the_radiance_of_its_chords() {
    let shape = [16, 16];
    let sphere = Ellipsoid::sphere([0.0; 3], 1.0).unwrap();
    let edges = vec![Edge::Ellipsoid(sphere)];
    let inside = |position: Vector| f64::from(u8::from(dot(position, position) < 1.0));
    let outside = Perspective::new(viewpoint([1.0, 2.0, 3.0]), [0.7, 0.7], [0.0, 8.0]).unwrap();
    let parallel = Orthographic::new(viewpoint([1.0, 2.0, 3.0]), [2.4, 2.4], [0.0, 8.0]).unwrap();
    let within = Equirectangular::new(viewpoint([0.3, 0.2, -0.4]), [3.0, 2.0], [0.0, 4.0]).unwrap();
    // With the lengths of their lines.
    let cameras: [(&str, Box<dyn Projection>, f64); 4] = [
        ("outside, with its edge", Box::new(outside.with_edges(edges.clone())), 8.0),
        ("parallel, with its edge", Box::new(parallel.with_edges(edges.clone())), 8.0),
        ("inside", Box::new(within.clone()), 4.0),
        ("inside, with its edge", Box::new(within.with_edges(edges)), 4.0),
    ];
    for coefficient in [0.5, 4.0] {
        let ball = medium(|r| 3.0 * inside(r), |r| coefficient * inside(r));
        let of_line = of_ball(3.0, coefficient, 1.0);
        for (name, camera, longest) in &cameras {
            let exact = means(&**camera, shape, 40, &of_line);
            check(name, &rendered(&ball, &**camera, shape, vol(0.01)), &exact, 0.01);
            // Adaptive steps miss a jump that is closer to the end of a panel, an eighth of the line, than its
            // outermost sample, 0.43 % of it, and chords between samples, whether the ball absorbs or not.
            let lines = means(&**camera, shape, 1, &of_line);
            let (_, largest) = lines.min_max();
            let found = rendered(&ball, &**camera, shape, adaptive(1, 1e-4));
            let pixels = found.values.pixels().iter().zip(lines.pixels());
            let bright = pixels.filter(|(_, exact)| **exact > 0.3 * largest);
            let error = bright.map(|(found, exact)| (found - exact).abs() / largest);
            let error = error.fold(0.0, f64::max);
            let missed = 0.0043 * longest / 8.0 * 3.0 / largest;
            assert!(error < 1e-4 + missed, "{name}: {error} {missed}");
        }
    }
}

/// Plane-parallel: g falls twice as fast as κ, seen from above and from below.
#[test]
fn an_exponential_atmosphere_has_its_closed_form() {
    let shape = [16, 16];
    let medium = medium(|r| (-2.0 * r[2]).exp(), |r| 1.5 * (-r[2]).exp());
    let above =
        Viewpoint { position: [0.0, 0.0, 31.0], target: [3.0, 1.0, 0.0], up: [0.0, 1.0, 0.0] };
    let bounds = Bounds::cuboid([-1e3, -1e3, 0.0], [1e3, 1e3, 30.0]).unwrap();
    let from_above = Perspective::new(above, [0.6, 0.6], [0.0, 60.0]).unwrap().with_bounds(bounds);
    let below = Viewpoint { position: [0.0; 3], target: [3.0, 1.0, 9.0], up: [0.0, 1.0, 0.0] };
    let from_below = Perspective::new(below, [0.6, 0.6], [0.0, f64::INFINITY]).unwrap();
    // With u = exp(−z) and a = 1.5 / μ: ∫ u exp(−a u) du / μ from above, ∫ u exp(−a (1 − u)) du / μ from below.
    let down = |_: Vector, direction: Vector| {
        let mu = -direction[2];
        let a = 1.5 / mu;
        (1.0 - (1.0 + a) * (-a).exp()) / (a * a) / mu
    };
    let up = |_: Vector, direction: Vector| {
        let mu = direction[2];
        let a = 1.5 / mu;
        ((a - 1.0) + (-a).exp()) / (a * a) / mu
    };
    type OfLine<'a> = &'a dyn Fn(Vector, Vector) -> f64;
    let views: [(&str, &dyn Projection, OfLine<'_>); 2] =
        [("above", &from_above, &down), ("below", &from_below, &up)];
    for (name, camera, of_line) in views {
        let exact = means(camera, shape, 8, of_line);
        for tolerance in [0.01, 1e-3, 1e-4] {
            check(name, &rendered(&medium, camera, shape, vol(tolerance)), &exact, tolerance);
        }
        let lines = means(camera, shape, 1, of_line);
        check(name, &rendered(&medium, camera, shape, adaptive(1, 1e-5)), &lines, 1e-5);
    }
}

/// A small cloud behind a slab, whose optical depth is 2.4 on all lines: the image is that of the cloud alone times
/// exp(−2.4).
#[test]
fn a_cloud_behind_a_slab_is_fainter_by_one_factor() {
    let (shape, width) = ([24, 24], 0.05_f64);
    let cloud = move |[x, y, z]: Vector| {
        let square = (x - 0.45).powi(2) + (y - 0.55).powi(2) + (z - 0.7).powi(2);
        (-square / (width * width)).exp()
    };
    let slab = |[_, _, z]: Vector| if (0.21..0.33).contains(&z) { 20.0 } else { 0.0 };
    let free = FromFn(move |position, _| cloud(position));
    let exact = rendered(&free, &Canonical, shape, vol(1e-5)).values;
    let pixels = exact.pixels().iter().map(|pixel| pixel * (-2.4_f64).exp()).collect();
    let exact = Image::from_pixels(shape[0], shape[1], pixels);
    for tolerance in [0.03, 1e-3] {
        let found = rendered(&medium(cloud, slab), &Canonical, shape, vol(tolerance));
        check("cloud", &found, &exact, tolerance);
        // The rates of all samples are those of the cloud times one factor; optical depths have a tenth of the
        // tolerance.
        let of_free = rendered(&free, &Canonical, shape, vol(0.9 * tolerance)).stats;
        assert_eq!(found.stats.evaluations, of_free.evaluations);
        assert_eq!(of_free.absorption_evaluations, 0);
    }
}

/// A planet with an exponential atmosphere and a moon in front of it, whose limbs are those of charts.
#[test]
fn an_atmosphere_around_a_planet_is_seen_behind_a_moon() {
    let shape = [16, 16];
    let (height, bodies) = (0.2, [([0.0; 3], 1.0), ([0.9, 0.8, 1.6], 0.25)]);
    let shell = move |r: Vector| (-(dot(r, r).sqrt() - 1.0) / height).exp();
    let medium = medium(move |r| shell(r).sqrt(), move |r| 1.2 * shell(r));
    let occulters = bodies.map(|(centre, radius)| Ellipsoid::sphere(centre, radius).unwrap());
    let camera = Perspective::new(viewpoint([2.0, 3.0, 4.0]), [0.6, 0.6], [0.0, 10.0]).unwrap();
    let camera = camera.with_occulters(occulters.to_vec()).unwrap();
    // The midpoint rule, with an error of 1e-5 of the largest line.
    let line = move |origin: Vector, direction: Vector| {
        let end = bodies.iter().fold(10.0, |end: f64, (centre, radius)| {
            let from: Vector = core::array::from_fn(|i| origin[i] - centre[i]);
            let nearest = -dot(from, direction);
            let within = radius * radius - dot(from, from) + nearest * nearest;
            if within > 0.0 { end.min(nearest - within.sqrt()) } else { end }
        });
        let steps = 800;
        let step = end / f64::from(steps);
        let (mut depth, mut sum) = (0.0, 0.0);
        for k in 0..steps {
            let s = (f64::from(k) + 0.5) * step;
            let density = shell(core::array::from_fn(|i| origin[i] + s * direction[i]));
            depth += 0.6 * step * density;
            sum += step * density.sqrt() * (-depth).exp();
            depth += 0.6 * step * density;
        }
        sum
    };
    let exact = means(&camera, shape, 8, &line);
    check("planet", &rendered(&medium, &camera, shape, vol(0.02)), &exact, 0.02);
    let lines = means(&camera, shape, 1, &line);
    check("planet", &rendered(&medium, &camera, shape, adaptive(1, 1e-4)), &lines, 2e-4);
}

/// Gaussians of g and of κ by number, against quadrature; seeds that played no part in the choice of constants.
fn check_family(seeds: core::ops::Range<u64>, tolerance: f64, evaluations: [u64; 2]) {
    let shape = [24, 24];
    let outcome = |seed: u64| {
        let scene = random_medium(seed);
        let reference = scene.reference_image(shape);
        let medium = medium(|r| scene.rate(r), |r| scene.coefficient(r));
        let found = rendered(&medium, &Canonical, shape, vol(tolerance));
        let error = relative_error(&found.values, &reference.image);
        assert!(found.converged() && error <= tolerance + reference.error, "{seed}: {error}");
        let (_, largest) = reference.image.min_max();
        let estimates = found.error.as_ref().unwrap().pixels().iter();
        let pixels = found.values.pixels().iter().zip(reference.image.pixels()).zip(estimates);
        let within = pixels.filter(|((found, exact), estimate)| {
            (*found - *exact).abs() <= *estimate + reference.error * largest
        });
        let share = within.count() as f64 / found.values.pixels().len() as f64;
        ([found.stats.evaluations, found.stats.absorption_evaluations], share)
    };
    let count = seeds.clone().count() as f64;
    let outcomes: Vec<([u64; 2], f64)> = seeds.into_par_iter().map(outcome).collect();
    let mean = |of: usize| {
        let logs: f64 = outcomes.iter().map(|(cost, _)| (cost[of] as f64).ln()).sum();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "rounded, above 0"
        )]
        let rounded = (logs / count).exp().round() as u64;
        rounded
    };
    let within = outcomes.iter().map(|(_, share)| share).sum::<f64>() / count;
    assert!(within >= 0.99, "{within} of the pixels are within their estimates");
    assert_eq!([mean(0), mean(1)], evaluations);
}

#[test]
fn random_media_meet_one_percent() {
    check_family(1000..1020, 0.01, [2_047, 2103]);
}

#[test]
fn random_media_meet_a_tenth_of_a_percent() {
    check_family(1020..1030, 1e-3, [2_020, 2192]);
}

/// ∫ exp(−κ z) dz with κ = 2 x E, in two bins, by both methods that make cubes to a tolerance.
#[test]
fn a_coefficient_may_depend_on_the_energy() {
    let medium = Absorbing {
        emission: FromSpectralFn(|_, _, _| 1.0),
        absorption: FromSpectralFn(|[x, _, _]: Vector, _, energy| 2.0 * x * energy),
    };
    let axis = EnergyAxis::new(1.0, 3.0, 2, EnergyScale::Linear).unwrap();
    let mean = |column: usize, band: usize| {
        let at = |k: usize| (k as f64 + 0.5) / 50.0;
        let of = |i: usize| {
            let (x, energy) = ((column as f64 + at(i % 50)) / 4.0, 1.0 + band as f64 + at(i / 50));
            -(-2.0 * x * energy).exp_m1() / (2.0 * x * energy)
        };
        (0..2500).map(of).sum::<f64>() / 2500.0
    };
    for method in [vol(1e-3), adaptive(4, 1e-4)] {
        let options = RenderOptions::new(method);
        let found = render_cube(&medium, &Canonical, [2, 4], &axis, &options).unwrap();
        for (band, image) in found.values.bands().iter().enumerate() {
            for column in 0..4 {
                let error = (image[(1, column)] - mean(column, band)).abs();
                assert!(error < 1e-3, "{column} {band}: {error}");
            }
        }
        assert!(found.converged() && found.stats.absorption_evaluations > 0);
    }
}

/// A smooth medium, whose κ has products, and one whose κ jumps.
fn two_media() -> [Box<dyn Fn(Vector) -> f64 + Sync>; 2] {
    let smooth = |[x, y, z]: Vector| (x - y * z).exp();
    let jumps = |[x, _, z]: Vector| if z < 0.2 + 0.3 * x { 2.0 } else { 0.5 };
    [Box::new(smooth), Box::new(jumps)]
}

fn bits(image: &Image) -> Vec<u64> {
    image.pixels().iter().map(|pixel| pixel.to_bits()).collect()
}

#[test]
fn threads_and_batches_change_no_bit_and_costs_are_pinned() {
    let mut costs = Vec::new();
    for coefficient in two_media() {
        let medium = medium(|[x, y, z]| 1.0 + x * y * z, &*coefficient);
        let with = |batch_size: u64, threads: usize| {
            let options = RenderOptions::new(vol(0.01)).with_batch_size(batch_size);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| render(&medium, &Canonical, [12, 16], &options)).unwrap()
        };
        let first = with(u64::MAX, 1);
        for other in [with(u64::MAX, 3), with(100, 2)] {
            assert_eq!(bits(&other.values), bits(&first.values));
            let cost = |of: &Rendering| [of.stats.evaluations, of.stats.absorption_evaluations];
            assert_eq!(cost(&other), cost(&first));
        }
        costs.push([first.stats.evaluations, first.stats.absorption_evaluations]);
    }
    assert_eq!(costs, [[1438, 1909], [6_902, 342_183]]);
}

#[test]
fn the_paper_and_uniform_steps_render_media_too() {
    let medium = medium(|_| 1.0, |[x, _, _]| 1.0 + x);
    let exact = means(&Canonical, [8, 8], 20, &|[x, ..], _| -(-1.0 - x).exp_m1() / (1.0 + x));
    let paper = BuildOptions::default();
    check("paper", &rendered(&medium, &Canonical, [8, 8], paper.into()), &exact, 1e-3);
    let steps = LosOptions::new(4, Steps::Fixed(50));
    let found = rendered(&medium, &Canonical, [8, 8], steps.into());
    check("los", &found, &exact, 1e-3);
    // Each of the 32 × 32 lines has 4 panels of 16 samples.
    assert_eq!(found.stats.absorption_evaluations, 32 * 32 * 64);
}

#[test]
fn a_session_is_continued_with_the_bits_of_one_that_began_there() {
    for coefficient in two_media() {
        let medium = medium(|[x, y, z]| (-5.0 * (x * x + y * y + z * z)).exp(), &*coefficient);
        let camera: &dyn Projection = &Canonical;
        let options = |tolerance: f64| RenderOptions::new(vol(tolerance));
        let to_end = |session: &mut Session<'_>| {
            while !session.is_done() {
                session.step(&medium).unwrap();
            }
            session.rendering().unwrap()
        };
        let mut session = Session::<Image>::new(camera, [12, 12], &options(0.03)).unwrap();
        to_end(&mut session);
        session.resume([16, 16], &options(0.003)).unwrap();
        let continued = to_end(&mut session);
        let mut fresh = Session::<Image>::new(camera, [16, 16], &options(0.003)).unwrap();
        let at_once = to_end(&mut fresh);
        assert_eq!(bits(&continued.values), bits(&at_once.values));
        assert_eq!(session.mesh().unwrap_err(), MeshError::Absorption);
    }
}

#[test]
fn a_medium_that_absorbs_has_no_mesh() {
    let medium = medium(|_| 1.0, |_| 1.0);
    let options = RenderOptions::new(vol(0.01)).with_mesh_up_to(100_000);
    assert!(render(&medium, &Canonical, [8, 8], &options).unwrap().mesh.is_none());
    let free = FromFn(|_: Vector, _: Vector| 1.0);
    assert!(render(&free, &Canonical, [8, 8], &options).unwrap().mesh.is_some());
}

#[test]
fn a_coefficient_that_is_not_finite_is_an_error_that_names_the_point() {
    let message = |method: Method| {
        let medium = medium(|_| 1.0, |[x, ..]| if x > 0.6 { f64::NAN } else { 1.0 });
        let found = render(&medium, &Canonical, [8, 8], &RenderOptions::new(method));
        let Err(error @ RenderError::AbsorptionNotFinite { .. }) = found else { panic!() };
        error.to_string()
    };
    for method in [vol(0.01), adaptive(1, 1e-3)] {
        let text = message(method);
        assert!(text.starts_with("the absorption coefficient is NaN at position [0."), "{text}");
        assert!(text.ends_with(", emission direction [0.0, 0.0, -1.0]: expected a finite number"));
    }
}
