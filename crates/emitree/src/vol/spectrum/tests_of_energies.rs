//! Bins, selected energies and spectral probes, on families of known rank.

use crate::EnergyScale;
use crate::energy::EnergyAxis;
use crate::image::Image;
use crate::vol::dyadic::{STEPS, spacing, unit};
use crate::vol::sampling::View;
use crate::vol::spectrum::Spectrum;
use crate::vol::spectrum::bins::Bins;
use crate::vol::spectrum::energies::{Energies, ResidualSpectrum, unexplained};
use crate::vol::spectrum::probes::{LINE_LEVEL, ProbePoint, SpectralProbes, SpotCheck};
use crate::vol::testing::{PANE, answered, assert_close, at, meter, view};
use crate::vol::tuning::TUNING;
use std::sync::Arc;

fn axis(min: f64, max: f64, bins: usize, scale: EnergyScale) -> EnergyAxis {
    EnergyAxis::new(min, max, bins, scale).unwrap()
}

/// Energies from 2 to 6 in four bins.
fn linear() -> EnergyAxis {
    axis(2.0, 6.0, 4, EnergyScale::Linear)
}

/// Energies from 1 to 16 in four bins.
fn logarithmic() -> EnergyAxis {
    axis(1.0, 16.0, 4, EnergyScale::Log)
}

/// A spectrum sampled on the lattice of `level`, given G at canonical coordinates.
fn spectrum(level: u8, rate: impl Fn(f64) -> f64) -> Spectrum {
    let mut spectrum = Spectrum::default();
    (0..=1_u32 << level)
        .for_each(|k| spectrum.add(k * spacing(level), rate(unit(k * spacing(level)))));
    spectrum
}

#[test]
fn the_means_of_a_linear_spectrum_are_its_values_in_the_middle_of_bins() {
    let axis = linear();
    let means = Bins::new(&axis).means(&spectrum(3, |u| 1.0 + 4.0 * u));
    for (mean, expected) in means.into_iter().zip([1.5, 2.5, 3.5, 4.5]) {
        assert_close(mean, expected, 1e-14);
    }
}

#[test]
fn on_a_logarithmic_axis_means_are_per_unit_of_energy() {
    let axis = logarithmic();
    let bins = Bins::new(&axis);
    for (factor, bin) in bins.factors.iter().zip(0..) {
        // Bins of 1, 2, 4 and 8 units, where they are 15 / 4 on average.
        assert_close(*factor, 3.75 / 2.0_f64.powi(bin), 1e-13);
    }
    // 3 per unit of energy, and as much as the energy.
    let even = bins.means(&spectrum(6, |u| 3.0 * bins.density(u)));
    let rising = bins.means(&spectrum(6, |u| axis.energy(u) * bins.density(u)));
    for (bin, (even, rising)) in even.into_iter().zip(rising).enumerate() {
        assert_close(even, 3.0, 1e-8);
        assert_close(rising, 1.5 * 2.0_f64.powi(i32::try_from(bin).unwrap()), 1e-7);
    }
}

#[test]
fn a_sample_has_its_energy_and_the_density_there() {
    let [linear, logarithmic] = [linear(), logarithmic()];
    let sample = Bins::new(&linear).sample_at(STEPS / 4);
    assert_close(sample.energy, 3.0, 1e-15);
    assert_close(sample.density, 1.0, 1e-15);
    let sample = Bins::new(&logarithmic).sample_at(STEPS / 4);
    assert_close(sample.energy, 2.0, 1e-14);
    assert_close(sample.density, 2.0 * 16.0_f64.ln() / 15.0, 1e-14);
}

/// The two functions of a family of rank 2, quartics, which are exact from the base on.
fn first(u: f64) -> f64 {
    1.0 + 3.0 * u * u
}

fn second(u: f64) -> f64 {
    2.0 - u - u.powi(4)
}

const MIXTURES: [(f64, f64); 4] = [(1.0, 0.0), (0.2, 1.0), (-0.5, 0.7), (2.0, 0.1)];

/// Spectral probes with the spectra of a family.
fn family<'a>(axis: &'a EnergyAxis, mixtures: &[(f64, f64)]) -> SpectralProbes<'a> {
    let mut probes = SpectralProbes::new(Bins::new(axis));
    for (k, (a, b)) in (0..).zip(mixtures) {
        probes.add(ProbePoint { part: 0, place: [0, k], depth: 0 }, 0.5, false);
        let own = &mut probes.probes[k as usize].spectrum;
        *own = spectrum(3, |u| a * first(u) + b * second(u));
    }
    probes
}

fn rests(energies: &Energies, probes: &SpectralProbes<'_>) -> Vec<ResidualSpectrum> {
    probes.probes.iter().map(|probe| energies.residual(probe, &probes.bins)).collect()
}

