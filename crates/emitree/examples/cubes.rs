//! Evaluations of spectral cubes against bins × one image: the tables of docs/results/engine.md.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example cubes -- 32 1e-1,1e-2,1e-3` renders the cubes of
//! `emitree_problems::cubes` with 64 × 64 pixels and 32 bins; a third argument names one of them.
//! Beside them are the evaluations of one image for each bin, at the middle of its energies: to the
//! same tolerance of its own largest pixel, and to the same error as the cube.

use emitree::{
    Canonical, Cube, EnergyAxis, FromFn, FromSpectralFn, RenderOptions, Rendering, VolOptions,
    render, render_cube,
};
use emitree_problems::cubes::{CubeProblem, problems};
use std::error::Error;
use std::time::Instant;

const SHAPE: [usize; 2] = [64, 64];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        [bins, tolerances] => table(bins.parse()?, tolerances, ""),
        [bins, tolerances, name] => table(bins.parse()?, tolerances, name),
        _ => Err("expected: BINS T,… [NAME]".into()),
    }
}

fn options(tolerance: f64) -> RenderOptions<'static> {
    let vol = VolOptions::new(tolerance);
    RenderOptions::new(vol).with_max_evaluations(10_000_000)
}

fn cube(
    problem: &CubeProblem,
    axis: &EnergyAxis,
    tolerance: f64,
) -> Result<Rendering<Cube>, Box<dyn Error>> {
    let emission = FromSpectralFn(|position, _, energy| problem.rate(position, energy));
    Ok(render_cube(&emission, &Canonical, SHAPE, axis, &options(tolerance))?)
}

/// Evaluations of one image for each bin: to a tolerance of its own largest pixel, or of `largest`.
fn images(
    problem: &CubeProblem,
    axis: &EnergyAxis,
    tolerance: f64,
    largest: Option<&[f64]>,
) -> Result<u64, Box<dyn Error>> {
    let mut evaluations = 0;
    let brightest = largest.map(|bands| bands.iter().copied().fold(0.0, f64::max));
    for bin in 0..axis.bins() {
        let energy = axis.energy((bin as f64 + 0.5) / axis.bins() as f64);
        let emission = FromFn(|position, _| problem.rate(position, energy));
        let tolerance = match (brightest, largest) {
            (Some(brightest), Some(bands)) => (tolerance * brightest / bands[bin]).min(0.5),
            _ => tolerance,
        };
        evaluations += render(&emission, &Canonical, SHAPE, &options(tolerance))?.stats.evaluations;
    }
    Ok(evaluations)
}

fn table(bins: usize, tolerances: &str, only: &str) -> Result<(), Box<dyn Error>> {
    println!(
        "| cube | tolerance | evaluations | energies | true error | estimate | inside | seconds | \
         one image a bin | to the same error |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for problem in problems().iter().filter(|p| p.name.starts_with(only)) {
        let axis = problem.default_axis(bins)?;
        let exact = problem.exact(SHAPE, &axis);
        let largest: Vec<f64> = exact.bands().iter().map(|band| band.min_max().1).collect();
        for tolerance in tolerances.split(',') {
            let tolerance: f64 = tolerance.parse()?;
            let start = Instant::now();
            let found = cube(problem, &axis, tolerance)?;
            let seconds = start.elapsed().as_secs_f64();
            let errors = found.error.as_ref().map(|error| error.voxels().collect::<Vec<_>>());
            let errors = errors.unwrap_or_default();
            let slack = problem.cube_error * exact.largest();
            let within = found.values.voxels().zip(exact.voxels()).zip(&errors);
            let within = within.filter(|((a, b), error)| (a - b).abs() <= **error + slack).count();
            println!(
                "| {} | {tolerance:.0e} | {} | {} | {:.1e} | {:.1e}{} | {:.4} | {seconds:.2} | {} | {} |",
                problem.name,
                found.stats.evaluations,
                found.stats.energies.len(),
                found.values.max_difference(&exact) / exact.largest(),
                found.estimated_error().unwrap_or(f64::NAN),
                if found.converged() { "" } else { " (not converged)" },
                within as f64 / errors.len() as f64,
                images(problem, &axis, tolerance, None)?,
                images(problem, &axis, tolerance, Some(&largest))?,
            );
        }
    }
    Ok(())
}
