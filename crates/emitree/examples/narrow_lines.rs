//! How narrow an emission line method `vol` detects: the number of cubes that end converged without it.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example narrow_lines -- 100` renders, to 1 %, cubes of 5 bins with a
//! broad continuum and an emission line at 100 scattered places and energies, for several widths of the line
//! (standard deviation over the width of the band), extents of its source and contrasts. The contrast is
//! the brightest voxel of the line alone over the error allowed. A miss is a cube that ends converged with
//! a true error beyond the tolerance. A second argument names the set of places (0); set 1 is kept out of
//! tuning.

use emitree::{
    Canonical, EnergyAxis, EnergyScale, FromSpectralFn, RenderOptions, VolOptions, render_cube,
};
use emitree_problems::cubes::parts::{self, Part};
use emitree_problems::cubes::spectrum::Spectrum;
use std::error::Error;

const SHAPE: [usize; 2] = [32, 32];
const BINS: usize = 5;
const TOLERANCE: f64 = 0.01;
const BAND: [f64; 2] = [1.0, 3.0];
/// Standard deviations of lines over the width of the band.
const WIDTHS: [f64; 6] = [3e-5, 1e-4, 3e-4, 6e-4, 1e-3, 2e-3];
/// Standard deviations of the sources of lines over the edge of the cube.
const EXTENTS: [f64; 2] = [0.25, 0.07];
const CONTRASTS: [f64; 2] = [20.0, 5.0];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        [places] => table(0, places.parse()?),
        [places, set] => table(set.parse()?, places.parse()?),
        _ => Err("expected: PLACES [SET]".into()),
    }
}

/// The continuum, and a line at a scattered place and energy whose brightest voxel is `peak` of that of
/// the continuum.
fn scene(number: u64, axis: &EnergyAxis, [width, extent, peak]: [f64; 3]) -> [Part; 2] {
    // Multiples of irrational numbers, modulo 1, which are unrelated to the samples of the method.
    let [energy, x, y, z] =
        [23.0, 3.0, 7.0, 11.0].map(|of: f64| (of.sqrt() * number as f64).fract());
    let energy = BAND[0] + (BAND[1] - BAND[0]) * energy;
    let centre = [x, y, z].map(|along| 0.1 + 0.8 * along);
    let root = core::f64::consts::SQRT_2;
    let continuum = Part {
        amplitude: 1.0,
        centre: [0.5; 3],
        widths: [0.35; 3],
        spectrum: Spectrum::PowerLaw { index: 2.0 },
    };
    let width = root * width * (BAND[1] - BAND[0]);
    let spectrum = Spectrum::Line { energy, width };
    let line = Part { amplitude: 1.0, centre, widths: [root * extent; 3], spectrum };
    let largest = |part: Part| parts::exact(&[part], SHAPE, axis).largest();
    let amplitude = peak * largest(continuum) / largest(line);
    [continuum, Part { amplitude, ..line }]
}

fn table(set: u64, places: u64) -> Result<(), Box<dyn Error>> {
    let axis = EnergyAxis::new(BAND[0], BAND[1], BINS, EnergyScale::Linear)?;
    println!(
        "| contrast | extent | width | missed | not converged | evaluations, geometric mean |"
    );
    println!("| --: | --: | --: | --: | --: | --: |");
    for contrast in CONTRASTS {
        for extent in EXTENTS {
            for width in WIDTHS {
                let (mut missed, mut unfinished, mut logs) = (0, 0, 0.0);
                for number in 0..places {
                    let peak = contrast * TOLERANCE;
                    let scene = scene(10_000 * set + number, &axis, [width, extent, peak]);
                    let emission =
                        FromSpectralFn(|at, _, energy: f64| parts::rate(&scene, at, energy));
                    let options = RenderOptions::new(VolOptions::new(TOLERANCE));
                    let found = render_cube(&emission, &Canonical, SHAPE, &axis, &options)?;
                    let exact = parts::exact(&scene, SHAPE, &axis);
                    let error = found.values.max_difference(&exact) / exact.largest();
                    unfinished += u64::from(!found.converged());
                    missed += u64::from(found.converged() && error > TOLERANCE);
                    logs += (found.stats.evaluations as f64).ln();
                }
                println!(
                    "| {contrast} | {extent} | {width:.0e} | {missed} of {places} | {unfinished} | {:.0} |",
                    (logs / places as f64).exp()
                );
            }
        }
    }
    Ok(())
}
