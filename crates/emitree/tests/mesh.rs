//! Meshes: the frozen quadrature of a rendering.

use emitree::los::{LosOptions, Steps};
use emitree::mesh::{Mesh, MeshError};
use emitree::quadrature::CellRule;
use emitree::result::Values;
use emitree::tree::BuildOptions;
use emitree::{
    Canonical, Cube, EnergyAxis, EnergyScale, FromFn, FromSpectralFn, Image, Method, Projection,
    RenderOptions, Session, StopReason, VolOptions,
};
use emitree_problems::ball::Ball;
use emitree_problems::family::random_scene;
use emitree_problems::relative_error;
use emitree_problems::views::random_view;
use std::collections::HashSet;

const CAMERA: &dyn Projection = &Canonical;
/// Of the values of a rendering: sums of some thousand terms in another order.
const ROUNDING: f64 = 1e-11;

/// Of meshes whose matrix is compared: it takes an image for each node.
const MOST_NODES: usize = 150;

fn vol(tolerance: f64) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(tolerance))
}

/// A session run to its end.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn ended<'a>(
    camera: &'a dyn Projection,
    shape: [usize; 2],
    options: &RenderOptions<'_>,
    rate: impl Fn([f64; 3]) -> f64 + Sync,
) -> Session<'a> {
    let mut session = Session::<Image>::new(camera, shape, options).unwrap();
    while !session.is_done() {
        session.step(&FromFn(|at, _| rate(at))).unwrap();
    }
    session
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn applied(mesh: &Mesh, rate: impl Fn([f64; 3]) -> f64) -> Image {
    let rates: Vec<f64> = mesh.points().positions().iter().map(|&at| rate(at)).collect();
    mesh.apply(&rates).unwrap()
}

/// Compares the values of a mesh with those expected, to rounding; NaN belongs to NaN.
fn assert_same(found: &Image, expected: &Image, name: &str) {
    let allowed = ROUNDING * expected.largest();
    for (found, expected) in found.pixels().iter().zip(expected.pixels()) {
        let are_equal = (found - expected).abs() <= allowed;
        assert!(are_equal || found.is_nan() && expected.is_nan(), "{name}: {found} {expected}");
    }
}

/// The mesh gives the values of its rendering, and those of a multiple and of a sum of two emissions.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn check(session: &Session<'_>, rate: impl Fn([f64; 3]) -> f64, name: &str) -> Mesh {
    let (mesh, rendering) = (session.mesh().unwrap(), session.rendering().unwrap());
    let image = rendering.values;
    assert_same(&applied(&mesh, &rate), &image, name);
    let scaled = |image: &Image, factor: f64| {
        let pixels = image.pixels().iter().map(|pixel| factor * pixel).collect();
        Image::from_pixels(image.height(), image.width(), pixels)
    };
    assert_same(&applied(&mesh, |at| 2.0 * rate(at)), &scaled(&image, 2.0), name);
    let other = |[x, y, z]: [f64; 3]| (x + 2.0 * y - z).sin();
    let mut sum = applied(&mesh, other);
    sum.pixels_mut().iter_mut().zip(image.pixels()).for_each(|(sum, pixel)| *sum += pixel);
    assert_same(&applied(&mesh, |at| rate(at) + other(at)), &sum, name);
    if mesh.weights().rows() <= MOST_NODES {
        let rates: Vec<f64> = mesh.points().positions().iter().map(|&at| rate(at)).collect();
        let mut pixels = mesh.matrix().times(&rates);
        let outside = pixels.iter_mut().zip(image.pixels()).filter(|(_, pixel)| pixel.is_nan());
        outside.for_each(|(found, _)| *found = f64::NAN);
        assert_same(&Image::from_pixels(image.height(), image.width(), pixels), &image, name);
    }
    let points = mesh.points();
    let both = points.positions().iter().zip(points.directions());
    let unique: HashSet<[u64; 6]> =
        both.map(|([x, y, z], [a, b, c])| [x, y, z, a, b, c].map(|k| k.to_bits())).collect();
    assert_eq!(unique.len(), points.len(), "{name}: no point is there twice");
    assert!(points.len() as u64 <= rendering.stats.evaluations, "{name}");
    assert_eq!(points.len(), mesh.weights().columns(), "{name}");
    mesh
}

fn peak([x, y, z]: [f64; 3]) -> f64 {
    0.1 + (-((x - 0.3_f64).powi(2) + (y - 0.6_f64).powi(2) + (z - 0.4_f64).powi(2)) / 0.02).exp()
}

#[test]
fn cells_and_lines_give_the_image_of_their_rendering() {
    let paper = |rule| Method::Paper(BuildOptions::default().with_rule(rule));
    let los = |lines, steps| Method::Los(LosOptions::new(lines, steps));
    let methods = [
        ("midpoint", paper(CellRule::Midpoint)),
        ("simpson", paper(CellRule::Simpson)),
        ("fixed", los(2, Steps::Fixed(20))),
        ("adaptive", los(1, Steps::Adaptive(1e-6))),
    ];
    for (name, method) in methods {
        let session = ended(CAMERA, [10, 15], &RenderOptions::new(method), peak);
        check(&session, peak, name);
    }
}

