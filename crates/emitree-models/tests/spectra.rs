//! The models with spectra against rates worked out by `reference/spectra.py`.

use emitree::{Emission, Samples};
use emitree_models::{build_model, catalogue};
use std::collections::BTreeMap;

const REFERENCE: &str = include_str!("reference/spectra.csv");

/// Relative errors: a few roundings in exponents of up to 130, or in logarithms of Γ functions of up
/// to 190.
const ALLOWED: f64 = 1e-13;

#[test]
fn rates_worked_out_independently() {
    let mut checked = BTreeMap::new();
    for line in REFERENCE.lines().skip(1) {
        let fields: Vec<_> = line.split(',').collect();
        let [model, given, numbers @ ..] = fields.as_slice() else { panic!("{line}") };
        let numbers: Vec<f64> = numbers.iter().map(|number| number.parse().unwrap()).collect();
        let [x, y, z, energy, expected] = numbers[..] else { panic!("{line}") };
        let parameters = given
            .split_whitespace()
            .map(|pair| pair.split_once('=').unwrap())
            .map(|(name, value)| (name.to_owned(), value.parse().unwrap()))
            .collect();

        let (positions, directions, energies) = ([[x, y, z]], [[0.0, 0.0, 1.0]], [energy]);
        let samples = Samples::new(&positions, &directions).at_energies(&energies);
        let mut rate = [f64::NAN];
        build_model(model, &parameters).unwrap().emission_rates(&samples, &mut rate).unwrap();
        let error = (rate[0] - expected).abs();
        assert!(
            error <= ALLOWED * expected,
            "{line}: {:e}, relative error {:e}",
            rate[0],
            error / expected
        );
        *checked.entry(*model).or_insert(0) += 1;
    }
    for description in catalogue().iter().filter(|model| model.needs_energy()) {
        assert!(checked[description.name] >= 40, "{}", description.name);
    }
}
