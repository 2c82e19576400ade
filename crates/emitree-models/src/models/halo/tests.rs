//! Halos have the published densities, and finite rates at all places but a cusp.

use super::*;
use crate::build_model;
use emitree::Emission;

type Build = fn(Process, &BTreeMap<String, f64>) -> Result<Halo, ModelError>;

const PROFILES: [Build; 3] = [Halo::nfw, Halo::einasto, Halo::burkert];

fn given<const N: usize>(parameters: [(&str, f64); N]) -> BTreeMap<String, f64> {
    parameters.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// Cirelli et al. 2011, section 2.1, have densities \[GeV cm⁻³\] where f is 1, to three digits or two,
/// that follow from 0.3 at 8.33 kpc, as ours do.
#[test]
fn characteristic_densities_are_the_published_ones() {
    let at_scale = |build: Build, scale_radius: f64, f: f64| {
        let halo = build(Process::Decay, &BTreeMap::new()).unwrap();
        halo.density_gev_cm3([0.0, 0.0, scale_radius]) / f
    };
    assert!((at_scale(Halo::nfw, 24.42, 0.25) - 0.184).abs() < 0.0005);
    assert!((at_scale(Halo::einasto, 28.44, 1.0) - 0.033).abs() < 0.0005);
    assert!((at_scale(Halo::burkert, 12.67, 0.25) - 0.712).abs() < 0.0005);
}

#[test]
fn annihilation_is_the_square_of_decay() {
    for build in PROFILES {
        let parameters = given([("centre_x", 1.0), ("local_density", 0.39), ("core_radius", 0.1)]);
        let [squared, plain] = [Process::Annihilation, Process::Decay]
            .map(|process| build(process, &parameters).unwrap());
        for position in [[1.0, 0.0, 0.0], [1.2, 0.0, -0.1], [1.0, 8.33, 0.0], [30.0, 40.0, 50.0]] {
            let density = plain.rate(position) / KILOPARSEC_CM;
            let ratio = squared.rate(position) / (density * density * KILOPARSEC_CM);
            assert!((ratio - 1.0).abs() < 1e-13, "{position:?}: {ratio}");
        }
        // A core changes the density at the Sun by a part in 10⁴.
        let sun = plain.density_gev_cm3([1.0, 8.33, 0.0]);
        assert!((sun / 0.39 - 1.0).abs() < 2e-4 && sun < 0.39, "{sun}");
    }
}

#[test]
fn the_halo_ends_at_its_outer_radius() {
    for build in PROFILES {
        let halo = build(Process::Annihilation, &given([("outer_radius", 8.5)])).unwrap();
        assert!(halo.rate([0.0, 8.5, 0.0]) > 0.0);
        assert_eq!(halo.rate([0.0, 8.500_001, 0.0]).to_bits(), 0);
    }
}

#[test]
fn rates_are_finite_everywhere_but_in_a_cusp_itself() {
    for build in PROFILES {
        for process in [Process::Annihilation, Process::Decay] {
            let halo = build(process, &BTreeMap::new()).unwrap();
            for distance in [1e-153, 1e-100, 1e-20, 1e-3, 1.0, 249.0] {
                let rate = halo.rate([0.0, 0.0, distance]);
                assert!(rate > 0.0 && rate.is_finite(), "{halo:?} at {distance:e}: {rate:e}");
            }
            let centre = halo.rate([0.0; 3]);
            assert_eq!(centre.is_infinite(), halo.profile == Profile::Nfw, "{halo:?}");
            assert!(!centre.is_nan());
        }
    }
}

#[test]
fn cusps_are_declared_with_the_power_of_the_rate() {
    for (name, exponent) in [
        ("nfw", Some(Some(2.0))),
        ("nfw_decay", Some(Some(1.0))),
        ("einasto", Some(None)),
        ("einasto_decay", Some(None)),
        ("burkert", None),
        ("burkert_decay", None),
    ] {
        let centre = given([("centre_x", 1.0), ("centre_y", -2.0), ("centre_z", 0.5)]);
        let halo = build_model(name, &centre).unwrap();
        let points: Vec<_> =
            halo.singular_points().iter().map(|point| (point.position, point.exponent)).collect();
        let expected: Vec<_> =
            exponent.map(|exponent| ([1.0, -2.0, 0.5], exponent)).into_iter().collect();
        assert_eq!(points, expected, "{name}");
        if let Some(Some(power)) = exponent {
            let at = |offset: f64| {
                let mut rate = [0.0];
                let positions = [[1.0 + offset, -2.0, 0.5]];
                let samples = Samples::new(&positions, &[[0.0, 0.0, 1.0]]);
                halo.emission_rates(&samples, &mut rate).map(|()| rate[0]).unwrap()
            };
            let measured = (at(1e-5) / at(2e-5)).log2();
            assert!((measured - power).abs() < 1e-5, "{name}: {measured}");
        }
    }
}

#[test]
fn absurd_scales_are_refused() {
    let message = |build: Build, parameters| {
        build(Process::Annihilation, &parameters).unwrap_err().to_string()
    };
    assert_eq!(
        message(Halo::einasto, given([("alpha", 10.0), ("scale_radius", 1e-3)])),
        "parameter `scale_radius` of model `einasto` is 0.001: expected such that the densities at \
         local_radius and at the centre are numbers"
    );
    assert!(message(Halo::nfw, given([("scale_radius", 1e-120)])).contains("`scale_radius`"));
}
