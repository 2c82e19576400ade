//! Opaque bodies: limbs are located analytically, and images cost as much as smooth ones.

use emitree::los::{LosOptions, Steps};
use emitree::projection::{Bounds, DiscMapping, Ellipsoid};
use emitree::{
    Emission, Equirectangular, Fisheye, FromFn, Healpix, Image, Method, Orthographic, Perspective,
    Polar, Projection, RenderOptions, Rendering, Viewpoint, VolOptions, render,
};
use std::f64::consts::PI;

const VIEWPOINT: Viewpoint =
    Viewpoint { position: [6.0, 2.0, 1.0], target: [0.0; 3], up: [0.0, 0.2, 1.0] };
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

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn planet() -> Vec<Ellipsoid> {
    vec![Ellipsoid::sphere([0.0; 3], 1.0).unwrap()]
}

/// An exosphere, r⁻⁴, that must not be evaluated inside of the planet.
fn exosphere([x, y, z]: [f64; 3], _: [f64; 3]) -> f64 {
    let squared = x * x + y * y + z * z;
    assert!(squared >= 1.0, "asked at {x}, {y}, {z}");
    squared.powi(-2)
}

/// ∫ of r⁻⁴ along a line from `from` to `to`, at the distance b from the centre.
fn exosphere_radiance(origin: [f64; 3], direction: [f64; 3], [from, to]: [f64; 2]) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let closest = -dot(origin, direction);
    let b = (dot(origin, origin) - closest * closest).max(0.0).sqrt();
    // ∫ dt / (b² + t²)²; its expansion for small b has no cancelling terms.
    let primitive = |t: f64| {
        if t.is_infinite() {
            return t.signum() * PI / 4.0 / b.powi(3);
        }
        0.5 * t / (b * b * (b * b + t * t)) + 0.5 * (t / b).atan() / b.powi(3)
    };
    primitive(to - closest) - primitive(from - closest)
}

/// Where a line from outside enters the unit sphere.
fn entry(origin: [f64; 3], direction: [f64; 3]) -> Option<f64> {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let closest = -dot(origin, direction);
    let within = 1.0 - (dot(origin, origin) - closest * closest);
    (within > 0.0 && closest > 0.0).then(|| closest - within.sqrt())
}

/// The radiance and the solid angle density of a line, and whether it ends at the planet.
fn line(camera: &dyn Projection, depth: [f64; 2], xy: [f64; 2]) -> (f64, f64, bool) {
    let begin = camera.world_from_canonical([xy[0], xy[1], 0.0]);
    let direction = begin.direction.map(|d| -d);
    let hit = entry(begin.position, direction);
    let ends = [depth[0], hit.unwrap_or(depth[1])];
    let density = camera.solid_angle_density(xy);
    (exosphere_radiance(begin.position, direction, ends), density, hit.is_some())
}

/// Rows of lines in a pixel that the limb crosses, before and behind it.
const ROWS: usize = 300;
/// Places along a row at which the limb is searched for, and lines between two crossings of it.
const COLUMNS: usize = 8;
const PARTS: usize = 24;

/// The places from 0 to 1 between which `hits` does not change.
fn pieces(hits: impl Fn(f64) -> bool) -> Vec<f64> {
    let place = |k: usize| k as f64 / COLUMNS as f64;
    let mut breaks = vec![0.0];
    for probe in 0..COLUMNS {
        let (mut low, mut high) = (place(probe), place(probe + 1));
        let hit = hits(low);
        if hits(high) != hit {
            for _ in 0..30 {
                let middle = 0.5 * (low + high);
                if hits(middle) == hit { low = middle } else { high = middle }
            }
            breaks.push(high);
        }
    }
    breaks.push(1.0);
    breaks
}