/// Random scenes, of which some have image trees, with depth rules, and some products.
#[test]
fn trees_and_products_give_the_image_of_their_rendering() {
    let (mut with_rules, mut with_products) = (0, 0);
    for seed in [0, 1, 2, 240, 241, 242] {
        let scene = random_scene(seed);
        let session = ended(CAMERA, [24, 32], &vol(0.01), |at| scene.rate(at));
        let mesh = check(&session, |at| scene.rate(at), &scene.name());
        // A full line has 9 depths at the least, a line with a rule fewer, and a pivot is one point.
        let depths = |row: usize| mesh.weights().row(row).count();
        let lines: Vec<usize> = (0..mesh.weights().rows()).map(depths).collect();
        let has_full = lines.iter().any(|depths| *depths >= 9);
        with_rules += usize::from(has_full && lines.iter().any(|depths| (1..9).contains(depths)));
        with_products += usize::from(lines.iter().all(|depths| *depths == 1));
    }
    assert!(with_rules > 1 && with_products > 1, "{with_rules} {with_products}");
}

/// Charts with products, with trees and with both, lines behind bodies, rims of discs and skies.
#[test]
fn views_with_bodies_have_meshes() {
    for seed in [3, 4, 9, 11, 13, 14, 15, 16, 18] {
        let view = random_view(seed);
        let session = ended(view.camera(), view.shape(), &vol(0.01), |at| view.rate(at));
        check(&session, |at| view.rate(at), &view.name());
    }
}

#[test]
fn cubes_have_meshes() {
    let axis = EnergyAxis::new(1.0, 10.0, 6, EnergyScale::Log).unwrap();
    let rate = |at: [f64; 3], energy: f64| peak(at) * (-energy * (1.0 + at[0])).exp();
    let emission = FromSpectralFn(|at, _, energy| rate(at, energy));
    let methods = [
        vol(0.01).method,
        Method::Paper(BuildOptions::default()),
        Method::Los(LosOptions::new(2, Steps::Fixed(8))),
    ];
    for method in methods {
        let options = RenderOptions::new(method);
        let energies = Some(axis);
        let mut session =
            Session::<Cube>::with_energies(CAMERA, [8, 12], energies, &options).unwrap();
        while !session.is_done() {
            session.step(&emission).unwrap();
        }
        let (mesh, rendering) = (session.mesh().unwrap(), session.rendering().unwrap());
        let points = mesh.points();
        let both = points.positions().iter().zip(points.energies());
        let rates: Vec<f64> = both.map(|(&at, &energy)| rate(at, energy)).collect();
        let cube = mesh.apply(&rates).unwrap();
        let difference = cube.max_difference(&rendering.values);
        assert!(difference < ROUNDING * rendering.values.largest(), "{options:?} {difference}");
    }
}

/// Another amplitude at the points of an image tree is as good as a new rendering to the same tolerance.
#[test]
fn a_mesh_serves_an_emission_like_its_own() {
    let tolerance = 0.01;
    for seed in [0, 2, 244] {
        let scene = random_scene(seed);
        let like = |at: [f64; 3]| scene.rate(at) * (1.0 + 0.3 * at[0] - 0.2 * at[2]);
        let session = ended(CAMERA, [24, 32], &vol(tolerance), |at| scene.rate(at));
        let exact = ended(CAMERA, [24, 32], &vol(1e-5), like).rendering().unwrap().values;
        let error = relative_error(&applied(&session.mesh().unwrap(), like), &exact);
        assert!(error < tolerance, "{}: {error}", scene.name());
    }
}

#[test]
fn why_there_is_no_mesh_is_named() {
    let session = Session::<Image>::new(CAMERA, [8, 8], &vol(0.01)).unwrap();
    assert_eq!(session.mesh().err(), Some(MeshError::NotEnded));
    let ball = Ball::default();
    let session = ended(CAMERA, [32, 32], &vol(0.01), |at| ball.rate(at));
    assert_eq!(session.mesh().err(), Some(MeshError::FoundSurfaces));
    let mesh = ended(CAMERA, [8, 8], &vol(0.01), peak).mesh().unwrap();
    let expected = mesh.points().len();
    assert_eq!(mesh.apply(&[1.0]).err(), Some(MeshError::Rates { number: 1, expected }));
}

/// Nothing is evaluated for a mesh; a time limit that was not reached changes nothing here.
#[test]
fn a_continued_session_has_the_mesh_of_its_last_tolerance() {
    let scene = random_scene(2);
    let rate = |at: [f64; 3]| scene.rate(at);
    let mut session = ended(CAMERA, [16, 16], &vol(0.02), rate);
    let coarse = session.mesh().unwrap();
    session.resume([20, 16], &vol(0.005).with_max_seconds(1e6)).unwrap();
    while !session.is_done() {
        session.step(&FromFn(|at, _| rate(at))).unwrap();
    }
    let evaluations = session.rendering().unwrap().stats.evaluations;
    let fine = check(&session, rate, "continued");
    assert_ne!(fine.points().len(), coarse.points().len());
    let at_once = ended(CAMERA, [20, 16], &vol(0.005), rate).mesh().unwrap();
    assert_eq!(fine.points().positions(), at_once.points().positions());
    assert_eq!(session.rendering().unwrap().stats.evaluations, evaluations);
}

/// What a time limit has cut short can't be repeated without new evaluations.
#[test]
fn a_session_that_the_time_has_ended_has_no_mesh() {
    let scene = random_scene(2);
    let options = vol(1e-6).with_max_seconds(0.2);
    let mut session = Session::<Image>::new(CAMERA, [16, 16], &options).unwrap();
    let slow = FromFn(|at: [f64; 3], _: [f64; 3]| scene.rate(at));
    while !session.is_done() {
        std::thread::sleep(std::time::Duration::from_millis(20));
        session.step(&slow).unwrap();
    }
    assert_eq!(session.rendering().unwrap().stats.ending, StopReason::Time);
    assert_eq!(session.mesh().err(), Some(MeshError::TimeLimit));
}
