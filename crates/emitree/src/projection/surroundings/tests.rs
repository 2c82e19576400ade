//! Where lines of sight begin and end, with bounds and bodies on an axis.

use super::*;

const ALONG_X: [f64; 3] = [1.0, 0.0, 0.0];

fn sphere(x: f64, radius: f64) -> Ellipsoid {
    Ellipsoid::sphere([x, 0.0, 0.0], radius).unwrap()
}

/// An observer at the origin with depths from 1 to 100.
fn surroundings(bounds: Option<Bounds>, bodies: Vec<Ellipsoid>) -> Surroundings {
    let depth = Depth::new([1.0, 100.0], 1.0, false).unwrap();
    Surroundings { bounds, bodies, ..Surroundings::new(Observer::Point([0.0; 3]), depth) }
}

fn assert_ends(found: [f64; 2], expected: [f64; 2]) {
    let is_close = |i: usize| (found[i] - expected[i]).abs() < 1e-7;
    assert!(is_close(0) && is_close(1), "{found:?} instead of {expected:?}");
}

#[test]
fn lines_are_clipped_to_the_inside_of_the_bounds() {
    let ends = |bounds: Ellipsoid, direction| {
        surroundings(Some(Bounds::Ellipsoid(bounds)), vec![]).line([0.0; 3], direction).ends
    };
    let clipped = ends(sphere(10.0, 4.0), ALONG_X);
    assert_ends(clipped, [6.0, 14.0]);
    assert!(clipped[0] > 6.0 && clipped[1] < 14.0);
    // Around the observer, and beyond the last depth.
    assert_ends(ends(sphere(0.0, 4.0), ALONG_X), [1.0, 4.0]);
    assert_ends(ends(sphere(90.0, 20.0), ALONG_X), [70.0, 100.0]);
    // Beside the line, behind the observer, and before the first depth: empty.
    let empty = [
        ends(sphere(10.0, 4.0), [0.0, 1.0, 0.0]),
        ends(sphere(-10.0, 4.0), ALONG_X),
        ends(sphere(0.0, 0.5), ALONG_X),
    ];
    assert!(empty.iter().all(|[from, to]| from >= to), "{empty:?}");
    assert_ends(surroundings(None, vec![]).line([0.0; 3], ALONG_X).ends, [1.0, 100.0]);
}

#[test]
fn a_line_ends_at_the_first_body_beyond_its_beginning() {
    let end = |bodies: &[Ellipsoid]| {
        let around = surroundings(None, bodies.to_vec());
        around.end_of(&around.line([0.0; 3], ALONG_X))
    };
    assert_eq!(end(&[]), (Region::Sky, 100.0));
    let (region, distance) = end(&[sphere(30.0, 2.0), sphere(20.0, 3.0)]);
    assert_eq!(region, Region::Body(1));
    assert!((distance - 17.0).abs() < 1e-12);
    // Before the first depth, behind the observer, and beyond the last depth.
    assert_eq!(end(&[sphere(0.5, 0.4), sphere(-9.0, 2.0), sphere(200.0, 9.0)]).0, Region::Sky);
    // Around the first depth.
    assert_eq!(end(&[sphere(1.5, 1.0)]), (Region::Body(0), 1.0));
}

#[test]
fn the_line_through_a_position_contains_it() {
    let depth = Depth::new([-5.0, 100.0], 1.0, true).unwrap();
    let direction = [0.6, 0.8, 0.0];
    let parallel = Observer::Parallel { plane_point: [1.0, 2.0, 3.0], direction };
    let [point, parallel] = [surroundings(None, vec![]), Surroundings::new(parallel, depth)];
    let position = [4.0, -7.0, 2.5];
    for around in [&point, &parallel] {
        let line = around.line_to(position).unwrap();
        let distance = dot(difference(position, line.origin), line.direction);
        let beside = difference(position, line.at(distance));
        assert!(dot(beside, beside) < 1e-24, "{line:?}");
        let sample = line.sample(distance, 0.25);
        assert!((0..3).all(|i| (sample.direction[i] + line.direction[i]).abs() < 1e-15));
        assert!((sample.path_per_depth - 0.25).abs() < 1e-15);
    }
    assert_eq!(point.line_to([0.0; 3]), None);
    // Parallel lines begin on the plane.
    let line = parallel.line_to(position).unwrap();
    assert!(dot(difference(line.origin, [1.0, 2.0, 3.0]), direction).abs() < 1e-14);
}

#[test]
#[expect(clippy::float_cmp, reason = "what is outside stays where it is")]
fn positions_are_outside_of_all_bodies() {
    let around = surroundings(None, vec![sphere(20.0, 3.0), sphere(40.0, 3.0)]);
    assert_eq!(around.outside([30.0, 1.0, 2.0]), [30.0, 1.0, 2.0]);
    for x in [19.0, 41.0] {
        let moved = around.outside([x, 1.0, 0.0]);
        assert!(around.bodies.iter().all(|body| !body.contains(moved)), "{moved:?}");
        let from_centre = difference(moved, [if x < 30.0 { 20.0 } else { 40.0 }, 0.0, 0.0]);
        assert!((dot(from_centre, from_centre) - 9.0).abs() < 1e-9, "{moved:?}");
    }
}

