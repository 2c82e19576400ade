//! The checks of all cubes from quadrature.

use super::local::{self, LocalSpectrum, Rule};
use emitree::{EnergyAxis, EnergyScale};

/// The parameter lies within its bounds all over the unit cube, and so within its series.
pub(super) fn parameter_is_bounded<L: LocalSpectrum>(emission: &L) {
    let [low, high] = L::PARAMETER;
    let at = |i: usize| i as f64 / 24.0;
    for point in 0..25 * 25 * 25_usize {
        let position = [at(point % 25), at(point / 25 % 25), at(point / 625)];
        let [density, parameter] = emission.place(position);
        assert!(density >= 0.0, "{density} at {position:?}");
        assert!((low..=high).contains(&parameter), "{parameter} at {position:?}");
    }
}

/// The cube, of narrow bins, is that of a finer rule to a tenth of `error`.
pub(super) fn rule_is_fine_enough<L: LocalSpectrum>(
    emission: &L,
    rule: &Rule,
    [min, max]: [f64; 2],
    error: f64,
) {
    let axis = EnergyAxis::new(min, max, 40, EnergyScale::Log).unwrap();
    let (nodes, terms) = (rule.nodes * 4 / 3, rule.terms * 4 / 3);
    let finer = local::cube(emission, &Rule { nodes, terms, ..rule.clone() }, [21, 30], &axis);
    let cube = local::cube(emission, rule, [21, 30], &axis);
    let far = cube.max_difference(&finer) / finer.largest();
    assert!(far < 0.1 * error, "{far:e}");
}
