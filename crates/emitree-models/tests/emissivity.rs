//! The magnetosheath models against emissivities worked out with 50 digits by
//! `reference/cmem.py`.

use emitree::{Emission, Samples};
use emitree_models::build_model;
use emitree_models::models::{Cmem, Jorgensen};
use std::collections::BTreeMap;

const REFERENCE: &str = include_str!("reference/emissivity.csv");

/// The solar winds of `reference/cmem.py`.
fn parameters(wind: &str) -> BTreeMap<String, f64> {
    let values = match wind {
        "view1" => [5.0, 400.0, 0.0, 0.0, 5.0, 0.0],
        "southward" => [12.0, 550.0, 2.0, -3.0, -6.5, 0.3],
        "northward" => [3.5, 320.0, -1.0, 4.0, 9.0, -0.25],
        // Refused as densities, so that a new name in the table can't pass unseen.
        _ => [f64::NAN; 6],
    };
    let names = ["density", "velocity", "bx", "by", "bz", "dipole_tilt"];
    names.map(str::to_owned).into_iter().zip(values).collect()
}

#[test]
fn emissivities_as_published() {
    let mut checked = 0;
    for line in REFERENCE.lines().skip(1) {
        let fields: Vec<_> = line.split(',').collect();
        let [model, wind, place, numbers @ ..] = fields.as_slice() else { panic!("{line}") };
        let numbers: Vec<f64> = numbers.iter().map(|number| number.parse().unwrap()).collect();
        let (position, expected) = ([numbers[0], numbers[1], numbers[2]], numbers[3]);

        let parameters = parameters(wind);
        let emissivity = match *model {
            "cmem" => Cmem::new(&parameters).unwrap().emissivity(position),
            _ => Jorgensen::new(&parameters).unwrap().emissivity(position),
        };
        let error = (emissivity - expected).abs();
        assert!(error <= 1e-12 * expected, "{model}, {wind}, {place}: {emissivity}, {expected}");

        let mut rate = [f64::NAN];
        let positions = [position];
        let samples = Samples::new(&positions, &[[0.0, 0.0, 1.0]]);
        build_model(model, &parameters).unwrap().emission_rates(&samples, &mut rate).unwrap();
        let expected = expected * 6.371e8 / (4.0 * std::f64::consts::PI) / 1000.0;
        assert!((rate[0] - expected).abs() <= 1e-12 * expected, "{model}, {wind}, {place}");
        checked += 1;
    }
    assert_eq!(checked, 2 * 3 * 13);
}