/// Means over lines, weighted with solid angles; where the limb crosses a pixel, over many rows of
/// them, each divided where it crosses.
fn exact_image(camera: &dyn Projection, depth: [f64; 2], [rows, columns]: [usize; 2]) -> Image {
    let at = |k: usize, place: f64, pixels: usize| (k as f64 + place) / pixels as f64;
    let coarse = |row: usize, column: usize| {
        let (mut sum, mut weights, mut hits, n) = (0.0, 0.0, 0, 32);
        for part in 0..n * n {
            let place = |k: usize| (k as f64 + 0.5) / n as f64;
            let xy = [at(column, place(part % n), columns), at(row, place(part / n), rows)];
            let (radiance, density, hit) = line(camera, depth, xy);
            (sum, weights) = (sum + density * radiance, weights + density);
            hits += usize::from(hit);
        }
        (sum / weights, hits > 0 && hits < n * n)
    };
    let fine = |row: usize, column: usize| {
        let of = |x: f64, y: f64| line(camera, depth, [at(column, x, columns), at(row, y, rows)]);
        let (mut sum, mut weights) = (0.0, 0.0);
        for of_rows in pieces(|y| of(0.5, y).2).windows(2) {
            for k in 0..ROWS {
                let height = (of_rows[1] - of_rows[0]) / ROWS as f64;
                let y = of_rows[0] + (k as f64 + 0.5) * height;
                for ends in pieces(|x| of(x, y).2).windows(2) {
                    for part in 0..PARTS {
                        let width = (ends[1] - ends[0]) / PARTS as f64;
                        let x = ends[0] + (part as f64 + 0.5) * width;
                        let (radiance, density, _) = of(x, y);
                        let weight = density * width * height;
                        (sum, weights) = (sum + weight * radiance, weights + weight);
                    }
                }
            }
        }
        sum / weights
    };
    let pixel = |pixel: usize| {
        let (row, column) = (pixel / columns, pixel % columns);
        match coarse(row, column) {
            (_, true) => fine(row, column),
            (value, false) => value,
        }
    };
    Image::from_pixels(rows, columns, (0..rows * columns).map(pixel).collect())
}

