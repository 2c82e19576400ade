//! The surfaces that a rendering has found, against those of known shapes.

use emitree::los::{LosOptions, Steps};
use emitree::projection::Bounds;
use emitree::result::FoundSurfaces;
use emitree::tree::BuildOptions;
use emitree::{
    Canonical, FromFn, Method, Orthographic, Perspective, Projection, RenderOptions, Rendering,
    Session, Viewpoint, VolOptions, render,
};

type Point = [f64; 3];

const CENTRE: Point = [0.1, -0.05, 0.03];
/// The radii of a shell and of the ball in it.
const RADII: [f64; 2] = [1.2, 0.8];

fn from_centre(at: Point) -> Point {
    core::array::from_fn(|k| at[k] - CENTRE[k])
}

fn norm(a: Point) -> f64 {
    a.iter().map(|along| along * along).sum::<f64>().sqrt()
}

/// A ball in a shell, whose rates depend on the place, in the dark.
fn ball_in_shell(at: Point) -> f64 {
    let r = norm(from_centre(at));
    if r < RADII[1] {
        0.5 + 0.1 * at[0]
    } else if r < RADII[0] {
        2.0 + 0.3 * at[1]
    } else {
        0.0
    }
}

fn viewpoint() -> Viewpoint {
    Viewpoint { position: [10.0, 2.0, 1.0], target: [0.1, 0.0, 0.0], up: [0.0, 0.0, 1.0] }
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn perspective() -> Perspective {
    Perspective::new(viewpoint(), [0.35, 0.35], [7.0, 13.0]).unwrap()
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn rendered(
    g: impl Fn(Point) -> f64 + Sync,
    camera: &dyn Projection,
    method: impl Into<Method>,
) -> Rendering {
    let options = RenderOptions::new(method);
    render(&FromFn(|at: Point, _: Point| g(at)), camera, [48, 48], &options).unwrap()
}

#[expect(clippy::expect_used, reason = "what fails here fails the test")]
fn found(
    g: impl Fn(Point) -> f64 + Sync,
    camera: &dyn Projection,
    tolerance: f64,
) -> FoundSurfaces {
    let rendering = rendered(g, camera, VolOptions::new(tolerance));
    (*rendering.surfaces.expect("surfaces are found")).clone()
}

/// The value below which a share of the values is.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(share * (values.len() - 1) as f64) as usize]
}

/// Places, normals and jumps of the ball and the shell: for each vertex the distance from the nearest
/// sphere, and the number of that sphere.
fn check_shell(surfaces: &FoundSurfaces, tolerance: f64) -> Vec<(f64, usize)> {
    let (mut off, mut cosines) = (Vec::new(), Vec::new());
    let vertices = surfaces.positions.iter().zip(&surfaces.normals).zip(&surfaces.jumps);
    for ((position, normal), jump) in vertices {
        let from = from_centre(*position);
        let r = norm(from);
        let sphere = usize::from((r - RADII[1]).abs() < (r - RADII[0]).abs());
        off.push(((r - RADII[sphere]).abs(), sphere));
        // The shell is brighter than the ball and the dark.
        let outward = if sphere == 0 { -1.0 } else { 1.0 };
        let cosine = outward * (0..3).map(|k| normal[k] * from[k] / r).sum::<f64>();
        assert!(cosine > 0.9 && (norm(*normal) - 1.0).abs() < 1e-12, "{position:?} {normal:?}");
        cosines.push(cosine);
        let beside = |side: f64| {
            let r_there = RADII[sphere] + side;
            ball_in_shell(core::array::from_fn(|k| CENTRE[k] + from[k] * r_there / r))
        };
        let exact = (beside(1e-9) - beside(-1e-9)).abs();
        assert!((jump - exact).abs() < 0.5 * tolerance * exact, "{position:?}: {jump}, {exact}");
    }
    let most = quantile(cosines, 0.02);
    assert!(most > 0.995, "{tolerance}: {most}");
    off
}

#[test]
fn vertices_are_as_near_to_the_surface_as_they_say() {
    for tolerance in [0.03, 0.01, 3e-3] {
        let surfaces = found(ball_in_shell, &perspective(), tolerance);
        let off = check_shell(&surfaces, tolerance);
        let ratios: Vec<f64> = off
            .iter()
            .zip(&surfaces.uncertainties)
            .map(|((off, _), expected)| off / expected)
            .collect();
        let [half, most] = [0.5, 0.95].map(|share| quantile(ratios.clone(), share));
        assert!(0.1 < half && half < 1.0, "{tolerance}: half are within {half}");
        assert!(most < 2.0, "{tolerance}: most are within {most}");
        let worst = off.iter().map(|(off, _)| *off).fold(0.0, f64::max);
        assert!(worst < tolerance, "{tolerance}: {worst}");
        let count = |sphere: usize| off.iter().filter(|(_, of)| *of == sphere).count();
        let ratio = count(0) as f64 / count(1) as f64;
        let of_areas = (RADII[0] / RADII[1]).powi(2);
        assert!((ratio / of_areas - 1.0).abs() < 0.1, "{ratio}: vertices are not even");
    }
}

#[test]
fn triangles_are_closed_and_turn_to_the_brighter_side() {
    let surfaces = found(ball_in_shell, &perspective(), 0.01);
    let mut edges = std::collections::HashMap::new();
    let (mut area, mut volume) = (0.0, 0.0);
    for triangle in &surfaces.triangles {
        for k in 0..3 {
            let [a, b] = [triangle[k], triangle[(k + 1) % 3]];
            *edges.entry([a.min(b), a.max(b)]).or_insert(0) += if a < b { 1 } else { -1 };
        }
        let [a, b, c] = triangle.map(|vertex| from_centre(surfaces.positions[vertex as usize]));
        let [u, v]: [Point; 2] = [b, c].map(|end| core::array::from_fn(|k| end[k] - a[k]));
        let across =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        area += 0.5 * norm(across);
        volume += (0..3).map(|k| a[k] * across[k]).sum::<f64>() / 6.0;
    }
    assert!(edges.values().all(|sum| *sum == 0), "each edge has triangles on both of its sides");
    let pi = core::f64::consts::PI;
    let exact = 4.0 * pi * (RADII[0].powi(2) + RADII[1].powi(2));
    assert!((area / exact - 1.0).abs() < 0.01, "{area}, {exact}");
    // The normals of the ball are outward, those of the shell around it inward.
    let exact = 4.0 / 3.0 * pi * (RADII[1].powi(3) - RADII[0].powi(3));
    assert!((volume / exact - 1.0).abs() < 0.01, "{volume}, {exact}");
}

#[test]
fn lengths_are_those_of_the_scene() {
    let camera = Orthographic::new(viewpoint(), [4.0, 4.0], [7.0, 13.0]).unwrap();
    check_shell(&found(ball_in_shell, &camera, 0.01), 0.01);
    let far = |at: Point| ball_in_shell(at.map(|along| along / 1e4));
    let viewpoint = Viewpoint { position: [1e5, 2e4, 1e4], target: [1e3, 0.0, 0.0], ..viewpoint() };
    let camera = Perspective::new(viewpoint, [0.35, 0.35], [7e4, 13e4]).unwrap();
    let surfaces = found(far, &camera, 0.01);
    let off = surfaces.positions.iter().map(|at| {
        let r = norm(from_centre(at.map(|along| along / 1e4)));
        (r - RADII[0]).abs().min((r - RADII[1]).abs())
    });
    assert!(off.fold(0.0, f64::max) < 0.01);
    let expected = quantile(surfaces.uncertainties.clone(), 0.5);
    assert!((1.0..30.0).contains(&expected), "{expected}");
}

#[test]
fn bounds_are_no_surfaces() {
    // The lines of sight end at two sides of the box, parallel to them: G jumps there, and g does not.
    let bounds = Bounds::cuboid([-2.0, -1.4, -1.45], [2.0, 1.4, 1.45]).unwrap();
    let viewpoint = Viewpoint { position: [10.0, 0.0, 0.0], ..viewpoint() };
    let camera = Orthographic::new(viewpoint, [4.0, 4.0], [7.0, 13.0]).unwrap();
    let camera = camera.with_bounds(bounds);
    let surfaces = found(|at| ball_in_shell(at) + 0.4, &camera, 0.02);
    assert!(surfaces.len() > 1_000);
    let off = surfaces.positions.iter().map(|position| {
        let r = norm(from_centre(*position));
        (r - RADII[0]).abs().min((r - RADII[1]).abs())
    });
    let off: Vec<f64> = off.collect();
    assert!(quantile(off.clone(), 0.999) < 0.02);
    // The bounds are 0.15 from the spheres at the least.
    assert!(quantile(off, 1.0) < 0.05);
}

#[test]
fn what_is_not_made_of_found_surfaces_has_none() {
    let smooth = |at: Point| (-at.iter().map(|along| along * along).sum::<f64>()).exp();
    let methods = [
        Method::Vol(VolOptions::new(0.01)),
        Method::Los(LosOptions::new(1, Steps::Fixed(16))),
        Method::Paper(BuildOptions::default()),
    ];
    for method in methods {
        assert!(rendered(smooth, &Canonical, method).surfaces.is_none());
    }
}

#[test]
fn a_session_has_them_when_it_ends() {
    let camera = perspective();
    let options = RenderOptions::new(VolOptions::new(0.03));
    let mut session =
        Session::<emitree::Image>::new(&camera as &dyn Projection, [48, 48], &options).unwrap();
    let emission = FromFn(|at: Point, _: Point| ball_in_shell(at));
    while !session.is_done() {
        assert!(session.rendering().is_none_or(|so_far| so_far.surfaces.is_none()));
        session.step(&emission).unwrap();
    }
    let surfaces = session.rendering().unwrap().surfaces.unwrap();
    assert_eq!(*surfaces, found(ball_in_shell, &camera, 0.03));
}
