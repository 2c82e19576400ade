use super::*;
use crate::redistribution::{Group, ResponseRow};
use emitree::EnergyScale;

fn axis(min: f64, max: f64, bins: usize) -> EnergyAxis {
    let axis = EnergyAxis::new(min, max, bins, EnergyScale::Linear);
    axis.unwrap()
}

fn flat(height: usize, width: usize, value: f64) -> Image {
    Image::from_pixels(height, width, vec![value; height * width])
}

fn constant_area(area_cm2: f64) -> EffectiveArea {
    EffectiveArea::from_points(&[0.0, 100.0], &[area_cm2; 2]).unwrap()
}

fn pinhole(exposure_s: f64) -> Instrument {
    Instrument {
        area: Some(constant_area(3.0)),
        redistribution: None,
        psf: None,
        exposure_s,
        background: None,
    }
}

/// Each row of the matrix into its own channel, with an efficiency.
fn diagonal(edges: &[f64], efficiency: f64, includes_area: bool) -> Redistribution {
    let ranges = || edges.windows(2).map(|ends| [ends[0], ends[1]]);
    let row = |(first, range_kev)| ResponseRow {
        range_kev,
        groups: vec![Group { first, responses: vec![efficiency] }],
    };
    let channels = (0..).zip(ranges()).map(|(number, range_kev)| Channel { number, range_kev });
    let rows = ranges().enumerate().map(row).collect();
    let matrix = Redistribution::new(rows, channels.collect(), includes_area);
    matrix.unwrap()
}

fn assert_balanced(observation: &Observation, steps: &[Step]) {
    assert_eq!(observation.steps.iter().map(|sum| sum.step).collect::<Vec<_>>(), steps);
    for sum in &observation.steps {
        assert!(sum.imbalance() < 1e-12, "{sum:?}");
    }
    // What one step has made the next one is given, unless the unit changes.
    for pair in observation.steps.windows(2) {
        let same = !matches!(pair[1].step, Step::Area);
        assert!(!same || (pair[0].after - pair[1].before).abs() < 1e-9 * pair[0].after, "{pair:?}");
    }
}

/// L ΔE Ω A t, in electronvolts too.
#[test]
fn a_uniform_glow_is_the_product() {
    let radiance = Cube::from_bands(vec![flat(2, 3, 7.0), flat(2, 3, 1.0)]);
    let angles = flat(2, 3, 2e-3);
    let found = pinhole(50.0).expected_counts(&radiance, &axis(1.0, 2.0, 2), 1.0, &angles).unwrap();
    assert_balanced(&found, &[Step::Photons, Step::Area]);
    for (counts, expected) in found.counts.voxels().zip([1.05; 6].into_iter().chain([0.15; 6])) {
        assert!((counts - expected).abs() < 1e-14, "{counts} {expected}");
    }
    assert_eq!(found.channels[1], Channel { number: 1, range_kev: [1.5, 2.0] });

    let per_ev = Cube::from_bands(vec![flat(2, 3, 7e-3), flat(2, 3, 1e-3)]);
    let in_ev = axis(1000.0, 2000.0, 2);
    let same = pinhole(50.0).expected_counts(&per_ev, &in_ev, 1e-3, &angles).unwrap();
    assert!(same.counts.max_difference(&found.counts) < 1e-14);
    assert!((same.channels[1].range_kev[0] - 1.5).abs() < 1e-15);
}

/// All steps, a scene with pixels below 0, and two pixels outside of the field.
fn everything() -> (Instrument, Cube, Image) {
    let band = |b: usize| {
        let pixel = |n: usize| bumpy(n) * (1.0 + b as f64);
        Image::from_pixels(12, 10, (0..120).map(pixel).collect())
    };
    let mut angles = flat(12, 10, 1e-4);
    angles[(3, 3)] = f64::NAN;
    let instrument = Instrument {
        area: EffectiveArea::from_points(&[0.5, 1.0, 3.0], &[10.0, 60.0, 5.0]).ok(),
        redistribution: Some(diagonal(&[0.7, 0.9, 1.3, 2.2, 2.4], 0.9, false)),
        psf: Psf::gaussian([2.0, 3.0]).ok(),
        exposure_s: 2e4,
        background: Background::per_kev_sr(8.0).ok(),
    };
    (instrument, Cube::from_bands((0..6).map(band).collect()), angles)
}

