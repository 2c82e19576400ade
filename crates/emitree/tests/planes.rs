//! Method `vol` on emissions that jump or have a kink at declared planes: tolerances are met, at what cost. No constant
//! was chosen on these scenes.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::projection::{Bounds, Edge, Ellipsoid};
use emitree::{
    FromFn, Image, Orthographic, RenderOptions, Rendering, Viewpoint, VolOptions, render,
};
use emitree_problems::divided::random_divided;
use emitree_problems::relative_error;
use rayon::prelude::*;
use std::ops::Range;

/// Renders to a tolerance, and checks the evaluations of all.
fn check(seeds: Range<u64>, tolerance: f64, evaluations: u64) {
    let outcome = |seed| {
        let scene = random_divided(seed);
        let reference = scene.reference_image([64; 2]);
        assert!(reference.error < 0.05 * tolerance, "{}", scene.name());
        let emission = FromFn(|position, _| scene.rate(position));
        let options = RenderOptions::new(VolOptions::new(tolerance));
        let camera = scene.camera().unwrap();
        let rendering = render(&emission, &*camera, [64; 2], &options).unwrap();
        assert!(rendering.converged(), "{}: {:?}", scene.name(), rendering.stats.ending);
        let error = relative_error(&rendering.values, &reference.image);
        assert!(error <= tolerance + reference.error, "{}: {error:.1e}", scene.name());
        rendering.stats.evaluations
    };
    let evaluated: u64 = seeds.into_par_iter().map(outcome).sum();
    assert_eq!(evaluated, evaluations);
}

#[test]
fn a_hundredth_seeds_0() {
    check(0..16, 1e-2, 252_492);
}

#[test]
fn a_hundredth_seeds_100() {
    check(100..116, 1e-2, 177_430);
}

#[test]
fn a_thousandth_seeds_0() {
    check(0..6, 1e-3, 471_855);
}

/// A Gaussian with a factor beyond a plane whose normal is at an angle to parallel lines of sight.
fn divided(angle_deg: f64, beyond: f64, is_declared: bool) -> Rendering<Image> {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let (position, normal) = ([0.1, 0.0, 0.2], [cos, sin, 0.0]);
    let viewpoint = Viewpoint { position: [-6.0, 0.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let camera = Orthographic::new(viewpoint, [4.0; 2], [0.0, 12.0]).unwrap();
    let edges = if is_declared { vec![Edge::plane(position, normal).unwrap()] } else { Vec::new() };
    let camera = camera.with_edges(edges);
    let rate = |r: [f64; 3]| {
        let height: f64 = (0..3).map(|i| (r[i] - position[i]) * normal[i]).sum();
        let gaussian = (-2.0 * (r[0] * r[0] + r[1] * r[1] + 1.5 * r[2] * r[2])).exp();
        gaussian * if height > 0.0 { beyond } else { 1.0 }
    };
    let options = RenderOptions::new(VolOptions::new(1e-2));
    render(&FromFn(|r, _| rate(r)), &camera, [64; 2], &options).unwrap()
}

#[test]
fn a_plane_without_a_jump_costs_nothing() {
    for angle_deg in [0.0, 40.0, 89.0] {
        let evaluations = |declared| divided(angle_deg, 1.0, declared).stats.evaluations;
        assert_eq!(evaluations(true), evaluations(false), "{angle_deg}");
    }
}

#[test]
fn a_declared_jump_costs_what_two_smooth_emissions_do() {
    let smooth = divided(30.0, 1.0, false).stats.evaluations;
    let declared = divided(30.0, 0.3, true).stats.evaluations;
    assert_eq!([smooth, declared], [1_431, 3_498]);
    // Behind the plane there is nothing.
    assert_eq!(divided(30.0, 0.0, true).stats.evaluations, 3_129);
}

/// A plane that nothing declares is found as a surface, without many boxes in the slivers beside it: this scene took
/// 78,000 boxes and minutes.
#[test]
fn a_plane_that_is_not_declared_is_found() {
    const WIDTH: f64 = 0.6;
    let (sin, cos) = 0.35_f64.sin_cos();
    let viewpoint =
        Viewpoint { position: [0.0, 0.0, -10.0], target: [0.0; 3], up: [0.0, 1.0, 0.0] };
    let bounds = Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], 2.0).unwrap());
    let camera = Orthographic::new(viewpoint, [2.4; 2], [0.0, 20.0]).unwrap().with_bounds(bounds);
    let gaussian =
        |r: [f64; 3]| (-r.iter().map(|x| x * x).sum::<f64>() / (2.0 * WIDTH * WIDTH)).exp();
    let emission = FromFn(|r: [f64; 3], _| {
        let is_beyond = r[0] * sin + r[2] * cos > 0.05;
        gaussian(r) * if is_beyond { 0.3 } else { 1.0 }
    });
    let options = RenderOptions::new(VolOptions::new(1e-2));
    let rendering = render(&emission, &camera, [64; 2], &options).unwrap();
    assert!(rendering.converged());
    // Integrals of the Gaussian up to the plane and to the bounds, in the middle of pixels.
    let exact = |pixel: usize| {
        let [x, y] = [pixel % 64, pixel / 64].map(|k| 2.4 * ((k as f64 + 0.5) / 64.0 - 0.5));
        let end = (4.0 - x * x - y * y).sqrt();
        // Orthographic images have x to the left of a camera along +z whose `up` is y.
        let plane = ((0.05 + x * sin) / cos).clamp(-end, end);
        let below = |z: f64| libm::erf(z / (WIDTH * 2.0_f64.sqrt()));
        let [all, part] = [below(end), below(plane)];
        let line = (part + all) + 0.3 * (all - part);
        gaussian([x, y, 0.0]) * WIDTH * (core::f64::consts::PI / 2.0).sqrt() * line
    };
    let values: Vec<f64> = (0..64 * 64).map(exact).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let of_pixels = rendering.values.pixels().iter().zip(&values);
    let worst = of_pixels.map(|(a, b)| (a - b).abs() / largest).fold(0.0, f64::max);
    assert!(worst < 0.01, "{worst}");
    assert!(rendering.stats.evaluations < 30_000, "{}", rendering.stats.evaluations);
}
