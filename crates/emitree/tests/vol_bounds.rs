//! Method `vol` on shapes within bounds that clip lines of sight at other distances; their integrals are closed forms.

use emitree::projection::{Bounds, Ellipsoid};
use emitree::{
    FromFn, Image, Orthographic, Perspective, Projection, RenderOptions, Viewpoint, VolOptions,
    render,
};
use emitree_problems::relative_error;

const TOLERANCE: f64 = 0.01;
const SHAPE: [usize; 2] = [32, 32];
/// Lines along each side of a pixel. Twice as many change the exact images below by less than 3e-4 of the largest pixel.
const LINES: usize = 24;
const INFINITE: f64 = f64::INFINITY;

/// A scene of closed forms.
trait Scene: Sync {
    fn rate(&self, position: [f64; 3]) -> f64;
    /// The integral from one point to another one.
    fn integral(&self, from: [f64; 3], to: [f64; 3]) -> f64;
}

/// A ball of emission rate 1.
struct Ball {
    centre: [f64; 3],
    radius: f64,
}

const BALL: Ball = Ball { centre: [0.1, -0.05, 0.15], radius: 0.5 };

/// The distance of two points, where on the line from one to the other a third one is nearest, and the square of how near.
fn along(from: [f64; 3], to: [f64; 3], centre: [f64; 3]) -> [f64; 3] {
    let [towards, aside] = [to, centre].map(|at| [0, 1, 2].map(|k| at[k] - from[k]));
    let square = |a: [f64; 3]| a.iter().map(|along| along * along).sum::<f64>();
    let length = square(towards).sqrt();
    // A line that is outside of the bounds has one point.
    let of_unit = if length > 0.0 { 1.0 / length } else { 0.0 };
    let nearest: f64 = (0..3).map(|k| aside[k] * towards[k] * of_unit).sum();
    [length, nearest, square(aside) - nearest * nearest]
}

impl Scene for Ball {
    fn rate(&self, position: [f64; 3]) -> f64 {
        let square: f64 = (0..3).map(|k| (position[k] - self.centre[k]).powi(2)).sum();
        f64::from(u8::from(square < self.radius * self.radius))
    }

    fn integral(&self, from: [f64; 3], to: [f64; 3]) -> f64 {
        let [length, nearest, miss] = along(from, to, self.centre);
        let half = (self.radius * self.radius - miss).max(0.0).sqrt();
        ((nearest + half).clamp(0.0, length) - (nearest - half).clamp(0.0, length)).max(0.0)
    }
}

/// An upright cylinder of radius 2, of emission rate 1.
struct Cylinder;

impl Scene for Cylinder {
    fn rate(&self, [x, y, _]: [f64; 3]) -> f64 {
        f64::from(u8::from(x * x + y * y < 4.0))
    }

    fn integral(&self, from: [f64; 3], to: [f64; 3]) -> f64 {
        let [foot, end] = [from, to].map(|[x, y, _]| [x, y, 0.0]);
        let [length, ..] = along(from, to, [0.0; 3]);
        let [upright, ..] = along(foot, end, [0.0; 3]);
        let of_unit = if upright > 0.0 { length / upright } else { 0.0 };
        of_unit * Ball { centre: [0.0; 3], radius: 2.0 }.integral(foot, end)
    }
}

/// A cluster of galaxies, (1 + r²/a²)⁻², with two cavities without emission.
struct Cluster;

const CORE: f64 = 0.2;
const CAVITIES: [Ball; 2] = [
    Ball { centre: [0.25, 0.0, 0.1], radius: 0.17 },
    Ball { centre: [-0.3, 0.05, -0.1], radius: 0.2 },
];

impl Cluster {
    /// The integral to a distance from where the line is nearest to the middle.
    fn to(miss: f64, distance: f64) -> f64 {
        let square = CORE * CORE + miss;
        let angle = (distance / square.sqrt()).atan() / square.sqrt();
        0.5 * CORE.powi(4) / square * (distance / (square + distance * distance) + angle)
    }
}

impl Scene for Cluster {
    fn rate(&self, position: [f64; 3]) -> f64 {
        let square: f64 = position.iter().map(|along| along * along).sum();
        let is_empty = CAVITIES.iter().any(|of| of.rate(position) > 0.0);
        if is_empty { 0.0 } else { (1.0 + square / (CORE * CORE)).powi(-2) }
    }

    fn integral(&self, from: [f64; 3], to: [f64; 3]) -> f64 {
        let [length, nearest, miss] = along(from, to, [0.0; 3]);
        let part =
            |[low, high]: [f64; 2]| Self::to(miss, high - nearest) - Self::to(miss, low - nearest);
        let of_cavity = |of: &Ball| {
            let [_, middle, miss] = along(from, to, of.centre);
            let half = (of.radius * of.radius - miss).max(0.0).sqrt();
            part([middle - half, middle + half].map(|end| end.clamp(0.0, length)))
        };
        part([0.0, length]) - CAVITIES.iter().map(of_cavity).sum::<f64>()
    }
}

