use super::*;
use crate::projection::{Bounds, Canonical, Ellipsoid};
use crate::{Orthographic, Perspective, Viewpoint};

fn viewpoint() -> Viewpoint {
    Viewpoint { position: [1.0, 2.0, 9.0], target: [0.1, 0.2, 0.0], up: [0.0, 1.0, 0.0] }
}

fn cameras() -> [Box<dyn Projection>; 3] {
    let depth = [0.5, f64::INFINITY];
    [
        Box::new(Perspective::new(viewpoint(), [0.4, 0.3], depth).unwrap()),
        Box::new(Orthographic::new(viewpoint(), [3.0, 2.0], [-4.0, 20.0]).unwrap()),
        Box::new(Canonical),
    ]
}

#[test]
fn points_of_a_line_have_its_key_and_lines_have_keys_of_their_own() {
    for camera in cameras() {
        let paths = Paths::of(&*camera);
        let key = |u: [f64; 3]| {
            let point = camera.world_from_canonical(u);
            paths.locate(point.position, point.direction).unwrap().0
        };
        // Rounding may make another line of a point near the border of a key: few are.
        let depths = (1..100).map(|k| key([0.3, 0.7, f64::from(k) / 100.0]));
        let first = key([0.3, 0.7, 0.005]);
        let same = depths.filter(|key| *key == first).count();
        assert!(same > 90, "{same} {camera:?}");
        assert_ne!(key([0.3, 0.7 + 1e-10, 0.5]), first);
    }
}

#[test]
fn a_path_leads_to_the_point_that_it_was_made_of() {
    for camera in cameras() {
        let paths = Paths::of(&*camera);
        for u in [[0.2, 0.8, 0.1], [0.5, 0.5, 0.6], [0.99, 0.01, 0.95]] {
            let point = camera.world_from_canonical(u);
            let (key, at) = paths.locate(point.position, point.direction).unwrap();
            let path = paths.path(key);
            let (part, z) = path.place(at).unwrap();
            let found = paths.point(&path, part, z);
            assert!((z - u[2]).abs() < 1e-11 && part == 0, "{z} {u:?}");
            let apart = difference(found.position, point.position);
            assert!(dot(apart, apart).sqrt() < 1e-11 * point.path_per_depth, "{apart:?}");
            assert!((found.path_per_depth / point.path_per_depth - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn lines_are_parted_by_bodies_and_edges_within_bounds() {
    let sphere = |radius| Ellipsoid::sphere([0.0; 3], radius).unwrap();
    let along_z = Viewpoint { position: [0.0, 0.0, 9.0], target: [0.0; 3], up: [0.0, 1.0, 0.0] };
    let camera = Perspective::new(along_z, [0.4, 0.4], [0.0, 30.0]).unwrap();
    let camera = camera
        .with_edges(vec![
            Edge::Ellipsoid(sphere(3.0)),
            Edge::plane([0.0, 0.0, -4.0], [0.0, 0.0, 1.0]).unwrap(),
        ])
        .with_bounds(Bounds::cuboid([-5.0; 3], [5.0; 3]).unwrap())
        .with_occulters(vec![sphere(1.0)])
        .unwrap();
    let paths = Paths::of(&camera);
    let (key, at) = paths.locate([0.0, 0.0, 3.5], [0.0, 0.0, 1.0]).unwrap();
    let path = paths.path(key);
    let ends: Vec<[f64; 2]> = path.parts.iter().map(|part| part.span.ends()).collect();
    let expected = [[4.0, 6.0], [6.0, 8.0], [8.0, 10.0], [10.0, 12.0], [12.0, 13.0], [13.0, 14.0]];
    for (found, expected) in ends.iter().zip(expected) {
        assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-7), "{ends:?}");
    }
    let inside: Vec<bool> = (0..path.parts()).map(|part| path.is_inside_body(part)).collect();
    assert_eq!(inside, [false, false, true, false, false, false]);
    assert!((path.length(2) - 2.0).abs() < 1e-12);
    assert_eq!(path.place(at).unwrap().0, 0);
    // On the surface of the body, and beyond the end.
    assert_eq!(path.place(8.0 + 1e-13).unwrap().0, 1);
    let (last, z) = path.place(99.0).unwrap();
    assert!(last == 5 && (z - 1.0).abs() < 1e-15);
}

#[test]
fn a_line_outside_of_the_bounds_has_no_parts() {
    let camera = Perspective::new(viewpoint(), [0.4, 0.3], [0.0, 30.0]).unwrap();
    let camera = camera.with_bounds(Bounds::cuboid([50.0; 3], [51.0; 3]).unwrap());
    let paths = Paths::of(&camera);
    let (key, at) = paths.locate([0.1, 0.2, 0.0], [0.1, 0.2, 0.97]).unwrap();
    let path = paths.path(key);
    assert_eq!((path.parts(), path.place(at)), (0, None));
}