#[test]
fn a_polynomial_of_degree_9_along_a_line_continues_through_another_body() {
    let around = surroundings(None, vec![sphere(20.0, 3.0), sphere(40.0, 3.0)]);
    let line = around.line([0.0; 3], ALONG_X);
    let coefficients = [1.0, -2.0, 0.5, 1.5, -0.7, 0.2, -0.4, 0.9, -1.1, 0.6];
    let polynomial = |s: f64| {
        let x = s / 20.0 - 1.0;
        coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
    };
    for distance in [17.2, 18.5, 20.0, 22.9] {
        let gap = around.gap(&line, [1.0, 36.0], distance, Some(1)).unwrap();
        for at in gap.distances {
            assert!(at > 1.0 && at < 36.0 && !(at > 17.0 + 1e-9 && at < 23.0 - 1e-9), "{at}");
        }
        let sum: f64 = gap.distances.iter().zip(gap.weights).map(|(s, w)| w * polynomial(*s)).sum();
        assert!((sum - polynomial(distance)).abs() < 1e-11, "{distance}: {sum}");
    }
    // Outside of bodies, inside of the own one, and without room on one side.
    for (ends, distance, own) in [
        ([1.0, 36.0], 16.9, None),
        ([1.0, 36.0], 23.1, None),
        ([1.0, 36.0], 20.0, Some(0)),
        ([17.5, 36.0], 20.0, None),
        ([1.0, 22.5], 20.0, None),
        // With so little room rounding would be multiplied with large weights.
        ([16.9, 36.0], 20.0, None),
    ] {
        assert!(around.gap(&line, ends, distance, own).is_none(), "{ends:?} {distance} {own:?}");
    }
    // Little room moves the points closer to the body.
    let gap = around.gap(&line, [15.6, 36.0], 20.0, None).unwrap();
    assert!(gap.distances[0] > 15.6 && gap.distances[1] > gap.distances[0]);
    let sum_of_weights: f64 = gap.weights.iter().map(|weight| weight.abs()).sum();
    assert!(sum_of_weights < 2_000.0, "{sum_of_weights}");
}

#[test]
fn bodies_that_are_close_on_a_line_are_one_gap() {
    let found =
        |crossings: &[[f64; 2]], distance: f64| gap_around(distance, &|| crossings.iter().copied());
    // Between the small body and the large one there is room for points beside the small one only.
    let near = [[10.0, 20.0], [23.0, 24.0], [40.0, 41.0]];
    for distance in [10.1, 15.0, 19.9, 21.0, 23.5] {
        assert_eq!(found(&near, distance), Some([10.0, 24.0]), "{distance}");
    }
    for distance in [9.9, 24.1, 39.9, 41.1] {
        assert_eq!(found(&near, distance), None, "{distance}");
    }
    assert_eq!(found(&near, 40.5), Some([40.0, 41.0]));
    // Together two are large enough to be near a third.
    let chain = [[0.0, 10.0], [14.0, 16.0], [23.0, 25.0]];
    assert_eq!(found(&chain, 24.0), Some([0.0, 25.0]));
    assert_eq!(found(&chain[1..], 24.0), Some([23.0, 25.0]));
    assert_eq!(found(&[], 1.0), None);
}

#[test]
fn no_point_of_a_gap_is_inside_a_body() {
    // The first two overlap, the third is close to them, and the next one is not.
    let spheres = [(20.0, 3.0), (23.5, 1.0), (27.0, 1.5), (50.0, 4.0), (60.0, 0.5), (90.0, 3.0)];
    let bodies: Vec<Ellipsoid> = spheres.iter().map(|&(x, radius)| sphere(x, radius)).collect();
    let around = surroundings(None, bodies);
    let ends = [1.0, 87.0];
    let mut gaps = 0;
    for tilt in [0.0, 0.01, 0.03, 0.06] {
        let line = around.line([0.0; 3], [f64::cos(tilt), f64::sin(tilt), 0.0]);
        for k in 0..500 {
            let distance = 1.0 + 86.0 * (f64::from(k) + 0.5) / 500.0;
            let Some(gap) = around.gap(&line, ends, distance, Some(5)) else {
                assert!(around.bodies[..5].iter().all(|body| !body.contains(line.at(distance))));
                continue;
            };
            gaps += 1;
            for at in gap.distances {
                let is_inside = around.bodies[..5].iter().any(|body| body.contains(line.at(at)));
                assert!(at > ends[0] && at < ends[1] && !is_inside, "{tilt} {distance}: {gap:?}");
            }
        }
    }
    assert!(gaps > 200, "{gaps}");
}

#[test]
fn a_body_behind_the_end_of_a_line_is_no_part_of_a_gap() {
    let around = surroundings(None, vec![sphere(20.0, 3.0), sphere(25.0, 0.5), sphere(27.5, 1.0)]);
    let line = around.line([0.0; 3], ALONG_X);
    let gap = around.gap(&line, [1.0, 24.5], 20.0, Some(1)).unwrap();
    assert!(gap.distances.iter().all(|at| *at < 24.5), "{gap:?}");
}
