//! Every camera on bodies with exact images: a uniform glow, a cluster, a shell, an opaque planet.

use emitree::projection::{Bounds, DiscMapping, Ellipsoid, Region};
use emitree::{
    Emission, Equirectangular, Fisheye, FromFn, Healpix, Image, Orthographic, Perspective, Polar,
    Projection, RenderOptions, Rendering, Viewpoint, VolOptions, render,
};
use std::f64::consts::{PI, TAU};

const INFINITE: f64 = f64::INFINITY;

fn vol(tolerance: f64) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(tolerance))
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn image_of<E: Emission>(
    emission: &E,
    camera: &dyn Projection,
    shape: [usize; 2],
    options: &RenderOptions<'_>,
) -> Rendering
where
    E::Error: std::fmt::Debug,
{
    render(emission, camera, shape, options).unwrap()
}

/// A name, a camera and the shape of its image.
type View = (&'static str, Box<dyn Projection>, [usize; 2]);

/// All kinds of cameras from one position; the narrow ones point at the origin.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn views(position: [f64; 3], depth: [f64; 2], fov_rad: f64, bounds: Option<Bounds>) -> Vec<View> {
    let viewpoint = Viewpoint { position, target: [0.1, 0.0, 0.0], up: [0.1, 0.2, 1.0] };
    let disc = |mapping| Fisheye::new(viewpoint, fov_rad, mapping, depth).unwrap();
    let flat = fov_rad.min(2.4);
    macro_rules! bounded {
        ($camera:expr) => {
            match bounds {
                Some(bounds) => Box::new($camera.with_bounds(bounds)) as Box<dyn Projection>,
                None => Box::new($camera),
            }
        };
    }
    let parallel = Orthographic::new(viewpoint, [2.2, 2.0], depth).unwrap();
    let perspective = Perspective::new(viewpoint, [flat, 0.8 * flat], depth).unwrap();
    let equal_angles = Equirectangular::new(viewpoint, [fov_rad, 0.5 * fov_rad], depth).unwrap();
    vec![
        ("orthographic", bounded!(parallel), [20, 22]),
        ("perspective", bounded!(perspective), [24, 30]),
        ("equirectangular", bounded!(equal_angles), [16, 32]),
        ("polar", bounded!(Polar::new(viewpoint, fov_rad, depth).unwrap()), [18, 40]),
        ("fisheye ARC", bounded!(disc(DiscMapping::Equidistant)), [30, 30]),
        ("fisheye ZEA", bounded!(disc(DiscMapping::EqualArea)), [30, 30]),
        ("healpix", bounded!(Healpix::new(position, depth).unwrap()), Healpix::shape(8)),
    ]
}

#[test]
fn a_uniform_glow_has_the_same_radiance_in_every_pixel_of_every_camera() {
    let uniform = FromFn(|_: [f64; 3], _: [f64; 3]| 0.5);
    for (name, camera, shape) in views([0.3, -0.2, 0.1], [0.0, 3.0], TAU, None) {
        let rendering = image_of(&uniform, &*camera, shape, &vol(1e-3));
        assert!(rendering.converged(), "{name}");
        let (rows, columns) = (shape[0], shape[1]);
        let mut inside = 0;
        for (pixel, value) in rendering.values.pixels().iter().enumerate() {
            let middle = [
                ((pixel % columns) as f64 + 0.5) / columns as f64,
                ((pixel / columns) as f64 + 0.5) / rows as f64,
            ];
            let region = camera.view_geometry().map(|geometry| geometry.region(middle));
            if region == Some(Region::Outside) && value.is_nan() {
                continue;
            }
            inside += 1;
            assert!((value - 1.5).abs() < 1.5e-3, "{name}: pixel {pixel} is {value}");
        }
        assert!(inside >= rendering.values.pixels().len() * 3 / 4, "{name}: {inside}");
    }
}

/// (1 + r²/rc²)⁻², the beta model of β = 2/3, whose integral along any line is elementary.
fn cluster([x, y, z]: [f64; 3], _: [f64; 3]) -> f64 {
    (1.0 + (x * x + y * y + z * z) / (CORE * CORE)).powi(-2)
}

