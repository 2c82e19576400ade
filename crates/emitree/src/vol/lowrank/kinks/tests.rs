//! Kinks, cusps and jumps are distinguished from smooth bends, and located.

use super::*;
use crate::vol::lowrank::chebyshev::all_places;
use core::f64::consts::TAU;

/// The places at which a kink remains after all divisions, and the number of evaluations.
fn remaining(f: impl Fn(f64) -> f64) -> (Vec<f64>, usize) {
    let places = all_places(6);
    let rates: Vec<f64> = places.iter().map(|&x| f(x)).collect();
    let mut evaluations = 0;
    let located = |bend: Bend| {
        (0..TUNING.lowrank.kink_halvings).try_fold(bend, |bend, _| {
            evaluations += 3;
            bend.halved(&bend.middles().map(&f))
        })
    };
    let bends = bends_of(&places, &rates);
    let mut found: Vec<f64> =
        bends.into_iter().filter_map(located).map(|bend| bend.middle()).collect();
    found.sort_by(f64::total_cmp);
    (found, evaluations)
}

fn has_kink_at(place: f64, f: impl Fn(f64) -> f64) -> bool {
    let places = BESIDE.map(|beside| place + beside * TUNING.lowrank.same_kink);
    has_kink(&places, &places.map(f))
}

#[test]
fn kinks_cusps_and_jumps_are_located() {
    for power in [0.5, 1.0] {
        let f = |x: f64| (-3.0 * (TAU * x).cos().abs().powf(power)).exp();
        let (found, _) = remaining(f);
        assert_eq!(found.len(), 2);
        for (found, expected) in found.into_iter().zip([0.25, 0.75]) {
            assert!((found - expected).abs() < 1e-8, "{found}");
            assert!(has_kink_at(found, f) && !has_kink_at(found + 0.01, f));
        }
    }
    for at in [0.11, 0.52, 0.93] {
        let f = |x: f64| x.cos() + if x < at { 0.0 } else { 1.0 };
        let (found, _) = remaining(f);
        assert!(found.len() == 1 && (found[0] - at).abs() < 1e-8, "{found:?}");
        assert!(has_kink_at(found[0], f));
    }
}

#[test]
fn smooth_bends_are_left_after_few_evaluations() {
    for at in [0.11, 0.52, 0.93] {
        for width in [0.02, 0.05, 0.2] {
            let (found, evaluations) = remaining(|x| (-((x - at) / width).powi(2)).exp());
            assert!(found.is_empty() && evaluations <= 60, "{at} {width}: {found:?} {evaluations}");
        }
    }
    assert!(remaining(|_| 1.0).0.is_empty() && remaining(|_| f64::NAN).0.is_empty());
    assert!(!has_kink_at(0.4, |_| 0.0) && !has_kink_at(0.4, |x| (5.0 * x).exp()));
}
