//! `emitree render`: a scene file in, images out.

mod frames;
mod outputs;
mod picture;
mod progress;
mod summary;

pub(crate) use outputs::history;
pub(crate) use progress::ProgressLine;
pub(crate) use summary::{grouped, percent, seconds};

use crate::arguments::RenderArguments;
use crate::failure::{BUDGET_ENDED, Failure};
use crate::interrupt;
use crate::report::{Report, available_memory_bytes};
use emitree::{Frame, Image, Method, RenderError, RenderOptions, irradiance_of, render};
use emitree_io::{Quantity, Scene};
use frames::FrameWriter;
use outputs::Outputs;
use std::ops::ControlFlow;
use std::process::ExitCode;

/// An image, or its error, in the quantity that the scene asks for.
fn in_quantity(scene: &Scene, radiance: &Image) -> Image {
    match scene.quantity {
        Quantity::Irradiance => irradiance_of(radiance, scene.camera.projection()),
        _ => radiance.clone(),
    }
}

pub(crate) fn run(arguments: &RenderArguments) -> Result<ExitCode, Failure> {
    let scene = Scene::open(&arguments.scene, &arguments.overrides())?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = arguments.threads {
        pool = pool.num_threads(usize::from(threads));
    }
    let pool = pool
        .build()
        .map_err(|error| Failure::Request(format!("--threads: can't start them: {error}")))?;

    interrupt::catch();
    // Temporary files beside the targets: what can't be written is found before g is called.
    let outputs = Outputs::prepare(arguments, scene.render.method)?;
    let line = ProgressLine::new(arguments.quiet);
    let progress = |evaluations| {
        line.set(evaluations);
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    // Only `vol` has images on its way; the frames of a tree are made from the whole of it.
    let frames = match (scene.render.method, &arguments.progressive) {
        (Method::Vol(_), Some(folder)) => Some(FrameWriter::new(folder, &scene)),
        _ => None,
    };
    let on_frame = |frame: &Frame<'_>| match &frames {
        Some(frames) => frames.write(frame),
        None => ControlFlow::Continue(()),
    };
    let mut options = RenderOptions::new(scene.render.method);
    options.max_evaluations = scene.render.max_evaluations.unwrap_or(options.max_evaluations);
    options.batch_size = scene.render.batch_size.unwrap_or(options.batch_size);
    options.seeds = &scene.render.seeds;
    options.progress = Some(&progress);
    if frames.is_some() {
        options.frame = Some(&on_frame);
    }
    if let Some(available) = available_memory_bytes() {
        options.max_memory_bytes = available;
    }
    let shape = [scene.height, scene.width];
    let rendering =
        pool.install(|| render(&scene.emission, scene.camera.projection(), shape, &options));
    line.finish();
    // A frame that can't be written ends the rendering as an interruption does: its own failure
    // says more.
    let frames = frames.map_or_else(|| Ok(Vec::new()), FrameWriter::finish)?;
    let mut rendering = rendering?;
    if scene.quantity == Quantity::Irradiance {
        rendering.image = in_quantity(&scene, &rendering.image);
        rendering.error = rendering.error.map(|error| in_quantity(&scene, &error));
    }
    if interrupt::requested() {
        return Err(Failure::Render(RenderError::Interrupted));
    }
    let report = Report::new(&scene, &rendering);
    let mut written = pool.install(|| outputs.write(&scene, &rendering, &report))?;
    written.extend(frames);
    if !arguments.quiet {
        // The files are written: that nobody reads the summary changes nothing.
        let _ = summary::print(&scene, &rendering, &written);
    }
    Ok(if rendering.converged() { ExitCode::SUCCESS } else { ExitCode::from(BUDGET_ENDED) })
}