type View = (&'static str, Box<dyn Projection>, [f64; 2], [usize; 2]);

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn views() -> Vec<View> {
    let depth = [0.0, INFINITE];
    let disc = Fisheye::new(VIEWPOINT, 0.9, DiscMapping::Equidistant, depth).unwrap();
    let pinhole = Perspective::new(VIEWPOINT, [0.7, 0.6], depth).unwrap();
    let equal_angles = Equirectangular::new(VIEWPOINT, [0.7, 0.6], depth).unwrap();
    let parallel = Orthographic::new(VIEWPOINT, [4.0, 4.0], depth).unwrap();
    let polar = Polar::new(VIEWPOINT, 1.0, depth).unwrap();
    let sky = Healpix::new(VIEWPOINT.position, depth).unwrap();
    vec![
        ("perspective", Box::new(pinhole.with_occulters(planet()).unwrap()), depth, [30, 35]),
        (
            "equirectangular",
            Box::new(equal_angles.with_occulters(planet()).unwrap()),
            depth,
            [20, 24],
        ),
        ("orthographic", Box::new(parallel.with_occulters(planet()).unwrap()), depth, [32, 32]),
        ("polar", Box::new(polar.with_occulters(planet()).unwrap()), depth, [24, 30]),
        ("fisheye", Box::new(disc.with_occulters(planet()).unwrap()), depth, [30, 30]),
        ("healpix", Box::new(sky.with_occulters(planet()).unwrap()), depth, Healpix::shape(8)),
    ]
}

/// Evaluations at 1 % and at 0.1 %, pinned.
const COSTS: [(&str, [u64; 2]); 6] = [
    ("perspective", [1_729, 1_914]),
    ("equirectangular", [1_732, 1_916]),
    ("orthographic", [1_581, 1_740]),
    ("polar", [1_714, 1_905]),
    ("fisheye", [1_685, 1_869]),
    ("healpix", [2_064, 2_523]),
];

fn check_limb(name: &str) {
    let (_, costs) = COSTS.into_iter().find(|(other, _)| *other == name).unwrap_or_default();
    for (_, camera, depth, shape) in views().into_iter().filter(|view| view.0 == name) {
        let exact = exact_image(&*camera, depth, shape);
        let largest = exact.min_max().1;
        for (tolerance, cost) in [1e-2, 1e-3].into_iter().zip(costs) {
            let rendering = image_of(&FromFn(exosphere), &*camera, shape, &vol(tolerance));
            assert!(rendering.converged(), "{name} {tolerance}: {:?}", rendering.stats.ending);
            let worst = rendering.values.max_difference(&exact) / largest;
            assert!(worst <= tolerance, "{name} {tolerance}: {worst:.2e}");
            assert_eq!(rendering.stats.evaluations, cost, "{name} {tolerance}");
        }
    }
}

#[test]
fn the_limb_of_a_planet_is_resolved_in_perspective() {
    check_limb("perspective");
}

#[test]
fn the_limb_of_a_planet_is_resolved_in_equal_angles() {
    check_limb("equirectangular");
}

#[test]
fn the_limb_of_a_planet_is_resolved_by_parallel_lines() {
    check_limb("orthographic");
}

#[test]
fn the_limb_of_a_planet_is_resolved_along_rows() {
    check_limb("polar");
}

#[test]
fn the_limb_of_a_planet_is_resolved_on_a_disc() {
    check_limb("fisheye");
}

#[test]
fn the_limb_of_a_planet_is_resolved_on_the_whole_sky() {
    check_limb("healpix");
}

/// Two bodies one before the other, an ellipsoid among them, and a glow that depends on direction:
/// against many lines of sight, each of which ends where it should.
#[test]
fn several_bodies_agree_with_lines_of_sight() {
    let glow = FromFn(|[x, y, z]: [f64; 3], [dx, dy, dz]: [f64; 3]| {
        let r = (x * x + y * y + z * z).sqrt();
        // Forward scattering.
        let along = (x * dx + y * dy + z * dz) / r;
        (2.0 + along) * r.powi(-3)
    });
    let planet = Ellipsoid::new([0.0; 3], [1.0, 0.8, 0.9]).unwrap();
    let planet = planet.oriented([0.3, 0.2, 1.0], [1.0, 0.0, 0.2]).unwrap();
    let moon = Ellipsoid::sphere([2.5, 1.2, 0.2], 0.3).unwrap();
    let camera = Perspective::new(VIEWPOINT, [0.6, 0.6], [0.0, 20.0]).unwrap();
    let camera = camera.with_occulters(vec![planet, moon]).unwrap();
    let shape = [16, 16];
    let rendering = image_of(&glow, &camera, shape, &vol(1e-2));
    assert!(rendering.converged());
    let los = Method::Los(LosOptions::new(16, Steps::Fixed(300)));
    let reference = image_of(&glow, &camera, shape, &RenderOptions::new(los));
    let largest = reference.values.min_max().1;
    let worst = rendering.values.max_difference(&reference.values) / largest;
    // Lines of sight count the limb in 256 parts of a pixel, and are off by half a step at the end.
    assert!(worst < 1e-2 + 6e-3, "{worst:.2e}");
    assert!(
        rendering.stats.evaluations < 16 * 16 * 256 * 300 / 100,
        "{}",
        rendering.stats.evaluations
    );
}

/// A body that is smaller than a pixel occults its part of it.
#[test]
fn a_body_smaller_than_a_pixel_is_not_overlooked() {
    let uniform = FromFn(|_: [f64; 3], _: [f64; 3]| 1.0);
    let viewpoint = Viewpoint { position: [5.0, 0.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let speck = Ellipsoid::sphere([0.0, 0.05, 0.03], 0.01).unwrap();
    let camera = Orthographic::new(viewpoint, [4.0, 4.0], [0.0, 10.0]).unwrap();
    let camera = camera.with_occulters(vec![speck]).unwrap();
    let rendering = image_of(&uniform, &camera, [20, 20], &vol(1e-4));
    // Half of the depth is hidden on the area of the speck, and what is before its front half too.
    let hidden = PI * 0.01_f64.powi(2) * 5.0 + 2.0 / 3.0 * PI * 0.01_f64.powi(3);
    let missing = 10.0 - rendering.values[(10, 10)];
    assert!((missing * 0.04 / hidden - 1.0).abs() < 0.02, "{missing} {}", hidden / 0.04);
    assert!((rendering.values[(10, 12)] - 10.0).abs() < 1e-3);
}

/// The irradiance of a whole sky is the same in every projection of it, behind an opaque body or not.
#[test]
fn the_total_irradiance_is_the_same_in_every_projection_of_the_whole_sky() {
    use std::f64::consts::TAU;
    let depth = [0.0, INFINITE];
    let viewpoint =
        Viewpoint { position: [2.0, 0.5, 0.3], target: [0.0, 0.1, 0.0], up: [0.2, 0.1, 1.0] };
    let all = Equirectangular::new(viewpoint, [TAU, PI], depth).unwrap();
    let polar = Polar::new(viewpoint, TAU, depth).unwrap();
    let disc = |mapping| Fisheye::new(viewpoint, TAU, mapping, depth).unwrap();
    let sky = Healpix::new(viewpoint.position, depth).unwrap();
    let views: Vec<(Box<dyn Projection>, [usize; 2])> = vec![
        (Box::new(all.with_occulters(planet()).unwrap()), [20, 40]),
        (Box::new(polar.with_occulters(planet()).unwrap()), [24, 24]),
        (Box::new(disc(DiscMapping::Equidistant).with_occulters(planet()).unwrap()), [40, 40]),
        (Box::new(disc(DiscMapping::EqualArea).with_occulters(planet()).unwrap()), [40, 40]),
        (Box::new(sky.with_occulters(planet()).unwrap()), Healpix::shape(8)),
    ];
    let totals: Vec<f64> = views
        .into_iter()
        .map(|(camera, shape)| {
            let rendering = image_of(&FromFn(exosphere), &*camera, shape, &vol(1e-2));
            assert!(rendering.converged(), "{camera:?}: {:?}", rendering.stats.ending);
            let irradiance = emitree::radiance::irradiance_of(&rendering.values, &*camera);
            irradiance.pixels().iter().filter(|pixel| !pixel.is_nan()).sum()
        })
        .collect();
    let (low, high) = totals
        .iter()
        .fold((INFINITE, 0.0_f64), |(low, high), &total| (low.min(total), high.max(total)));
    assert!(high / low - 1.0 < 5e-3, "{totals:?}");
}

/// A corner of a box before a large sphere: a few open nodes of the sky are all zero there. Polynomials
/// of degree 4 continued from them were wrong without limit: a pixel of −146 where there is nothing.
#[test]
fn pixels_beside_bounds_before_a_large_body_are_0() {
    let viewpoint =
        Viewpoint { position: [60.0, -120.0, 70.0], target: [0.0, 0.0, 12.0], up: [0.0, 0.0, 1.0] };
    let camera = Orthographic::new(viewpoint, [92.0, 72.0], [-INFINITE, INFINITE]).unwrap();
    let bounds = Bounds::cuboid([-60.0, -60.0, -5.0], [60.0, 60.0, 45.0]).unwrap();
    let sun = Ellipsoid::sphere([0.0, 0.0, -695.7], 695.7).unwrap();
    let camera = camera.with_bounds(bounds).with_occulters(vec![sun]).unwrap();
    let uniform = FromFn(|_: [f64; 3], _: [f64; 3]| 1.0);
    for (tolerance, evaluations) in [(1e-2, 7_127), (1e-3, 29_582)] {
        let rendering = image_of(&uniform, &camera, [64, 64], &vol(tolerance));
        let (low, high) = rendering.values.min_max();
        assert!(rendering.converged(), "{tolerance}: {:?}", rendering.stats.ending);
        assert!((high - 125.504).abs() < 125.504 * tolerance, "{tolerance}: {high}");
        assert!(low >= -tolerance * high, "{tolerance}: {low}");
        assert_eq!(rendering.stats.evaluations, evaluations, "{tolerance}");
    }
}

/// A body that fills the view but for a corner: a pixel was 68.4 where the maximum is 0.5226.
#[test]
fn a_corner_of_the_sky_is_as_bright_as_it_is() {
    let viewpoint = Viewpoint {
        position: [2.79075342, -1.34252922, 6.15563999],
        target: [-0.6215713, -0.12258444, 0.25506349],
        up: [0.0, 0.0, 1.0],
    };
    let fov_rad = 20.52403711283803_f64.to_radians();
    let camera = Perspective::new(viewpoint, [fov_rad; 2], [0.0, INFINITE]).unwrap();
    let bounds = Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], 8.0).unwrap());
    let camera = camera.with_bounds(bounds).with_occulters(planet()).unwrap();
    let atmosphere = FromFn(|[x, y, z]: [f64; 3], _: [f64; 3]| {
        let r = (x * x + y * y + z * z).sqrt();
        (-(r.max(1.0) - 1.0) / 0.07).exp()
    });
    let rendering = image_of(&atmosphere, &camera, [64, 64], &vol(1e-2));
    let (low, high) = rendering.values.min_max();
    assert!(rendering.converged(), "{:?}", rendering.stats.ending);
    assert!((high - 0.5226).abs() < 0.5226 * 1e-2 && low > -0.5226 * 1e-2, "{low} {high}");
    assert_eq!(rendering.stats.evaluations, 1_729);
}

