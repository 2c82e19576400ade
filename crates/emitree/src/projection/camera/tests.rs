//! Cameras: points are found again, solid angles add up, layers add up to the whole line.

use super::*;
use crate::projection::plane::Sight;
use core::f64::consts::{PI, TAU};

const VIEWPOINT: Viewpoint =
    Viewpoint { position: [10.0, -30.0, 3.0], target: [6.0, 0.0, 0.0], up: [0.0, 0.1, 1.0] };
const DEPTH: [f64; 2] = [1.0, 80.0];

/// Every kind of camera, with narrow and wide fields of view.
fn cameras() -> Vec<Box<dyn Projection>> {
    let disc = |fov: f64, mapping| Fisheye::new(VIEWPOINT, fov, mapping, DEPTH).unwrap();
    vec![
        Box::new(Orthographic::new(VIEWPOINT, [9.0, 4.0], [-5.0, f64::INFINITY]).unwrap()),
        Box::new(Perspective::new(VIEWPOINT, [0.1, 0.2], DEPTH).unwrap()),
        Box::new(Perspective::new(VIEWPOINT, [2.8, 2.0], [0.0, f64::INFINITY]).unwrap()),
        Box::new(Equirectangular::new(VIEWPOINT, [0.2, 0.1], DEPTH).unwrap()),
        Box::new(Equirectangular::new(VIEWPOINT, [TAU, PI], DEPTH).unwrap()),
        Box::new(Polar::new(VIEWPOINT, 0.4, DEPTH).unwrap()),
        Box::new(Polar::new(VIEWPOINT, TAU, DEPTH).unwrap()),
        Box::new(disc(0.4, DiscMapping::Equidistant)),
        Box::new(disc(TAU, DiscMapping::Equidistant)),
        Box::new(disc(0.4, DiscMapping::EqualArea)),
        Box::new(disc(TAU, DiscMapping::EqualArea)),
    ]
}

#[test]
fn each_point_is_found_again() {
    for camera in cameras() {
        for u in [[0.5, 0.6, 0.5], [0.3, 0.2, 0.01], [0.6, 0.7, 0.9], [0.3, 0.68, 0.8]] {
            let position = camera.world_from_canonical(u).position;
            let found = camera.canonical_from_world(position).unwrap();
            for axis in 0..3 {
                assert!((found[axis] - u[axis]).abs() < 1e-10, "{camera:?}: {found:?} for {u:?}");
            }
        }
    }
}

#[test]
fn the_observer_is_on_all_lines_of_sight() {
    for camera in cameras().into_iter().skip(1) {
        assert_eq!(camera.canonical_from_world(VIEWPOINT.position), None, "{camera:?}");
    }
}

#[test]
fn directions_are_unit_vectors_back_along_the_line() {
    for camera in cameras() {
        for xy in [[0.1, 0.5], [0.5, 0.9], [0.7, 0.7]] {
            let [a, b] = [0.3, 0.4].map(|z| camera.world_from_canonical([xy[0], xy[1], z]));
            let step = difference(a.position, b.position);
            assert!((norm(a.direction) - 1.0).abs() < 1e-14, "{camera:?}");
            assert!((dot(step, a.direction) - norm(step)).abs() < 1e-10 * norm(step));
        }
    }
}

#[test]
fn densities_are_the_solid_angle_of_sight_vectors() {
    // |∂d/∂x × ∂d/∂y| of the direction itself, by central differences.
    for camera in cameras().into_iter().skip(1) {
        for [x, y] in [[0.31, 0.62], [0.55, 0.4], [0.62, 0.71]] {
            let step = 1e-5;
            let sight = |x: f64, y: f64| camera.world_from_canonical([x, y, 0.5]).direction;
            let slope = |a: [f64; 3], b: [f64; 3]| difference(a, b).map(|d| d / (2.0 * step));
            let along_x = slope(sight(x + step, y), sight(x - step, y));
            let along_y = slope(sight(x, y + step), sight(x, y - step));
            let numerical = norm(crate::projection::vector::cross(along_x, along_y));
            let density = camera.solid_angle_density([x, y]);
            assert!((numerical / density - 1.0).abs() < 1e-7, "{camera:?}: {numerical} {density}");
        }
    }
}

