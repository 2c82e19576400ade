//! Charts about singularities: all lines of sight are in them, and they lead back to these lines.

use super::*;
use crate::projection::camera::Camera;
use crate::projection::singularity::Singularity;
use crate::projection::vector::{along, difference, dot, norm};
use crate::projection::{Ellipsoid, ImagePlane};
use crate::{Equirectangular, Orthographic, Perspective, Viewpoint};

const VIEWPOINT: Viewpoint =
    Viewpoint { position: [0.3, -6.0, 1.0], target: [0.1, -0.2, 0.05], up: [0.0, 0.3, 1.0] };

/// Checks lines over the image of a camera with these singularities; the number of charts seen.
fn check<P: ImagePlane>(camera: Camera<P>, singularities: &[Singularity]) -> usize {
    let camera = camera.with_singularities(singularities.to_vec());
    let geometry: &dyn ViewGeometry = &camera;
    let surroundings = geometry.surroundings().unwrap();
    let atlas = Atlas::new(vec![geometry], [32; 2], &[]).unwrap();
    let (mut pieces, mut seen) = (Vec::new(), vec![false; atlas.len()]);
    for k in 0..300 {
        let xy = [(0.5 + f64::from(k) * 0.618_033_988_749) % 1.0, (f64::from(k) + 0.5) / 300.0];
        let line = geometry.line(xy).unwrap();
        let (_, end) = surroundings.end_of(&line);
        atlas.pieces(&line, &mut pieces);
        let mut sum = 0.0;
        for piece in &pieces {
            seen[piece.chart] = true;
            assert!(piece.density > 0.0 && piece.density <= 1.0, "{piece:?}");
            let [low, high] = atlas.natural_ends(piece.chart);
            let sector = atlas.sector_rad(piece.chart).unwrap_or([0.0, TAU]);
            let c = [low, high.min(piece.place[0] + 1.0)];
            let window = Window { c, azimuth_rad: sector };
            let chart = atlas.chart(piece.chart, window);
            let [u, v] = window.unit(piece.place);
            let distance = |z: f64| {
                let point = chart.world_from_chart([u, v, z]);
                let from_origin = difference(point.position, line.origin);
                let distance = dot(from_origin, line.direction);
                let on_line = along(line.origin, distance, line.direction);
                assert!(norm(difference(point.position, on_line)) < 1e-6, "{piece:?} {xy:?}");
                (distance, point)
            };
            sum += distance(1.0).0 - distance(0.0).0;
            for z in [0.02, 0.3, 0.5, 0.9] {
                let (_, point) = distance(z);
                let step = 1e-5 * f64::min(z, 1.0 - z);
                let slope = (distance(z + step).0 - distance(z - step).0) / (2.0 * step);
                let path = point.path_per_depth / piece.density;
                assert!((slope / path - 1.0).abs() < 1e-3, "{piece:?} {z}: {slope} {path}");
                let back = chart.chart_from_world(point.position).unwrap();
                assert!((back[0] - u).abs() + (back[1] - v).abs() < 1e-6, "{back:?} {u} {v}");
                assert!((back[2] - z).abs() < 1e-6, "{back:?} {z}");
            }
        }
        assert!((sum - (end - line.ends[0])).abs() < 1e-6, "{xy:?}: {sum}");
    }
    seen.iter().filter(|seen| **seen).count()
}

fn point(position: [f64; 3]) -> Singularity {
    Singularity::point(position).unwrap()
}

#[test]
fn all_lines_are_in_charts_about_a_point_or_an_axis() {
    let tilted = Singularity::axis([0.1, 0.3, 0.2], [0.3, 0.2, 1.0]).unwrap();
    for singularity in [point([0.2, 0.5, 0.1]), tilted] {
        // An axis has a chart on each side.
        let charts = if singularity.axis.is_some() { 2 } else { 1 };
        let only = &[singularity][..];
        let depth = [0.0, 15.0];
        assert_eq!(check(Perspective::new(VIEWPOINT, [0.6; 2], depth).unwrap(), only), charts);
        assert_eq!(check(Orthographic::new(VIEWPOINT, [3.0; 2], depth).unwrap(), only), charts);
        let wide = Equirectangular::new(VIEWPOINT, [1.5, 1.0], depth).unwrap();
        assert_eq!(check(wide, only), charts);
    }
}

