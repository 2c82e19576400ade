//! The image of a sheet, on trees with polynomials for values.

use crate::image::Image;
use crate::vol::dyadic::{Place, STEPS, unit};
use crate::vol::image::block::Block;
use crate::vol::image::opening::ChoiceLimits;
use crate::vol::image::tree::level_of_place;
use crate::vol::line::node_lines::{LineSource, base_depths};
use crate::vol::sampling::Stop;
use crate::vol::testing::{
    PANE, Pane, answered, assert_close, at, fill, lattice, line_of, meter, sheet, uniform,
};
use crate::vol::tuning::TUNING;
use std::sync::Arc;

const SHAPE: [usize; 2] = [8, 16];

#[test]
fn the_base_has_all_depths_of_its_lattice_on_each_line() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 2, SHAPE);
    let wanted = sheet.add_base();
    let expected: Vec<_> = (0..25).map(|i| (i, base_depths(2))).collect();
    assert_eq!(wanted, expected);
    let mut places: Vec<Place> = sheet.scan.tree.nodes().iter().map(|node| node.place).collect();
    places.sort_unstable();
    assert_eq!(places, lattice(2));
    assert!((0..25).all(|i| sheet.scan.node_lines.is_full(i)));
}

#[test]
fn the_pieces_of_a_line_share_its_tolerance() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 2, SHAPE);
    (sheet.pieces_of_line, sheet.id.energy) = (4, 1);
    assert_close(sheet.line_tolerance(&[1.0, 0.2, 3.0]), 0.05, 1e-16);
}

#[test]
fn values_are_radiances_times_the_density_less_what_earlier_energies_explain() {
    let meter = meter(0);
    let pane = Pane { density: |[x, y]| 1.0 + 2.0 * x + y, ..PANE };
    let mut earlier = [(); 2].map(|()| sheet(&meter, &pane, 2, SHAPE));
    fill(&mut earlier[0], &lattice(2), |[x, ..]| x);
    fill(&mut earlier[1], &lattice(2), |[_, y, _]| y);
    let mut last = sheet(&meter, &pane, 2, SHAPE);
    fill(&mut last, &lattice(3), |[x, y, z]| 5.0 + x * y + 2.0 * z);
    last.set_values(&[&earlier[0], &earlier[1]], &[0.5, -3.0]);
    for node in last.scan.tree.nodes() {
        let [x, y] = node.place.map(unit);
        let expected = (1.0 + 2.0 * x + y) * (6.0 + x * y - 0.5 * x + 3.0 * y);
        assert_close(node.value, expected, 1e-13);
    }
}

#[test]
fn a_pixel_is_that_of_its_row_and_column() {
    let meter = meter(0);
    let sheet = sheet(&meter, &PANE, 2, SHAPE);
    assert_eq!(sheet.pixel([0, 0]), [0, 0]);
    assert_eq!(sheet.pixel(at(4, 3, 13)), [6, 3]);
    assert_eq!(sheet.pixel(at(5, 31, 30)), [7, 15]);
    assert_eq!(sheet.pixel([STEPS, STEPS]), [7, 15]);
}

#[test]
fn the_image_has_the_means_of_polynomials_times_the_scale() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
    fill(&mut sheet, &lattice(3), |[x, y, _]| 3.0 * x * x + 2.0 * y);
    sheet.scan.node_lines.lines[7].error = 0.25;
    sheet.scale = Arc::new(uniform(SHAPE, 2.0));
    let (part, _) = sheet.assemble();
    for row in 0..8 {
        for column in 0..16 {
            let [left, right] = [column, column + 1].map(|edge| edge as f64 / 16.0);
            let of_x = (right.powi(3) - left.powi(3)) * 16.0;
            let of_y = 2.0 * (row as f64 + 0.5) / 8.0;
            assert_close(part.image[(row, column)], 2.0 * (of_x + of_y), 1e-12);
        }
    }
    assert_eq!(part.of_lines, uniform(SHAPE, 0.25));
}

#[test]
fn a_sheet_needs_the_nodes_of_all_required_levels() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 2, SHAPE);
    fill(&mut sheet, &lattice(2), |_| 1.0);
    sheet.scan.base_level = 1;
    assert!(sheet.assemble().1.has_required);
    sheet.scan.base_level = 2;
    assert!(!sheet.assemble().1.has_required);
    let mut next: Vec<Place> =
        lattice(3).into_iter().filter(|place| level_of_place(*place) == 3).collect();
    let last = next.pop();
    fill(&mut sheet, &next, |_| 1.0);
    assert!(!sheet.assemble().1.has_required);
    fill(&mut sheet, last.as_slice(), |_| 1.0);
    assert!(sheet.assemble().1.has_required);
}

