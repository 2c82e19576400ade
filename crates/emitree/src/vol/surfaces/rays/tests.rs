//! Lines through cells with planes.

use super::*;
use crate::vol::surfaces::octree::{Grid, Leaf};
use crate::vol::surfaces::patch::{FitPoint, Patch};

/// A plane z = 0.3 + 0.1 x between regions 0 and 1.
fn tree() -> Octree {
    let grid = Grid { edges: [1.0; 3], base: [1; 3], finest: 2 };
    let height = |x: f64| 0.3 + 0.1 * x;
    let point = |k: u32| {
        let [x, y] = [f64::from(k % 4) / 3.0, f64::from(k / 4) / 3.0];
        FitPoint { at: [x, y, height(x)], axis: 2, is_upward: true, distance: 0.01 * f64::from(k) }
    };
    let points: Vec<FitPoint> = (0..16).map(point).collect();
    let (patch, _) = Patch::fit(&points, [0.5, 0.5, 0.35], [0.0, 0.0, 1.0], 0.5, 0.0).unwrap();
    let facet =
        Facet { wall: patch.into(), below: 0, above: 1, error: 1e-3, allowed: 2e-3, jump: 3.0 };
    Octree::new(grid, vec![((0, [0; 3]), Leaf::Cut(vec![facet]))])
}

#[test]
fn segments_end_at_the_surface() {
    let tree = tree();
    let ray = Ray::new(&tree, [0.7, 0.2], [0.0, 1.0]);
    let [first, second] = ray.segments[..] else { panic!("{ray:?}") };
    assert_eq!((first.label, second.label), (0, 1));
    assert!((first.ends[1] - 0.37).abs() < 1e-9 && (second.ends[1] - 1.0).abs() < 1e-12);
}

#[test]
fn the_error_of_a_crossing_is_its_displacement_times_the_jump() {
    let tree = tree();
    let ray = Ray::new(&tree, [0.7, 0.2], [0.0, 1.0]);
    let slope = 1.0 / 1.01_f64.sqrt();
    let expected = TUNING.surfaces.smooth_margin * 3.0 * 2e-3 / slope;
    let [[z, error, along]] = ray.crossings[..] else { panic!("{ray:?}") };
    assert!((z - 0.37).abs() < 1e-9 && (along - 2e-3 / slope).abs() < 1e-9);
    assert!((error - expected).abs() < 1e-9);
    assert!((ray.error_of_surfaces() - expected).abs() < 1e-9);
}

#[test]
fn an_unresolved_cell_is_wrong_by_half_of_its_jump() {
    let grid = Grid { edges: [1.0; 3], base: [1; 3], finest: 2 };
    let tree = Octree::new(grid, vec![((0, [0; 3]), Leaf::Unresolved(0, 2.0))]);
    let ray = Ray::new(&tree, [0.5; 2], [0.0, 1.0]);
    assert_eq!(ray.unresolved_leaves, [0]);
    assert!((ray.error_of_surfaces() - 1.0).abs() < 1e-12);
}