#[test]
fn two_energies_explain_a_family_of_rank_2() {
    let axis = linear();
    let probes = family(&axis, &MIXTURES);
    let mut energies = Energies::default();
    let mut rests = rests(&energies, &probes);
    assert!(energies.select(&mut rests, 1, None, &probes.bins));
    assert!(rests[2].largest() > 0.1);
    assert!(energies.select(&mut rests, 2, None, &probes.bins));
    assert_eq!(energies.len(), 2);
    for rest in rests.iter().chain(&self::rests(&energies, &probes)) {
        assert!(rest.largest() < 1e-14);
    }
    assert!(unexplained(&rests, &probes.bins).iter().all(|left| *left < 1e-14));
}

#[test]
fn the_selected_energies_determine_a_spectrum_at_all_others() {
    let axis = linear();
    let probes = family(&axis, &MIXTURES);
    let mut energies = Energies::default();
    let mut rests = rests(&energies, &probes);
    for from in [1, 0] {
        assert!(energies.select(&mut rests, from, None, &probes.bins));
    }
    // A mixture that is not among the spectral probes.
    let mixed = |u: f64| 0.9 * first(u) - 1.3 * second(u);
    let at_selected: Vec<f64> =
        energies.selected.iter().map(|one| mixed(unit(one.place))).collect();
    for k in 0..=16 {
        let place = k * spacing(4);
        let found = energies.explained(at_selected.iter().copied(), place);
        assert_close(found, mixed(unit(place)), 1e-13);
    }
    // The same holds for the means over bins.
    let means = probes.bins.means(&spectrum(3, mixed));
    for (of_bin, mean) in energies.nodal_weights().iter().zip(means) {
        let sum: f64 = of_bin.iter().zip(&at_selected).map(|(weight, rate)| weight * rate).sum();
        assert_close(sum, mean, 1e-13);
    }
}

#[test]
fn an_energy_is_at_the_largest_residual_after_those_before() {
    let axis = linear();
    let probes = family(&axis, &[(1.0, 0.0), (0.0, 1.0)]);
    let mut energies = Energies::default();
    let mut rests = rests(&energies, &probes);
    assert!(energies.select(&mut rests, 0, None, &probes.bins));
    assert!(energies.select(&mut rests, 1, None, &probes.bins));
    // The first function is largest at the end, and falls to a quarter.
    let [one, other] = [&energies.selected[0], &energies.selected[1]];
    assert_eq!((one.place, one.of_earlier.len()), (STEPS, 0));
    // The other one is 0 there, so that nothing is subtracted.
    assert_eq!(other.place, 0);
    assert_close(other.of_earlier[0], 0.25, 1e-14);
    let mean =
        |low: f64, high: f64, integral: fn(f64) -> f64| (integral(high) - integral(low)) * 4.0;
    for bin in 0..4 {
        let [low, high] = [bin, bin + 1].map(|edge| edge as f64 / 4.0);
        assert_close(one.weights[bin], mean(low, high, |u| u + u.powi(3)) / 4.0, 1e-14);
        let of_other = mean(low, high, |u| 2.0 * u - u * u / 2.0 - u.powi(5) / 5.0) / 2.0;
        assert_close(other.weights[bin], of_other, 1e-14);
    }
}

#[test]
fn no_energy_is_selected_where_a_spectrum_is_dark() {
    let axis = linear();
    let probes = family(&axis, &[(0.0, 1.0), (0.0, 0.0)]);
    let mut energies = Energies::default();
    let mut rests = rests(&energies, &probes);
    assert!(!energies.select(&mut rests, 0, Some(STEPS), &probes.bins));
    assert!(!energies.select(&mut rests, 1, None, &probes.bins));
    assert_eq!(energies.len(), 0);
    assert!(energies.select(&mut rests, 0, Some(STEPS / 2), &probes.bins));
    assert_eq!(energies.selected[0].place, STEPS / 2);
}

#[test]
fn the_unexplained_error_is_the_largest_of_a_voxel_in_each_bin() {
    let axis = logarithmic();
    let mut probes = SpectralProbes::new(Bins::new(&axis));
    for (k, path) in [0.5, 0.25].into_iter().enumerate() {
        let place = [0, u32::try_from(k).unwrap()];
        probes.add(ProbePoint { part: 0, place, depth: 0 }, path, false);
    }
    // Per unit of energy −2, and as much as the energy.
    let density = |u: f64| probes.bins.density(u);
    let [even, rising] =
        [spectrum(6, |u| -2.0 * density(u)), spectrum(6, |u| axis.energy(u) * density(u))];
    probes.probes[0].spectrum = even;
    probes.probes[1].spectrum = rising;
    let rests = rests(&Energies::default(), &probes);
    for (left, expected) in unexplained(&rests, &probes.bins).into_iter().zip([1.0, 1.0, 1.5, 3.0])
    {
        assert_close(left, expected, 1e-7);
    }
    assert_close(rests[0].largest(), 1.0, 1e-8);
    assert_close(rests[0].effect_at(STEPS / 2, &probes.bins), 1.0, 1e-14);
    assert_close(rests[1].effect_at(STEPS / 2, &probes.bins), 0.25 * 4.0, 1e-13);
    assert_close(probes.largest(), 3.0, 1e-7);
}