const CORE: f64 = 0.3;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// ∫ of the cluster from distance `from` to `to` along a line.
fn cluster_radiance(origin: [f64; 3], direction: [f64; 3], [from, to]: [f64; 2]) -> f64 {
    let closest = -dot(origin, direction);
    let squared = dot(origin, origin) - closest * closest;
    let a = 1.0 + squared / (CORE * CORE);
    let primitive = |s: f64| {
        let t = (s - closest) / CORE;
        if t.is_infinite() {
            return t.signum() * PI / 4.0 * a.powf(-1.5);
        }
        0.5 * t / (a * (a + t * t)) + 0.5 * (t / a.sqrt()).atan() * a.powf(-1.5)
    };
    CORE * (primitive(to) - primitive(from))
}

/// A uniform shell between two radii.
fn shell([x, y, z]: [f64; 3], _: [f64; 3]) -> f64 {
    let r = (x * x + y * y + z * z).sqrt();
    f64::from(u8::from((RADII[0]..=RADII[1]).contains(&r)))
}

const RADII: [f64; 2] = [0.6, 0.9];

/// The length of a line from distance `from` to `to` that is in the shell.
fn shell_radiance(origin: [f64; 3], direction: [f64; 3], [from, to]: [f64; 2]) -> f64 {
    let closest = -dot(origin, direction);
    let squared = dot(origin, origin) - closest * closest;
    let inside = |radius: f64| {
        let half = (radius * radius - squared).max(0.0).sqrt();
        ((closest + half).min(to) - (closest - half).max(from)).max(0.0)
    };
    inside(RADII[1]) - inside(RADII[0])
}

type LineIntegral = fn([f64; 3], [f64; 3], [f64; 2]) -> f64;

/// The exact image: means over `n` × `n` lines for each pixel, weighted with solid angles, and over
/// more of them where the rim of a disc crosses it.
fn exact_image(
    exact: LineIntegral,
    camera: &dyn Projection,
    depth: [f64; 2],
    [rows, columns]: [usize; 2],
    n: usize,
) -> Image {
    let mean = |pixel: usize, n: usize| {
        let (row, column) = (pixel / columns, pixel % columns);
        let (mut sum, mut weights, mut outside) = (0.0, 0.0, 0);
        for part in 0..n * n {
            let at =
                |k: usize, p: usize, m: usize| (k as f64 + (p as f64 + 0.5) / n as f64) / m as f64;
            let [x, y] = [at(column, part % n, columns), at(row, part / n, rows)];
            let weight = camera.solid_angle_density([x, y]);
            if weight > 0.0 {
                let begin = camera.world_from_canonical([x, y, 0.0]);
                sum += weight * exact(begin.position, begin.direction.map(|d| -d), depth);
                weights += weight;
            } else {
                outside += 1;
            }
        }
        (sum / weights, outside > 0 && outside < n * n)
    };
    let pixel = |pixel: usize| match mean(pixel, n) {
        (_, true) => mean(pixel, RIM_LINES).0,
        (value, false) => value,
    };
    Image::from_pixels(rows, columns, (0..rows * columns).map(pixel).collect())
}

/// Lines along each side of a pixel at the rim of a disc.
const RIM_LINES: usize = 240;

fn check_image(name: &str, rendering: &Rendering, exact: &Image, tolerance: f64, of_exact: f64) {
    assert!(rendering.converged(), "{name}: {:?}", rendering.stats.ending);
    let largest = exact.min_max().1;
    let errors = rendering.values.pixels().iter().zip(exact.pixels());
    let worst = errors.clone().fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
    let blank = |image: &Image| image.pixels().iter().filter(|p| p.is_nan()).count();
    // A sliver of a disc may fall between the lines of the exact image.
    assert!(blank(&rendering.values) <= blank(exact), "{name}");
    assert!(worst <= (tolerance + of_exact) * largest, "{name}: {:.2e}", worst / largest);
}

#[test]
fn the_cluster_has_its_exact_image_in_every_camera_outside() {
    check_cluster([1.5, 0.6, 0.4], [0.0, INFINITE], 1.3);
}