#[test]
fn bodies_and_several_points_have_charts_side_by_side() {
    let depth = [0.0, 15.0];
    let camera = || Perspective::new(VIEWPOINT, [0.6; 2], depth).unwrap();
    assert_eq!(check(camera(), &[point([0.8, 0.5, 0.1]), point([-0.7, 0.0, 0.4])]), 2);
    let body = Ellipsoid::sphere([-0.6, 0.0, 0.3], 0.4).unwrap();
    let bodied = camera().with_occulters(vec![body]).unwrap();
    // The near side of the body, what is beside it, and the point.
    assert_eq!(check(bodied, &[point([0.8, 0.5, 0.1])]), 3);
}

/// A point in the centre of bounds is in their chart of lines that enter them.
#[test]
fn a_point_in_the_centre_of_bounds_has_their_chart() {
    let bounds = Ellipsoid::sphere([0.1, 0.0, 0.2], 1.3).unwrap();
    let camera = Perspective::new(VIEWPOINT, [0.3; 2], [0.0, 15.0]).unwrap();
    let camera = camera.with_bounds(Bounds::Ellipsoid(bounds));
    assert_eq!(check(camera, &[point([0.1, 0.0, 0.2])]), 1);
}

#[test]
fn the_observer_and_hidden_points_have_no_charts() {
    let atlas = |singularity, body: Option<Ellipsoid>| {
        let camera = Perspective::new(VIEWPOINT, [0.6; 2], [0.0, 15.0]).unwrap();
        let camera = camera.with_singularities(vec![singularity]);
        let camera = camera.with_occulters(body.into_iter().collect()).unwrap();
        Atlas::new(vec![&camera], [32; 2], &[]).map(|atlas| atlas.has_singularities())
    };
    assert_eq!(atlas(point(VIEWPOINT.position), None), None);
    let on_it = Singularity::axis(VIEWPOINT.position, [0.0, 1.0, 0.0]).unwrap();
    assert_eq!(atlas(on_it, None), None);
    let body = Ellipsoid::sphere([0.0; 3], 0.5).unwrap();
    assert_eq!(atlas(point([0.1, 0.1, 0.0]), Some(body)), Some(false));
    assert_eq!(atlas(point([0.1, 0.1, 0.0]), None), Some(true));
}

#[test]
fn other_charts_are_bounded_near_a_point() {
    let [near, far] = [[0.8, 0.5, 0.1], [-0.7, 0.0, 0.4]];
    let camera = Orthographic::new(VIEWPOINT, [3.0; 2], [0.0, 15.0]).unwrap();
    let camera = camera.with_singularities(vec![point(near), point(far)]);
    let geometry: &dyn ViewGeometry = &camera;
    let atlas = Atlas::new(vec![geometry], [32; 2], &[]).unwrap();
    let to_far = atlas.surroundings.line_to(far).unwrap();
    let (own, other) = (&atlas.shells[0], &atlas.shells[1]);
    assert!(norm(difference(own.reference.centre(), near)) < 1e-12);
    let closest = |shells: &Shells| {
        let weights = shells.usual_weights(Piece::Sky);
        let at = |k: i32| {
            let z = (f64::from(k) + 0.5) / 2000.0;
            let point =
                shells.point(atlas.surroundings, (Piece::Sky, Side::Both), weights, &to_far, z);
            norm(difference(point.position, far))
        };
        (0..2000).map(at).fold(f64::INFINITY, f64::min)
    };
    // The line through a point is at a distance of it in the chart of the other one alone.
    assert!(closest(own) > 0.2, "{}", closest(own));
    assert!(closest(other) < 1e-3, "{}", closest(other));
}
