//! Pieces add up to lines of sight, and charts lead back to the lines that they are charts of.

use super::*;
use crate::projection::camera::Camera;
use crate::projection::span::Depth;
use crate::projection::surroundings::{Observer, POINTS_OF_GAP};
use crate::projection::vector::{along, difference, dot, norm};
use crate::projection::{Ellipsoid, ImagePlane, MappedPoint, Projection};
use crate::{Equirectangular, Orthographic, Perspective, Viewpoint};
use core::f64::consts::{PI, TAU};

fn viewpoint(position: [f64; 3]) -> Viewpoint {
    Viewpoint { position, target: [0.1, -0.2, 0.05], up: [0.0, 0.3, 1.0] }
}

fn saturn() -> Ellipsoid {
    let body = Ellipsoid::new([0.0; 3], [1.0, 1.1, 0.8]).unwrap();
    body.oriented([0.2, 0.3, 1.0], [1.0, 0.0, 0.1]).unwrap()
}

/// Checks all pieces of lines over the image of a camera. Returns the number of charts seen.
fn check<P: ImagePlane>(camera: &Camera<P>) -> usize {
    check_atlas(camera, &atlas_of(camera))
}

fn atlas_of(geometry: &dyn ViewGeometry) -> Atlas<'_> {
    Atlas::new(vec![geometry], [8; 2], &[]).unwrap()
}

fn check_atlas(geometry: &dyn ViewGeometry, atlas: &Atlas<'_>) -> usize {
    let surroundings = geometry.surroundings().unwrap();
    let mut seen = vec![false; atlas.len()];
    let (mut pieces, mut checked) = (Vec::new(), 0);
    for k in 0..400 {
        let xy = [(0.5 + k as f64 * 0.618_033_988_749) % 1.0, (k as f64 + 0.5) / 400.0];
        let line = geometry.line(xy).unwrap();
        let (_, end) = surroundings.end_of(&line);
        let length = (end - line.ends[0]).max(0.0);
        atlas.pieces(&line, &mut pieces);
        let mut sum = 0.0;
        for piece in &pieces {
            seen[piece.chart] = true;
            let [low, high] = atlas.natural_ends(piece.chart);
            assert!(piece.place[0] > low - 1e-9 && piece.place[0] < high + 1e-9, "{piece:?}");
            let window =
                Window { c: [low, high.min(piece.place[0] + 1.0)], azimuth_rad: [0.0, TAU] };
            let chart = atlas.chart(piece.chart, window);
            let [u, v] = window.unit(piece.place);
            let distance_at = |z: f64| {
                let point = chart.world_from_chart([u, v, z]);
                let from_origin = difference(point.position, line.origin);
                let distance = dot(from_origin, line.direction);
                // On the same line of sight.
                let beside =
                    difference(point.position, along(line.origin, distance, line.direction));
                assert!(
                    norm(beside) < 1e-6 * (1.0 + distance.abs()),
                    "{piece:?} {xy:?} {beside:?}"
                );
                (distance, point)
            };
            sum += distance_at(1.0).0 - distance_at(0.0).0;
            for z in [1e-3, 0.02, 0.13, 0.48, 0.77, 0.99] {
                let (_, point) = distance_at(z);
                // ds/dz is the slope of the distance.
                let step = 1e-2 * f64::min(z, 1.0 - z);
                let rise = distance_at(z + step).0 - distance_at(z - step).0;
                let slope = rise / (2.0 * step);
                let wrong = (slope - point.path_per_depth).abs();
                let allowed = 1e-3 * slope + 1e-7 / step;
                assert!(
                    slope > -1e-7 / step && wrong < allowed,
                    "{piece:?} {z}: {slope} {point:?}"
                );
                if let Some(back) = chart.chart_from_world(point.position) {
                    checked += 1;
                    let apart = (back[2] - z).abs() + (back[0] - u).abs();
                    assert!(apart < 1e-5, "{piece:?} {back:?} {u} {v} {z}");
                }
            }
            let (tile, place) = chart.image_place([u, v]);
            assert_eq!(tile, 0);
            assert!((0..2).all(|i| (place[i] - xy[i]).abs() < 1e-6), "{place:?} {xy:?}");
        }
        assert!((sum - length).abs() < 1e-7 * (1.0 + length), "{xy:?}: {sum} {length} {pieces:?}");
    }
    assert!(checked > 500, "{checked}");
    seen.into_iter().filter(|seen| *seen).count()
}

