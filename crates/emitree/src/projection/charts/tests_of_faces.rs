//! Charts of boxes: that places and lines lead to each other, and that paths are whole.

use super::chart::{Chart, Window};
use super::faces::Faces;
use crate::projection::ViewGeometry;
use crate::projection::bounds::{Bounds, Cuboid};
use crate::projection::surroundings::Surroundings;
use crate::projection::vector::difference;
use crate::{Orthographic, Perspective, Viewpoint};
use core::f64::consts::FRAC_PI_4;

const CUBOID: [[f64; 3]; 2] = [[-1.0, -2.0, -0.5], [2.0, 1.0, 1.5]];

fn cuboid() -> Cuboid {
    let Bounds::Cuboid(cuboid) = Bounds::cuboid(CUBOID[0], CUBOID[1]).unwrap() else {
        unreachable!("a box")
    };
    cuboid
}

fn viewpoint(position: [f64; 3]) -> Viewpoint {
    Viewpoint { position, target: [0.4, -0.6, 0.5], up: [0.1, 0.2, 0.97] }
}

/// Observers that see one, two and three faces, and one inside.
const POSITIONS: [[f64; 3]; 6] = [
    [9.0, -0.6, 0.5],
    [9.0, 0.9, 0.6],
    [7.0, 6.0, 0.5],
    [-4.0, 5.0, 3.0],
    [2.2, 1.1, 1.6],
    [0.9, 0.3, 0.2],
];

/// The atlases of all observers, as points and as directions of parallel lines.
fn for_each_view(check: impl Fn(&Surroundings, &Faces, &dyn ViewGeometry)) {
    for position in POSITIONS {
        let bounds = Bounds::cuboid(CUBOID[0], CUBOID[1]).unwrap();
        let view = viewpoint(position);
        let camera = Perspective::new(view, [2.0 * FRAC_PI_4; 2], [0.0, 50.0]).unwrap();
        let camera = camera.with_bounds(bounds);
        let parallel = Orthographic::new(view, [7.0; 2], [f64::NEG_INFINITY, f64::INFINITY]);
        let parallel = parallel.unwrap().with_bounds(bounds);
        for geometry in [&camera as &dyn ViewGeometry, &parallel] {
            let surroundings = geometry.surroundings().unwrap();
            check(surroundings, &Faces::new(cuboid(), surroundings.observer), geometry);
        }
    }
}

#[test]
fn each_line_through_the_box_has_one_place_that_leads_back_to_it() {
    for_each_view(|surroundings, faces, geometry| {
        let mut through = 0;
        for k in 0..1600 {
            let xy = [k % 40, k / 40].map(|along| (f64::from(along) + 0.5) / 40.0);
            let line = geometry.line(xy).unwrap();
            let path = line.ends[1] - line.ends[0];
            let Some((number, place)) = faces.place(&line) else {
                assert!(path <= 0.0, "{xy:?} {line:?}");
                continue;
            };
            through += 1;
            assert!(place.iter().all(|along| (-1e-9..1.0 + 1e-9).contains(along)), "{place:?}");
            let window = Window { c: [0.0, 1.0], azimuth_rad: [0.0, 1.0] };
            let chart = faces.passages()[number].chart(surroundings, window, vec![geometry]);
            let back = chart.line_at(place);
            let apart = |a: [f64; 3], b: [f64; 3]| {
                difference(a, b).iter().fold(0.0_f64, |most, along| most.max(along.abs()))
            };
            assert!(apart(back.direction, line.direction) < 1e-9);
            for (a, b) in back.ends.into_iter().zip(line.ends) {
                assert!(apart(back.at(a), line.at(b)) < 1e-7, "{line:?} {back:?}");
            }
            let (tile, seen) = chart.image_place(place);
            assert_eq!(tile, 0);
            assert!((seen[0] - xy[0]).abs() + (seen[1] - xy[1]).abs() < 1e-9);
            let point = chart.world_from_chart([place[0], place[1], 0.3]);
            let [u, v, z] = chart.chart_from_world(point.position).unwrap();
            assert!((u - place[0]).abs() + (v - place[1]).abs() + (z - 0.3).abs() < 1e-5);
        }
        assert!(through > 40, "{through}");
    });
}

#[test]
fn each_place_of_a_chart_is_a_line_of_its_passage() {
    for_each_view(|surroundings, faces, geometry| {
        for (number, passage) in faces.passages().iter().enumerate() {
            let window = Window { c: [0.0, 1.0], azimuth_rad: [0.0, 1.0] };
            let chart = passage.chart(surroundings, window, vec![geometry]);
            for k in 0..64 {
                let uv = [k % 8, k / 8].map(|along| (f64::from(along) + 0.5) / 8.0);
                let line = chart.line_at(uv);
                let (found, place) = faces.place(&line).unwrap();
                assert_eq!(found, number, "{passage:?} {uv:?}");
                assert!((place[0] - uv[0]).abs() + (place[1] - uv[1]).abs() < 1e-8);
            }
        }
    });
}

#[test]
fn paths_along_an_axis_are_whole_up_to_the_edges_of_a_face() {
    let everything = [f64::NEG_INFINITY, f64::INFINITY];
    let along =
        Viewpoint { position: [9.0, 0.1, 0.2], target: [0.0, 0.1, 0.2], up: [0.0, 0.0, 1.0] };
    let camera = Orthographic::new(along, [5.0; 2], everything).unwrap();
    let surroundings = camera.surroundings().unwrap();
    let faces = Faces::new(cuboid(), surroundings.observer);
    assert_eq!(faces.passages().len(), 1);
    let window = Window { c: [0.0, 1.0], azimuth_rad: [0.0, 1.0] };
    let chart = faces.passages()[0].chart(surroundings, window, vec![&camera]);
    for uv in [[0.0, 0.0], [1.0, 0.0], [0.3, 1.0], [1.0, 1.0], [0.5, 0.5]] {
        let point = chart.world_from_chart([uv[0], uv[1], 0.5]);
        assert!((point.path_per_depth - 3.0).abs() < 1e-12, "{point:?}");
        let place = cuboid().place_of(point.position);
        assert!(place.iter().all(|along| *along > 0.0 && *along < 1.0), "{place:?}");
    }
}