#[test]
fn the_cluster_has_its_exact_image_in_every_camera_inside() {
    check_cluster([0.2, 0.1, -0.1], [0.0, 4.0], TAU);
}

fn check_cluster(position: [f64; 3], depth: [f64; 2], fov_rad: f64) {
    for (name, camera, shape) in views(position, depth, fov_rad, None) {
        let exact = exact_image(cluster_radiance, &*camera, depth, shape, 16);
        for tolerance in [1e-2, 1e-3] {
            let rendering = image_of(&FromFn(cluster), &*camera, shape, &vol(tolerance));
            check_image(name, &rendering, &exact, tolerance, 3e-4);
        }
    }
}

#[test]
fn the_shell_has_its_exact_image_in_every_camera_outside() {
    check_shell([1.5, 0.6, 0.4], 1.3);
}

#[test]
fn the_shell_has_its_exact_image_in_every_camera_inside() {
    check_shell([0.1, 0.05, -0.1], TAU);
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn check_shell(position: [f64; 3], fov_rad: f64) {
    let bounds = Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], RADII[1]).unwrap());
    let depth = [0.0, 5.0];
    let unbounded = views(position, depth, fov_rad, None);
    let bounded = views(position, depth, fov_rad, Some(bounds));
    for ((name, camera, shape), (_, free, _)) in bounded.into_iter().zip(unbounded) {
        let rendering = image_of(&FromFn(shell), &*camera, shape, &vol(1e-2));
        let exact = exact_image(shell_radiance, &*free, depth, shape, 16);
        check_image(name, &rendering, &exact, 1e-2, 1e-3);
    }
}

/// ∫ of (1 + r²/c²)⁻² along a line at the distance b from the centre, in a sphere of radius R.
fn cluster_column(b: f64, core: f64, radius: f64) -> f64 {
    let [a, half] = [core.hypot(b), (radius * radius - b * b).sqrt()];
    core.powi(4) * (half / (a * a * (a * a + half * half)) + (half / a).atan() / a.powi(3))
}

/// A telescope's field is as good as a wide one, at the same cost: nothing depends on the size of the
/// solid angles.
#[test]
fn narrow_fields_cost_what_wide_ones_do() {
    let (core, radius, width) = (100.0, 2000.0, 872.0);
    let cluster =
        FromFn(|[x, y, z]: [f64; 3], _| (1.0 + (x * x + y * y + z * z) / (core * core)).powi(-2));
    // Means over pixels by 8 x 8 midpoints: right to a few 10⁻⁴ in the core.
    let exact = |distance: f64, at: usize| {
        let offset = |pixel: usize, part: usize| {
            ((pixel as f64 + (part as f64 + 0.5) / 8.0) / 64.0 - 0.5) * width
        };
        let column = |part: usize| {
            let off = offset(at % 64, part % 8).hypot(offset(at / 64, part / 8));
            cluster_column(off / (off / distance).hypot(1.0), core, radius)
        };
        (0..64).map(column).sum::<f64>() / 64.0
    };
    for (distance, evaluations) in [(2e4, 7_202), (1e5, 7_397), (1e6, 7_474)] {
        let viewpoint =
            Viewpoint { position: [0.0, -distance, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
        let fov_rad = 2.0 * (0.5 * width / distance).atan();
        let camera = Perspective::new(viewpoint, [fov_rad; 2], [0.0, INFINITE]).unwrap();
        let sphere = Ellipsoid::sphere([0.0; 3], radius).unwrap();
        let camera = camera.with_bounds(Bounds::Ellipsoid(sphere));
        let rendering = image_of(&cluster, &camera, [64, 64], &vol(0.01));
        let pixels = (0..64 * 64).map(|at| exact(distance, at)).collect();
        let exact = Image::from_pixels(64, 64, pixels);
        let error = rendering.values.max_difference(&exact) / exact.min_max().1;
        assert!(rendering.converged() && error < 0.01, "{distance:e}: {error}");
        assert_eq!(rendering.stats.evaluations, evaluations, "{distance:e}");
    }
}
