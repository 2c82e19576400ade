//! Charts end at planes through the axis, and at no others.

use super::*;
use crate::projection::camera::Camera;
use crate::projection::{Ellipsoid, ImagePlane};
use crate::{Orthographic, Perspective, Viewpoint};

const CENTRE: [f64; 3] = [1.0, -2.0, 0.5];

fn body() -> Ellipsoid {
    let body = Ellipsoid::new(CENTRE, [1.0, 1.1, 0.8]).unwrap();
    body.oriented([0.2, 0.3, 1.0], [1.0, 0.0, 0.1]).unwrap()
}

fn viewpoint() -> Viewpoint {
    Viewpoint { position: [1.0, -9.0, 0.5], target: [1.1, -2.0, 0.3], up: [0.0, 0.3, 1.0] }
}

fn plane(normal: [f64; 3]) -> Edge {
    Edge::plane([CENTRE[0], -9.0, CENTRE[2]], normal).unwrap()
}

/// Checks that the pieces of all lines are on one side of the plane through the axis with this
/// `normal`. Returns the number of charts.
fn check<P: ImagePlane + Clone>(camera: Camera<P>, normal: [f64; 3]) -> usize {
    let camera = camera.with_occulters(vec![body()]).unwrap();
    let other = camera.clone().with_edges(vec![plane([0.1, 1.0, 0.3])]);
    let whole = Atlas::new(vec![&camera], [8; 2], &[]).unwrap().len();
    assert_eq!(Atlas::new(vec![&other], [8; 2], &[]).unwrap().len(), whole);
    let camera = camera.with_edges(vec![plane(normal), plane(normal.map(|along| -along))]);
    let atlas = Atlas::new(vec![&camera], [8; 2], &[]).unwrap();
    let found = whole_with_cuts(&camera, &atlas);
    assert_eq!([atlas.len(), found], [2 * whole; 2]);
    let above =
        |position: [f64; 3]| -> f64 { (0..3).map(|i| normal[i] * (position[i] - CENTRE[i])).sum() };
    let geometry: &dyn ViewGeometry = &camera;
    let (mut pieces, mut zones) = (Vec::new(), [None; 2]);
    for k in 0..200 {
        let xy = [(0.5 + k as f64 * 0.618_033_988_749) % 1.0, (k as f64 + 0.5) / 200.0];
        let line = geometry.line(xy).unwrap();
        atlas.pieces(&line, &mut pieces);
        for piece in &pieces {
            let azimuth_rad = atlas.sector_rad(piece.chart).unwrap();
            let [low, high] = atlas.natural_ends(piece.chart);
            let window = Window { c: [low, high.min(piece.place[0] + 1.0)], azimuth_rad };
            let [u, v] = window.unit(piece.place);
            assert!((-1e-6..=1.0 + 1e-6).contains(&v), "{v}");
            let chart = atlas.chart(piece.chart, window);
            let side = above(chart.world_from_chart([u, v, 0.4]).position).signum();
            for end in [0.0, 0.5, 1.0] {
                let at_end = above(chart.world_from_chart([u.max(0.01), end, 0.4]).position);
                assert!(side * at_end > 0.0, "{piece:?} {end}: {at_end}");
            }
            zones[usize::from(side > 0.0)] = Some(atlas.sectors(&line));
        }
    }
    assert!(zones[0].is_some() && zones[0] != zones[1]);
    atlas.len()
}

/// The number of charts if the same cuts are found once more.
fn whole_with_cuts<P: ImagePlane>(camera: &Camera<P>, atlas: &Atlas<'_>) -> usize {
    let azimuth_rad = atlas.sector_rad(0).unwrap();
    let window = Window { c: [0.0, 1.0], azimuth_rad };
    let cuts = [0.0, 1.0].map(|v| atlas.cut(0, &window, v).unwrap());
    Atlas::new(vec![camera], [8; 2], &[]).unwrap().with_cuts(&cuts).len()
}

#[test]
fn charts_end_at_planes_through_the_axis() {
    let normal = [0.6, 0.0, 0.8];
    let everything = [f64::NEG_INFINITY, f64::INFINITY];
    let parallel =
        Viewpoint { position: [1.3, -9.0, 0.6], target: [1.3, 0.0, 0.6], up: [0.0, 0.3, 1.0] };
    // Before, behind and beside the body, on both sides of the plane.
    assert_eq!(check(Orthographic::new(parallel, [4.0, 3.0], everything).unwrap(), normal), 6);
    assert_eq!(check(Perspective::new(viewpoint(), [0.7, 0.6], [0.0, 30.0]).unwrap(), normal), 6);
}
