//! The verification of the selected energies, for emissions whose spectra are known.

use super::{TILES, TOLERANCE, engine, whole_view};
use crate::EnergyScale;
use crate::energy::EnergyAxis;
use crate::meter::Meter;
use crate::vol::dyadic::{STEPS, unit};
use crate::vol::engine::Engine;
use crate::vol::engine::verification::Verdict;
use crate::vol::testing::{answered, meter};
use crate::vol::tuning::TUNING;

fn axis() -> EnergyAxis {
    EnergyAxis::new(0.0, 1.0, 4, EnergyScale::Linear).unwrap()
}

/// One spectrum everywhere.
fn continuum([x, y, _]: [f64; 3], energy: f64) -> f64 {
    (1.0 + x + y) * (2.0 - energy)
}

/// Verifies all lines, with energies if lines pass.
fn verdict(
    engine: &mut Engine<'_>,
    meter: &Meter,
    rate: impl Fn([f64; 3], f64) -> f64 + Sync,
) -> Verdict {
    let current = engine.assemble().unwrap();
    let target = TOLERANCE * current.largest_pixel();
    answered(meter, rate, engine.verify(&current, target)).unwrap()
}

#[test]
fn spectra_that_are_explained_cost_their_energies_and_pass() {
    let (axis, meter) = (axis(), meter(100_000));
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    assert_eq!(answered(&meter, continuum, engine.sample_at_all_energies()), Ok(true));
    assert_eq!(engine.energies.len(), 1);
    assert_eq!(verdict(&mut engine, &meter, continuum), Verdict::Passed);
    assert_eq!(engine.energies.len(), 1);
    let lines = engine.sheets[0].verification.places.len();
    assert!(lines >= TUNING.verification.least_lines);
    // Lines that have been compared are not compared again.
    let before = meter.evaluations();
    let again = answered(&meter, continuum, engine.verify_energies(0.01, 1.0)).unwrap();
    assert_eq!((again, meter.evaluations()), (Verdict::Passed, before));
    // Some of the new lines have evaluations at energies besides the selected one.
    assert_eq!(verdict(&mut engine, &meter, continuum), Verdict::Passed);
    let more = engine.sheets[0].verification.places.len() - lines;
    let compared = TUNING.verification.least_lines as u64;
    let energies = u64::from(TUNING.spectra.energies_per_line);
    assert!(more as u64 > compared);
    assert!(meter.evaluations() - before >= more as u64 * 17 + compared * energies);
}

/// The continuum with a line between the energies of all spectra and spot checks.
fn with_line(at: [f64; 3], energy: f64) -> f64 {
    let middle = unit(STEPS / 256 * 77);
    continuum(at, energy) + 100.0 * at[0] * (-0.5 * ((energy - middle) / 6e-4).powi(2)).exp()
}

#[test]
fn a_narrow_line_between_the_energies_of_spot_checks_adds_an_energy() {
    let (axis, meter) = (axis(), meter(1_000_000));
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    assert_eq!(answered(&meter, with_line, engine.sample_at_all_energies()), Ok(true));
    assert_eq!(engine.energies.len(), 1);
    assert_eq!(verdict(&mut engine, &meter, with_line), Verdict::Failed);
    assert_eq!(engine.energies.len(), 2);
    let used = engine.energies_used();
    assert!(used.iter().any(|energy| (energy - 77.0 / 256.0).abs() < 6e-4), "{used:?}");
    assert_eq!(engine.sheets.len(), 2);
}

#[test]
fn a_short_budget_ends_the_verification() {
    let axis = axis();
    let parts = whole_view(1);
    let evaluations = |most: u64| {
        let meter = meter(most);
        let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
        assert_eq!(answered(&meter, continuum, engine.sample_at_all_energies()), Ok(true));
        (verdict(&mut engine, &meter, continuum), meter.evaluations())
    };
    let (passed, needed) = evaluations(100_000);
    assert_eq!(passed, Verdict::Passed);
    assert_eq!(evaluations(needed), (Verdict::Passed, needed));
    assert_eq!(evaluations(needed - 1).0, Verdict::Unaffordable);
}
