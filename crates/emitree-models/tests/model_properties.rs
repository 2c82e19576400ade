//! What holds for every place and direction, and for every parameter that is accepted.

use emitree::{Emission, Samples};
use emitree_models::models::{Bremsstrahlung, Chamberlain, Ena, EnaRing};
use emitree_models::{build_model, catalogue};
use proptest::prelude::*;
use std::collections::BTreeMap;

/// A unit vector.
fn direction() -> impl Strategy<Value = [f64; 3]> {
    (-1.0..=1.0_f64, 0.0..std::f64::consts::TAU).prop_map(|(z, phi)| {
        let rho = (1.0 - z * z).sqrt();
        [rho * phi.cos(), rho * phi.sin(), z]
    })
}

/// A number of a magnitude between two powers of 10.
fn magnitude(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from..to).prop_map(|exponent| 10.0_f64.powf(exponent))
}

fn given<const N: usize>(parameters: [(&str, f64); N]) -> BTreeMap<String, f64> {
    parameters.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

proptest! {
    #[test]
    fn rates_are_finite_and_not_negative(
        distance in magnitude(-12.0, 60.0),
        place in direction(),
        towards in direction(),
        energy in magnitude(-12.0, 12.0),
    ) {
        let position = [place.map(|component| distance * component)];
        for description in catalogue() {
            let mut rate = [f64::NAN];
            let model = build_model(description.name, &BTreeMap::new()).unwrap();
            let samples = Samples::new(&position, std::slice::from_ref(&towards))
                .at_energies(std::slice::from_ref(&energy));
            model.emission_rates(&samples, &mut rate).unwrap();
            prop_assert!(rate[0].is_finite() && rate[0] >= 0.0, "{}", description.name);
        }
    }

    /// Models that work on blocks of positions have blocks that are lit in part.
    #[test]
    fn in_any_batch_the_same_bits(
        scale in magnitude(-2.0, 9.0),
        towards in direction(),
        energy in magnitude(-1.0, 1.0),
        count in 1_usize..600,
    ) {
        let steps = [2.0_f64.sqrt(), 3.0_f64.sqrt(), 5.0_f64.sqrt()];
        let component = |i: usize, step: f64| scale * (2.0 * (i as f64 * step).fract() - 1.0);
        let positions: Vec<_> = (0..count).map(|i| steps.map(|step| component(i, step))).collect();
        let (directions, energies) = (vec![towards; count], vec![energy; count]);
        let samples = Samples::new(&positions, &directions).at_energies(&energies);
        for description in catalogue() {
            let model = build_model(description.name, &BTreeMap::new()).unwrap();
            let (mut rates, mut rate) = (vec![f64::NAN; count], [f64::NAN]);
            model.emission_rates(&samples, &mut rates).unwrap();
            for i in (0..count).step_by(7) {
                let sample = Samples::new(&positions[i..=i], &directions[i..=i]);
                let sample = sample.at_energies(&energies[i..=i]);
                model.emission_rates(&sample, &mut rate).unwrap();
                prop_assert_eq!(rate[0].to_bits(), rates[i].to_bits(), "{}", description.name);
            }
        }
    }

    /// Whatever the cluster, however cold and far.
    #[test]
    fn spectra_of_any_cluster_are_numbers(
        core_radius in magnitude(-3.0, 6.0),
        beta in 0.0..100.0_f64,
        temperature in magnitude(-6.0, 6.0),
        (core_fraction, cooling_exponent) in (0.01..=1.0_f64, magnitude(-1.0, 2.0)),
        (decline_radius, decline_exponent) in (magnitude(-3.0, 6.0), 0.0..100.0_f64),
        distance in magnitude(-12.0, 200.0),
        energy in magnitude(-12.0, 12.0),
    ) {
        let cluster = Bremsstrahlung::new(&given([
            ("core_radius", core_radius),
            ("beta", beta),
            ("temperature", temperature),
            ("core_fraction", core_fraction),
            ("cooling_exponent", cooling_exponent),
            ("decline_radius", decline_radius),
            ("decline_exponent", decline_exponent),
        ])).unwrap();
        let [rate, harder] =
            [energy, 2.0 * energy].map(|energy| cluster.rate([0.0, distance, 0.0], energy));
        prop_assert!(rate.is_finite() && harder >= 0.0, "{rate:e}, {harder:e}");
        prop_assert!(harder < rate || rate <= f64::MIN_POSITIVE, "{rate:e}, {harder:e}");
    }

    /// Whatever the ring, at any latitude, as if there were no charge exchange.
    #[test]
    fn spectra_of_any_ring_are_numbers(
        temperature in magnitude(-3.0, 4.0),
        (exponent, kappa) in (0.0..=10.0_f64, magnitude(0.21, 4.0)),
        (shell, shell_width) in (1.08..=20.0_f64, magnitude(-2.0, 1.3)),
        latitude_width in magnitude(-1.0, 6.0),
        place in direction(),
        distance in magnitude(0.034, 200.0),
        energy in magnitude(-12.0, 12.0),
    ) {
        let ring = EnaRing::new(&given([
            ("ion_temperature", temperature),
            ("temperature_exponent", exponent),
            ("kappa", kappa),
            ("shell", shell),
            ("shell_width", shell_width),
            ("latitude_width", latitude_width),
        ])).unwrap();
        let position = place.map(|component| distance * component);
        let (flux, rate) = (ring.proton_flux(position, energy), ring.rate(position, energy));
        prop_assert!(flux.is_finite() && flux >= 0.0, "{flux:e}");
        prop_assert!(rate.is_finite() && rate >= 0.0, "{rate:e}");
        // Symmetric around the axis, and about the equator.
        let [x, y, z] = position;
        let turned = ring.proton_flux([y, -x, -z], energy);
        let bound = 1e-9 * flux + f64::MIN_POSITIVE;
        prop_assert!((turned - flux).abs() <= bound, "{flux:e}, {turned:e}");
    }

    #[test]
    fn exospheres_of_any_binding_fall_with_the_distance(
        temperature in magnitude(0.0, 7.0),
        particle_mass in magnitude(-27.0, -24.0),
        lower in magnitude(0.0, 6.0),
        step in magnitude(-6.0, 1.0),
    ) {
        let parameters = given([("temperature", temperature), ("particle_mass", particle_mass)]);
        let exosphere = Chamberlain::new(&parameters).unwrap();
        let [below, above] = [lower, lower * (1.0 + step)]
            .map(|in_radii| exosphere.density_m3([0.0, 0.0, 6.871e6 * in_radii]));
        prop_assert!(below.is_finite() && above >= 0.0);
        prop_assert!(above < below || below <= f64::MIN_POSITIVE, "{below:e}, {above:e}");
    }

    #[test]
    fn atoms_depend_only_on_the_drift_along_their_path(
        temperature in magnitude(3.0, 9.0),
        velocity in prop::array::uniform3(-3e6..3e6_f64),
        towards in direction(),
    ) {
        let [x, y, z] = velocity;
        let drift = [("velocity_x", x), ("velocity_y", y), ("velocity_z", z)];
        // The same wind and direction with their axes exchanged.
        let turned = [("velocity_x", z), ("velocity_y", x), ("velocity_z", y)];
        let [rate, again] = [(drift, towards), (turned, [towards[2], towards[0], towards[1]])].map(
            |(drift, towards)| {
                let mut parameters = given(drift);
                parameters.insert("ion_temperature".to_owned(), temperature);
                Ena::new(&parameters).unwrap().rate([5e6, 0.0, 0.0], towards)
            },
        );
        prop_assert!(rate.is_finite() && rate >= 0.0);
        prop_assert!((again - rate).abs() <= 1e-8 * rate + f64::MIN_POSITIVE, "{rate:e}, {again:e}");
    }
}
