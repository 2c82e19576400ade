//! Lines that are compared with a tree that is exact, or wrong at a given place.

use crate::vol::dyadic::{Place, STEPS, from_unit, spacing, unit};
use crate::vol::image::tree::level_of_place;
use crate::vol::lattice::point;
use crate::vol::line::node_lines::base_depths;
use crate::vol::testing::{
    PANE, Pane, answered, assert_close, at, fill, lattice, meter, sheet, uniform,
};
use crate::vol::tuning::TUNING;
use crate::vol::view::verification_lines::FIRST_LINE;
use std::borrow::Cow;
use std::sync::Arc;

const SHAPE: [usize; 2] = [16, 16];

/// A function that the tree has exactly.
fn plane([x, y, z]: [f64; 3]) -> f64 {
    1.0 + 2.0 * x - y + z
}

fn of_plane(place: Place) -> f64 {
    let [x, y] = place.map(unit);
    1.5 + 2.0 * x - y
}

#[test]
fn scattered_lines_differ_each_time_and_every_third_is_dense() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
    let mut lines = sheet.scattered_lines(4);
    lines.extend(sheet.scattered_lines(5));
    let usual = 3 + TUNING.verification.extra_depth_levels;
    for (k, (place, depths)) in lines.iter().enumerate() {
        let [x, y, _] = point(FIRST_LINE + k);
        assert_eq!(*place, [x, y].map(from_unit));
        let dense = if k % 3 == 0 { TUNING.verification.dense_extra_levels } else { 0 };
        assert_eq!(*depths, base_depths(usual + dense));
    }
}

#[test]
fn the_worst_lines_are_in_the_worst_pixels_far_from_each_other() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
    let [mut one, mut other] = [uniform(SHAPE, 1.0), uniform(SHAPE, 1.0)];
    // Two pixels beside each other, one elsewhere in another bin, and one out of view.
    (one[(4, 4)], one[(4, 5)], other[(9, 2)], one[(15, 15)]) = (7.0, 6.0, 5.0, 9.0);
    let mut scale = uniform(SHAPE, 1.0);
    scale[(15, 15)] = 0.0;
    sheet.scale = Arc::new(scale);
    sheet.weighted_scale = sheet.scale.clone();
    let lines = sheet.worst_lines(&[Cow::Borrowed(&one), Cow::Borrowed(&other)], 3);
    let places: Vec<Place> = lines.iter().map(|(place, _)| *place).collect();
    assert_eq!(places[..2], [at(5, 9, 9), at(5, 5, 19)]);
    // Of equals the first that is far enough from both.
    assert_eq!(places[2], at(5, 1, 1));
    assert!(lines.iter().all(|line| line.1 == base_depths(4)));
}

#[test]
fn the_level_around_a_place_is_of_the_finest_cell_with_nodes_at_all_corners() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
    fill(&mut sheet, &lattice(3), plane);
    let middle = at(5, 9, 21);
    assert_eq!(sheet.level_around(middle), 3);
    fill(&mut sheet, &[at(4, 4, 11), at(4, 5, 10)], plane);
    assert_eq!(sheet.level_around(middle), 3);
    fill(&mut sheet, &[at(4, 5, 11)], plane);
    assert_eq!([middle, at(5, 11, 21)].map(|place| sheet.level_around(place)), [4, 3]);
    assert_eq!(sheet.level_around([STEPS, STEPS]), 3);
    fill(&mut sheet, &[at(4, 15, 15), at(4, 15, 16), at(4, 16, 15)], plane);
    assert_eq!(sheet.level_around([STEPS, STEPS]), 4);
}

#[test]
fn new_lines_agree_with_a_tree_that_is_exact() {
    let meter = meter(100_000);
    let pane = Pane { density: |_| 2.0, ..PANE };
    let mut sheet = sheet(&meter, &pane, 3, SHAPE);
    fill(&mut sheet, &lattice(3), plane);
    let (node, new) = (at(3, 2, 2), at(6, 11, 7));
    let lines = [node, new, new, at(6, 50, 9)].map(|place| (place, base_depths(4)));
    answered(&meter, |at, _| plane(at), sheet.verify_lines(lines.to_vec(), 1e-6)).unwrap();
    // Neither nodes nor lines are compared twice.
    let places: Vec<Place> =
        sheet.verification.places.nodes().iter().map(|node| node.place).collect();
    assert_eq!(places, [new, at(6, 50, 9)]);
    assert_eq!(meter.evaluations(), 2 * 17);
    for difference in sheet.differences(0, &[], &[]) {
        assert_close(difference, 0.0, 1e-13);
    }
    assert!(!sheet.is_changed_by_depths(0, 1e-12));
}