#[test]
fn solid_angles_of_pixels_are_integrals_and_add_up() {
    let whole = [36.0, 0.0, 0.0, 0.0, 4.0 * PI, 0.0, 4.0 * PI, 0.0, 4.0 * PI, 0.0, 4.0 * PI];
    for (camera, whole) in cameras().into_iter().zip(whole) {
        let (rows, columns) = (7, 9);
        let pixel = |row: usize, column: usize| {
            let at = |k: usize, n: usize| k as f64 / n as f64;
            let (min, max) = (
                [at(column, columns), at(row, rows)],
                [at(column + 1, columns), at(row + 1, rows)],
            );
            (min, max)
        };
        let mut sum = 0.0;
        for row in 0..rows {
            for column in 0..columns {
                let (min, max) = pixel(row, column);
                let solid_angle = camera.solid_angle(min, max);
                sum += solid_angle;
                let corners = [min, max, [min[0], max[1]], [max[0], min[1]]];
                if corners.iter().all(|&xy| camera.region(xy) == Region::Sky) {
                    let n = 40;
                    let mut mean = 0.0;
                    for i in 0..n * n {
                        let t = [(i % n) as f64 + 0.5, (i / n) as f64 + 0.5];
                        let xy =
                            core::array::from_fn(|a| min[a] + (max[a] - min[a]) * t[a] / n as f64);
                        mean += camera.solid_angle_density(xy) / (n * n) as f64;
                    }
                    let area = (max[0] - min[0]) * (max[1] - min[1]);
                    let relative = (mean * area / solid_angle - 1.0).abs();
                    assert!(relative < 1e-4, "{camera:?}: {min:?} {relative}");
                }
            }
        }
        let one = camera.solid_angle([0.0; 2], [1.0; 2]);
        assert!((sum / one - 1.0).abs() < 1e-9, "{camera:?}: {sum} {one}");
        if whole > 0.0 {
            assert!((sum / whole - 1.0).abs() < 1e-9, "{camera:?}: {sum} {whole}");
        }
    }
}

#[test]
fn small_pixels_add_up_to_larger_ones() {
    let camera = Perspective::new(VIEWPOINT, [1.2, 1.2], DEPTH).unwrap();
    // Of the plane's 2 tan 0.6: the whole is above, and its quarters below the size of two nodes.
    let [whole, quarter] = [7e-4, 3.5e-4].map(|side| side / (2.0 * 0.6_f64.tan()));
    for min in [[0.0, 0.0], [0.31, 0.62], [0.9, 0.5]] {
        let of = |min: [f64; 2], side: f64| camera.solid_angle(min, min.map(|low| low + side));
        let corners = [[0.0, 0.0], [quarter, 0.0], [0.0, quarter], [quarter, quarter]];
        let sum: f64 = corners.map(|[x, y]| of([min[0] + x, min[1] + y], quarter)).iter().sum();
        assert!((sum / of(min, whole) - 1.0).abs() < 1e-12, "{min:?}");
    }
}

#[test]
fn small_pixels_keep_their_digits() {
    let camera = Perspective::new(VIEWPOINT, [0.5, 0.5], DEPTH).unwrap();
    let edge = 1.0 / 65_536.0;
    let density = camera.solid_angle_density([0.25 + 0.5 * edge, 0.75 + 0.5 * edge]);
    let solid_angle = camera.solid_angle([0.25, 0.75], [0.25 + edge, 0.75 + edge]);
    assert!((solid_angle / (density * edge * edge) - 1.0).abs() < 1e-9);
}

