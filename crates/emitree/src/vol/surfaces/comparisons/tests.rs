//! Surfaces of neighbouring cells that are displaced from each other.

use super::*;
use crate::image::Image;
use crate::vol::surfaces::octree::Grid;
use crate::vol::surfaces::patch::{FitPoint, Patch};
use crate::vol::surfaces::wall::Wall;

/// The displacement allowed: far below the distance of the points of a face from each other.
const ALLOWED: f64 = 1e-3;

/// The plane z = 0.4 + 0.1 y + `by`, upwards or downwards.
fn plane(by: f64, is_upward: bool) -> Patch {
    let point = |k: u32| {
        let [x, y] = [f64::from(k % 4), f64::from(k / 4) / 3.0];
        let distance = 0.01 * f64::from(k);
        FitPoint { at: [x, y, 0.4 + 0.1 * y + by], axis: 2, is_upward, distance }
    };
    let points: Vec<FitPoint> = (0..16).map(point).collect();
    let normal = [0.0, 0.0, if is_upward { 1.0 } else { -1.0 }];
    Patch::fit(&points, [1.0, 0.5, 0.4], normal, 1.0, 0.0).unwrap().0
}

fn facet(wall: Wall, [below, above]: [Label; 2]) -> Facet {
    Facet { wall, below, above, error: 0.5 * ALLOWED, allowed: ALLOWED, jump: 1.0 }
}

/// Two cells beside each other.
fn cells(first: Vec<Facet>, second: Vec<Facet>) -> Octree {
    let grid = Grid { edges: [2.0, 1.0, 1.0], base: [2, 1, 1], finest: 3 };
    let cells = [first, second].into_iter().zip([0, 1]);
    let leaves = cells.map(|(facets, x)| ((0, [x, 0, 0]), Leaf::Cut(facets)));
    Octree::new(grid, leaves.collect())
}

/// What `compare` returns for a view without bodies.
fn with_aim<T>(compare: impl FnOnce(&Aim<'_>) -> T) -> T {
    let scale = Image::from_pixels(8, 8, vec![1.0; 64]);
    compare(&Aim { target: 1e-2, scale: &scale, visible: None, sky: None, plane: None })
}

/// What the first of two cells beside each other says of the second one.
fn found(first: Vec<Facet>, second: Vec<Facet>) -> Vec<Disagreement> {
    with_aim(|aim| comparison(&cells(first, second), aim, 0).found)
}

#[test]
fn smooth_surfaces_are_compared_in_the_middle_between_them() {
    for (by, is_found) in [(0.0, false), (1.5, false), (2.5, true), (5.0, true)] {
        for (is_upward, sides) in [(true, [0, 1]), (false, [1, 0])] {
            let second = facet(plane(by * ALLOWED, is_upward).into(), sides);
            let found = found(vec![facet(plane(0.0, true).into(), [0, 1])], vec![second]);
            assert_eq!(!found.is_empty(), is_found, "{by} {found:?}");
            for of in found {
                assert_eq!(of.labels, [1, 0]);
                assert!((of.clearance - 0.5 * by).abs() < 1e-2 * by, "{by} {of:?}");
                let height = of.at[2] - (0.4 + 0.1 * of.at[1]);
                assert!((height - 0.5 * by * ALLOWED).abs() < 1e-2 * by * ALLOWED, "{by} {of:?}");
            }
        }
    }
}

/// Three regions: a second surface passes far above the first.
#[test]
fn surfaces_of_several_patches_may_differ_by_more() {
    for (by, is_found) in [(2.5, false), (5.0, false), (7.0, true)] {
        let all = |by: f64| {
            let far = facet(plane(0.3, true).into(), [1, 2]);
            vec![facet(plane(by * ALLOWED, true).into(), [0, 1]), far]
        };
        let found = found(all(0.0), all(by));
        assert_eq!(!found.is_empty(), is_found, "{by} {found:?}");
    }
}

#[test]
fn surfaces_between_other_regions_are_not_compared() {
    let second = vec![facet(plane(2.5 * ALLOWED, true).into(), [0, 2])];
    let leaves = [vec![facet(plane(0.0, true).into(), [0, 1])], second].map(Leaf::Cut);
    assert!(middles([&leaves[0], &leaves[1]], [1.0, 0.5, 0.45], 0.2).is_empty());
}

/// A change of the second cell, too, changes what the first one says of it.
#[test]
fn comparisons_are_repeated_where_a_leaf_has_changed() {
    let tree = |by: f64| {
        let [first, second] = [0.0, by].map(|by| vec![facet(plane(by, true).into(), [0, 1])]);
        cells(first, second)
    };
    let places = |found: Vec<Disagreement>| -> Vec<([Cell; 2], [f64; 3])> {
        found.into_iter().map(|of| (of.leaves, of.at)).collect()
    };
    let mut last = Comparisons::default();
    let mut repeat = |by: f64| with_aim(|aim| places(last.repeat(&tree(by), aim)));
    for by in [0.0, 2.5, 2.5, 5.0, 0.0] {
        let by = by * ALLOWED;
        let anew = with_aim(|aim| places(Comparisons::default().repeat(&tree(by), aim)));
        assert_eq!(anew.is_empty(), by < ALLOWED);
        assert_eq!(repeat(by), anew, "{by}");
    }
}

#[test]
fn leaves_that_remain_are_not_compared_again() {
    let facets = |by: f64| vec![facet(plane(by, true).into(), [0, 1])];
    let tree = cells(facets(0.0), facets(5.0 * ALLOWED));
    with_aim(|aim| {
        let mut last = Comparisons::default();
        assert!(!last.repeat(&tree, aim).is_empty());
        last.all.values_mut().for_each(|of| of.found.clear());
        assert!(last.repeat(&tree, aim).is_empty());
    });
}