#[test]
fn without_spectra_there_is_one_energy() {
    let none = Energies::none();
    assert_eq!(none.nodal_weights(), [[1.0]]);
    let unselected = Energies::unselected(STEPS / 2, 3, 0.5);
    assert_eq!(unselected.nodal_weights(), [[0.5]; 3]);
    assert_eq!((unselected.len(), unselected.selected[0].place), (1, STEPS / 2));
}

/// Spectral probes at some places of the diagonal of the image; every second one samples every bin.
fn probes(axis: &EnergyAxis, count: u32) -> SpectralProbes<'_> {
    let mut probes = SpectralProbes::new(Bins::new(axis));
    for k in 0..count {
        let point = ProbePoint { part: 0, place: at(4, k, k), depth: at(4, 8, 0)[0] };
        probes.add(point, 1.0, k % 2 == 1);
    }
    probes
}

#[test]
fn a_smooth_spectrum_is_sampled_on_the_base_and_a_full_one_in_every_bin() {
    // 17 to 32 bins have a place each on the lattice of level 5.
    for (bins, of_full) in [(4, 9), (8, 9), (9, 17), (17, 33), (32, 33), (3000, 1025)] {
        let (axis, meter) = (axis(2.0, 6.0, bins, EnergyScale::Linear), meter(10_000));
        let mut probes = probes(&axis, 2);
        let views = [view(&meter, &PANE)];
        let rate = |[x, ..]: [f64; 3], energy: f64| (1.0 + x) * energy.powi(3);
        answered(&meter, rate, probes.sample(&views, 1e-3)).unwrap();
        let samples = probes.probes.iter().map(|probe| probe.spectrum.places().count());
        assert_eq!(samples.collect::<Vec<_>>(), [9, of_full], "{bins}");
        assert_eq!(meter.evaluations(), 9 + of_full as u64);
        let expected = (1.0 + 1.0 / 16.0) * 4.0_f64.powi(3);
        assert_close(probes.probes[1].spectrum.rate(STEPS / 2), expected, 1e-10);
    }
}

#[test]
fn a_probe_is_added_once_and_samples_are_made_once() {
    let (axis, meter) = (linear(), meter(10_000));
    let mut probes = probes(&axis, 2);
    let point = probes.probes[1].point;
    probes.add(point, 0.1, false);
    assert_eq!(probes.probes.len(), 2);
    let views = [view(&meter, &PANE)];
    for expected in [18, 18] {
        answered(&meter, |_, energy| energy, probes.sample(&views, 1e-3)).unwrap();
        assert_eq!(meter.evaluations(), expected);
    }
    probes.add_common_energy(spacing(5));
    answered(&meter, |_, energy| energy, probes.sample(&views, 1e-3)).unwrap();
    assert_eq!(meter.evaluations(), 20);
}

#[test]
fn the_energy_of_a_named_line_is_sampled_in_every_spectrum() {
    let axis = linear();
    let mut probes = probes(&axis, 2);
    let line = 2.0 + 4.0 * 12_345.0 / f64::from(1_u32 << LINE_LEVEL);
    let beyond = [1.99, 6.01];
    probes.add_line_energies(&[line + 1e-5, beyond[0], beyond[1], 6.0]);
    let everywhere: Vec<u32> = probes.common_energies().collect();
    assert_eq!(everywhere, [12_345 * spacing(LINE_LEVEL), STEPS]);
}

#[test]
fn spot_checks_are_on_a_lattice_that_depends_on_the_bins() {
    // 128 energies, or four for each bin up to 256, or one for each bin up to 1024.
    for (bins, energies) in [(1, 128), (32, 128), (64, 256), (128, 256), (512, 512), (4000, 1024)] {
        let axis = axis(2.0, 6.0, bins, EnergyScale::Linear);
        let level = SpectralProbes::new(Bins::new(&axis)).checked_level();
        assert_eq!(1 << level, energies, "{bins}");
    }
}