#[test]
fn lines_that_miss_the_bounds_have_no_path() {
    let bounds = Bounds::Ellipsoid(Ellipsoid::sphere([6.0, 0.0, 0.0], 2.0).unwrap());
    let camera = Perspective::new(VIEWPOINT, [0.4, 0.4], [0.0, f64::INFINITY]).unwrap();
    let camera = camera.with_bounds(bounds);
    assert!(camera.world_from_canonical([0.02, 0.5, 0.5]).path_per_depth.abs() < 1e-300);
    let middle = camera.world_from_canonical([0.5, 0.5, 0.5]);
    assert!((middle.path_per_depth - 4.0).abs() < 1e-8);
    assert!(norm(difference(middle.position, [6.0, 0.0, 0.0])) < 1e-12);
}

fn bodies() -> Vec<Ellipsoid> {
    let moon = Ellipsoid::sphere([7.0, -6.0, 1.0], 1.2).unwrap();
    let planet = Ellipsoid::new([6.0, 0.0, 0.0], [2.0, 3.0, 1.5]).unwrap();
    vec![planet.oriented([0.2, 0.1, 1.0], [1.0, 0.0, 0.3]).unwrap(), moon]
}

/// ∫ g ds along the line at (x, y) of a map, by many midpoints.
fn radiance(map: impl Fn([f64; 3]) -> MappedPoint, [x, y]: [f64; 2]) -> f64 {
    let g = |[a, b, c]: [f64; 3]| 1.0 / (1.0 + (a - 6.0).powi(2) + b * b + c * c) + 0.01 * a;
    let steps = 4000;
    let sum: f64 = (0..steps)
        .map(|k| map([x, y, (f64::from(k) + 0.5) / f64::from(steps)]))
        .map(|point| g(point.position) * point.path_per_depth)
        .sum();
    sum / f64::from(steps)
}

#[test]
fn layers_times_shares_add_up_to_the_line_that_ends_at_a_body() {
    let perspective = Perspective::new(VIEWPOINT, [0.3, 0.3], DEPTH).unwrap();
    let wide = Equirectangular::new(VIEWPOINT, [TAU, PI], DEPTH).unwrap();
    let parallel = Orthographic::new(VIEWPOINT, [8.0, 8.0], DEPTH).unwrap();
    check_layers(&perspective.with_occulters(bodies()).unwrap(), [0.25, 0.75]);
    check_layers(&wide.with_occulters(bodies()).unwrap(), [0.47, 0.53]);
    check_layers(&parallel.with_occulters(bodies()).unwrap(), [0.2, 0.8]);
}

fn check_layers<P: ImagePlane>(camera: &Camera<P>, [low, high]: [f64; 2]) {
    let layers = camera.layers();
    assert_eq!(layers.len(), 5);
    let mut seen = [0; 3];
    for k in 0..144 {
        let at = |i: i32| low + (high - low) * (f64::from(i) + 0.37) / 12.0;
        let xy = [at(k % 12), at(k / 12)];
        let region = camera.region(xy);
        match region {
            Region::Body(body) => seen[body] += 1,
            _ => seen[2] += 1,
        }
        let whole = radiance(|u| camera.world_from_canonical(u), xy);
        let sum: f64 = layers
            .iter()
            .map(|layer| layer.share(xy, region) * radiance(|u| layer.world_from_canonical(u), xy))
            .sum();
        assert!((sum - whole).abs() < 2e-5 * whole.abs(), "{xy:?} {region:?}: {sum} {whole}");
    }
    assert!(seen.iter().all(|&count| count > 3), "{seen:?}");
}

#[test]
fn layers_have_no_edge_at_the_limb() {
    let camera = Perspective::new(VIEWPOINT, [0.3, 0.3], DEPTH).unwrap();
    let camera = camera.with_occulters(bodies()).unwrap();
    // Two lines on both sides of the planet's limb, as close as bisection gets them.
    let (mut inside, mut outside) = ([0.5, 0.5], [0.9, 0.45]);
    for _ in 0..45 {
        let middle = core::array::from_fn(|i| 0.5 * (inside[i] + outside[i]));
        if camera.region(middle) == Region::Sky { outside = middle } else { inside = middle }
    }
    assert_eq!(camera.region(inside), Region::Body(0));
    for layer in camera.layers() {
        let [a, b] = [inside, outside].map(|xy| radiance(|u| layer.world_from_canonical(u), xy));
        assert!((a - b).abs() < 1e-5 * a.abs(), "{layer:?}: {a} {b}");
    }
    let open = |xy| camera.layers().iter().map(|layer| layer.is_open(xy)).collect::<Vec<_>>();
    assert_eq!(open(outside), [true, false, false, false, false]);
    assert_eq!(open(inside), [false, true, true, false, false]);
    // The image itself jumps.
    let [a, b] = [inside, outside].map(|xy| radiance(|u| camera.world_from_canonical(u), xy));
    assert!(b > 1.1 * a, "{a} {b}");
}

