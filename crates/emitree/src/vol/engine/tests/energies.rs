//! The energies of a cube, for emissions whose spectra are known.

use super::{TILES, default_options, engine, whole_view};
use crate::EnergyScale;
use crate::energy::EnergyAxis;
use crate::vol::VolOptions;
use crate::vol::dyadic::{STEPS, unit};
use crate::vol::engine::first_energy::EnergySearch;
use crate::vol::testing::{answered, assert_close, meter};

fn axis() -> EnergyAxis {
    EnergyAxis::new(0.0, 1.0, 4, EnergyScale::Linear).unwrap()
}

#[test]
fn the_initial_sampling_at_energies_has_64_points_at_five_and_named_ones() {
    let (axis, meter) = (axis(), meter(0));
    let parts = whole_view(1).parts;
    let cost = |vol: &VolOptions| EnergySearch::new(&meter, &TILES, &parts, &axis, vol).cost();
    assert_eq!(cost(default_options()), 64 * 5);
    // One of them is on the lattice.
    let lines = VolOptions { line_energies: vec![0.25, 0.3], ..default_options().clone() };
    assert_eq!(cost(&lines), 64 * 6);
}

#[test]
fn the_brightest_of_five_energies_is_the_first() {
    let axis = axis();
    for (middle, expected) in [(0.2, STEPS / 4), (0.99, STEPS), (0.55, STEPS / 2)] {
        let meter = meter(2000);
        let parts = whole_view(1);
        let engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
        let rate = |_: [f64; 3], energy: f64| -(-((energy - middle) / 0.1_f64).powi(2)).exp();
        let found = answered(&meter, rate, engine.first_energy()).unwrap().unwrap();
        assert_eq!(found.place, expected);
        assert!(found.hits.is_empty());
        assert_eq!(meter.evaluations(), 320);
    }
}

#[test]
fn a_spectrum_between_the_five_energies_is_found_and_a_dark_one_is_not() {
    let (axis, meter) = (axis(), meter(10_000));
    let parts = whole_view(1);
    let engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    let band = |_: [f64; 3], energy: f64| {
        if (0.3..0.33).contains(&energy) { 1.0 } else { 0.0 }
    };
    let found = answered(&meter, band, engine.first_energy()).unwrap().unwrap();
    assert!((0.3..0.33).contains(&unit(found.place)));
    let dark = answered(&meter, |_, _| 0.0, engine.first_energy()).unwrap().unwrap();
    assert_eq!((dark.place, dark.hits.len()), (STEPS / 2, 0));
}

/// None of the first 64 points is in a shape of a five-hundredth of the view; scattered ones are, at energies of their
/// own, and the trees have nodes around one of them.
#[test]
fn scattered_points_find_a_small_shape_in_a_dark_view() {
    let (axis, meter) = (axis(), meter(100_000));
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    let is_in = |at: [f64; 3]| at.iter().all(|x| (0.19..0.315).contains(x));
    let rate = |at: [f64; 3], energy: f64| if is_in(at) { 1.0 + energy } else { 0.0 };
    let found = answered(&meter, rate, engine.first_energy()).unwrap().unwrap();
    let [hit] = found.hits[..] else { panic!("{found:?}") };
    let [x, y] = hit.point.place.map(unit);
    assert!(is_in([x, y, unit(hit.point.depth)]));
    assert!(hit.rate > 0.0 && meter.evaluations() < 3000, "{hit:?}");
    engine.first_hits = found.hits;
    engine.add_sheets(Some(found.place));
    let seeds = &engine.sheets[0].scan.seeds;
    assert!(!seeds.places.is_empty());
    assert!(seeds.depths(hit.point.place).iter().any(|depth| is_in([x, y, unit(*depth)])));
}

#[test]
fn without_an_energy_axis_no_energy_is_selected() {
    let meter = meter(0);
    let parts = whole_view(1);
    let engine = engine(&meter, &TILES, &parts, 3, None);
    assert!(answered(&meter, |_, _| 1.0, engine.first_energy()).unwrap().is_none());
    assert!(engine.energies_used().is_empty());
}

/// A mixture of two spectra, in parts that differ from place to place.
fn mixed([x, y, z]: [f64; 3], energy: f64) -> f64 {
    (1.0 + x) * (1.0 + energy) + (y + z) * energy * energy
}

/// Its mean over a pixel and over a bin from `low` to `high`.
fn of_mixed([row, column]: [usize; 2], [low, high]: [f64; 2]) -> f64 {
    let [x, y] = [column, row].map(|k| (k as f64 + 0.5) / 16.0);
    let mean = |power: i32| {
        (high.powi(power + 1) - low.powi(power + 1)) / (f64::from(power + 1) * (high - low))
    };
    (1.0 + x) * (1.0 + mean(1)) + (y + 0.5) * mean(2)
}