#[test]
fn pieces_are_the_lines_of_sight_of_all_cameras() {
    let near_and_far = [0.1, 30.0];
    let bodies = || vec![saturn(), Ellipsoid::sphere([1.2, -1.9, 0.7], 0.3).unwrap()];
    let perspective = Perspective::new(viewpoint([0.5, -6.0, 1.0]), [0.7, 0.6], near_and_far);
    assert_eq!(check(&perspective.unwrap().with_occulters(bodies()).unwrap()), 4);
    let wide = Equirectangular::new(viewpoint([0.5, -2.5, 1.0]), [6.0, 3.0], near_and_far);
    assert_eq!(check(&wide.unwrap().with_occulters(bodies()).unwrap()), 4);
    let parallel = Orthographic::new(viewpoint([0.5, -6.0, 1.0]), [4.0, 3.0], [-20.0, 30.0]);
    assert_eq!(check(&parallel.unwrap().with_occulters(bodies()).unwrap()), 4);
}

#[test]
fn bounds_around_a_body_are_another_surface() {
    let bounds = |size: f64| {
        let shape = Ellipsoid::new([0.0; 3], [size, 1.1 * size, 0.8 * size]).unwrap();
        Bounds::Ellipsoid(shape.oriented([0.2, 0.3, 1.0], [1.0, 0.0, 0.1]).unwrap())
    };
    let camera = Perspective::new(viewpoint([0.5, -9.0, 1.0]), [0.7, 0.6], [0.0, 60.0]).unwrap();
    let camera = camera.with_occulters(vec![saturn()]).unwrap();
    // In front of the body, and around it.
    assert_eq!(check(&camera.clone().with_bounds(bounds(2.0))), 2);
    // The observer inside the bounds.
    assert_eq!(check(&camera.clone().with_bounds(bounds(20.0))), 2);
    let off_centre = Bounds::Ellipsoid(Ellipsoid::sphere([0.2, 0.3, 0.1], 2.5).unwrap());
    assert_eq!(check(&camera.with_bounds(off_centre)), 3);
}

#[test]
fn lines_that_pass_a_body_are_divided_where_they_are_nearest_to_it() {
    let bodies = || vec![saturn(), Ellipsoid::sphere([1.2, -1.9, 0.7], 0.3).unwrap()];
    let perspective = Perspective::new(viewpoint([0.5, -6.0, 1.0]), [0.7, 0.6], [0.1, 30.0]);
    let perspective = perspective.unwrap().with_occulters(bodies()).unwrap();
    let bounds = Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], 3.0).unwrap());
    let parallel = Orthographic::new(viewpoint([0.5, -6.0, 1.0]), [4.0, 3.0], [-20.0, 30.0]);
    let parallel = parallel.unwrap().with_occulters(bodies()).unwrap();
    let halved = atlas_of(&perspective).with_halves();
    // Two charts of the discs, and two of the sky around each body.
    assert_eq!((check_atlas(&perspective, &halved), halved.has_halves()), (6, true));
    let around = perspective.clone().with_bounds(bounds);
    let halved = atlas_of(&around).with_halves();
    assert!(check_atlas(&around, &halved) > check(&around) && halved.has_halves());
    let halved = atlas_of(&parallel).with_halves();
    assert_eq!((check_atlas(&parallel, &halved), halved.has_halves()), (6, true));
    // Behind the observer, lines are nearest to the body where they begin.
    let wide = Equirectangular::new(viewpoint([0.5, -2.5, 1.0]), [6.0, 3.0], [0.1, 30.0]);
    let wide = wide.unwrap().with_occulters(bodies()).unwrap();
    assert!(!atlas_of(&wide).with_halves().has_halves());
    let short = Perspective::new(viewpoint([0.5, -6.0, 1.0]), [0.7, 0.6], [0.1, 5.0]).unwrap();
    let short = short.with_occulters(vec![saturn()]).unwrap();
    assert!(!atlas_of(&short).with_halves().has_halves());
}

/// A body and two more surfaces of its shape, the largest of which is dark beyond.
fn nested(observer: Observer) -> Shells {
    let mut shells = Shells::new(saturn(), Some(0), observer);
    shells.insert(2.5);
    shells.insert(1.4);
    shells.is_dark_beyond = true;
    shells
}

fn with(
    bounds: Option<Bounds>,
    bodies: Vec<Ellipsoid>,
    mut surroundings: Surroundings,
) -> Surroundings {
    (surroundings.bounds, surroundings.bodies) = (bounds, bodies);
    surroundings
}

