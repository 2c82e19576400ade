//! `emitree build`: a scene file in, the tree of its emission out.

mod summary;

use crate::arguments::BuildArguments;
use crate::failure::{BUDGET_ENDED, Failure};
use crate::interrupt;
use crate::progress::ProgressLine;
use crate::threads;
use emitree::world_tree::{WorldTreeError, WorldTreeOptions, build_world_tree};
use emitree::{RenderError, StopReason};
use emitree_io::{OutputFile, Quantity, Scene, TreeFile, available_memory_bytes, scene_history};
use std::path::Path;
use std::process::ExitCode;

pub(crate) fn run(arguments: &BuildArguments) -> Result<ExitCode, Failure> {
    let scene = Scene::open(&arguments.scene, &arguments.overrides())?;
    let Some(settings) = &scene.build else {
        return Err(Failure::Request(format!(
            "{}: the scene has no `[build]`: expected a table `[build]` with `min` and `max`, the \
             corners of a box",
            scene.name
        )));
    };
    if scene.component_names().is_some() {
        let why = "a tree holds one rate at each point: expected a single `emission.expression`";
        return Err(Failure::Request(format!("{}: `emission.expressions`: {why}", scene.name)));
    }
    if scene.energy.is_some() {
        let why = "a tree holds rates of one energy: expected a scene without an energy axis";
        return Err(Failure::Request(format!("{}: `[energy]`: {why}", scene.name)));
    }
    if scene.exposure.is_some() {
        let why = "a tree holds rates of one time: expected a scene without a time axis";
        return Err(Failure::Request(format!("{}: `[time]`: {why}", scene.name)));
    }
    if scene.quantity == Quantity::Irradiance {
        let why = "a tree holds rates, whose integrals are radiances: expected \"radiance\"";
        return Err(Failure::Request(format!("{}: `image.quantity`: {why}", scene.name)));
    }
    let pool = threads::pool(arguments.running.threads)?;

    interrupt::catch();
    let output = prepare(&arguments.output, &arguments.scene)?;
    let line = ProgressLine::new(arguments.running.quiet);
    let progress = |evaluations| line.advance(evaluations);
    let defaults = WorldTreeOptions::default();
    let options = WorldTreeOptions::new(settings.tolerance)
        .with_order(settings.order)
        .with_base_level(settings.base_level)
        .with_finest_level(settings.finest_level)
        .with_max_evaluations(settings.max_evaluations.unwrap_or(defaults.max_evaluations))
        .with_max_memory_bytes(available_memory_bytes().unwrap_or(defaults.max_memory_bytes))
        .with_progress(&progress);
    let built = pool.install(|| build_world_tree(&scene.emission, settings.bounds, &options));
    line.finish();
    let built = built?;
    if interrupt::requested() {
        return Err(WorldTreeError::Render(RenderError::Interrupted).into());
    }
    let summary = summary::text(&scene, settings, &built, output.path());
    let complete = built.ending == StopReason::Complete;
    let file = TreeFile::new(built, settings.tolerance)
        .with_units(scene.length_unit.as_deref(), scene.image_unit())
        .with_scene(&scene_history(&scene.text, &scene.overrides));
    output.commit(&file.encode()?)?;
    if !arguments.running.quiet {
        // The file is written: a summary without a reader is not a failure.
        let _ = summary::print(&summary);
    }
    Ok(if complete { ExitCode::SUCCESS } else { ExitCode::from(BUDGET_ENDED) })
}

/// The temporary file beside the target: what can't be written is found before g is called.
fn prepare(path: &Path, scene: &Path) -> Result<OutputFile, Failure> {
    let ending = path.extension().unwrap_or_default();
    if !["fits", "fit"].iter().any(|fits| ending.eq_ignore_ascii_case(fits)) {
        let path = path.display();
        let why = "a tree has no format for this ending: expected .fits or .fit";
        return Err(Failure::Request(format!("output: `{path}`: {why}")));
    }
    if let (Ok(target), Ok(scene)) = (std::fs::canonicalize(path), std::fs::canonicalize(scene))
        && target == scene
    {
        let path = path.display();
        let why = "is the scene itself: expected another name";
        return Err(Failure::Request(format!("the output {path} {why}")));
    }
    Ok(OutputFile::create(path)?)
}
