//! Cubes with energy axes of both scales and in several units.

use emitree::{Cube, EnergyAxis, EnergyScale, Image};
use emitree_instrument::Channel;
use emitree_io::{Energies, FitsFile, FitsImage, HealpixColumn, HealpixFile, Wcs, encode_npy_cube};
use std::error::Error;

/// A file's name and its bytes.
type File = (String, Vec<u8>);

/// Names, ends, bins, units and scales; `test_cubes.py` has the same.
const AXES: [(&str, [f64; 2], usize, &str, EnergyScale); 6] = [
    ("linear_kev", [0.3, 12.0], 9, "keV", EnergyScale::Linear),
    ("linear_ev", [0.0, 2000.0], 4, "eV", EnergyScale::Linear),
    ("linear_one", [6.39, 6.41], 1, "keV", EnergyScale::Linear),
    ("log_kev", [0.3, 12.0], 9, "keV", EnergyScale::Log),
    ("log_gev", [0.1, 300.0], 3, "GeV", EnergyScale::Log),
    ("log_j", [1e-17, 3e-15], 6, "J", EnergyScale::Log),
];

const UNIT: &str = "ph cm-2 s-1 sr-1 keV-1";

/// A cube for each axis, bin · 1e6 + row · 1000 + column + ¼, and one as a map of the sky.
pub(crate) fn files() -> Result<Vec<File>, Box<dyn Error>> {
    let mut files = Vec::new();
    for (name, [min, max], bins, unit, scale) in AXES {
        let energies = Energies::new(EnergyAxis::new(min, max, bins, scale)?, unit)?;
        let cube = Cube::from_bands((0..bins).map(band).collect());
        let sum = cube.sum_over_energy(energies.axis());
        let [_, height, width] = cube.shape();
        let file = FitsFile {
            primary: FitsImage::cube("RADIANCE", &cube, Some(UNIT)),
            extensions: vec![
                FitsImage::cube("ERROR", &cube, Some(UNIT)),
                FitsImage::new("BAND", &sum, None),
            ],
            wcs: Some(Wcs::perspective(height, width, [100.0, 60.0])),
            energies: Some(&energies),
            provenance: Vec::new(),
            history: String::new(),
            date: None,
        };
        files.push((format!("cube_{name}.fits"), file.encode()?));
        files.push((format!("cube_{name}.npy"), encode_npy_cube(&cube)));
    }
    files.push(("cube_sky.fits".to_owned(), sky()?));
    for (name, step) in [("even", 1), ("uneven", 2)] {
        files.push((format!("counts_{name}.fits"), counts(step)?));
    }
    Ok(files)
}

/// Counts in four channels, the first of them 31 and the last `last_step` after the one before, each
/// half a keV wide from 0.5 keV on.
fn counts(last_step: i64) -> Result<Vec<u8>, Box<dyn Error>> {
    let numbers = [31, 32, 33, 33 + last_step].into_iter().zip(1..);
    let channel = |(number, half_kev): (i64, i32)| {
        let low_kev = 0.5 * f64::from(half_kev);
        Channel { number, range_kev: [low_kev, low_kev + 0.5] }
    };
    let channels: Vec<Channel> = numbers.map(channel).collect();
    let cube = Cube::from_bands((0..channels.len()).map(band).collect());
    let [_, height, width] = cube.shape();
    let file = FitsFile {
        primary: FitsImage::channels("COUNTS", &cube, &channels, Some("count")),
        extensions: Vec::new(),
        wcs: Some(Wcs::perspective(height, width, [100.0, 60.0])),
        energies: None,
        provenance: Vec::new(),
        history: String::new(),
        date: None,
    };
    Ok(file.encode()?)
}

fn band(bin: usize) -> Image {
    let pixel = |index: usize| {
        let [row, column] = [index / super::WIDTH, index % super::WIDTH];
        bin as f64 * 1e6 + row as f64 * 1000.0 + column as f64 + 0.25
    };
    let pixels = (0..super::HEIGHT * super::WIDTH).map(pixel).collect();
    Image::from_pixels(super::HEIGHT, super::WIDTH, pixels)
}

/// Three bands with 48 pixels, each the number of its bin times 100 plus that of its pixel.
fn sky() -> Result<Vec<u8>, Box<dyn Error>> {
    let energies = Energies::new(EnergyAxis::new(0.5, 4.0, 3, EnergyScale::Log)?, "keV")?;
    let names: Vec<String> = (1..=3).map(|number| format!("RADIANCE_{number}")).collect();
    let values: Vec<Vec<f64>> =
        (0..3).map(|bin| (0..48).map(|pixel| f64::from(bin * 100 + pixel)).collect()).collect();
    let columns = names.iter().zip(&values);
    let columns = columns.map(|(name, values)| HealpixColumn { name, unit: Some(UNIT), values });
    let file = HealpixFile {
        columns: columns.collect(),
        coordinates: None,
        energies: Some(&energies),
        provenance: Vec::new(),
        history: String::new(),
        date: None,
    };
    Ok(file.encode()?)
}
