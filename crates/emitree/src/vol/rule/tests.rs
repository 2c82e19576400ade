//! Plans and rounds, where lines are mixtures of two functions and where they are not.

use crate::vol::dyadic::{Place, unit};
use crate::vol::image::block::Block;
use crate::vol::image::tree::level_of_place;
use crate::vol::line::Line;
use crate::vol::line::node_lines::{LineSource, base_depths};
use crate::vol::rule::plan::{Plan, TrainingLines};
use crate::vol::rule::scan::Scan;
use crate::vol::sampling::Stop;
use crate::vol::testing::{
    PANE, answered, assert_close, at, lattice, line_of, lines_of, meter, scan,
};
use crate::vol::tuning::TUNING;

/// Two functions of depth in parts that differ from line to line.
fn mixed([x, y, z]: [f64; 3]) -> f64 {
    (1.0 + x * x) * (1.0 - z) + (0.2 + y) * z * z
}

/// ∫ of it along a line.
fn of_mixed(place: Place) -> f64 {
    let [x, y] = place.map(unit);
    0.5 * (1.0 + x * x) + (0.2 + y) / 3.0
}

/// Lines of high rank: no depth rule integrates all of them.
fn rough([x, y, z]: [f64; 3]) -> f64 {
    1.0 + (40.0 * x * y + 30.0 * x + 50.0 * y + (9.0 + 20.0 * x - 15.0 * y) * z).sin()
}

/// Gives a scan the full lines of its base, level 3, and adds the nodes of level 4 without any.
fn begin(scan: &mut Scan<'_>, rate: impl Fn([f64; 3]) -> f64) -> usize {
    scan.add(&lattice(3));
    scan.node_lines = lines_of(&scan.tree, 3, rate);
    add_next_level(scan)
}

fn add_next_level(scan: &mut Scan<'_>) -> usize {
    let first = scan.tree.len();
    let new: Vec<Place> = lattice(4).into_iter().filter(|at| level_of_place(*at) == 4).collect();
    scan.add(&new);
    first
}

fn plan(scan: &Scan<'_>, first: usize, tolerance: f64, postpone: bool) -> Plan {
    let new: Vec<usize> = (first..scan.tree.len()).collect();
    scan.plan(&new, first, &vec![0.0; first], tolerance, postpone)
}

/// A line with a bracketed jump.
fn stepped() -> Line {
    let mut line = line_of(8, |z| if z < 0.4 { 0.0 } else { 1.0 });
    line.assess(1e-3, 3);
    line
}

/// The block of `level` in the corner of small coordinates.
fn corner(level: u8) -> Block {
    Block::around([0, 0], level)
}

#[test]
fn rules_are_fitted_to_full_lines_and_lines_with_jumps_are_listed() {
    let meter = meter(0);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, mixed);
    let i = scan.tree.find(at(3, 7, 1)).unwrap_or_default();
    scan.node_lines.lines[i] = stepped();
    let TrainingLines { lines, jumping } = scan.training();
    let expected = scan.tree.nodes()[..first].iter().map(|node| node.place).enumerate();
    assert_eq!(lines, expected.collect::<Vec<_>>());
    assert_eq!(jumping, [at(3, 7, 1)]);
    scan.node_lines.sources[i] = LineSource::Unknown;
    let training = scan.training();
    assert_eq!((training.lines.len(), training.jumping.len()), (first - 1, 0));
}

#[test]
fn a_mixture_of_two_functions_has_a_rule_of_two_depths() {
    let meter = meter(0);
    let mut scan = scan(&meter, &PANE, 3);
    begin(&mut scan, mixed);
    let fit = |block, most| scan.fit_rule(block, &scan.training(), 1e-9, most);
    let found = fit(corner(1), 6).unwrap();
    assert_eq!((found.block, found.rule.depths.len()), (corner(1), 2));
    assert!(fit(corner(1), 1).is_none());
    // A block of level 2 has 3 × 3 lines.
    assert!(fit(corner(2), 6).is_none());
}

#[test]
fn beside_a_line_with_a_jump_there_is_no_rule() {
    let meter = meter(0);
    let mut scan = scan(&meter, &PANE, 3);
    begin(&mut scan, mixed);
    // An eighth of the image beyond a half of it, and two eighths beyond the other.
    let i = scan.tree.find(at(3, 5, 2)).unwrap();
    scan.node_lines.lines[i] = stepped();
    let fit = |block| scan.fit_rule(block, &scan.training(), 1e-9, 6);
    assert!(fit(corner(0)).is_none() && fit(corner(1)).is_none());
    assert!(fit(Block::around(at(3, 0, 8), 1)).is_some());
}