fn bumpy(n: usize) -> f64 {
    if n == 17 { f64::NAN } else { (n as f64 * 0.37).fract() - 0.05 }
}

#[test]
fn a_pixel_that_is_none_in_one_bin_is_outside_in_all() {
    let mut radiance = Cube::from_bands(vec![flat(1, 2, 7.0), flat(1, 2, 1.0)]);
    radiance.bands_mut()[1][(0, 1)] = f64::NAN;
    let angles = flat(1, 2, 2e-3);
    let found = pinhole(50.0).expected_counts(&radiance, &axis(1.0, 2.0, 2), 1.0, &angles).unwrap();
    assert_balanced(&found, &[Step::Photons, Step::Area]);
    assert_eq!(
        found.counts.voxels().map(f64::is_nan).collect::<Vec<_>>(),
        [false, true, false, true]
    );
}

#[test]
fn every_step_is_balanced() {
    let (instrument, radiance, angles) = everything();
    let found = instrument.expected_counts(&radiance, &axis(0.4, 2.8, 6), 1.0, &angles).unwrap();
    assert_balanced(
        &found,
        &[
            Step::Photons,
            Step::Area,
            Step::Psf,
            Step::Energies,
            Step::Redistribution,
            Step::Background,
        ],
    );
    let [photons, _, psf, energies, redistribution, background] = &*found.steps else {
        unreachable!("six steps")
    };
    // The pixels below 0 are those with fractions under 0.05.
    let below = |n: usize| n != 17 && n != 33 && bumpy(n) < 0.0;
    let negative: f64 = (0..120).filter(|&n| below(n)).map(bumpy).sum();
    assert!((photons.lost - negative * 21.0 * 0.4 * 1e-4 * 2e4).abs() < 1e-9, "{}", photons.lost);
    assert!(psf.lost > 0.02 * psf.before && energies.lost > 0.02 * energies.before);
    assert!((redistribution.lost - 0.1 * redistribution.before).abs() < 1e-9);
    assert!((background.added - 8.0 * 1.7 * 118.0 * 1e-4 * 2e4).abs() < 1e-9);
    for band in found.counts.bands() {
        assert!(band[(1, 7)].is_nan() && band[(3, 3)].is_nan());
        assert_eq!(band.pixels().iter().filter(|count| count.is_nan()).count(), 2);
        assert!(band.min_max().0 >= 0.0);
    }
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let (instrument, radiance, angles) = everything();
    let axis = axis(0.4, 2.8, 6);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found =
            pool.install(|| instrument.expected_counts(&radiance, &axis, 1.0, &angles).unwrap());
        let bits: Vec<u64> = found.counts.voxels().map(f64::to_bits).collect();
        (bits, found.steps)
    };
    assert_eq!(on(1), on(3));
}

/// One bin of the cube over many of the matrix: the area is folded in at the resolution of the matrix,
/// so that each channel has ∫ A dE over itself.
#[test]
fn the_area_varies_within_bins() {
    let edges = [1.0, 1.1, 1.5, 1.8, 2.0];
    let area = EffectiveArea::from_points(&[1.0, 1.3, 2.0], &[0.0, 90.0, 20.0]).unwrap();
    let instrument = Instrument {
        area: Some(area.clone()),
        redistribution: Some(diagonal(&edges, 1.0, false)),
        ..pinhole(10.0)
    };
    let radiance = Cube::from_bands(vec![flat(1, 1, 5.0)]);
    let angles = flat(1, 1, 0.01);
    let found = instrument.expected_counts(&radiance, &axis(1.0, 2.0, 1), 1.0, &angles).unwrap();
    assert_balanced(&found, &[Step::Photons, Step::Area, Step::Energies, Step::Redistribution]);
    for (counts, ends) in found.counts.voxels().zip(edges.windows(2)) {
        let expected = 5.0 * 0.01 * 10.0 * area.integral([ends[0], ends[1]]);
        assert!((counts - expected).abs() < 1e-12, "{counts} {expected}");
    }
}