fn check(row: u32, expected: f64) -> SpotCheck {
    let point = ProbePoint { part: 0, place: at(7, 3, row), depth: 0 };
    SpotCheck { point, energy: 3 * spacing(7), path: 0.5, expected, weight: 1.0 }
}

#[test]
fn an_unexplained_spot_check_becomes_a_spectral_probe() {
    let (axis, meter) = (logarithmic(), meter(10_000));
    let mut probes = SpectralProbes::new(Bins::new(&axis));
    let views = [view(&meter, &PANE)];
    let energy = probes.bins.sample_at(3 * spacing(7));
    // 1 per unit of energy.
    let expected = [1.0, 0.89, 1.11, 0.91, 1.09].map(|part| part * energy.density);
    let checks: Vec<SpotCheck> = (0..).zip(expected).map(|(row, of)| check(row, of)).collect();
    let allowed = 0.5 * 0.1;
    answered(&meter, |_, _| 1.0, probes.spot_check(&views, &checks, allowed)).unwrap();
    let sent: Vec<ProbePoint> = probes.probes.iter().map(|probe| probe.point).collect();
    assert_eq!(sent.len(), 2);
    assert!(sent.contains(&checks[1].point) && sent.contains(&checks[2].point));
    assert_eq!(meter.evaluations(), 5);
    answered(&meter, |_, _| 1.0, probes.sample(&views, 1e3)).unwrap();
    assert!(probes.probes.iter().all(|probe| probe.spectrum.has(3 * spacing(7))));
}

#[test]
fn the_largest_residuals_of_spot_checks_become_probes() {
    let (axis, meter) = (linear(), meter(10_000));
    let mut probes = SpectralProbes::new(Bins::new(&axis));
    let views = [view(&meter, &PANE)];
    let checks: Vec<SpotCheck> = (0..100).map(|k| check(k, f64::from(k))).collect();
    answered(&meter, |_, _| 0.0, probes.spot_check(&views, &checks, 1e-3)).unwrap();
    let most = TUNING.spectra.most_followed_checks;
    assert_eq!(probes.probes.len(), most);
    for (probe, check) in probes.probes.iter().zip(checks.iter().rev()) {
        assert_eq!(probe.point, check.point);
    }
}

#[test]
fn a_spectrum_that_becomes_a_function_is_sampled_more_precisely() {
    let axis = linear();
    let samples = |effect: Option<f64>| {
        let meter = meter(10_000);
        let mut probes = probes(&axis, 1);
        if let Some(effect) = effect {
            probes.raise_precision(0, effect, 1.0);
        }
        let views: [View<'_>; 1] = [view(&meter, &PANE)];
        let rate = |_: [f64; 3], energy: f64| (-(energy - 3.7).powi(2) / 0.02).exp();
        answered(&meter, rate, probes.sample(&views, 0.1)).unwrap();
        meter.evaluations()
    };
    let [usual, large, small, smallest, smaller] =
        [None, Some(10.0), Some(1e-3), Some(1e-4), Some(1e-9)].map(samples);
    assert_eq!(usual, large);
    assert!(small > usual && smallest > small);
    // Not beyond a limit.
    assert_eq!(smaller, smallest);
}

#[test]
fn a_short_budget_ends_the_sampling_of_spectra() {
    let (axis, meter) = (linear(), meter(17));
    let mut probes = probes(&axis, 2);
    let views = [view(&meter, &PANE)];
    assert!(answered(&meter, |_, _| 1.0, probes.sample(&views, 1.0)).is_err());
    assert_eq!(meter.evaluations(), 0);
}

#[test]
fn residuals_have_the_weights_of_their_place_in_each_bin() {
    let axis = linear();
    let mut probes = family(&axis, &MIXTURES);
    let without = unexplained(&rests(&Energies::default(), &probes), &probes.bins);
    let weights = [1.0, 10.0, 0.0, 2.0];
    // The probes are in the upper one of two pixels.
    let map = |weight: &f64| Arc::new(Image::from_pixels(2, 1, vec![*weight, 5.0]));
    probes.set_weights(vec![weights.iter().map(map).collect()]);
    let weighted = unexplained(&rests(&Energies::default(), &probes), &probes.bins);
    for ((weighted, without), weight) in weighted.iter().zip(&without).zip(weights) {
        assert_close(*weighted, weight * without, 1e-12);
    }
    let [above, below] = [0, STEPS].map(|row| ProbePoint { part: 0, place: [0, row], depth: 0 });
    let is = |weight: f64, expected: f64| assert!((weight - expected).abs() < 1e-12, "{weight}");
    for (place, expected) in [(0, 1.0), (STEPS / 3, 10.0), (STEPS, 2.0)] {
        is(probes.weight_at(&above, place), expected);
    }
    is(probes.weight_at(&below, STEPS / 3), 5.0);
}
