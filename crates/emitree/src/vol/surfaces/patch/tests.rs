//! Fits to spheres and to points of several walls.

use super::*;

const CENTRE: [f64; 3] = [0.4, 0.5, 0.6];
const RADIUS: f64 = 0.3;

/// Points of a sphere around a cell of a size whose centre is above the pole along z.
fn points(cell: [f64; 3], size: f64) -> Vec<FitPoint> {
    let reach = 2.6 * size;
    let mut points = Vec::new();
    for k in 0..120_u32 {
        let turn = 2.4 * f64::from(k);
        let distance = reach * (f64::from(k) / 120.0).sqrt();
        let [x, y] = [cell[0] + distance * turn.cos(), cell[1] + distance * turn.sin()];
        let square = RADIUS * RADIUS - (x - CENTRE[0]).powi(2) - (y - CENTRE[1]).powi(2);
        let at = [x, y, CENTRE[2] + square.sqrt()];
        let distance = norm(difference(at, cell));
        points.push(FitPoint { at, axis: 2, is_upward: true, distance });
    }
    points.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    points.truncate(60);
    points
}

/// The largest distance of a fitted patch from the sphere inside its cell, with its error.
fn worst(size: f64) -> (f64, f64) {
    let cell = [CENTRE[0] + 0.05, CENTRE[1] - 0.03, CENTRE[2] + 0.29];
    let normal = unit(difference(cell, CENTRE)).unwrap();
    let (patch, error) = Patch::fit(&points(cell, size), cell, normal, size, 0.0).unwrap();
    let mut worst: f64 = 0.0;
    for k in 0..25 {
        let step = |k: usize| (k as f64 / 4.0 - 0.5) * size;
        let foot = patch.foot([cell[0] + step(k % 5), cell[1] + step(k / 5), cell[2]]);
        worst = worst.max((norm(difference(foot, CENTRE)) - RADIUS).abs());
    }
    (worst, error)
}

#[test]
fn patches_of_a_sphere_converge_with_order_five() {
    let [coarse, fine] = [0.06, 0.03].map(worst);
    let order = (coarse.0 / fine.0).log2();
    assert!(order > 4.0, "{order}: {coarse:?} {fine:?}");
    assert!(coarse.0 < 2e-4 && fine.0 < 1e-5, "{coarse:?} {fine:?}");
    for (worst, error) in [coarse, fine] {
        assert!(worst < 3.0 * error && error < 100.0 * worst, "{worst} {error}");
    }
}

#[test]
fn heights_normals_and_curvatures_are_those_of_the_sphere() {
    let cell = [CENTRE[0], CENTRE[1], CENTRE[2] + RADIUS];
    let (patch, _) = Patch::fit(&points(cell, 0.04), cell, [0.0, 0.0, 1.0], 0.04, 0.0).unwrap();
    let above = [cell[0], cell[1], cell[2] + 0.01];
    assert!((patch.above(above) - 0.01).abs() < 1e-6);
    let normal = patch.normal([cell[0] + 0.03, cell[1], cell[2]]);
    assert!((normal[0] - 0.03 / RADIUS).abs() < 1e-3, "{normal:?}");
    assert!((patch.curvature() * RADIUS - 1.0).abs() < 0.02, "{}", patch.curvature());
}

#[test]
fn points_of_an_opposite_wall_are_left_out() {
    let cell = [CENTRE[0], CENTRE[1], CENTRE[2] + RADIUS];
    let mut both = points(cell, 0.04);
    let other = both.clone().into_iter().map(|point| {
        let at = [point.at[0], point.at[1], point.at[2] - 0.03];
        FitPoint { at, is_upward: false, ..point }
    });
    both.extend(other.collect::<Vec<_>>());
    let (patch, error) = Patch::fit(&both, cell, [0.0, 0.0, 1.0], 0.04, 0.0).unwrap();
    assert!(patch.above(cell).abs() < 1e-5 && error < 1e-4, "{error}");
}

#[test]
fn too_few_points_give_no_patch() {
    let cell = [CENTRE[0], CENTRE[1], CENTRE[2] + RADIUS];
    assert_eq!(Patch::fit(&points(cell, 0.04)[..2], cell, [0.0, 0.0, 1.0], 0.04, 0.0), None);
}