#[test]
fn two_spectra_need_two_energies() {
    let (axis, meter) = (axis(), meter(100_000));
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    assert_eq!(answered(&meter, mixed, engine.sample_at_all_energies()), Ok(true));
    assert_eq!((engine.energies.len(), engine.sheets.len()), (2, 2));
    assert_eq!(engine.sheets[1].id.energy, 1);
    let used = engine.energies_used();
    assert!(used.len() == 2 && used[0] < used[1]);
    let current = engine.assemble().unwrap();
    for bin in 0..4 {
        let edges = [bin, bin + 1].map(|edge| edge as f64 / 4.0);
        for pixel in [[0, 0], [3, 12], [15, 15]] {
            let found = current.maps[bin][0][(pixel[0], pixel[1])];
            assert_close(found, of_mixed(pixel, edges), 1e-10);
        }
    }
    assert!(current.largest_error() < 1e-10);
    // All that new lines show is explained.
    assert_eq!(answered(&meter, mixed, engine.sample_spectra(1.0)), Ok(true));
    assert_eq!(engine.energies.len(), 2);
}

#[test]
fn lines_at_several_energies_share_the_tolerance_of_a_bin() {
    let (axis, meter) = (axis(), meter(100_000));
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    answered(&meter, mixed, engine.sample_at_all_energies()).unwrap();
    let tolerances = engine.line_tolerances(0.5);
    let of_bin = |weights: &Vec<f64>| -> f64 {
        weights.iter().zip(&tolerances).map(|(weight, tolerance)| weight.abs() * tolerance).sum()
    };
    let most = engine.energies.nodal_weights().iter().map(of_bin).fold(0.0, f64::max);
    assert_close(most, 0.2 * 0.5, 1e-13);
}

#[test]
fn the_second_energy_of_one_spectrum_is_not_needed() {
    let (axis, meter) = (axis(), meter(100_000));
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    let rate = |[x, ..]: [f64; 3], energy: f64| (1.0 + x) * (2.0 - energy);
    assert_eq!(answered(&meter, rate, engine.sample_at_all_energies()), Ok(true));
    assert_eq!(engine.energies_used(), [0.0]);
}

#[test]
fn a_cube_that_is_dark_has_one_energy_without_weight() {
    let (axis, meter) = (axis(), meter(100_000));
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    assert_eq!(answered(&meter, |_, _| 0.0, engine.sample_at_all_energies()), Ok(true));
    assert_eq!(engine.energies_used(), [0.5]);
    assert_eq!(engine.energies.selected[0].weights, [0.0; 4]);
    let current = engine.assemble().unwrap();
    assert_eq!(current.maps.len(), 4);
    assert_eq!((current.largest_pixel().to_bits(), current.largest_error().to_bits()), (0, 0));
}

#[test]
fn the_error_of_unsampled_spectra_is_at_least_the_brightest_line() {
    let (axis, meter) = (axis(), meter(320 + 729 + 10));
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    assert_eq!(answered(&meter, mixed, engine.sample_at_all_energies()), Ok(false));
    let current = engine.assemble().unwrap();
    let brightest = engine.brightest();
    assert!(brightest > 0.0);
    assert!(current.errors(&parts.parts[0]).iter().all(|error| error.min_max().0 >= brightest));
}

#[test]
fn the_residual_of_the_energies_is_in_the_error_of_each_bin() {
    let (axis, meter) = (axis(), meter(100_000));
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    answered(&meter, mixed, engine.sample_at_all_energies()).unwrap();
    engine.spectra.as_mut().unwrap().unexplained = vec![0.0, 0.5, 0.0, 2.0];
    let current = engine.assemble().unwrap();
    for (error, expected) in current.errors(&parts.parts[0]).into_iter().zip([0.0, 0.5, 0.0, 2.0]) {
        assert_close(error[(7, 7)], expected, 1e-10);
    }
}

#[test]
fn a_sheet_has_its_part_its_energy_and_the_base() {
    let (axis, meter) = (axis(), meter(0));
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, Some(&axis));
    engine.add_sheets(Some(STEPS / 4));
    engine.add_sheets(Some(STEPS));
    let ids: Vec<_> = engine.sheets.iter().map(|sheet| (sheet.id.part, sheet.id.energy)).collect();
    assert_eq!(ids, [(0, 0), (0, 1)]);
    let energies = engine.sheets.iter().map(|sheet| sheet.scan.view.energy.map(|of| of.energy));
    assert_eq!(energies.collect::<Vec<_>>(), [Some(0.25), Some(1.0)]);
    assert!(engine.sheets.iter().all(|sheet| sheet.scan.depth_level == 3));
}