#[test]
fn most_nodes_are_integrated_by_the_rule_and_a_few_in_full() {
    let meter = meter(0);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, mixed);
    let plan = plan(&scan, first, 1e-9, true);
    let new = scan.tree.len() - first;
    // The rule of the whole image is as short as any.
    let whole = plan.rules.iter().position(|of| of.block == corner(0)).unwrap();
    assert!(plan.ruled.values().all(|rule| *rule == whole));
    let of_root = TUNING.rule.validation_factor * (new as f64).sqrt();
    assert_close(plan.full.len() as f64, of_root.ceil(), 0.0);
    assert_eq!(plan.ruled.len(), new - plan.full.len());
    let mut validated: Vec<usize> = plan.validated.iter().map(|(i, _)| *i).collect();
    validated.sort_unstable();
    assert_eq!(validated, plan.full);
    assert!(plan.full.iter().all(|i| !plan.ruled.contains_key(i)));
    assert!(plan.postponed.is_empty());
}

#[test]
fn half_of_the_validation_lines_are_where_details_are_largest() {
    let meter = meter(0);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, mixed);
    let mut guarded = vec![0.0; first];
    guarded[scan.tree.find(at(3, 6, 2)).unwrap()] = 1.0;
    let new: Vec<usize> = (first..scan.tree.len()).collect();
    let plan = scan.plan(&new, first, &guarded, 1e-9, true);
    let near = |i: &usize| {
        let place = scan.tree.nodes()[*i].place;
        (0..2).all(|k| place[k].abs_diff(at(3, 6, 2)[k]) <= at(4, 1, 1)[k])
    };
    assert_eq!(plan.full.iter().copied().filter(|i| near(i)).count(), plan.full.len().div_ceil(2));
}

#[test]
fn a_third_of_the_lines_comes_first_where_there_is_no_rule() {
    let meter = meter(0);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, rough);
    let new = scan.tree.len() - first;
    let all_at_once = plan(&scan, first, 1e-6, false);
    assert!(all_at_once.rules.is_empty());
    assert_eq!((all_at_once.full.len(), all_at_once.postponed.len()), (new, 0));
    let in_two_steps = plan(&scan, first, 1e-6, true);
    assert_eq!(in_two_steps.full.len() + in_two_steps.postponed.len(), new);
    let third = in_two_steps.full.len() as f64 / new as f64;
    assert!((0.3..0.4).contains(&third), "{third}");
    // It is spread over the image.
    for part in 0..4 {
        let block = Block::around(at(1, part % 2, part / 2), 1);
        let inside = |i: &&usize| block.contains(scan.tree.nodes()[**i].place, 0.0);
        let full = in_two_steps.full.iter().filter(inside).count();
        assert!(full >= new / 16, "{full}");
    }
    // Where lines jump, no line waits for a rule.
    scan.node_lines.lines[..first].fill(stepped());
    assert!(plan(&scan, first, 1e-6, true).postponed.is_empty());
}

#[test]
fn a_node_at_a_seed_gets_a_full_line() {
    let meter = meter(0);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, mixed);
    scan.seeds.add_depths_around(at(4, 5, 5), 5, &[1]);
    let plan = plan(&scan, first, 1e-9, true);
    let seeded = scan.tree.find(at(4, 5, 5)).unwrap();
    assert!(plan.full.contains(&seeded));
    assert!(plan.validated.iter().all(|(i, _)| *i != seeded));
    assert!(plan.ruled.len() > 100 && !plan.ruled.contains_key(&seeded));
}

#[test]
fn rules_with_nearly_all_depths_of_a_line_are_not_used() {
    let meter = meter(0);
    // 0.7 of the 9 depths of a line are 6.
    for (terms, has_rule) in [(6, true), (7, false)] {
        let mut scan = scan(&meter, &PANE, 3);
        let sum = |[x, y, z]: [f64; 3]| {
            let term = |k: i32| ((7.0 + f64::from(k)) * (x + 0.3 * y * f64::from(k))).sin();
            (0..terms).map(|k| term(k) * z.powi(k)).sum::<f64>()
        };
        let first = begin(&mut scan, sum);
        assert_eq!(!plan(&scan, first, 1e-9, true).rules.is_empty(), has_rule, "{terms}");
    }
}

#[test]
fn new_nodes_have_no_line_until_they_are_scanned() {
    let meter = meter(0);
    let mut scan = scan(&meter, &PANE, 3);
    scan.add(&[at(3, 7, 3)]);
    assert_eq!(scan.node_lines.sources, [LineSource::Unknown]);
    scan.truncate(0);
    assert_eq!((scan.tree.len(), scan.node_lines.lines.len()), (0, 0));
}

