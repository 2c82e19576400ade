//! Regions of samples by their values.

use super::*;

/// Samples on a lattice, of the regions below and above a plane.
fn samples(rate: impl Fn([f64; 3]) -> f64) -> Samples {
    let mut samples = Samples::new(0.05, 1e-4);
    let labels = [samples.new_label(), samples.new_label()];
    for k in 0..512_u32 {
        let at = [k % 8, k / 8 % 8, k / 64].map(|k| f64::from(k) / 7.0);
        let label = labels[usize::from(at[2] > 0.5)];
        samples.add(at, rate(at), label);
    }
    samples
}

#[test]
fn values_beside_a_jump_belong_to_the_region_that_they_continue() {
    let below = |[x, y, z]: [f64; 3]| 1.0 + 0.5 * x + 0.3 * y * z;
    let above = |[x, y, z]: [f64; 3]| 0.2 + 0.1 * x - 0.1 * y + 0.05 * z;
    let rate = |at: [f64; 3]| if at[2] > 0.5 { above(at) } else { below(at) };
    let samples = samples(rate);
    for k in 0..100_u32 {
        let at = [f64::from(k % 10) / 9.0, f64::from(k / 10) / 9.0, 0.5];
        assert_eq!(samples.classify(at, below(at)), Some(0), "{at:?}");
        assert_eq!(samples.classify(at, above(at)), Some(1), "{at:?}");
    }
}

#[test]
fn another_value_among_constant_ones_is_a_new_region() {
    let mut samples = samples(|[_, _, z]| if z > 0.5 { 0.7 } else { 0.0 });
    assert_eq!(samples.classify([0.4, 0.4, 0.2], 0.3), None);
    assert_eq!(samples.constant(0.7), Some(1));
    assert_eq!(samples.constant(0.3), None);
    let label = samples.new_label();
    let number = samples.add([0.4, 0.4, 0.2], 0.3, label);
    assert_eq!((samples.regions(), samples.label(number)), (3, 2));
    samples.merge(label, 0);
    assert_eq!((samples.regions(), samples.label(number)), (2, 0));
    assert_eq!(samples.constant(0.0), None);
}

#[test]
fn a_region_of_few_equal_values_admits_no_other_value() {
    let mut samples = samples(|_| 0.0);
    let label = samples.new_label();
    samples.add([0.4, 0.4, 0.2], 0.7, label);
    // 0.5 is nearer to 0.7 than to 0, but all regions are constant.
    assert_eq!(samples.classify([0.41, 0.4, 0.2], 0.5), None);
    assert_eq!(samples.classify([0.41, 0.4, 0.2], 0.7), Some(label));
}

#[test]
fn merging_a_region_with_itself_changes_nothing() {
    let mut samples = samples(|_| 0.0);
    let label = samples.new_label();
    samples.merge(label, label);
    assert_eq!(samples.regions(), 3);
    assert!(samples.is_constant(0));
}

#[test]
fn regions_are_one_if_g_jumps_between_them_rarely() {
    let mut samples = samples(|_| 0.0);
    let label = samples.new_label();
    assert!(samples.is_unknown_border(0, label) && !samples.is_unknown_border(0, 0));
    samples.note_border(0, label, true);
    for _ in 0..TUNING.surfaces.rare_jumps {
        samples.note_border(label, 0, false);
    }
    assert!(!samples.is_unknown_border(0, label));
    assert_eq!((samples.regions(), samples.current(label)), (3, label));
    samples.note_border(0, label, false);
    assert_eq!((samples.regions(), samples.current(label)), (2, 0));
    // The counts of a region that has become another one are added to those of that.
    let [third, fourth] = [samples.new_label(), samples.new_label()];
    samples.note_border(1, third, true);
    samples.note_border(1, fourth, true);
    samples.merge(third, fourth);
    for _ in 0..2 * TUNING.surfaces.rare_jumps {
        samples.note_border(1, third, false);
    }
    assert_eq!(samples.current(third), third);
    samples.note_border(1, fourth, false);
    assert_eq!(samples.current(fourth), 1);
}

#[test]
fn foreign_values_and_jumps_that_fade_out_follow_from_predictions() {
    let below = |[x, y, _]: [f64; 3]| 1.0 + 0.5 * x + 0.3 * y;
    let jump = |[x, ..]: [f64; 3]| 1.0 - x;
    let rate = |at: [f64; 3]| below(at) + if at[2] > 0.5 { jump(at) } else { 0.0 };
    let samples = samples(rate);
    let at = [0.1, 0.5, 0.5];
    assert!(samples.is_foreign(at, below(at) + jump(at), 0, 0.1));
    assert!(!samples.is_foreign(at, below(at) + 0.01, 0, 0.1));
    // Another value than that of both regions.
    assert!(!samples.is_foreign(at, below(at) - 5.0, 0, 0.1));
    for x in [0.1, 0.5, 0.9] {
        let at = [x, 0.5, 0.5];
        let [found, error] = samples.largest_jump(at, &[0, 1]).unwrap();
        assert!((found - jump(at)).abs() < 0.03 && error < 0.2, "{x}: {found} {error}");
    }
    assert_eq!(samples.largest_jump(at, &[0, 7]), None);
}

#[test]
fn an_inferred_point_has_the_value_of_its_region_and_counts_once_it_is_measured() {
    let mut samples = samples(|[x, _, z]| if z > 0.5 { 3.0 + x } else { 0.0 });
    let at = [0.31, 0.42, 0.93];
    let number = samples.add_inferred(at, samples.rate_near(at, 1), 1);
    let inferred = samples.get(number);
    assert!((inferred.rate - (3.0 + at[0])).abs() < 1e-9, "{inferred:?}");
    assert!(
        !samples.is_measured(number) && !samples.is_of(number, 1) && samples.label(number) == 1
    );
    let is_near = |samples: &Samples| samples.placed.nearest(at, 1) == [(0.0, number)];
    assert!(!is_near(&samples));
    // The evaluation may contradict what was inferred.
    samples.measure(number, 0.0, 0);
    assert!(is_near(&samples) && samples.is_of(number, 0) && samples.get(number).rate == 0.0);
}

#[test]
fn regions_between_which_many_edges_jump_remain_two() {
    let regions_after = |jumps: usize| {
        let mut samples = Samples::new(0.1, 0.0);
        let [a, b] = [samples.new_label(), samples.new_label()];
        (0..jumps).for_each(|_| samples.note_border(a, b, true));
        let others = 2 * TUNING.surfaces.rare_jumps * jumps;
        (0..others).for_each(|_| samples.note_border(a, b, false));
        samples.regions()
    };
    assert_eq!(regions_after(TUNING.surfaces.sure_jumps - 1), 1);
    assert_eq!(regions_after(TUNING.surfaces.sure_jumps), 2);
}