#[test]
fn an_observer_inside_a_body_is_refused() {
    let camera = Perspective::new(VIEWPOINT, [0.3, 0.3], DEPTH).unwrap();
    let around = Ellipsoid::sphere(VIEWPOINT.position, 1.0).unwrap();
    let error = camera.with_occulters(vec![bodies()[0], around]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the observer at [10.0, -30.0, 3.0] is inside occulter 2, or on its surface: expected a \
         position outside of all opaque bodies"
    );
}

#[test]
fn the_unit_cube_as_a_camera_is_the_canonical_view() {
    let camera = Orthographic::of_unit_cube();
    for u in [[0.1, 0.2, 0.3], [1.0, 0.0, 1.0], [0.5; 3]] {
        let canonical = crate::Canonical.world_from_canonical(u);
        assert_eq!(camera.world_from_canonical(u), canonical);
    }
}

/// A custom projection: a plane tilted by a smooth map.
#[derive(Debug)]
struct Anamorphic;

impl ImagePlane for Anamorphic {
    fn sight(&self, [x, y]: [f64; 2]) -> Sight {
        let (sin, cos) = (0.2 * (x - 0.5)).sin_cos();
        Sight { origin: [0.0, y, 0.0], direction: [sin, 0.0, cos] }
    }

    fn xy_of(&self, [right, up, forward]: [f64; 3]) -> Option<[f64; 2]> {
        Some([0.5 + 5.0 * right.atan2(forward), up])
    }

    fn solid_angle_density(&self, _xy: [f64; 2]) -> f64 {
        0.2
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        0.2 * (max[0] - min[0]) * (max[1] - min[1])
    }
}

#[test]
fn an_image_plane_of_ones_own_makes_a_camera() {
    let camera = Camera::at(&VIEWPOINT, Anamorphic, DEPTH).unwrap();
    let position = camera.world_from_canonical([0.3, 0.8, 0.5]).position;
    let found = camera.canonical_from_world(position).unwrap();
    assert!((found[0] - 0.3).abs() + (found[1] - 0.8).abs() + (found[2] - 0.5).abs() < 1e-12);
}

#[test]
fn fields_of_view_that_no_camera_has_are_refused() {
    let message = |error: GeometryError| error.to_string();
    let error = Perspective::new(VIEWPOINT, [1.0, PI], DEPTH).unwrap_err();
    let expected = "a width and a height above 0 and at most 178 degrees, since a flat screen is too \
                    wide beyond (for more of the sky: `fisheye` or `equirectangular`)";
    assert_eq!(message(error), format!("`field_of_view` is 180: expected {expected}"));
    assert!(Perspective::new(VIEWPOINT, [178.0_f64, 1.0].map(f64::to_radians), DEPTH).is_ok());
    let error = Polar::new(VIEWPOINT, 7.0, DEPTH).unwrap_err();
    assert!(message(error).ends_with("a full angle of the cone in (0, 360] degrees"));
    let error = Fisheye::new(VIEWPOINT, 0.0, DiscMapping::EqualArea, DEPTH).unwrap_err();
    assert!(message(error).starts_with("`field_of_view` is 0"));
    let error = Orthographic::new(VIEWPOINT, [1.0, -2.0], DEPTH).unwrap_err();
    assert_eq!(message(error), "`extent` is -2: expected a finite width and height above 0");
}
