//! `emitree sweep`: a scene file and the values of some of its keys in, an image for each out.
//!
//! An image that fails leaves the others as they are: the exit code is the worst of all.

mod outputs;
mod summary;

use crate::arguments::SweepArguments;
use crate::failure::{BUDGET_ENDED, Failure};
use crate::interrupt;
use crate::progress::ProgressLine;
use crate::threads;
use emitree::sweep::Sweep;
use emitree::{RenderError, RenderOptions};
use emitree_io::{Override, RenderedScene, Scene, SceneSweep, SweepReport, SweptImage, SweptKey};
use outputs::Outputs;
use std::process::ExitCode;

pub(crate) fn run(arguments: &SweepArguments) -> Result<ExitCode, Failure> {
    let keys = arguments.over.iter().map(|text| SweptKey::parse(text)).collect::<Result<_, _>>();
    let of_option = |error| Failure::Request(format!("--over: {error}"));
    let sweep = SceneSweep::new(keys.map_err(of_option)?).map_err(of_option)?;
    let scenes = Scenes { arguments, sweep: &sweep, overrides: arguments.overrides() };
    let pool = threads::pool(arguments.running.threads)?;
    // A wrong value, and a file that can't be written, are found before g is called.
    for image in 0..sweep.len() {
        outputs::check_scene(arguments, &scenes.open(image)?)?;
    }
    interrupt::catch();
    let outputs = Outputs::prepare(arguments, &sweep)?;

    let line = ProgressLine::new(arguments.running.quiet);
    let progress = |evaluations| line.advance(evaluations);
    let mut in_progress =
        Sweep::new(&(0..sweep.len()).map(|i| sweep.values(i)).collect::<Vec<_>>());
    let mut images: Vec<Option<SweptImage>> = vec![None; sweep.len()];
    while let Some(image) = in_progress.next_image() {
        let found = scenes.open(image).and_then(|scene| {
            let options = scene.render_options().with_progress(&progress);
            pool.install(|| rendered(&mut in_progress, &scene, &options))
                .and_then(|found| found.map(|of| outputs.write(image, &scene, of)).transpose())
        });
        let values = sweep.values(image);
        let made = match found {
            Ok(None) => continue,
            Ok(Some((rendered, written))) => {
                let code = if rendered.account.converged() { 0 } else { BUDGET_ENDED };
                SweptImage::new(values, code, &rendered.report(None), written)
            }
            Err(_) if interrupt::requested() => {
                return Err(Failure::Render(RenderError::Interrupted));
            }
            Err(failure) => {
                let failure = failure.of_image(sweep.label(image));
                line.finish();
                let _ = failure.report();
                SweptImage::failed(values, failure.code(), failure.to_string())
            }
        };
        images[image] = Some(made);
    }
    line.finish();
    let images: Vec<SweptImage> = images.into_iter().flatten().collect();
    let worst = images.iter().map(|image| image.exit_code).max_by_key(|&code| severity(code));
    let report = SweepReport::new(&sweep, in_progress.evaluations(), images);
    outputs.write_report(&report)?;
    if !arguments.running.quiet {
        // The files are written: a summary without a reader is not a failure.
        let _ = summary::print(&arguments.scene, &report);
    }
    Ok(ExitCode::from(worst.unwrap_or(0)))
}

/// The image of a scene, if it is the turn of this one.
fn rendered(
    sweep: &mut Sweep,
    scene: &Scene,
    options: &RenderOptions<'_>,
) -> Result<Option<RenderedScene>, Failure> {
    let (camera, shape) = (scene.camera.projection(), [scene.height, scene.width]);
    let found = sweep.step(&scene.emission, camera, shape, scene.axis(), options)?;
    if interrupt::requested() {
        return Err(Failure::Render(RenderError::Interrupted));
    }
    Ok(found.map(|found| RenderedScene::new(scene, &found)))
}

/// Images that were not made are worse than those that a budget ended.
fn severity(code: u8) -> u8 {
    match code {
        0 => 0,
        BUDGET_ENDED => 1,
        _ => u8::MAX - code,
    }
}

/// The scenes of a sweep, each read when it is needed.
struct Scenes<'a> {
    arguments: &'a SweepArguments,
    sweep: &'a SceneSweep,
    overrides: Vec<Override>,
}

impl Scenes<'_> {
    fn open(&self, image: usize) -> Result<Scene, Failure> {
        let overrides = [self.overrides.as_slice(), &self.sweep.overrides(image)].concat();
        Ok(Scene::open(&self.arguments.scene, &overrides)?)
    }
}