/// A view with given surroundings, without an image plane.
#[derive(Debug)]
struct View(Surroundings);

impl Projection for View {
    fn world_from_canonical(&self, _u: [f64; 3]) -> MappedPoint {
        MappedPoint::default()
    }

    fn canonical_from_world(&self, _position: [f64; 3]) -> Option<[f64; 3]> {
        None
    }

    fn solid_angle_density(&self, _xy: [f64; 2]) -> f64 {
        1.0
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        (max[0] - min[0]) * (max[1] - min[1])
    }
}

impl ViewGeometry for View {
    fn surroundings(&self) -> Option<&Surroundings> {
        Some(&self.0)
    }
}

/// What is around a body with bounds of 2.5 times its size, along depths without end.
fn surroundings(observer: Observer, is_parallel: bool) -> Surroundings {
    let near = if is_parallel { f64::NEG_INFINITY } else { 0.0 };
    let depth = Depth::new([near, f64::INFINITY], 6.0, is_parallel).unwrap();
    let bounds = Ellipsoid::new([0.0; 3], [2.5, 2.75, 2.0]).unwrap();
    let bounds = bounds.oriented([0.2, 0.3, 1.0], [1.0, 0.0, 0.1]).unwrap();
    let bounds = Some(Bounds::Ellipsoid(bounds));
    with(bounds, vec![saturn()], Surroundings::new(observer, depth))
}

const OBSERVERS: [Observer; 3] = [
    Observer::Point([0.5, -6.0, 1.0]),
    // Inside the bounds.
    Observer::Point([0.3, -2.2, 0.4]),
    Observer::Parallel { plane_point: [0.5, -6.0, 1.0], direction: [0.0, 0.8, 0.6] },
];

/// Lines at angles up to the largest one, or at distances up to that of the bounds.
fn lines(shells: &Shells, surroundings: &Surroundings) -> Vec<SightLine> {
    let most = if shells.is_parallel() { 2.6 } else { 3.1 };
    let line = |k: i32| {
        let angle = most * (f64::from(k) + 0.5) / 300.0;
        shells.line(surroundings, angle, 2.4 * f64::from(k))
    };
    (0..300).map(line).collect()
}

#[test]
fn surfaces_with_the_observer_outside_have_limbs() {
    let limbs = OBSERVERS.map(|observer| nested(observer).limbs);
    assert_eq!(limbs, [3, 2, 3]);
    let shells = nested(OBSERVERS[0]);
    assert!(shells.radii.is_sorted() && shells.radii.len() == 3);
    let of_size = |size: f64, height: f64| {
        let shape = Ellipsoid::new([0.0; 3], [size, 1.1 * size, height * size]).unwrap();
        shells.radius_of(&shape.oriented([0.2, 0.3, 1.0], [1.0, 0.0, 0.1]).unwrap())
    };
    assert!((of_size(1.7, 0.8).unwrap() - 1.7).abs() < 1e-12);
    assert_eq!(of_size(1.7, 0.81), None);
    assert_eq!(shells.radius_of(&Ellipsoid::sphere([0.0; 3], 1.0).unwrap()), None);
}

#[test]
fn a_line_has_the_angle_and_azimuth_that_it_is_made_from() {
    for observer in OBSERVERS {
        let (shells, around) = (
            nested(observer),
            surroundings(observer, matches!(observer, Observer::Parallel { .. })),
        );
        for (angle, azimuth) in [(0.03, 0.4), (0.4, -2.0), (0.9, 3.0), (1.9, 1.2)] {
            let line = shells.line(&around, angle, azimuth);
            let aim = shells.aim(&line);
            assert!(
                (aim.angle() - angle).abs() + (aim.azimuth() - azimuth).abs() < 1e-12,
                "{aim:?}"
            );
            // The nearest point is as far from the centre as the line.
            let nearest = shells.radius_at(line.at(aim.nearest));
            assert!((nearest - aim.miss).abs() < 1e-12, "{nearest} {aim:?}");
            for step in [-1e-3, 1e-3] {
                assert!(shells.radius_at(line.at(aim.nearest + step)) > nearest);
            }
            assert_eq!(aim.is_ahead, shells.is_parallel() || aim.nearest > 0.0);
        }
    }
}

