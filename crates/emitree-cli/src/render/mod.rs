//! `emitree render`: a scene file in, images out.

mod by_rows;
mod components;
mod counts;
mod frames;
mod outputs;
mod rendered;
mod summary;

use counts::Counts;
use rendered::Rendered;
pub(crate) use summary::{method as method_text, size_text};

use crate::arguments::RenderArguments;
use crate::failure::{BUDGET_ENDED, Failure};
use crate::interrupt;
use crate::progress::{Goal, ProgressLine};
use crate::threads;
use emitree::progress::Frame;
use emitree::{Cube, Method, RenderError, RenderOptions, Rendering};
use emitree_io::Scene;
use frames::FrameWriter;
pub(crate) use frames::same_file;
pub(crate) use outputs::Outputs;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;

pub(crate) fn run(arguments: &RenderArguments) -> Result<ExitCode, Failure> {
    let scene = Scene::open(&arguments.scene, &arguments.scene_options.overrides())?;
    let pool = threads::pool(arguments.running.threads)?;

    interrupt::catch();
    if let Some(components) = scene.components() {
        return components::run(arguments, &scene, &components, &pool);
    }
    if by_rows::is_asked_for(arguments, &scene) {
        return by_rows::run(arguments, &scene, &pool);
    }
    // Temporary files beside the targets: what can't be written is found before g is called.
    let outputs = Outputs::prepare(arguments, &scene)?;
    let mut options: RenderOptions<'_> = scene.render_options();
    let is_vol = matches!(scene.render.method, Method::Vol(_));
    let tolerance = scene.render.tolerance.filter(|_| is_of_largest(&scene.render.method));
    let line = ProgressLine::towards(Goal::of(&options, tolerance), arguments.running.quiet);
    let progress = |evaluations| line.advance(evaluations);
    options.progress = Some(&progress);
    // Only `vol` has intermediate images; the frames of a tree are made from the whole of it.
    let frames = arguments.progressive.as_ref().filter(|_| is_vol);
    let frames = frames.map(|folder| FrameWriter::new(folder, &scene));
    let on_frame = |frame: &Frame<'_>| {
        line.show(frame);
        frames.as_ref().map_or(ControlFlow::Continue(()), |frames| frames.write(frame))
    };
    if is_vol && (frames.is_some() || line.is_seen()) {
        options.frame = Some(&on_frame);
    }
    let rendered: Result<(Rendered, Option<Failure>), Failure> = pool.install(|| {
        let rendering = scene.render(&scene.emission, &options)?;
        let (counts, failure) = Counts::of(arguments, &scene, &rendering.values);
        Ok((Rendered::new(&scene, rendering, counts), failure))
    });
    line.finish();
    // A frame that can't be written ends the rendering as an interruption does: its own failure
    // says more.
    let frames = frames.map_or_else(|| Ok(Vec::new()), FrameWriter::finish)?;
    let found = rendered?;
    if interrupt::requested() {
        return Err(Failure::Render(RenderError::Interrupted));
    }
    write(arguments, &scene, outputs, found, frames, &pool)
}

/// Writes all outputs of a rendering with its counts, and prints the summary. `frames` have been written.
fn write(
    arguments: &RenderArguments,
    scene: &Scene,
    outputs: Outputs,
    (rendered, of_counts): (Rendered, Option<Failure>),
    frames: Vec<PathBuf>,
    pool: &rayon::ThreadPool,
) -> Result<ExitCode, Failure> {
    let (mut written, of_files) = pool.install(|| outputs.write(scene, &rendered))?;
    written.extend(frames);
    if !arguments.running.quiet {
        // The files are written: a summary without a reader is not a failure.
        let _ = summary::print(scene, &rendered, &written);
    }
    // Counts and surfaces that can't be had cost no more than themselves: the rendering may have taken
    // hours.
    if let Some(failure) = of_counts.or(of_files) {
        return Err(Failure::Request(format!("{failure}; all other outputs were written")));
    }
    Ok(if rendered.account.converged() { ExitCode::SUCCESS } else { ExitCode::from(BUDGET_ENDED) })
}

/// Writes all outputs of a rendering whose rates came from elsewhere; `outputs` were prepared before.
pub(crate) fn write_finished(
    arguments: &RenderArguments,
    scene: &Scene,
    outputs: Outputs,
    rendering: Rendering<Cube>,
    pool: &rayon::ThreadPool,
) -> Result<ExitCode, Failure> {
    let found = pool.install(|| {
        let (counts, failure) = Counts::of(arguments, scene, &rendering.values);
        (Rendered::new(scene, rendering, counts), failure)
    });
    write(arguments, scene, outputs, found, Vec::new(), pool)
}

/// Whether the tolerance is that of all pixels, relative to the largest.
fn is_of_largest(method: &Method) -> bool {
    match method {
        Method::Vol(vol) => vol.by_pixel.is_none() && vol.weights.is_none() && !vol.per_band,
        _ => false,
    }
}
