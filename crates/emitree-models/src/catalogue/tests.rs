//! The catalogue is complete and consistent, and its errors are clear.

use super::*;
use emitree::{Emission, Samples};

fn parameters<const N: usize>(given: [(&str, f64); N]) -> BTreeMap<String, f64> {
    given.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn failure<const N: usize>(model: &str, given: [(&str, f64); N]) -> String {
    build_model(model, &parameters(given)).unwrap_err().to_string()
}

#[test]
fn every_model_builds_with_its_defaults() {
    for description in catalogue() {
        let model = build_model(description.name, &BTreeMap::new()).unwrap();
        assert_eq!(model.parameters().len(), description.parameters.len());
        assert!(model.parameters().all(|(_, value)| value.is_finite()));
        // Given explicitly, the same values make the same model.
        let given = model.parameters().map(|(name, value)| (name.to_owned(), value)).collect();
        let again = build_model(description.name, &given).unwrap();
        assert_eq!(format!("{model:?}"), format!("{again:?}"));
    }
}

#[test]
fn every_model_is_finite_except_at_the_points_that_it_declares() {
    let mut positions = vec![[0.0; 3], [-0.0; 3]];
    for axis in 0..3 {
        for distance in [1e-300, 1e-9, 1e-3, 1.0, 10.0, 1e3, 1e9, 1e30, 1e100] {
            let mut position = [0.0; 3];
            position[axis] = distance;
            positions.push(position);
            positions.push(position.map(|component: f64| -component));
        }
    }
    let directions = vec![[0.0, 0.0, 1.0]; positions.len()];
    let energies = vec![2.0; positions.len()];
    let samples = Samples::new(&positions, &directions).at_energies(&energies);
    for description in catalogue() {
        let model = build_model(description.name, &BTreeMap::new()).unwrap();
        let mut rates = vec![f64::NAN; positions.len()];
        model.emission_rates(&samples, &mut rates).unwrap();
        // The square of a smaller distance is not a number.
        let cusps = model.singular_points();
        let declared = |position: &[f64; 3]| {
            let far = |cusp: &SingularPoint, i: usize| (position[i] - cusp.position[i]).abs();
            cusps.iter().any(|cusp| (0..3).all(|i| far(cusp, i) < 1e-150))
        };
        for (rate, position) in rates.iter().zip(&positions) {
            let is_allowed = rate.is_finite() || (*rate == f64::INFINITY && declared(position));
            assert!(is_allowed && *rate >= 0.0, "{} at {position:?}", description.name);
        }
    }
}

/// On one side of each declared sphere the rate is 0, on the other it is not.
#[test]
fn rates_jump_at_the_declared_edges() {
    let mut spheres = Vec::new();
    for description in catalogue() {
        // The usual layer of the airglow is below the least number at the surface of the planet.
        let low_layer = BTreeMap::from([("peak_altitude".to_owned(), 5.0)]);
        let given = if description.name == "airglow" { low_layer } else { BTreeMap::new() };
        let model = build_model(description.name, &given).unwrap();
        for edge in model.edges() {
            let rate = |factor: f64| {
                let [x, y, z] = edge.centre;
                let along = factor * edge.radius;
                let (position, mut rates) = ([[x + 0.6 * along, y, z + 0.8 * along]], [f64::NAN]);
                let samples = Samples::new(&position, &[[0.0, 0.6, 0.8]]);
                model.emission_rates(&samples.at_energies(&[2.0]), &mut rates).unwrap();
                rates[0]
            };
            let [inside, outside] = [1.0 - 1e-9, 1.0 + 1e-9].map(rate);
            let (least, most) = (inside.min(outside), inside.max(outside));
            assert!(least == 0.0 && most > 0.0, "{}: {edge:?}", description.name);
            spheres.push(description.name);
        }
    }
    let without = ["cmem", "jorgensen", "beta_model", "bremsstrahlung", "uniform", "holmstrom"];
    assert_eq!(spheres.len(), 19, "{spheres:?}");
    spheres.dedup();
    assert_eq!(spheres.len() + without.len(), catalogue().len());
    assert!(without.iter().all(|name| !spheres.contains(name)), "{spheres:?}");
}

#[test]
fn models_that_need_energies_say_so_and_the_others_have_flat_spectra() {
    let (positions, directions) = ([[3.0, -2.0, 1.0]; 3], [[0.0, 0.0, 1.0]; 3]);
    let samples = Samples::new(&positions, &directions);
    let mut spectral = Vec::new();
    for description in catalogue() {
        let model = build_model(description.name, &BTreeMap::new()).unwrap();
        let (mut without, mut with) = ([f64::NAN; 3], [f64::NAN; 3]);
        model.emission_rates(&samples, &mut without).unwrap();
        model.emission_rates(&samples.at_energies(&[1.0, 5.0, 20.0]), &mut with).unwrap();
        assert_eq!(model.needs_energy(), description.energy_unit.is_some());
        if model.needs_energy() {
            assert!(without.iter().all(|rate| rate.is_nan()), "{}", description.name);
            assert!(with[0] > 0.0 && with[1] > 0.0 && with[2] > 0.0, "{}", description.name);
            assert!((with[0] / with[1] - 1.0).abs() > 0.1, "{}", description.name);
            spectral.push(description.name);
        } else {
            assert_eq!(with.map(f64::to_bits), without.map(f64::to_bits), "{}", description.name);
        }
    }
    assert_eq!(spectral, ["ena_ring", "bremsstrahlung"]);
}

#[test]
fn names_are_unique_and_texts_are_there() {
    let mut names: Vec<_> = catalogue().iter().map(|model| model.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), catalogue().len());
    for model in catalogue() {
        assert!(model.summary.ends_with('.') && !model.source.is_empty());
        let mut names: Vec<_> = model.parameters.iter().map(|parameter| parameter.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), model.parameters.len(), "{}", model.name);
        assert!(model.parameters.iter().all(|parameter| !parameter.meaning.is_empty()));
    }
}