/// A matrix with the area in it counts what the two count one after the other.
#[test]
fn a_matrix_with_area_needs_no_other() {
    let edges = [1.0, 1.5, 2.0];
    let radiance = Cube::from_bands(vec![flat(2, 2, 5.0), flat(2, 2, 8.0)]);
    let angles = flat(2, 2, 0.01);
    let count = |instrument: &Instrument| {
        instrument.expected_counts(&radiance, &axis(1.0, 2.0, 2), 1.0, &angles)
    };
    let apart = Instrument { redistribution: Some(diagonal(&edges, 1.0, false)), ..pinhole(10.0) };
    let together = Instrument {
        area: None,
        redistribution: Some(diagonal(&edges, 3.0, true)),
        ..pinhole(10.0)
    };
    let found = count(&together).unwrap();
    // Photons cm⁻² become counts in the last step.
    let sums: Vec<Step> = found.steps.iter().map(|sum| sum.step).collect();
    assert_eq!(sums, [Step::Photons, Step::Energies, Step::Redistribution]);
    assert!(found.steps.iter().all(|sum| sum.imbalance() < 1e-14));
    assert!(found.counts.max_difference(&count(&apart).unwrap().counts) < 1e-14);

    let text = |instrument: &Instrument| count(instrument).unwrap_err().to_string();
    let twice = Instrument { area: Some(constant_area(1.0)), ..together };
    assert_eq!(
        text(&twice),
        "the redistribution matrix includes an effective area, and there is another one: expected \
         one of them"
    );
    assert!(text(&Instrument { area: None, ..apart }).starts_with("there is no effective area"));
}

#[test]
fn input_that_can_not_be_is_refused_by_name() {
    let radiance = Cube::from_bands(vec![flat(2, 3, 1.0)]);
    let text = |exposure, radiance: &Cube, axis: &EnergyAxis, kev, angles: &Image| {
        let found = pinhole(exposure).expected_counts(radiance, axis, kev, angles);
        found.unwrap_err().to_string()
    };
    let (one, angles) = (axis(1.0, 2.0, 1), flat(2, 3, 1e-3));
    assert_eq!(
        text(0.0, &radiance, &one, 1.0, &angles),
        "the exposure in s is 0: expected a finite number above 0"
    );
    assert!(text(1.0, &radiance, &one, f64::NAN, &angles).contains("unit of energy in keV is NaN"));
    assert_eq!(
        text(1.0, &radiance, &axis(1.0, 2.0, 4), 1.0, &angles),
        "the cube has 1 bins: expected 4, those of the energy axis"
    );
    assert_eq!(
        text(1.0, &radiance, &axis(-2.0, 2.0, 1), 0.5, &angles),
        "the energies start at -1 keV: expected 0 or more"
    );
    assert_eq!(
        text(1.0, &radiance, &one, 1.0, &flat(3, 2, 1.0)),
        "there are solid angles for 3 x 2 pixels (height x width): expected 2 x 3, as the cube has"
    );
    let mut wrong = angles.clone();
    wrong[(1, 2)] = -1.0;
    assert!(
        text(1.0, &radiance, &one, 1.0, &wrong)
            .starts_with("the solid angle of the pixel at row 1, column 2 is -1 sr: expected")
    );
    let mut infinite = radiance;
    infinite.bands_mut()[0][(1, 0)] = f64::INFINITY;
    assert!(
        text(1.0, &infinite, &one, 1.0, &angles)
            .starts_with("the radiance in bin 0 at row 1, column 0 is inf: expected")
    );
}

#[test]
fn memory_grows_with_bins_and_channels() {
    let mut instrument = pinhole(1.0);
    assert_eq!(instrument.memory_bytes([10, 20, 30]), 8 * 600 * 11);
    instrument.redistribution = Some(diagonal(&[1.0, 2.0, 3.0], 1.0, false));
    assert_eq!(instrument.memory_bytes([10, 20, 30]), 8 * 600 * 13);
    instrument.psf = Some(Psf::gaussian([1.0, 1.0]).unwrap());
    assert!(instrument.memory_bytes([10, 20, 30]) >= 8 * 600 * 31);
    assert_eq!(instrument.memory_bytes([usize::MAX; 3]), u64::MAX);
}