#[test]
fn the_zone_of_a_line_is_the_number_of_surfaces_that_it_does_not_cross() {
    for observer in OBSERVERS {
        let (shells, around) = (
            nested(observer),
            surroundings(observer, matches!(observer, Observer::Parallel { .. })),
        );
        let mut seen = vec![0; shells.limbs + 1];
        for line in lines(&shells, &around) {
            let aim = shells.aim(&line);
            // The smallest radius on the line, by many points from the observer on.
            let distance =
                |k: i32| if shells.is_parallel() { f64::from(k - 2000) } else { f64::from(k) };
            let smallest = (0..4000)
                .map(|k| shells.radius_at(line.at(0.01 * distance(k))))
                .fold(f64::INFINITY, f64::min);
            if shells.radii.iter().any(|radius| (smallest - radius).abs() < 1e-3) {
                continue;
            }
            let missed = shells.radii[..shells.limbs].iter().filter(|radius| **radius < smallest);
            let zone = shells.zone(&aim);
            assert_eq!(zone, missed.count(), "{aim:?}");
            seen[zone] += 1;
        }
        assert!(seen.iter().all(|count| *count > 3), "{seen:?}");
    }
}

#[test]
fn the_pieces_of_a_line_follow_each_other_between_its_surfaces() {
    for observer in OBSERVERS {
        let (shells, around) = (
            nested(observer),
            surroundings(observer, matches!(observer, Observer::Parallel { .. })),
        );
        for line in lines(&shells, &around) {
            let aim = shells.aim(&line);
            let zone = shells.zone(&aim);
            let (_, end) = around.end_of(&line);
            let ends = shells.ends(&around, &line);
            let mut ranges = Vec::new();
            for piece in shells.pieces().into_iter().filter(|piece| shells.has(zone, *piece, ends))
            {
                let [from, to] = shells.range(piece, Side::Both, &line, &aim);
                let c = shells.coordinate(piece, &aim);
                assert!((shells.angle(piece, c) - aim.angle()).abs() < 1e-9, "{piece:?} {aim:?}");
                if to <= from {
                    continue;
                }
                ranges.push([from, to]);
                // No other surface is between the ends.
                let order = |distance: f64| {
                    shells
                        .radii
                        .partition_point(|radius| *radius < shells.radius_at(line.at(distance)))
                };
                let inside = [1e-6, 0.3, 0.7, 1.0 - 1e-6].map(|at| order(from + at * (to - from)));
                assert!(inside.iter().all(|order| *order == inside[0]), "{piece:?} {inside:?}");
            }
            ranges.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let [begin, _] = line.ends;
            if end <= begin {
                assert!(ranges.is_empty(), "{ranges:?}");
                continue;
            }
            let borders: Vec<f64> = ranges.iter().map(|range| range[0]).chain([end]).collect();
            assert!((borders[0] - begin).abs() < 1e-7, "{ranges:?} {:?}", line.ends);
            for (range, next) in ranges.iter().zip(&borders[1..]) {
                assert!((range[1] - next).abs() < 1e-7, "{ranges:?} {end}");
            }
        }
    }
}

/// On both sides of a limb the length of a piece is a smooth function of its coordinate, with a
/// slope; as a function of the angle it has a square root.
#[test]
fn lengths_are_smooth_functions_of_the_coordinate_up_to_the_limb() {
    for observer in OBSERVERS {
        let (shells, around) = (
            nested(observer),
            surroundings(observer, matches!(observer, Observer::Parallel { .. })),
        );
        for piece in shells.pieces() {
            let [low, high] = shells.natural_ends(piece);
            let ends = match piece {
                Piece::Near(_) | Piece::Far(_) => {
                    vec![if piece == Piece::Near(0) { high } else { low }]
                }
                Piece::Chord(_) => vec![low, high],
                Piece::Sky => vec![low],
            };
            for limb in ends.into_iter().filter(|limb| *limb > 0.0 || piece == Piece::Sky) {
                let inwards = if limb > low { -1.0 } else { 1.0 };
                let length = |step: f64| {
                    let c = limb + inwards * step;
                    let line = shells.line(&around, shells.angle(piece, c), 0.7);
                    let [from, to] = shells.range(piece, Side::Both, &line, &shells.aim(&line));
                    to - from
                };
                // Differences of third order at the limb fall with the third power of the step.
                let third = |h: f64| {
                    length(h) - 3.0 * length(2.0 * h) + 3.0 * length(3.0 * h) - length(4.0 * h)
                };
                let [coarse, fine] = [0.02, 0.005].map(third);
                assert!(fine.abs() < 0.1 * coarse.abs() + 1e-6, "{piece:?}: {coarse:e} {fine:e}");
            }
        }
    }
}