#[test]
fn derived_defaults_follow_what_is_given() {
    let derived = |given, name| build_model("jorgensen", &given).unwrap().parameter(name).unwrap();
    let moved = parameters([("magnetopause_r0", 9.0), ("magnetopause_ay", 0.5)]);
    assert!((derived(moved.clone(), "bow_shock_r0") - 12.0).abs() < 1e-15);
    assert!((derived(moved, "bow_shock_ay") - 0.7).abs() < 1e-15);
    let cmem = build_model("cmem", &parameters([("density", 10.0)])).unwrap();
    assert!((cmem.parameter("p0").unwrap() - 0.7973).abs() < 1e-15);
    assert!((cmem.parameter("bow_shock_r0").unwrap() - 12.04).abs() < 1e-14);
    assert_eq!(cmem.parameter("p4"), None);
}

#[test]
fn defaults_can_be_shown() {
    let cmem = &catalogue()[0];
    let shown = |name: &str| {
        let parameter = cmem.parameters.iter().find(|parameter| parameter.name == name);
        parameter.unwrap().default.to_string()
    };
    assert_eq!(shown("density"), "5.0");
    assert_eq!(shown("p0"), "0.0022 density + 0.7753");
}

#[test]
fn unknown_names() {
    const KNOWN: &str = "(known: cmem, jorgensen, geocorona, chamberlain, airglow, mars_hydrogen, \
                         mars_oxygen, ena, ena_ring, k_corona, k_corona_polarised, beta_model, bremsstrahlung, \
                         nfw, nfw_decay, einasto, einasto_decay, burkert, burkert_decay, \
                         shell_nebula, power_law, uniform, holmstrom)";
    assert_eq!(
        failure("cmem_2", []),
        format!("unknown model `cmem_2`: did you mean `cmem`? {KNOWN}")
    );
    assert_eq!(failure("aurora", []), format!("unknown model `aurora` {KNOWN}"));
    assert_eq!(
        failure("cmem", [("a1", 1e-5)]),
        "model `cmem` has no parameter `a1`: did you mean `A1`? (known: density, velocity, bx, by, \
         bz, dipole_tilt, p0, p1, p2, p3, bow_shock_r0, bow_shock_ay, bow_shock_az, A1, A2, B, \
         alpha, beta)"
    );
    assert_eq!(
        failure("holmstrom", [("width", 1.0)]),
        "model `holmstrom` has no parameter `width` (known: alpha)"
    );
}

#[test]
fn values_out_of_range() {
    assert_eq!(
        failure("cmem", [("density", f64::NAN)]),
        "parameter `density` of model `cmem` is NaN: expected a finite number more than 0"
    );
    assert_eq!(
        failure("jorgensen", [("B", f64::INFINITY)]),
        "parameter `B` of model `jorgensen` is inf: expected a finite number"
    );
    assert_eq!(
        failure("jorgensen", [("bz", 500.0)]),
        "parameter `bz` of model `jorgensen` is 500.0: expected a number from -200 to 200"
    );
    assert_eq!(
        failure("holmstrom", [("alpha", -1.0)]),
        "parameter `alpha` of model `holmstrom` is -1.0: expected a finite number, 0 or more"
    );
    assert_eq!(
        failure("bremsstrahlung", [("temperature", 0.0)]),
        "parameter `temperature` of model `bremsstrahlung` is 0.0: expected a finite number more \
         than 0"
    );
    assert_eq!(
        failure("ena_ring", [("kappa", 1.5)]),
        "parameter `kappa` of model `ena_ring` is 1.5: expected a number from 1.6 to 10000"
    );
}

#[test]
fn values_that_do_not_go_together() {
    assert_eq!(
        failure("jorgensen", [("B", -4e-5)]),
        "parameter `B` of model `jorgensen` is -4e-5: expected at least -A1 = -3.2e-5"
    );
    assert_eq!(
        failure("cmem", [("density", 200.0)]),
        "parameter `bow_shock_r0` of model `cmem` is -10.76, from its default 13.24 - 0.12 \
         density: expected a finite number more than 0; change what it depends on, or give \
         `bow_shock_r0` itself"
    );
    assert!(build_model("cmem", &parameters([("density", 200.0), ("bow_shock_r0", 5.0)])).is_ok());
    assert!(failure("cmem", [("density", 2.0)]).starts_with("parameter `A1` of model `cmem` is -"));
}
