//! The models other than the magnetosheath's and those with spectra against rates worked out by
//! `reference/models.py`.

use emitree::{Emission, Samples};
use emitree_models::{build_model, catalogue};
use std::collections::BTreeMap;

const REFERENCE: &str = include_str!("reference/models.csv");

/// Relative errors above a few roundings, and why.
fn allowed(model: &str) -> f64 {
    match model {
        // The speed integral is tabulated to 1e-11, and exponents reach 1e4.
        "ena" => 1e-11,
        // Rounded heights above the exobase or the limb, and exponents of 100.
        "chamberlain" => 1e-12,
        // The Thomson cross section has 11 digits.
        "k_corona" | "k_corona_polarised" => 1e-10,
        _ => 1e-13,
    }
}

#[test]
fn rates_worked_out_independently() {
    let mut checked = BTreeMap::new();
    for line in REFERENCE.lines().skip(1) {
        let fields: Vec<_> = line.split(',').collect();
        let [model, given, numbers @ ..] = fields.as_slice() else { panic!("{line}") };
        let numbers: Vec<f64> = numbers.iter().map(|number| number.parse().unwrap()).collect();
        let [x, y, z, dx, dy, dz, expected] = numbers[..] else { panic!("{line}") };
        let parameters = given
            .split_whitespace()
            .map(|pair| pair.split_once('=').unwrap())
            .map(|(name, value)| (name.to_owned(), value.parse().unwrap()))
            .collect();

        let mut rate = [f64::NAN];
        let (positions, directions) = ([[x, y, z]], [[dx, dy, dz]]);
        let samples = Samples::new(&positions, &directions);
        build_model(model, &parameters).unwrap().emission_rates(&samples, &mut rate).unwrap();
        let error = (rate[0] - expected).abs();
        assert!(
            error <= allowed(model) * expected,
            "{line}: {:e}, relative error {:e}",
            rate[0],
            error / expected
        );
        *checked.entry(*model).or_insert(0) += 1;
    }
    // All but the magnetosheath's and those with spectra, which have tables of their own, and the
    // test function.
    for description in catalogue() {
        let elsewhere = ["cmem", "jorgensen", "holmstrom"].contains(&description.name);
        assert!(
            elsewhere || description.needs_energy() || checked[description.name] >= 4,
            "{}",
            description.name
        );
    }
}