/// ∫ ds/(b² + s²), along lines that do not end: the emission falls with the square of the distance
/// from the centre of a sphere.
#[test]
fn infinite_lines_are_integrated_over_few_depths() {
    let observer = Observer::Point([0.0, -6.0, 0.0]);
    let depth = Depth::new([0.0, f64::INFINITY], 6.0, false).unwrap();
    let sphere = Ellipsoid::sphere([0.0; 3], 1.0).unwrap();
    let around = with(None, vec![sphere], Surroundings::new(observer, depth));
    let view = View(around.clone());
    let atlas = Atlas::new(vec![&view], [8; 2], &[]).unwrap();
    // No line is in the chart behind the body.
    assert_eq!(atlas.len(), 3);
    let shells = &atlas.shells[0];
    let mut pieces = Vec::new();
    for angle in [0.02, 0.1, 0.16, 0.17, 0.3, 1.2, 1.6, 2.9] {
        let line = shells.line(&around, angle, 0.4);
        let (miss, back) = (6.0 * angle.sin(), 6.0 * angle.cos());
        let end = if miss < 1.0 { -(1.0 - miss * miss).sqrt() } else { f64::INFINITY };
        let expected = ((end / miss).atan() + (back / miss).atan()) / miss;
        atlas.pieces(&line, &mut pieces);
        assert_eq!(pieces.len(), 1);
        let window = Window { c: [0.0, 2.0], azimuth_rad: [0.0, TAU] };
        let chart = atlas.chart(pieces[0].chart, window);
        let [u, v] = window.unit(pieces[0].place);
        let steps = 200;
        let sample = |k: i32| {
            let point = chart.world_from_chart([u, v, (f64::from(k) + 0.5) / f64::from(steps)]);
            point.path_per_depth / dot(point.position, point.position)
        };
        let found = (0..steps).map(sample).sum::<f64>() / f64::from(steps);
        assert!((found / expected - 1.0).abs() < 1e-4, "{angle}: {found} {expected}");
        // The end itself has no weight.
        let last = chart.world_from_chart([u, v, 1.0]);
        assert!(last.position.iter().all(|x| x.is_finite()), "{last:?}");
    }
}

#[test]
fn windows_of_azimuth_have_a_beginning_and_an_end() {
    let window = Window { c: [0.5, 2.5], azimuth_rad: [6.0, 1.0] };
    for (c, azimuth, expected) in [
        (0.5, 6.0, [0.0, 0.0]),
        (1.5, 6.2, [0.5, 0.2]),
        (2.5, 7.0 - TAU, [1.0, 1.0]),
        (1.0, 0.0, [0.25, TAU - 6.0]),
        // Beyond either end by the smaller angle.
        (1.0, 5.9, [0.25, -0.1]),
        (1.0, 7.2, [0.25, 1.2]),
    ] {
        let found = window.unit([c, azimuth]);
        let apart = (found[0] - expected[0]).abs() + (found[1] - expected[1]).abs();
        assert!(apart < 1e-12, "{c} {azimuth}: {found:?}");
    }
    assert!(!window.is_closed());
    // Both ends of a full circle are the same lines.
    let around = surroundings(OBSERVERS[0], false);
    let view = View(around.clone());
    let atlas = Atlas::new(vec![&view], [8; 2], &[]).unwrap();
    let window = Window { c: [0.1, 0.9], azimuth_rad: [0.3, TAU] };
    assert!(window.is_closed());
    let chart = atlas.chart(0, window);
    for u in [0.0, 0.3, 1.0] {
        assert_eq!(chart.world_from_chart([u, 0.0, 0.4]), chart.world_from_chart([u, 1.0, 0.4]));
    }
}