/// A cloud between the observer and a body that is small beside the distance of the cloud from it:
/// in a depth that resolves only what is close to the body, no sample met the cloud, and the disc
/// was dark.
#[test]
fn a_cloud_far_in_front_of_a_small_body_is_not_overlooked() {
    const WIDTH: f64 = 2.0;
    let cloud = FromFn(|[x, y, z]: [f64; 3], _: [f64; 3]| {
        (-0.5 * (x * x + (y - 20.0).powi(2) + z * z) / (WIDTH * WIDTH)).exp()
    });
    let viewpoint = Viewpoint { position: [0.0; 3], target: [0.0, 60.0, 0.0], up: [0.0, 0.0, 1.0] };
    let camera = Perspective::new(viewpoint, [1.0_f64.to_radians(); 2], [0.0, INFINITE]).unwrap();
    let body = Ellipsoid::sphere([0.0, 60.0, 0.0], 0.27).unwrap();
    let camera = camera.with_occulters(vec![body]).unwrap();
    let (shape, tolerance) = ([32, 32], 1e-2);
    let rendering = image_of(&cloud, &camera, shape, &vol(tolerance));
    assert!(rendering.converged(), "{:?}", rendering.stats.ending);
    let largest = (2.0 * PI).sqrt() * WIDTH;
    let mut on_disc = 0;
    for row in 0..shape[0] {
        for column in 0..shape[1] {
            let middle = |k: usize| (k as f64 + 0.5) / 32.0;
            let point = camera.world_from_canonical([middle(column), middle(row), 0.0]);
            let [x, _, z] = point.direction;
            // All of the cloud is in front of the body.
            let away = 20.0 * x.hypot(z);
            let expected = largest * (-0.5 * (away / WIDTH).powi(2)).exp();
            let wrong = (rendering.values[(row, column)] - expected).abs();
            assert!(wrong <= tolerance * largest, "{row} {column}: {wrong} of {expected}");
            on_disc += usize::from(60.0 * x.hypot(z) < 0.27);
        }
    }
    assert!(on_disc > 100, "{on_disc}");
    assert_eq!(rendering.stats.evaluations, 8_458);
}