#[test]
fn a_round_integrates_all_nodes_at_few_depths() {
    let meter = meter(100_000);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, mixed);
    let guarded = vec![0.0; first];
    answered(&meter, |at, _| mixed(at), scan.scan(first, &guarded, 1e-6)).unwrap();
    let mut ruled = 0;
    for (i, node) in scan.tree.nodes().iter().enumerate() {
        assert_close(scan.node_lines.lines[i].integral, of_mixed(node.place), 1e-6);
        ruled += u64::from(!scan.node_lines.is_full(i));
        assert!(scan.node_lines.error(i) <= 1e-6);
    }
    let new = (scan.tree.len() - first) as u64;
    // Two depths for the nodes of the rule, and those of the base with the rule's for the others.
    assert!(ruled > new * 9 / 10);
    assert!(meter.evaluations() <= 2 * ruled + 11 * (new - ruled), "{}", meter.evaluations());
    assert!(meter.evaluations() >= 2 * ruled + 9 * (new - ruled), "{}", meter.evaluations());
}

#[test]
fn a_round_beyond_the_budget_ends() {
    let meter = meter(100);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, mixed);
    let guarded = vec![0.0; first];
    let scanned = answered(&meter, |at, _| mixed(at), scan.scan(first, &guarded, 1e-6));
    assert!(matches!(scanned, Err(Stop::Budget)));
    assert!(meter.evaluations() <= 100);
}

#[test]
fn an_outlier_is_integrated_in_full() {
    let (meter, odd) = (meter(100_000), at(4, 5, 11));
    let [x_odd, y_odd] = odd.map(unit);
    let column = |[x, y, z]: [f64; 3]| {
        let square = (x - x_odd).powi(2) + (y - y_odd).powi(2);
        mixed([x, y, z]) + 20.0 * (-square / 1e-4).exp() * z
    };
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, column);
    let guarded = vec![0.0; first];
    answered(&meter, |at, _| column(at), scan.scan(first, &guarded, 1e-6)).unwrap();
    let i = scan.tree.find(odd).unwrap();
    assert!(scan.node_lines.is_full(i));
    assert_close(scan.node_lines.lines[i].integral, of_mixed(odd) + 10.0, 1e-6);
    let ruled = (first..scan.tree.len()).filter(|&i| !scan.node_lines.is_full(i)).count();
    assert!(ruled > (scan.tree.len() - first) * 8 / 10);
}

#[test]
fn where_a_rule_fails_its_quarter_gets_a_better_one_or_full_lines() {
    // A third function, in a quarter of the image and on the lines of level 4 only.
    let third = |[x, y, z]: [f64; 3]| {
        let between = (8.0 * core::f64::consts::PI * x).sin().powi(2);
        let in_quarter = if x < 0.5 && y < 0.5 { 1.0 } else { 0.0 };
        mixed([x, y, z]) + 0.1 * in_quarter * between * z.powi(4)
    };
    let meter = meter(100_000);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, third);
    let mut guarded = vec![0.0; first];
    // Half of the validation lines are there.
    for (i, node) in scan.tree.nodes()[..first].iter().enumerate() {
        guarded[i] = if corner(1).contains(node.place, 0.0) { 1.0 } else { 0.0 };
    }
    answered(&meter, |at, _| third(at), scan.scan(first, &guarded, 1e-4)).unwrap();
    for (i, node) in scan.tree.nodes().iter().enumerate() {
        let [x, y] = node.place.map(unit);
        let expected = of_mixed(node.place) + third([x, y, 1.0]) / 5.0 - mixed([x, y, 1.0]) / 5.0;
        assert_close(scan.node_lines.lines[i].integral, expected, 1e-4);
    }
}

#[test]
fn the_error_of_a_rule_is_that_on_its_validation_lines() {
    // A third function of 0.01 between the lines that the rule is fitted to.
    let third = |[x, y, z]: [f64; 3]| {
        mixed([x, y, z]) + 0.01 * (8.0 * core::f64::consts::PI * x).sin().powi(2) * z.powi(4)
    };
    let meter = meter(100_000);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, third);
    let guarded = vec![0.0; first];
    answered(&meter, |at, _| third(at), scan.scan(first, &guarded, 0.01)).unwrap();
    let ruled: Vec<usize> =
        (first..scan.tree.len()).filter(|&i| !scan.node_lines.is_full(i)).collect();
    assert!(ruled.len() > (scan.tree.len() - first) * 8 / 10);
    // Its weight of z² at the end of the line is 1/3, where z⁴ has an integral of 1/5.
    for i in ruled {
        assert_close(scan.node_lines.error(i), 0.01 * (1.0 / 3.0 - 1.0 / 5.0), 1e-6);
    }
}

