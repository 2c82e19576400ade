//! Walls of several patches: edges, corners, sheets, and what passes beside a cell.

use super::*;
use crate::projection::vector::{difference, norm};

const SIZE: f64 = 0.1;
const CELL: [f64; 3] = [0.45, 0.45, 0.45];

/// Points on all edges of a lattice where a function changes its sign, as they are found in cells:
/// above is where it is positive.
fn points(height: impl Fn([f64; 3]) -> f64, reach: f64) -> Vec<FitPoint> {
    let mut found = Vec::new();
    for number in 0..3 * 20_usize.pow(3) {
        let (axis, k) = (number % 3, number / 3);
        let from = [k % 20, k / 20 % 20, k / 400].map(|k| k as f64 * SIZE - 0.6);
        let end = |share: f64| {
            let mut at = from;
            at[axis] += share * SIZE;
            at
        };
        let is_above = [0.0, 1.0].map(|share| height(end(share)) > 0.0);
        if is_above[0] == is_above[1] {
            continue;
        }
        let [mut low, mut high] = [0.0, 1.0];
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if (height(end(middle)) > 0.0) == is_above[0] { low = middle } else { high = middle }
        }
        let distance = norm(difference(end(low), CELL));
        if distance <= reach * SIZE {
            found.push(FitPoint { at: end(low), axis, is_upward: is_above[1], distance });
        }
    }
    found.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    found
}

/// The largest difference of sides in the cell, as the |height| at points that are on the wrong side.
fn worst(wall: &Wall, height: impl Fn([f64; 3]) -> f64) -> f64 {
    let place = |k: usize| (k as f64 + 0.5) / 12.0 - 0.5;
    let at = |k: usize| {
        let steps = [k % 12, k / 12 % 12, k / 144].map(place);
        core::array::from_fn(|axis| CELL[axis] + SIZE * steps[axis])
    };
    let wrong = |at: [f64; 3]| {
        if (wall.above(at) > 0.0) == (height(at) > 0.0) { 0.0 } else { height(at).abs() }
    };
    (0..12 * 12 * 12).map(|k| wrong(at(k))).fold(0.0, f64::max)
}

/// Heights above the faces of a rotated box whose edge or corner is near the centre of the cell.
fn faces(at: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = difference(at, [0.44, 0.46, 0.45]);
    [0.36 * x + 0.48 * y - 0.8 * z, -0.8 * x + 0.6 * y, 0.48 * x + 0.64 * y + 0.6 * z]
}

#[test]
fn an_edge_is_two_patches_whichever_side_is_convex() {
    for sign in [1.0, -1.0] {
        let height = |at| sign * faces(at)[0].min(faces(at)[1]);
        let (wall, error) = Wall::fit(&points(height, 2.6), CELL, (SIZE, 1), 1e-3).unwrap();
        assert_eq!(wall.patches().len(), 2);
        assert!(error < 1e-6 && worst(&wall, height) < 1e-6, "{error} {}", worst(&wall, height));
    }
}

#[test]
fn a_corner_is_three_patches() {
    let height = |at| faces(at).into_iter().fold(f64::INFINITY, f64::min);
    let (wall, error) = Wall::fit(&points(height, 5.2), CELL, (SIZE, 2), 1e-3).unwrap();
    assert_eq!(wall.patches().len(), 3);
    assert!(error < 1e-6 && worst(&wall, height) < 1e-6, "{error} {}", worst(&wall, height));
}

#[test]
fn a_thin_sheet_is_two_patches_with_opposite_normals() {
    let height = |at: [f64; 3]| 0.3 * SIZE - faces(at)[2].abs();
    let (wall, error) = Wall::fit(&points(height, 2.6), CELL, (SIZE, 1), 1e-3).unwrap();
    let [a, b] = [0, 1].map(|k| wall.patches()[k].axis());
    assert!((0..3).all(|k| (a[k] + b[k]).abs() < 1e-3));
    assert!(error < 1e-6 && worst(&wall, height) < 1e-6, "{error} {}", worst(&wall, height));
}

#[test]
fn a_wall_beside_the_cell_is_left_out() {
    // A second edge 1.5 cells away, with another direction.
    let height = |at: [f64; 3]| {
        let [a, b, _] = faces(at);
        a.min(b).min(0.15 + 0.6 * (at[0] - CELL[0]) + 0.8 * (at[2] - CELL[2]))
    };
    let (wall, error) = Wall::fit(&points(height, 2.6), CELL, (SIZE, 1), 1e-3).unwrap();
    assert!(error < 1e-3 && worst(&wall, height) < 1e-3, "{error} {}", worst(&wall, height));
}

#[test]
fn too_few_points_give_no_wall() {
    let height = |at| faces(at)[0].min(faces(at)[1]);
    let few: Vec<FitPoint> = points(height, 2.6).into_iter().take(4).collect();
    assert_eq!(Wall::fit(&few, CELL, (SIZE, 1), 1e-3), None);
}

#[test]
fn the_edge_between_two_patches_is_where_both_surfaces_are() {
    // Two spheres that meet in a circle.
    let centres = [[0.9, 0.45, 0.45], [0.45, 0.9, 0.45]];
    let height = |k: usize, at: [f64; 3]| norm(difference(at, centres[k])) - 0.46;
    let patches = [0, 1].map(|k| {
        let normal = unit(difference(CELL, centres[k])).unwrap();
        let fit = Patch::fit(&points(|at| height(k, at), 1.8), CELL, normal, SIZE, 0.0);
        let (patch, error) = fit.unwrap();
        assert!(error < 1e-4, "{error}");
        patch
    });
    let wall = Wall { patches: patches.to_vec(), is_above_all: true };
    for from in [CELL, [0.47, 0.44, 0.48], [0.42, 0.42, 0.41]] {
        let (at, upward) = wall.edge((0, 1), from).unwrap();
        assert!(norm(difference(at, from)) < 0.05, "{at:?}");
        for k in [0, 1] {
            assert!(wall.patches[k].above(at).abs() < 1e-12);
            assert!(height(k, at).abs() < 5e-4, "{}", height(k, at));
            let step = 1e-3;
            let rise = (height(k, along(at, step, upward)) - height(k, at)) / step;
            assert!((rise - 1.0).abs() < 0.01, "{rise}");
        }
    }
}

#[test]
fn patches_that_are_parallel_have_no_edge() {
    let plane = |height: f64| {
        let at = |k: usize| [0.4 + 0.02 * (k % 5) as f64, 0.4 + 0.02 * (k / 5) as f64, height];
        let point = |k| FitPoint { at: at(k), axis: 2, is_upward: true, distance: 0.01 };
        let points: Vec<FitPoint> = (0..25).map(point).collect();
        Patch::fit(&points, CELL, [0.0, 0.0, 1.0], SIZE, 0.0).unwrap().0
    };
    let wall = Wall { patches: vec![plane(0.44), plane(0.46)], is_above_all: true };
    assert_eq!(wall.edge((0, 1), CELL), None);
}
