//! Images and cubes that are made row by row, since they are larger than the memory.

use super::is_of_largest;
use super::summary::{bins_text, evaluated};
use crate::arguments::RenderArguments;
use crate::failure::{BUDGET_ENDED, Failure};
use crate::interrupt;
use crate::numbers::seconds;
use crate::progress::{Goal, ProgressLine};
use emitree::large::fits_in_memory;
use emitree::{EnergyAxis, Method, RenderError};
use emitree_io::{LargeOutput, OutputFile, Scene, grouped, peak_memory_bytes, write_large};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Whether the image is to be made so: by the option, or since it does not fit in the memory and nothing but a
/// FITS file is to be written.
pub(super) fn is_asked_for(arguments: &RenderArguments, scene: &Scene) -> bool {
    let is_possible = matches!(scene.render.method, Method::Vol(_)) && output(arguments).is_ok();
    let (shape, bins) = ([scene.height, scene.width], scene.axis().map(EnergyAxis::bins));
    arguments.by_rows || is_possible && !fits_in_memory(shape, bins, &scene.render_options())
}

/// The one output.
fn output(arguments: &RenderArguments) -> Result<&Path, Failure> {
    let others = [
        ("--report", arguments.report.is_some()),
        ("--error-map", arguments.error_map.is_some()),
        ("--band", !arguments.bands.is_empty()),
        ("--expected-counts", !arguments.expected_counts.is_empty()),
        ("--counts", !arguments.counts.is_empty()),
        ("--surfaces", !arguments.surfaces.is_empty()),
        ("--progressive", arguments.progressive.is_some()),
    ];
    let refuse = |why: String| Err(Failure::Request(format!("--by-rows: {why}")));
    if let Some((name, _)) = others.into_iter().find(|(_, is_given)| *is_given) {
        return refuse(format!(
            "there is no {name} of an image made row by row: expected --output alone"
        ));
    }
    match &arguments.outputs[..] {
        [one] if is_fits(one) => Ok(one),
        [one] => refuse(format!("the output is `{}`: expected .fits or .fits.gz", one.display())),
        several => refuse(format!("{} outputs: expected one, .fits or .fits.gz", several.len())),
    }
}

fn is_fits(path: &Path) -> bool {
    let name = path.to_string_lossy().to_lowercase();
    [".fits", ".fit", ".fits.gz", ".fit.gz"].iter().any(|ending| name.ends_with(ending))
}

/// Renders and writes the image, and prints a summary.
pub(super) fn run(
    arguments: &RenderArguments,
    scene: &Scene,
    pool: &rayon::ThreadPool,
) -> Result<ExitCode, Failure> {
    let path = output(arguments)?;
    if super::same_file(path, &arguments.scene) {
        let path = path.display();
        let why = "is the scene itself: expected another name";
        return Err(Failure::Request(format!("the output {path} {why}")));
    }
    let file = OutputFile::create(path)?;
    let started = Instant::now();
    let mut options = scene.render_options();
    let tolerance = scene.render.tolerance.filter(|_| is_of_largest(&scene.render.method));
    let line = ProgressLine::towards(Goal::of(&options, tolerance), arguments.running.quiet);
    let progress = |evaluations| line.advance(evaluations);
    options.progress = Some(&progress);
    let made = pool.install(|| write_large(scene, &scene.emission, &options, file));
    line.finish();
    if interrupt::requested() {
        return Err(Failure::Render(RenderError::Interrupted));
    }
    let made = made?;
    if !arguments.running.quiet {
        // The file is written: a summary without a reader is not a failure.
        let _ = print(scene, &made, path, started);
    }
    Ok(if made.account.converged() { ExitCode::SUCCESS } else { ExitCode::from(BUDGET_ENDED) })
}

fn print(
    scene: &Scene,
    made: &LargeOutput,
    path: &Path,
    started: Instant,
) -> Result<(), std::io::Error> {
    let mut out = std::io::stdout().lock();
    let [low, high] = made.range;
    let account = &made.account;
    let error = account.estimated_error.unwrap_or_default();
    writeln!(
        out,
        "{}: {} x {} pixels (width x height), row by row",
        scene.name, scene.width, scene.height
    )?;
    if let Some(energies) = &scene.energy {
        writeln!(out, "{}{}", bins_text(energies), evaluated(account))?;
    }
    writeln!(
        out,
        "  evaluations  {} in {} batches",
        grouped(account.evaluations),
        account.batches
    )?;
    let value = if scene.energy.is_some() { "voxel" } else { "pixel" };
    writeln!(out, "  error        {error:.2e} of the largest {value} (estimated)")?;
    writeln!(out, "  {:11}  {low:.4e} to {high:.4e}", account.quantity)?;
    if let Some(bytes) = peak_memory_bytes() {
        writeln!(out, "  memory       {} MiB at most", bytes >> 20)?;
    }
    writeln!(out, "  time         {}", seconds(started.elapsed()))?;
    writeln!(out, "  written      {}", PathBuf::from(path).display())?;
    if !account.converged() {
        writeln!(out, "  NOT CONVERGED: ended by {}", account.ending)?;
    }
    Ok(())
}