#[test]
fn a_detail_is_in_the_error_map_around_its_node() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 3, [16, 16]);
    let peak = at(3, 3, 5);
    sheet.scale = Arc::new(uniform([16, 16], 2.0));
    fill(&mut sheet, &lattice(3), |_| 0.0);
    let i = sheet.scan.tree.find(peak).unwrap();
    sheet.scan.node_lines.lines[i].integral = 1.0;
    sheet.set_values(&[], &[]);
    let (part, seen) = sheet.assemble();
    assert_close(seen.guarded[i], 1.0, 1e-15);
    // The hats of the node and of the eight around it, which have a half of it, and the next ones.
    let [next, second] = [TUNING.image.first_neighbour_guard, TUNING.image.second_neighbour_guard];
    let (row, column) = (10, 6);
    let hats = [0.75, 0.25];
    let sizes = |i: usize, j: usize| match (i, j) {
        (0, 0) => 1.0,
        // Of the nodes around only those of the same level are guarded.
        (1, 0) | (0, 1) => next,
        _ => 0.0,
    };
    let on_level = |i: u32, j: u32| level_of_place(at(3, 3 + i, 5 + j)) == 3;
    let mut expected = 0.0;
    for (i, along) in hats.iter().enumerate() {
        for (j, across) in hats.iter().enumerate() {
            let is_there = on_level(u32::try_from(i).unwrap(), u32::try_from(j).unwrap());
            expected += if is_there { sizes(i, j) * along * across } else { 0.0 };
        }
    }
    assert_close(part.error[(row, column)], 2.0 * expected, 1e-14);
    assert!(second > 0.0 && part.error[(0, 15)] == 0.0);
}

#[test]
fn jumps_on_many_lines_are_tracked_with_shorter_stencils() {
    let meter = meter(0);
    let [of_base, of_nodes] = [TUNING.view.rough_share, TUNING.view.rough_share_of_nodes];
    for (share, jumping, is_rough) in
        [(of_base, 2, false), (of_base, 3, true), (of_nodes, 20, false), (of_nodes, 21, true)]
    {
        let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
        fill(&mut sheet, &lattice(3), |_| 1.0);
        for line in &mut sheet.scan.node_lines.lines[..jumping] {
            *line = line_of(8, |z| if z < 0.4 { 0.0 } else { 1.0 });
            line.assess(1e-3, 3);
        }
        sheet.choose_order(share);
        assert_eq!(sheet.scan.node_lines.tracks_jumps, is_rough, "{jumping} of 81");
        assert_eq!(sheet.scan.tree.order(), if is_rough { 4 } else { 6 });
    }
}

#[test]
fn nodes_beyond_the_budget_are_removed() {
    let meter = meter(1);
    let mut sheet = sheet(&meter, &PANE, 2, SHAPE);
    fill(&mut sheet, &lattice(2), |_| 1.0);
    // An older node whose rule exceeds the tolerance is integrated again with the new ones.
    let old = LineSource::Rule { block: Block::around([0, 0], 0), error: 1.0, rule: 0 };
    let node_lines = &mut sheet.scan.node_lines;
    (node_lines.sources[3], node_lines.lines[3].integral) = (old, 7.0);
    let places = [at(3, 1, 1), at(3, 3, 3)];
    let sampled = answered(&meter, |_, _| 1.0, sheet.sample_nodes(&places, &[0.0; 25], 1e-3));
    assert!(matches!(sampled, Err(Stop::Budget)));
    assert_eq!((sheet.scan.tree.len(), sheet.scan.node_lines.lines.len()), (25, 25));
    assert_eq!(sheet.scan.tree.find(places[0]), None);
    assert_eq!(sheet.scan.node_lines.sources[3], old);
    assert_close(sheet.scan.node_lines.lines[3].integral, 7.0, 1e-15);
    // All lines have the same rates: one depth is enough for the new one.
    let sampled = answered(&meter, |_, _| 1.0, sheet.sample_nodes(&places[..1], &[0.0; 25], 1e-3));
    assert!(sampled.is_ok());
    assert!(matches!(sheet.scan.node_lines.sources[25], LineSource::Rule { .. }));
    assert!(sheet.scan.node_lines.is_full(3));
    assert_close(sheet.scan.node_lines.lines[25].integral, 1.0, 1e-12);
}

#[test]
fn places_of_seeds_come_first_and_then_the_children_of_coarse_nodes() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 2, SHAPE);
    fill(&mut sheet, &lattice(2), |_| 1.0);
    sheet.scan.seeds.add_depths_around(at(3, 3, 3), 3, &[9]);
    let missing = sheet.missing_seed_places();
    // 4 × 4 places without the 2 × 2 of the base.
    assert_eq!(missing.len(), 12);
    let seeded: Vec<usize> = sheet.seeded().into_iter().map(|(i, _)| i).collect();
    assert_eq!(seeded.len(), 4);
    assert!(seeded.iter().all(|&i| level_of_place(sheet.scan.tree.nodes()[i].place) < 3));
    let (_, seen) = sheet.assemble();
    let limits = ChoiceLimits { tolerance: 1.0, finest_level: 9, required_level: 3 };
    let choice = sheet.choice(&seen, &[1.0], &[], &limits);
    let places = sheet.places(&seen, &choice, vec![]);
    assert_eq!(places[..12], missing);
    let mut all: Vec<Place> = places;
    all.sort_unstable();
    all.dedup();
    // All of the next level.
    assert_eq!(all.len(), 81 - 25);
}

#[test]
fn the_largest_line_is_that_of_the_largest_size() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 2, SHAPE);
    fill(&mut sheet, &lattice(2), |[x, y, _]| x - 3.0 * y);
    assert_close(sheet.largest_line(), 3.0, 1e-15);
    sheet.scale = Arc::new(Image::zeros(8, 16));
    let (part, _) = sheet.assemble();
    assert_eq!(part.image, Image::zeros(8, 16));
}
