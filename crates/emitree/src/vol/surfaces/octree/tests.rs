//! Cells at points, and the regions beside several patches.

use super::*;
use crate::vol::surfaces::patch::{FitPoint, Patch};

const GRID: Grid = Grid { edges: [0.5, 0.5, 1.0], base: [2, 2, 4], finest: 3 };

/// A plane at `at` across an axis, towards its higher end.
fn plane(axis: usize, at: f64, [below, above]: [Label; 2]) -> Facet {
    let others = [(axis + 1) % 3, (axis + 2) % 3];
    let points: Vec<FitPoint> = (0..9)
        .map(|k| {
            let mut place = [0.1; 3];
            place[axis] = at;
            place[others[0]] += 0.1 * f64::from(k % 3);
            place[others[1]] += 0.1 * f64::from(k / 3);
            FitPoint { at: place, axis, is_upward: true, distance: 0.01 * f64::from(k) }
        })
        .collect();
    let mut normal = [0.0; 3];
    normal[axis] = 1.0;
    let (patch, error) = Patch::fit(&points, [0.2; 3], normal, 0.2, 0.0).unwrap();
    Facet { wall: patch.into(), below, above, error, allowed: 0.01, jump: 1.0 }
}

#[test]
fn leaves_are_found_at_points_on_all_levels() {
    let mut leaves = Vec::new();
    for x in 0..2 {
        for y in 0..2 {
            for z in 0..4 {
                if [x, y, z] != [1, 0, 2] {
                    leaves.push(((0, [x, y, z]), Leaf::Uncut(0)));
                }
            }
        }
    }
    for c in 0..8 {
        let at = [2 + (c & 1), (c >> 1) & 1, 4 + (c >> 2)];
        leaves.push(((1, at), Leaf::Uncut(1)));
    }
    let tree = Octree::new(GRID, leaves);
    for (number, (cell, _)) in tree.leaves.iter().enumerate() {
        assert_eq!(tree.find(GRID.centre(*cell)), number);
        assert_eq!(GRID.cell_at(cell.0, GRID.centre(*cell)), cell.1);
        let [low, high] = tree.ends(number, 2);
        assert!(low < GRID.centre(*cell)[2] && GRID.centre(*cell)[2] < high);
    }
    assert_eq!(tree.leaf([0.3, 0.1, 0.6]).region([0.3, 0.1, 0.6]), 1);
    assert_eq!(tree.find(GRID.edges), tree.find([0.49, 0.49, 0.99]));
}

#[test]
fn the_side_of_a_patch_is_the_region() {
    let leaf = Leaf::Cut(vec![plane(2, 0.2, [3, 5])]);
    assert_eq!(leaf.region([0.1, 0.1, 0.19]), 3);
    assert_eq!(leaf.region([0.1, 0.1, 0.21]), 5);
    assert!((leaf.clearance([0.1, 0.1, 0.25]) - 5.0).abs() < 1e-6);
    assert!(Leaf::Uncut(2).clearance([0.0; 3]).is_infinite());
}

#[test]
fn two_patches_that_cross_separate_four_regions() {
    // Region 3 is where both bodies are.
    let facets = [
        plane(0, 0.2, [0, 1]),
        plane(0, 0.2, [2, 3]),
        plane(1, 0.2, [0, 2]),
        plane(1, 0.2, [1, 3]),
    ];
    for (at, expected) in
        [([0.1, 0.1], 0), ([0.3, 0.1], 1), ([0.1, 0.3], 2), ([0.3, 0.3], 3), ([0.21, 0.35], 3)]
    {
        let (label, distance) = region(&facets, [at[0], at[1], 0.3]);
        assert_eq!(label, expected, "{at:?}");
        assert!(distance > 0.0);
    }
}

/// Without the patches between the two pairs, each place is in a region of both.
#[test]
fn pairs_of_regions_without_patches_between_them_are_ambiguous() {
    let all = [
        plane(0, 0.2, [0, 1]),
        plane(0, 0.2, [2, 3]),
        plane(1, 0.2, [0, 2]),
        plane(1, 0.2, [1, 3]),
    ];
    for at in [[0.1, 0.1, 0.3], [0.3, 0.1, 0.3], [0.25, 0.35, 0.1]] {
        assert!(!is_ambiguous(&all, at), "{at:?}");
        assert!(is_ambiguous(&all[..2], at), "{at:?}");
    }
}

#[test]
fn the_least_jump_is_that_at_the_borders_of_a_region() {
    let mut facets = vec![plane(0, 0.2, [0, 1]), plane(1, 0.2, [0, 2])];
    facets[1].jump = 0.25;
    let leaf = Leaf::Cut(facets);
    for (label, expected) in [(0, 0.25), (1, 1.0), (2, 0.25)] {
        assert!((leaf.least_jump(label) - expected).abs() < 1e-12, "{label}");
    }
    assert!(leaf.least_jump(3).is_infinite());
}

/// Beyond the nearest wall may be another region than the one asked for.
#[test]
fn the_distance_to_a_region_is_that_from_its_own_walls() {
    let leaf = Leaf::Cut(vec![plane(2, 0.2, [1, 5]), plane(2, 0.3, [5, 2])]);
    let at = [0.1, 0.1, 0.32];
    assert_eq!(leaf.region(at), 2);
    assert!((leaf.clearance(at) - 2.0).abs() < 1e-6);
    assert!((leaf.distance_to(5, at) - 2.0).abs() < 1e-6);
    assert!((leaf.distance_to(1, at) - 12.0).abs() < 1e-6);
    assert!(leaf.distance_to(4, at).is_infinite());
    assert!(Leaf::Uncut(2).distance_to(1, at).is_infinite());
}