#[test]
fn a_line_through_a_bump_differs_by_its_part_of_a_pixel() {
    let (meter, place) = (meter(100_000), at(6, 11, 7));
    let [x, y] = place.map(unit);
    let bumpy = |[a, b, z]: [f64; 3]| {
        let square = (a - x).powi(2) + (b - y).powi(2);
        plane([a, b, z]) + 0.5 * (-square / 1e-5).exp()
    };
    // Nodes are closer than pixels are wide along x, and half as far apart as they are high.
    for (shape, share) in [([16, 16], 1.0), ([4, 16], 0.5), ([2, 4], 0.125)] {
        let pane = Pane { density: |_| 2.0, ..PANE };
        let mut sheet = sheet(&meter, &pane, 3, shape);
        sheet.scale = Arc::new(uniform(shape, 3.0));
        sheet.weighted_scale = sheet.scale.clone();
        fill(&mut sheet, &lattice(3), plane);
        let lines = vec![(at(6, 50, 9), vec![]), (place, base_depths(4))];
        answered(&meter, |at, _| bumpy(at), sheet.verify_lines(lines, 1e-6)).unwrap();
        let differences = sheet.differences(0, &[], &[]);
        assert_close(differences[0], 0.0, 1e-12);
        assert_close(differences[1], 2.0 * 0.5 * share * 3.0, 1e-12);
        assert_eq!(sheet.differences(1, &[], &[]), differences[1..]);
    }
}

#[test]
fn what_earlier_energies_explain_is_no_difference() {
    let meter = meter(100_000);
    let mut sheets = [(); 2].map(|()| sheet(&meter, &PANE, 3, SHAPE));
    fill(&mut sheets[0], &lattice(3), |[x, y, _]| x * y);
    let [earlier, last] = &mut sheets;
    last.scan.add(&lattice(3));
    last.scan.node_lines = crate::vol::testing::lines_of(&last.scan.tree, 3, plane);
    last.set_values(&[earlier], &[0.5]);
    let lines = vec![(at(6, 11, 7), base_depths(4))];
    answered(&meter, |at, _| plane(at), last.verify_lines(lines, 1e-6)).unwrap();
    assert_close(last.differences(0, &[earlier], &[0.5])[0], 0.0, 1e-13);
    assert_close(last.differences(0, &[], &[])[0], 0.5 * 77.0 / 4096.0, 1e-13);
}

/// A thin emitting sheet between the depths of the base, which finer depths detect in part.
fn thin([_, _, z]: [f64; 3]) -> f64 {
    (-((z - 0.4375) / 0.02).powi(2)).exp()
}

#[test]
fn depths_that_nodes_step_over_are_found() {
    let meter = meter(100_000);
    let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
    fill(&mut sheet, &lattice(3), |_| 0.0);
    let lines = vec![(at(6, 11, 7), base_depths(4))];
    answered(&meter, |at, _| thin(at), sheet.verify_lines(lines, 1e-5)).unwrap();
    let integral = 0.02 * core::f64::consts::PI.sqrt();
    assert_close(sheet.differences(0, &[], &[])[0], integral, 1e-4);
    assert!(sheet.is_changed_by_depths(0, 0.9 * integral));
    assert!(!sheet.is_changed_by_depths(0, 1.1 * integral));
    assert!(!sheet.is_changed_by_depths(1, 0.9 * integral), "it was in an earlier verification");
    let depths = sheet.verification.significant_depths(0, 1e-3);
    assert!(depths.contains(&from_unit(0.4375)) && !depths.contains(&0));
}

#[test]
fn lines_beyond_the_budget_are_removed() {
    let meter = meter(16);
    let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
    fill(&mut sheet, &lattice(3), plane);
    let lines = vec![(at(6, 11, 7), base_depths(4))];
    assert!(answered(&meter, |at, _| plane(at), sheet.verify_lines(lines, 1e-6)).is_err());
    assert_eq!(sheet.verification.places.len(), 0);
    assert!(sheet.differences(0, &[], &[]).is_empty());
}

#[test]
fn beside_a_line_are_four_at_half_the_distance_of_the_nodes() {
    let meter = meter(100_000);
    let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
    fill(&mut sheet, &lattice(3), plane);
    let lines = [at(6, 11, 7), at(6, 2, 30)].map(|place| (place, vec![]));
    answered(&meter, |at, _| plane(at), sheet.verify_lines(lines.to_vec(), 1e-6)).unwrap();
    let places = |line: usize| {
        let mut places: Vec<Place> =
            sheet.beside(line).into_iter().map(|(place, _)| place).collect();
        places.sort_unstable();
        places
    };
    assert_eq!(places(0), [at(6, 7, 7), at(6, 11, 3), at(6, 11, 11), at(6, 15, 7)]);
    assert_eq!(places(1), [at(6, 2, 26), at(6, 2, 34), at(6, 6, 30)]);
    assert!(sheet.beside(0).iter().all(|line| line.1 == base_depths(4)));
}

#[test]
fn the_nodes_within_a_spacing_are_sampled_at_the_given_depths() {
    let meter = meter(100_000);
    let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
    fill(&mut sheet, &lattice(3), plane);
    let (place, depths) = (at(6, 11, 23), [3 * spacing(9)]);
    let task = sheet.scan.sample_around(place, 3, &depths, 1e-6);
    answered(&meter, |at, _| plane(at), task).unwrap();
    for (i, node) in sheet.scan.tree.nodes().iter().enumerate() {
        let is_near = (0..2).all(|k| node.place[k].abs_diff(place[k]) <= spacing(3));
        assert_eq!(sheet.scan.node_lines.lines[i].has(depths[0]), is_near);
        assert_close(sheet.scan.node_lines.lines[i].integral, of_plane(node.place), 1e-12);
    }
    assert_eq!(meter.evaluations(), 4);
    assert_eq!(level_of_place(place), 6);
}