fn viewpoint(position: [f64; 3]) -> Viewpoint {
    Viewpoint { position, target: [0.0; 3], up: [0.0, 0.0, 1.0] }
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn room() -> Bounds {
    Bounds::cuboid([-1.0, -0.8, -0.9], [0.9, 1.0, 0.8]).unwrap()
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn sphere() -> Bounds {
    Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], 0.9).unwrap())
}

/// Means of the integrals over pixels, weighted with solid angle.
fn exact(scene: &dyn Scene, camera: &dyn Projection, [height, width]: [usize; 2]) -> Image {
    let of_pixel = |pixel: usize| {
        let (mut sum, mut whole) = (0.0, 0.0);
        for k in 0..LINES * LINES {
            let place = |number: usize, k: usize| number as f64 + (k as f64 + 0.5) / LINES as f64;
            let x = place(pixel % width, k % LINES) / width as f64;
            let y = place(pixel / width, k / LINES) / height as f64;
            let weight = camera.solid_angle_density([x, y]);
            let [from, to] = [0.0, 1.0].map(|z| camera.world_from_canonical([x, y, z]).position);
            whole += weight;
            sum += weight * scene.integral(from, to);
        }
        sum / whole
    };
    Image::from_pixels(height, width, (0..height * width).map(of_pixel).collect())
}

fn check(scene: &dyn Scene, camera: &dyn Projection, evaluations: u64) {
    check_image(scene, camera, SHAPE, evaluations);
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn check_image(scene: &dyn Scene, camera: &dyn Projection, shape: [usize; 2], evaluations: u64) {
    let emission = FromFn(|position, _| scene.rate(position));
    let options = RenderOptions::new(VolOptions::new(TOLERANCE));
    let rendering = render(&emission, camera, shape, &options).unwrap();
    let error = relative_error(&rendering.values, &exact(scene, camera, shape));
    let estimate = rendering.estimated_error().unwrap();
    assert!(rendering.converged() && rendering.surfaces.is_some());
    assert!(error <= estimate && estimate <= TOLERANCE, "{error} instead of {estimate}");
    assert_eq!(rendering.stats.evaluations, evaluations);
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn pinhole(position: [f64; 3], fov_rad: f64, bounds: Bounds) -> Perspective {
    let camera = Perspective::new(viewpoint(position), [fov_rad; 2], [0.0, INFINITE]).unwrap();
    camera.with_bounds(bounds)
}

#[test]
fn a_ball_in_a_box_is_seen_over_an_edge() {
    check(&BALL, &pinhole([3.0, -5.0, 2.0], 0.42, room()), 4_056);
}

#[test]
fn a_ball_in_a_box_is_seen_from_inside() {
    check(&BALL, &pinhole([-0.8, -0.6, -0.6], 1.4, room()), 6_446);
}

#[test]
fn a_ball_in_a_sphere_is_seen_from_outside() {
    check(&BALL, &pinhole([3.0, -5.0, 2.0], 0.42, sphere()), 3_506);
}

#[test]
fn a_ball_in_a_box_is_seen_along_a_diagonal() {
    let viewpoint = viewpoint([4.0, 4.0, 4.0]);
    let camera = Orthographic::new(viewpoint, [3.2; 2], [-INFINITE, INFINITE]).unwrap();
    check(&BALL, &camera.with_bounds(room()), 4_794);
}

/// Little is between the cylinder and the walls that it touches: cells there have corners in the cylinder and corners
/// behind the walls, but none between them.
#[test]
fn a_cylinder_that_touches_a_box_is_seen_from_the_side() {
    let touched = Bounds::cuboid([-2.0, -2.0, -1.0], [2.0, 2.0, 1.0]).unwrap();
    for (position, shape, extent, evaluations) in [
        ([9.0, 0.0, 0.0], [1, 20], [5.0, 1.0], 6_420),
        ([7.0, 4.0, 3.0], [24, 32], [6.0, 4.5], 5_174),
    ] {
        let camera = Orthographic::new(viewpoint(position), extent, [-INFINITE, INFINITE]).unwrap();
        check_image(&Cylinder, &camera.with_bounds(touched), shape, evaluations);
    }
}

/// The first lattice has corners in one cavity only: the search is repeated from a finer one.
#[test]
fn small_cavities_in_a_cluster() {
    check(&Cluster, &pinhole([3.0, -5.0, 2.0], 0.42, room()), 74_432);
}