/// ∫ dt/(b² + t²)³ from `from` to `to`, both below 0, by Simpson's rule in 1/t.
fn before_closest(b: f64, [from, to]: [f64; 2]) -> f64 {
    const PARTS: usize = 200;
    let [begin, end] = [-1.0 / from, -1.0 / to];
    let step = (end - begin) / PARTS as f64;
    let value = |k: usize| {
        let u = begin + k as f64 * step;
        let weight = if k == 0 || k == PARTS { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
        weight * u.powi(4) / (1.0 + b * b * u * u).powi(3)
    };
    (0..=PARTS).map(value).sum::<f64>() * step / 3.0
}

/// A moon before the limb of a planet: on the chart of the planet the moon is a gap.
#[test]
fn a_moon_before_the_limb_of_a_planet_costs_little() {
    const MOON: [f64; 3] = [0.0, -1.6, 0.75];
    const MOON_RADIUS: f64 = 0.4;
    let corona = FromFn(|[x, y, z]: [f64; 3], _: [f64; 3]| {
        let squared = x * x + y * y + z * z;
        let of_moon = (x - MOON[0]).hypot(y - MOON[1]).hypot(z - MOON[2]);
        assert!(squared >= 1.0 && of_moon >= MOON_RADIUS, "asked at {x}, {y}, {z}");
        squared.powi(-3)
    });
    let viewpoint =
        Viewpoint { position: [0.0, -10.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let camera = Orthographic::new(viewpoint, [4.0; 2], [0.0, INFINITE]).unwrap();
    let mut bodies = planet();
    bodies.push(Ellipsoid::sphere(MOON, MOON_RADIUS).unwrap());
    let camera = camera.with_occulters(bodies).unwrap();
    let (shape, tolerance) = ([32, 32], 1e-3);
    let rendering = image_of(&corona, &camera, shape, &vol(tolerance));
    assert!(rendering.converged(), "{:?}", rendering.stats.ending);
    let largest = rendering.values.min_max().1;
    // The radiance of a line, and its distance from the nearest limb.
    let line = |xy: [f64; 2]| {
        let [x, _, z] = camera.world_from_canonical([xy[0], xy[1], 0.0]).position;
        let (b, of_moon) = (x.hypot(z), (x - MOON[0]).hypot(z - MOON[2]));
        let radiance = if of_moon < MOON_RADIUS {
            let front = MOON[1] - (MOON_RADIUS.powi(2) - of_moon.powi(2)).sqrt();
            before_closest(b, [-10.0, front])
        } else if b < 1.0 {
            before_closest(b, [-10.0, -(1.0 - b * b).sqrt()])
        } else {
            0.375 * PI * b.powi(-5) - before_closest(b, [-INFINITE, -10.0])
        };
        (radiance, (b - 1.0).abs().min((of_moon - MOON_RADIUS).abs()))
    };
    let mut regions = [0; 2];
    for row in 0..shape[0] {
        for column in 0..shape[1] {
            let at = |k: usize, place: f64| (k as f64 + place) / 32.0;
            if line([at(column, 0.5), at(row, 0.5)]).1 < 0.1 {
                continue;
            }
            let place = |k: usize| (k as f64 + 0.5) / 16.0;
            let lines = (0..256).map(|k| line([at(column, place(k % 16)), at(row, place(k / 16))]));
            let expected = lines.map(|line| line.0).sum::<f64>() / 256.0;
            let wrong = (rendering.values[(row, column)] - expected).abs();
            assert!(wrong <= tolerance * largest, "{row} {column}: {wrong:e} of {expected}");
            regions[usize::from(expected > 0.1 * largest)] += 1;
        }
    }
    assert!(regions.iter().all(|count| *count > 100), "{regions:?}");
    assert_eq!(rendering.stats.evaluations, 3_603);
}

/// Parallel lines that begin at infinity pass a planet at the distance b: ∫ dt/(b² + t²)² = π/(2 b³).
#[test]
fn lines_without_a_beginning_pass_a_planet() {
    let camera = Orthographic::new(VIEWPOINT, [4.0; 2], [-INFINITE, INFINITE]).unwrap();
    let camera = camera.with_occulters(planet()).unwrap();
    let rendering = image_of(&FromFn(exosphere), &camera, [32, 32], &vol(1e-3));
    assert!(rendering.converged(), "{:?}", rendering.stats.ending);
    let largest = rendering.values.min_max().1;
    for pixel in 0..1024 {
        let (row, column) = (pixel / 32, pixel % 32);
        let at = |k: usize, place: usize| (k as f64 + (place as f64 + 0.5) / 16.0) / 8.0 - 2.0;
        let distances = (0..256).map(|k| at(column, k % 16).hypot(at(row, k / 16)));
        let distances: Vec<f64> = distances.collect();
        if distances.iter().all(|b| *b > 1.0) {
            let radiances = distances.iter().map(|b| 0.5 * PI * b.powi(-3));
            let expected = radiances.sum::<f64>() / 256.0;
            let wrong = (rendering.values[(row, column)] - expected).abs();
            assert!(wrong < 1e-3 * largest, "{row} {column}: {wrong:e} of {expected}");
        }
    }
}