#[test]
fn zones_change_at_limbs_where_misses_are_1() {
    let around = surroundings(OBSERVERS[0], false);
    let view = View(around.clone());
    let atlas = Atlas::new(vec![&view], [8; 2], &[]).unwrap();
    // The bounds have the shape of the body.
    assert_eq!((atlas.shells.len(), atlas.shells[0].limbs), (1, 2));
    let shells = &atlas.shells[0];
    let mut misses = Vec::new();
    for (limb, radius) in [1.0, 2.5].into_iter().enumerate() {
        let angle = (radius / shells.distance).asin();
        let [inside, outside] =
            [-1e-7, 1e-7].map(|beside| shells.line(&around, angle + beside, 1.1));
        assert_ne!(atlas.zones(&inside), atlas.zones(&outside));
        for line in [inside, outside] {
            atlas.misses(&line, &mut misses);
            assert!((misses[limb] - 1.0).abs() < 1e-6, "{misses:?}");
        }
        let further = shells.line(&around, angle + 2e-7, 1.1);
        assert_eq!(atlas.zones(&further), atlas.zones(&outside));
    }
    // Away from the centre no limb is near, although the infinite line may cross the surfaces.
    let away = shells.line(&around, PI - 0.01, 1.1);
    atlas.misses(&away, &mut misses);
    assert!(misses.iter().all(|miss| *miss > 2.0), "{misses:?}");
}

#[test]
fn without_limbs_there_is_no_atlas() {
    let observer = OBSERVERS[0];
    let depth = Depth::new([0.0, 9.0], 6.0, false).unwrap();
    let empty = Surroundings::new(observer, depth);
    let atlas = |around: Surroundings| {
        Atlas::new(vec![&View(around)], [8; 2], &[]).map(|atlas| atlas.len())
    };
    assert_eq!(atlas(empty.clone()), None);
    let room = Bounds::cuboid([-1.0; 3], [1.0; 3]).unwrap();
    assert_eq!(atlas(with(Some(room), vec![], empty.clone())), None);
    let around = |radius| Some(Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], radius).unwrap()));
    assert_eq!(atlas(with(around(7.0), vec![], empty.clone())), None);
    assert_eq!(atlas(with(around(3.0), vec![], empty)), Some(1));
}

#[test]
fn pieces_behind_a_body_in_front_continue_those_beside_it() {
    let observer = Observer::Point([0.0, -6.0, 0.0]);
    let depth = Depth::new([0.0, 20.0], 6.0, false).unwrap();
    let sphere = |y: f64, radius: f64| Ellipsoid::sphere([0.0, y, 0.0], radius).unwrap();
    let bodies = vec![sphere(0.0, 1.0), sphere(-3.0, 0.2)];
    let around = with(None, bodies, Surroundings::new(observer, depth));
    let view = View(around.clone());
    let atlas = Atlas::new(vec![&view], [8; 2], &[]).unwrap();
    let window = Window { c: [0.0, 1.4], azimuth_rad: [0.0, TAU] };
    let mut pieces = Vec::new();
    // The small one is seen up to asin(0.2/3).
    // The charts of the large one are 0 to 2: before it, behind it, and beside it.
    for (angle, chart, is_free) in [(0.06, 3, false), (0.07, 0, true), (0.16, 0, true)] {
        let line = atlas.shells[0].line(&around, angle, 0.5);
        atlas.pieces(&line, &mut pieces);
        assert_eq!((pieces.len(), pieces[0].chart), (1, chart));
        // On the chart of the large one the small one is in front.
        let aim = atlas.shells[0].aim(&line);
        let c = atlas.shells[0].coordinate(Piece::Near(0), &aim);
        let of_large = atlas.chart(0, window);
        assert!(of_large.has_gaps());
        let [u, v] = window.unit([c, 0.5]);
        let mut gaps = 0;
        for k in 0..1000 {
            let at = [u, v, (f64::from(k) + 0.5) / 1000.0];
            let Some(gap) = of_large.across_gap(at) else { continue };
            gaps += 1;
            // A constant is continued by itself, from points outside of both bodies.
            let path = of_large.world_from_chart(at).path_per_depth;
            let sum = gap.value(&[1.0; POINTS_OF_GAP]);
            assert!((sum - path).abs() < 1e-9 * path, "{angle}: {sum} {path}");
            let is_outside = |point: &MappedPoint| {
                point.path_per_depth.to_bits() == 1.0_f64.to_bits()
                    && around.bodies.iter().all(|body| !body.contains(point.position))
            };
            assert!(gap.around.iter().all(is_outside), "{gap:?}");
        }
        assert_eq!(gaps == 0, is_free, "{angle}");
        let of_piece = atlas.chart(chart, window);
        let [u, v] = window.unit(pieces[0].place);
        let is_free = (1..100).all(|k| of_piece.across_gap([u, v, f64::from(k) / 100.0]).is_none());
        assert!(is_free, "{angle}");
    }
}
