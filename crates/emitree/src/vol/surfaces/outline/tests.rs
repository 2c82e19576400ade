//! The places of samples, and boxes with few of them.

use super::*;
use crate::vol::lowrank::WeightedView;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::octree::{Facet, Grid};
use crate::vol::surfaces::patch::{FitPoint, Patch};
use crate::vol::surfaces::samples::Samples;
use crate::vol::testing::{PANE, meter, part_of, uniform};

/// A sliver of a region, one in a hundred of its places, is far from the samples of the rest of it.
#[test]
fn the_places_that_count_are_those_far_from_samples() {
    let edges = [1.0, 0.5, 2.0];
    let at = |u: [f64; 3]| along_each([0.0; 3], u, edges);
    let samples: Vec<[f64; 3]> =
        (0..60).map(lattice::point).map(|[x, y, z]| at([0.5 * x, y, z])).collect();
    let sliver = |k: usize| k % 100 == 99;
    let places = (0..400).map(|k| {
        let [x, y, z] = lattice::point(1000 + k);
        at(if sliver(k) { [0.95 + 0.05 * x, 0.1 * y, z] } else { [0.5 * x, y, z] })
    });
    let found = furthest(places.collect(), &samples, edges);
    assert_eq!(found.len(), PLACES);
    assert!(found[..4].iter().all(|[x, _, _]| *x > 0.9), "{found:?}");
    assert!(found[4..].iter().all(|[x, _, _]| *x <= 0.5), "{found:?}");
}

/// The outline of a box that is the whole cube: of the region in it, which is below a plane at `height`, samples are
/// known below `known`. Surfaces may be displaced by 0.05.
fn outline_of(height: f64, known: f64) -> Outline {
    let meter = meter(0);
    let part = part_of(PANE);
    let view = WeightedView::new(&meter, &part, 1);
    let scale = uniform([4, 4], 1.0);
    let aim = Aim { target: 0.01, scale: &scale, visible: None, sky: None, plane: None };
    let grid = Grid { edges: [1.0; 3], base: [1; 3], finest: 0 };
    let rate = |[x, y, z]: [f64; 3]| 1.0 + x + y * y + z;
    let mut samples = Samples::new(0.25, 1e-4);
    let label = samples.new_label();
    for k in 0..60 {
        let [x, y, z] = lattice::point(k);
        let at = [0.2 * x, 0.2 * y, known * z];
        samples.add(at, rate(at), label);
    }
    let search = Search::new(&view, grid, aim, 0.01, samples, 0);
    let points: Vec<FitPoint> = (0..9)
        .map(|k| {
            let at = [0.25 + 0.25 * f64::from(k % 3), 0.25 + 0.25 * f64::from(k / 3), height];
            FitPoint { at, axis: 2, is_upward: true, distance: 0.01 * f64::from(k) }
        })
        .collect();
    let (patch, error) = Patch::fit(&points, [0.5; 3], [0.0, 0.0, 1.0], 0.5, 0.0).unwrap();
    let facet =
        Facet { wall: patch.into(), below: label, above: 7, error, allowed: 0.05, jump: 1.0 };
    let tree = Octree::new(grid, vec![((0, [0; 3]), Leaf::Cut(vec![facet]))]);
    let all = (0..60).collect();
    let (low, high) = ([0.0; 3], [1.0; 3]);
    let whole = OpenBox { node: 0, low, high, level: 0, samples: all, leaves: vec![0] };
    search.outline(&tree, label, whole).1
}

/// Only a slice of the region, 0.002 thick, is further than three displacements from its surface.
#[test]
fn a_box_with_few_places_for_samples_is_continued_from_those_around() {
    let Outline::Continued(found) = outline_of(0.152, 0.01) else { panic!("it has its own") };
    assert!(!found.checks.is_empty());
}

#[test]
fn a_box_with_places_for_samples_has_its_own_and_checks() {
    let Outline::Samples(plan) = outline_of(0.6, 0.3) else { panic!("it is continued") };
    assert_eq!(plan.checks.len(), TUNING.surfaces.piece_checks);
    assert!(!plan.new.is_empty());
}
