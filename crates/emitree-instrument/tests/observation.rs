//! A whole observation against the same with `NumPy` and `SciPy` (`reference/observation.py`).

use emitree::{Cube, EnergyAxis, EnergyScale, Image};
use emitree_instrument::{Background, EffectiveArea, Instrument, Psf, Redistribution};
use std::path::PathBuf;

const BINS: usize = 5;
const HEIGHT: usize = 6;
const WIDTH: usize = 7;

fn reference(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "reference", name].iter().collect()
}

fn image(pixel: impl Fn(f64, f64) -> f64) -> Image {
    let mut image = Image::zeros(HEIGHT, WIDTH);
    for row in 0..HEIGHT {
        for column in 0..WIDTH {
            image[(row, column)] = pixel(row as f64, column as f64);
        }
    }
    image
}

#[test]
fn counts_are_those_of_another_program() {
    let camera = Instrument {
        area: Some(EffectiveArea::read_arf(reference("bins.arf")).unwrap()),
        redistribution: Some(Redistribution::read_rmf(reference("variable.rmf")).unwrap()),
        psf: Some(
            Psf::from_kernel(&Image::from_pixels(4, 3, (1..13).map(f64::from).collect())).unwrap(),
        ),
        exposure_s: 2000.0,
        background: Some(Background::per_kev_sr(5.0).unwrap()),
    };
    let axis = EnergyAxis::new(0.25, 1.25, BINS, EnergyScale::Log).unwrap();
    let band = |bin: usize| image(|row, column| (1.0 + bin as f64) * (1.0 + row + 2.0 * column));
    let radiance = Cube::from_bands((0..BINS).map(band).collect());
    let solid_angles_sr = image(|_, column| (1.0 + column / 10.0) * 1e-3);
    let found = camera.expected_counts(&radiance, &axis, 1.0, &solid_angles_sr).unwrap();
    for sum in &found.steps {
        assert!(sum.imbalance() < 1e-13, "{sum:?}");
    }

    let table = std::fs::read_to_string(reference("observation.csv")).unwrap();
    let rows = table.lines().skip(1);
    assert_eq!(rows.clone().count(), found.counts.voxels().count());
    for row in rows {
        let fields: Vec<&str> = row.split(',').collect();
        let [channel, y, x] = [0, 1, 2].map(|n| fields[n].parse::<usize>().unwrap());
        let expected: f64 = fields[3].parse().unwrap();
        let counts = found.counts.bands()[channel][(y, x)];
        assert!((counts / expected - 1.0).abs() < 1e-12, "{row}: {counts}");
    }
}
