//! Cameras: points are found again, solid angles add up, lines end at bodies.

use super::*;
use crate::projection::plane::Sight;
use core::f64::consts::{PI, TAU};

const VIEWPOINT: Viewpoint =
    Viewpoint { position: [10.0, -30.0, 3.0], target: [6.0, 0.0, 0.0], up: [0.0, 0.1, 1.0] };
const DEPTH: [f64; 2] = [1.0, 80.0];

fn off_centre(fov_rad: [f64; 2], principal_point: [f64; 2]) -> Perspective {
    let camera = Perspective::new(VIEWPOINT, fov_rad, DEPTH).unwrap();
    camera.with_principal_point(principal_point).unwrap()
}

#[test]
fn a_part_of_a_screen_has_its_lines_of_sight() {
    let whole = Perspective::new(VIEWPOINT, [0.5, 0.5], DEPTH).unwrap();
    // The upper left quarter.
    let fov_rad = 2.0 * f64::atan(0.5 * f64::tan(0.25));
    let part = off_centre([fov_rad; 2], [1.0, 0.0]);
    for [x, y] in [[0.1, 0.5], [0.5, 0.9], [0.7, 0.7]] {
        let [a, b] = [whole.line([0.5 * x, 0.5 + 0.5 * y]), part.line([x, y])];
        assert!(norm(difference(a.direction, b.direction)) < 1e-15);
    }
    let quarter = whole.solid_angle([0.0, 0.5], [0.5, 1.0]);
    assert!((part.solid_angle([0.0; 2], [1.0; 2]) / quarter - 1.0).abs() < 1e-12);
}

#[test]
fn a_pointing_far_beside_the_image_is_refused() {
    let camera = || Perspective::new(VIEWPOINT, [1.0, 1.0], DEPTH).unwrap();
    for (point, value) in [([60.0, 0.5], 60.0), ([0.5, f64::NAN], f64::NAN), ([0.5, -60.0], -60.0)]
    {
        let error = camera().with_principal_point(point).unwrap_err().to_string();
        let expected = format!(
            "`principal_point` is {value}: expected the place of the pointing as fractions"
        );
        assert!(error.starts_with(&expected), "{error}");
    }
}

/// Every kind of camera, with narrow and wide fields of view.
fn cameras() -> Vec<Box<dyn Projection>> {
    let disc = |fov: f64, mapping| Fisheye::new(VIEWPOINT, fov, mapping, DEPTH).unwrap();
    vec![
        Box::new(Orthographic::new(VIEWPOINT, [9.0, 4.0], [-5.0, f64::INFINITY]).unwrap()),
        Box::new(Perspective::new(VIEWPOINT, [0.1, 0.2], DEPTH).unwrap()),
        Box::new(Perspective::new(VIEWPOINT, [2.8, 2.0], [0.0, f64::INFINITY]).unwrap()),
        Box::new(off_centre([0.4, 0.3], [0.2, 0.9])),
        Box::new(off_centre([0.02, 0.03], [-7.0, 1.5])),
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
    // 0 where it is not known in closed form.
    let whole =
        [36.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0 * PI, 0.0, 4.0 * PI, 0.0, 4.0 * PI, 0.0, 4.0 * PI];
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

/// The region of a line and where it ends, from the crossings of all bodies.
fn seen_on(camera: &Perspective, xy: [f64; 2]) -> (Region, f64) {
    let forward = camera.world_from_canonical([xy[0], xy[1], 0.5]).direction.map(|along| -along);
    let crossing = |body: &Ellipsoid| body.crossing(VIEWPOINT.position, forward);
    let hits = bodies().into_iter().enumerate().filter_map(|(number, body)| {
        crossing(&body).map(|[enter, _]| (Region::Body(number), enter))
    });
    hits.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((Region::Sky, DEPTH[1]))
}

#[test]
fn lines_end_at_the_first_body() {
    let camera = Perspective::new(VIEWPOINT, [0.3, 0.3], DEPTH).unwrap();
    let camera = camera.with_occulters(bodies()).unwrap();
    let mut seen = [0; 3];
    for k in 0..400 {
        let xy = [k % 20, k / 20].map(|i| 0.25 + 0.5 * (f64::from(i) + 0.37) / 20.0);
        let (region, end) = seen_on(&camera, xy);
        assert_eq!(camera.region(xy), region);
        seen[if let Region::Body(body) = region { body } else { 2 }] += 1;
        for z in [0.0, 0.3, 1.0] {
            let point = camera.world_from_canonical([xy[0], xy[1], z]);
            let distance = norm(difference(point.position, VIEWPOINT.position));
            assert!((distance - (DEPTH[0] + z * (end - DEPTH[0]))).abs() < 1e-8 * end);
            assert!((point.path_per_depth - (end - DEPTH[0])).abs() < 1e-8 * end);
            assert!(bodies().iter().all(|body| !body.contains(point.position)));
        }
    }
    assert!(seen.iter().all(|&count| count > 10), "{seen:?}");
}

#[test]
fn the_chart_of_the_image_plane_goes_on_where_there_is_no_image() {
    let camera = Fisheye::new(VIEWPOINT, 0.5, DiscMapping::EqualArea, DEPTH).unwrap();
    let chart = ViewGeometry::chart(&camera, 3);
    let corner = [0.02, 0.97];
    assert_eq!(camera.region(corner), Region::Outside);
    assert!(camera.world_from_canonical([corner[0], corner[1], 0.4]).path_per_depth.abs() < 1e-300);
    assert!(camera.solid_angle_density(corner).abs() < 1e-300);
    let point = chart.world_from_chart([corner[0], corner[1], 0.4]);
    assert!((point.path_per_depth - (DEPTH[1] - DEPTH[0])).abs() < 1e-12);
    // The density of equal areas is the same everywhere.
    assert!((chart.density(corner) / camera.solid_angle_density([0.5; 2]) - 1.0).abs() < 1e-12);
    let back = chart.chart_from_world(point.position).unwrap();
    for (found, expected) in back.into_iter().zip([corner[0], corner[1], 0.4]) {
        assert!((found - expected).abs() < 1e-10, "{back:?}");
    }
    assert_eq!(chart.image_place(corner), (3, corner));
    // A line that is seen at a place is the line of that place.
    let line = ViewGeometry::line(&camera, corner).unwrap();
    let place = camera.place_of_line(&line).unwrap();
    assert!((0..2).all(|i| (place[i] - corner[i]).abs() < 1e-12), "{place:?}");
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

#[test]
fn edges_are_kept_and_change_no_line_of_sight() {
    let camera = Perspective::new(VIEWPOINT, [0.5, 0.4], DEPTH).unwrap();
    // One of them around the observer, which no opaque body may be.
    let around = Edge::Ellipsoid(Ellipsoid::sphere(VIEWPOINT.position, 20.0).unwrap());
    let edges = vec![around, Edge::plane(VIEWPOINT.target, [1.0, 0.0, 2.0]).unwrap()];
    let edged = camera.clone().with_edges(edges.clone());
    assert_eq!((&camera.surroundings.edges[..], &edged.surroundings.edges), (&[][..], &edges));
    for u in [[0.5, 0.5, 0.5], [0.1, 0.9, 0.3]] {
        assert_eq!(edged.world_from_canonical(u), camera.world_from_canonical(u));
    }
    assert!(!edged.has_regions());
    let body = Ellipsoid::sphere([6.0, 0.0, 0.0], 1.0).unwrap();
    let bodied = edged.with_occulters(vec![body]).unwrap();
    assert_eq!(bodied.surroundings.edges, edges);
    assert_eq!(bodied.surroundings.bodies, [body]);
}