#[test]
fn lines_with_errors_above_a_new_tolerance_are_refined_again() {
    let (meter, loose) = (meter(100_000), 5e-6);
    let wave = |[x, y, z]: [f64; 3]| (1.0 + x) * (14.0 * z).sin() + y * (9.0 * z).cos();
    let exact =
        |[x, y]: [f64; 2]| (1.0 + x) * (1.0 - 14.0_f64.cos()) / 14.0 + y * 9.0_f64.sin() / 9.0;
    let mut scan = scan(&meter, &PANE, 3);
    scan.add(&lattice(3));
    let number = scan.tree.len();
    answered(&meter, |at, _| wave(at), scan.scan(0, &[], loose)).unwrap();
    let guarded = vec![0.0; number];
    answered(&meter, |at, _| wave(at), scan.scan(number, &guarded, 1e-6)).unwrap();
    for (i, node) in scan.tree.nodes().iter().enumerate() {
        assert!(scan.node_lines.error(i) <= TUNING.rule.refinement_margin * 1e-6);
        assert_close(scan.node_lines.lines[i].integral, exact(node.place.map(unit)), 1e-5);
    }
}

#[test]
fn depths_finer_by_two_levels_are_on_every_full_line() {
    let meter = meter(100_000);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, mixed);
    let guarded = vec![0.0; first];
    answered(&meter, |at, _| mixed(at), scan.scan(first, &guarded, 1e-6)).unwrap();
    let guarded = vec![0.0; scan.tree.len()];
    answered(&meter, |at, _| mixed(at), scan.refine_depths(2, &guarded, 1e-6)).unwrap();
    assert_eq!(scan.depth_level, 5);
    for i in 0..scan.tree.len() {
        let line = &scan.node_lines.lines[i];
        let has_all = base_depths(5).into_iter().all(|depth| line.has(depth));
        assert_eq!(has_all, scan.node_lines.is_full(i));
        assert_close(line.integral, of_mixed(scan.tree.nodes()[i].place), 1e-6);
    }
}

#[test]
fn a_line_integrated_in_full_has_the_given_depths() {
    let meter = meter(100_000);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, mixed);
    let (nodes, depths) = ([first, first + 3], [at(7, 5, 0)[0], at(7, 77, 0)[0]]);
    let integrated = scan.integrate_in_full(&nodes, &depths, 1e-6);
    answered(&meter, |at, _| mixed(at), integrated).unwrap();
    for i in first..first + 4 {
        assert_eq!(scan.node_lines.is_full(i), nodes.contains(&i));
    }
    for i in nodes {
        let line = &scan.node_lines.lines[i];
        assert!(depths.iter().chain(&base_depths(3)).all(|depth| line.has(*depth)));
        assert_close(line.integral, of_mixed(scan.tree.nodes()[i].place), 1e-6);
    }
}

#[test]
fn full_lines_on_which_older_rules_are_wrong_replace_them_around() {
    // A third function in an eighth of the image, on the lines of level 4 only.
    let third = |[x, y, z]: [f64; 3]| {
        let between = (8.0 * core::f64::consts::PI * x).sin().powi(2);
        let is_inside = x < 0.25 && y < 0.5;
        mixed([x, y, z]) + if is_inside { 0.1 * between * z.powi(4) } else { 0.0 }
    };
    let meter = meter(100_000);
    let mut scan = scan(&meter, &PANE, 3);
    let first = begin(&mut scan, third);
    // The validation lines are elsewhere.
    let far = |scan: &Scan<'_>, i: usize| {
        f64::from(u8::from(scan.tree.nodes()[i].place[0] > at(2, 2, 0)[0]))
    };
    let guarded: Vec<f64> = (0..first).map(|i| far(&scan, i)).collect();
    answered(&meter, |at, _| third(at), scan.scan(first, &guarded, 1e-4)).unwrap();
    let wrong = |scan: &Scan<'_>| -> Vec<usize> {
        let exact = |place: Place| {
            let [x, y] = place.map(unit);
            of_mixed(place) + (third([x, y, 1.0]) - mixed([x, y, 1.0])) / 5.0
        };
        let error = |i: usize| {
            (scan.node_lines.lines[i].integral - exact(scan.tree.nodes()[i].place)).abs()
        };
        (0..scan.tree.len()).filter(|&i| error(i) > 1e-4).collect()
    };
    let before = wrong(&scan);
    assert!(before.len() > 10, "{before:?}");
    let evaluations = meter.evaluations();
    // Lines of level 3 between the two columns of these nodes have nothing of the third function.
    let one_of = |column: u32| {
        let is_there = |&&i: &&usize| scan.tree.nodes()[i].place[0] == at(4, column, 0)[0];
        before.iter().find(is_there).copied().unwrap()
    };
    let nodes = [1, 3].map(one_of);
    let integrated = scan.integrate_in_full(&nodes, &[], 1e-4);
    answered(&meter, |at, _| third(at), integrated).unwrap();
    assert!(wrong(&scan).is_empty());
    assert!(meter.evaluations() - evaluations < 12 * 2 * before.len() as u64);
}
