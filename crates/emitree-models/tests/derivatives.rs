//! The derivatives of every built-in model by every parameter, against differences of its rates; and where
//! the rate jumps as a parameter changes.

use emitree::{Emission, Samples};
use emitree_models::{DifferentiableModel, build_model, catalogue};
use std::collections::BTreeMap;

/// A model, the distances of its test points from the origin, and parameters other than their defaults.
type Case = (&'static str, [f64; 2], &'static [(&'static str, f64)]);

const CASES: [Case; 23] = [
    ("cmem", [4.0, 25.0], &[("bx", 3.0), ("by", -2.0), ("dipole_tilt", 0.2), ("density", 8.0)]),
    ("jorgensen", [4.0, 25.0], &[("bx", 3.0), ("bz", -4.0), ("B", 3e-6)]),
    ("geocorona", [1.1, 15.0], &[("inner_radius", 2.0)]),
    ("chamberlain", [5e6, 5e7], &[]),
    ("airglow", [6365.0, 6410.0], &[("peak_altitude", 5.0)]),
    ("mars_hydrogen", [3e6, 2e7], &[]),
    ("mars_oxygen", [3e6, 2e7], &[]),
    ("ena", [3e6, 2e7], &[("ion_temperature", 2e6), ("velocity_y", 1e5), ("velocity_z", -5e4)]),
    ("ena_ring", [1.1, 8.0], &[]),
    ("k_corona", [1.0, 8.0], &[]),
    ("k_corona_polarised", [1.0, 8.0], &[]),
    ("beta_model", [0.0, 5.0], &[("centre_x", 0.3), ("centre_y", -0.2), ("centre_z", 0.1)]),
    (
        "bremsstrahlung",
        [0.0, 1500.0],
        &[("centre_x", 30.0), ("centre_y", -20.0), ("centre_z", 9.0)],
    ),
    ("nfw", [0.1, 300.0], &[("centre_x", 3.0), ("centre_y", -2.0), ("centre_z", 1.0)]),
    ("nfw_decay", [0.1, 300.0], &[("core_radius", 0.5), ("centre_x", 3.0)]),
    ("einasto", [0.1, 300.0], &[("core_radius", 0.5), ("centre_y", -3.0)]),
    ("einasto_decay", [0.1, 300.0], &[("centre_z", 3.0)]),
    ("burkert", [0.1, 300.0], &[("core_radius", 2.0), ("centre_x", 3.0)]),
    ("burkert_decay", [0.1, 300.0], &[("centre_x", 3.0)]),
    ("shell_nebula", [0.5, 1.2], &[("centre_x", 0.1), ("centre_y", -0.05), ("centre_z", 0.02)]),
    ("power_law", [0.7, 5.0], &[("centre_x", 0.3), ("centre_y", -0.2), ("centre_z", 0.1)]),
    ("uniform", [0.0, 5.0], &[]),
    ("holmstrom", [0.5, 1.2], &[]),
];

/// Points at distances that are uniform in a range, with directions and energies \[keV\].
struct Points {
    positions: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
    energies: Vec<f64>,
}

impl Points {
    fn new(count: usize, [from, to]: [f64; 2], are_positive: bool) -> Self {
        let at = |i: usize, step: f64| ((i + 1) as f64 * step).fract();
        let sphere = |i: usize, steps: [f64; 2]| {
            let (z, phi) = (2.0 * at(i, steps[0]) - 1.0, std::f64::consts::TAU * at(i, steps[1]));
            let rho = (1.0 - z * z).sqrt();
            [rho * phi.cos(), rho * phi.sin(), z]
        };
        let distance = |i: usize| from + (to - from) * at(i, 2.0_f64.sqrt());
        let position = |i: usize| {
            let place = sphere(i, [3.0_f64.sqrt(), 5.0_f64.sqrt()]).map(|x| distance(i) * x);
            if are_positive { place.map(f64::abs) } else { place }
        };
        Self {
            positions: (0..count).map(position).collect(),
            directions: (0..count).map(|i| sphere(i, [7.0_f64.sqrt(), 11.0_f64.sqrt()])).collect(),
            energies: (0..count).map(|i| 0.5 + 30.0 * at(i, 13.0_f64.sqrt())).collect(),
        }
    }

    fn samples(&self) -> Samples<'_> {
        Samples::new(&self.positions, &self.directions).at_energies(&self.energies)
    }

    fn one(&self, i: usize) -> Samples<'_> {
        Samples::new(&self.positions[i..=i], &self.directions[i..=i])
            .at_energies(&self.energies[i..=i])
    }
}

/// All cases, with the parameters given and points.
fn cases(count: usize) -> impl Iterator<Item = (&'static str, BTreeMap<String, f64>, Points)> {
    CASES.into_iter().map(move |(name, distances, given)| {
        let given = given.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        (name, given, Points::new(count, distances, name == "holmstrom"))
    })
}

/// The rates with one parameter changed; `None` if the model does not accept it.
fn changed(
    name: &str,
    given: &BTreeMap<String, f64>,
    (parameter, value): (&str, f64),
    samples: &Samples<'_>,
) -> Option<Vec<f64>> {
    let mut given = given.clone();
    given.insert(parameter.to_owned(), value);
    let model = build_model(name, &given).ok()?;
    let mut rates = vec![f64::NAN; samples.len()];
    model.emission_rates(samples, &mut rates).unwrap();
    Some(rates)
}

#[test]
fn every_model_has_a_case() {
    let names: Vec<_> = catalogue().iter().map(|model| model.name).collect();
    assert!(CASES.iter().map(|(name, ..)| *name).eq(names));
}

/// Differences of the fourth order, (8 (f(h) − f(−h)) − (f(2h) − f(−2h)))/12h, in steps that are halved from a
/// tenth of the parameter to 10⁻⁸ of it. The error of the best step is its difference from the one before and
/// that of the roundings of the rates; the derivative has to be within ten times that.
#[test]
fn derivatives_are_limits_of_differences() {
    let mut checked = 0;
    for (name, given, points) in cases(40) {
        let samples = points.samples();
        let all: Vec<_> = build_model(name, &given).unwrap().parameters().collect();
        let names: Vec<_> = all.iter().map(|(parameter, _)| *parameter).collect();
        let model = DifferentiableModel::new(name, &given, &names).unwrap();
        let n = samples.len();
        let (mut rates, mut derivatives) = (vec![0.0; n], vec![f64::NAN; n * names.len()]);
        model.rates_and_derivatives(&samples, &mut rates, &mut derivatives);
        assert!(rates.iter().any(|&rate| rate > 0.0), "{name}");
        for ((parameter, value), derivatives) in all.into_iter().zip(derivatives.chunks(n)) {
            let moves_jump = model.moves_jumps().contains(&parameter);
            let scale = if value == 0.0 { 1.0 } else { value.abs() };
            // Beside a surface that moves, large steps have it pass the points.
            let largest = if moves_jump { 16 } else { 3 };
            let differences: Vec<_> = (largest..27)
                .filter_map(|halvings| {
                    let step = scale * 0.5_f64.powi(halvings);
                    let at = |steps: f64| {
                        changed(name, &given, (parameter, value + steps * step), &samples)
                    };
                    let [far_below, below, above, far_above] =
                        [at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?];
                    let difference = |i: usize| {
                        let (near, far) = (above[i] - below[i], far_above[i] - far_below[i]);
                        (8.0 * near - far) / (12.0 * step)
                    };
                    let values = (0..n).map(difference).collect::<Vec<_>>();
                    let roundings: Vec<_> = (0..n)
                        .map(|i| 4.0 * f64::EPSILON * far_above[i].max(rates[i]) / step)
                        .collect();
                    Some((values, roundings))
                })
                .collect();
            // At the border of the accepted values there are no central differences.
            assert!(differences.len() > 4 || value == 0.0, "{name}, {parameter}");
            for (i, &derivative) in derivatives.iter().enumerate() {
                let best = differences
                    .windows(2)
                    .map(|pair| {
                        let ((coarse, _), (fine, roundings)) = (&pair[0], &pair[1]);
                        (fine[i], (fine[i] - coarse[i]).abs() + roundings[i])
                    })
                    .min_by(|(_, a), (_, b)| a.total_cmp(b));
                let Some((difference, error)) = best else { continue };
                let size = derivative.abs().max(rates[i] / scale);
                if size > 0.0 && size < 1e-250 {
                    // Numbers of the size of the smallest one have few digits.
                    continue;
                }
                // Roundings of exponents of hundreds are more than those of the rates.
                let allowed = 10.0 * error + 1e-9 * size;
                assert!(
                    (derivative - difference).abs() <= allowed,
                    "{name} by {parameter} at {:?}: {derivative:e}, differences {difference:e}, \
                     error {error:e}, rate {:e}",
                    points.positions[i],
                    rates[i],
                );
                // A jump within all of the steps would make the error as large as anything.
                assert!(error <= 1e-8 * size, "{name} by {parameter}: {error:e}");
                checked += 1;
            }
        }
    }
    assert!(checked > 6000, "{checked}");
}

/// Values of a parameter between which jumps are looked for, and the points at which they are bisected: those
/// whose rates change most from one value to the next.
const VALUES: u32 = 16;
const BISECTED: usize = 3;

/// Relative differences of rates above this are jumps, if they remain between values that are neighbours.
const CONTINUOUS: f64 = 1e-6;

/// The difference of two rates relative to the larger one; rates of the size of the smallest number are steps.
fn relative_change(a: f64, b: f64) -> f64 {
    let largest = a.max(b);
    if largest > 1e-250 { (b - a).abs() / largest } else { 0.0 }
}

/// Whether the rate at a point jumps between two values of a parameter: bisection keeps the half with the larger
/// difference, until there is none or no half is left.
fn jumps_between(
    rate_at: impl Fn(f64) -> Option<f64>,
    mut values: [f64; 2],
    mut rates: [f64; 2],
) -> bool {
    loop {
        let middle = 0.5 * (values[0] + values[1]);
        if relative_change(rates[0], rates[1]) < CONTINUOUS {
            return false;
        }
        if middle <= values[0] || middle >= values[1] {
            return true;
        }
        let Some(rate) = rate_at(middle) else { return false };
        let upper = usize::from((rate - rates[0]).abs() > (rates[1] - rate).abs());
        (values[upper], rates[upper]) = (middle, rate);
    }
}

/// Whether the rate at one of the points jumps as a parameter changes over a range.
fn jumps(
    name: &str,
    given: &BTreeMap<String, f64>,
    parameter: &str,
    [from, to]: [f64; 2],
    points: &Points,
) -> bool {
    let value = |k: u32| from + (to - from) * f64::from(k) / f64::from(VALUES);
    let rates: Vec<_> = (0..=VALUES)
        .map(|k| changed(name, given, (parameter, value(k)), &points.samples()))
        .collect();
    let mut steps: Vec<_> = (0..VALUES)
        .filter_map(|k| {
            let at = |k: u32| rates[k as usize].as_ref();
            Some((k, at(k)?, at(k + 1)?))
        })
        .flat_map(|(k, low, high)| {
            let change = move |(i, (&a, &b)): (usize, (&f64, &f64))| {
                (relative_change(a, b), i, [value(k), value(k + 1)], [a, b])
            };
            low.iter().zip(high).enumerate().map(change)
        })
        .collect();
    steps.sort_by(|a, b| b.0.total_cmp(&a.0));
    steps.into_iter().take(BISECTED).any(|(_, i, values, rates)| {
        let rate_at =
            |value| changed(name, given, (parameter, value), &points.one(i)).map(|rates| rates[0]);
        jumps_between(rate_at, values, rates)
    })
}

#[test]
fn the_rates_jump_with_the_parameters_that_say_so_and_no_others() {
    for (name, given, points) in cases(2000) {
        let all: Vec<_> = build_model(name, &given).unwrap().parameters().collect();
        for (parameter, value) in all {
            let model = DifferentiableModel::new(name, &given, &[parameter]).unwrap();
            let moves_jump = !model.moves_jumps().is_empty();
            let scale = if value == 0.0 { 1.0 } else { 0.25 * value.abs() };
            let far = if value.abs() < 10.0 { 30.0 } else { scale };
            let ranges = [[value, value + scale], [value - scale, value], [value, value + far]];
            let found =
                ranges.into_iter().any(|range| jumps(name, &given, parameter, range, &points));
            assert_eq!(found, moves_jump, "{name}, {parameter}");
        }
    }
}

#[test]
fn rates_are_those_of_the_model_and_parts_of_batches_are_the_same() {
    for (name, given, points) in cases(5000) {
        let samples = points.samples();
        let model = build_model(name, &given).unwrap();
        let parameter = model.parameters().next().unwrap().0;
        let differentiable = DifferentiableModel::new(name, &given, &[parameter]).unwrap();
        let mut expected = vec![f64::NAN; samples.len()];
        model.emission_rates(&samples, &mut expected).unwrap();
        let [mut rates, mut derivatives] = [(); 2].map(|()| vec![f64::NAN; samples.len()]);
        differentiable.rates_and_derivatives(&samples, &mut rates, &mut derivatives);
        assert!(rates.iter().zip(&expected).all(|(a, b)| a.to_bits() == b.to_bits()), "{name}");
        for i in [0, 4095, 4096, 4999] {
            let (mut rate, mut derivative) = ([f64::NAN], [f64::NAN]);
            differentiable.rates_and_derivatives(&points.one(i), &mut rate, &mut derivative);
            assert_eq!(derivative[0].to_bits(), derivatives[i].to_bits(), "{name}, {i}");
        }
    }
}

#[test]
fn defaults_that_follow_from_a_parameter_change_with_it() {
    // The emissivity of the solar wind of cmem is A2 (r/10)^-3 with A2 = 9e-7 density - 1e-6.
    let points = Points {
        positions: vec![[30.0, 0.0, 0.0]],
        directions: vec![[1.0, 0.0, 0.0]],
        energies: vec![],
    };
    let derivative = |given: &BTreeMap<String, f64>| {
        let model = DifferentiableModel::new("cmem", given, &["density"]).unwrap();
        let (mut rate, mut derivative) = ([0.0], [f64::NAN]);
        model.rates_and_derivatives(
            &Samples::new(&points.positions, &points.directions),
            &mut rate,
            &mut derivative,
        );
        (rate[0], derivative[0])
    };
    let (rate, by_density) = derivative(&BTreeMap::new());
    assert!((by_density / rate * (9e-7 * 5.0 - 1e-6) / 9e-7 - 1.0).abs() < 1e-14);
    let (_, given) = derivative(&BTreeMap::from([("A2".to_owned(), 3e-6)]));
    assert_eq!(given.to_bits(), 0.0_f64.to_bits());
}

#[test]
fn errors_name_the_parameter() {
    let failure = |name: &str, by: &[&str]| {
        DifferentiableModel::new(name, &BTreeMap::new(), by).unwrap_err().to_string()
    };
    assert_eq!(
        failure("uniform", &["amplitude", "amplitude"]),
        "parameter `amplitude` of model `uniform` is differentiated by twice: expected each once"
    );
    assert_eq!(
        failure("holmstrom", &["alpa"]),
        "model `holmstrom` has no parameter `alpa`: did you mean `alpha`? (known: alpha)"
    );
    assert!(failure("cmen", &[]).starts_with("unknown model `cmen`"));
}
