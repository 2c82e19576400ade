//! `emitree plan` and `emitree resume`: a rendering whose rates another program makes, by files.

use crate::arguments::{PlanArguments, ResumeArguments};
use crate::failure::{Failure, NEEDS_RATES};
use crate::render::{Outputs, same_file, write_finished};
use crate::threads;
use emitree_io::{OutputSet, PlannedRun, PointsFormat, Scene, commit_all, grouped};
use std::io::{Write, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// The first points of a scene.
pub(crate) fn begin(arguments: &PlanArguments) -> Result<ExitCode, Failure> {
    let scene = Scene::open_planned(&arguments.scene, &arguments.scene_options.overrides())?;
    let pool = threads::pool(arguments.running.threads)?;
    let state = state_of(arguments.state.as_deref(), &arguments.scene);
    if state.exists() {
        let path = state.display();
        return Err(Failure::Request(format!(
            "the state {path} exists, with the rates of another run: expected `emitree resume`, or another --state"
        )));
    }
    let files = Files::prepare(&arguments.output, &state, &arguments.scene)?;
    let run = pool.install(|| PlannedRun::new(&Arc::new(scene.clone())))?;
    files.write(&run, &scene, arguments.running.quiet)
}

/// The next points after some rates, or the images.
pub(crate) fn resume(arguments: &ResumeArguments) -> Result<ExitCode, Failure> {
    let ResumeArguments { render, rates, points, state } = arguments;
    if render.progressive.is_some() {
        let why = "a run that is resumed has no frames: expected `emitree render`";
        return Err(Failure::Request(format!("--progressive: {why}")));
    }
    let scene = Scene::open_planned(&render.scene, &render.scene_options.overrides())?;
    let pool = threads::pool(render.running.threads)?;
    let state = state_of(state.as_deref(), &render.scene);
    let shared = Arc::new(scene.clone());
    let mut run = pool.install(|| PlannedRun::open(&shared, &state))?;
    // What can't be written is found before the rates are taken.
    let files = Files::prepare(points, &state, &render.scene)?;
    let outputs = Outputs::prepare(render, &scene)?;
    if !rates.is_empty() {
        let rates = run.read_rates(rates)?;
        pool.install(|| run.tell(&rates))?;
    }
    if run.points().is_some() {
        files.write(&run, &scene, render.running.quiet)?;
        return Ok(ExitCode::from(NEEDS_RATES));
    }
    // The rates are stored first: whatever the outputs come to, they need not be made again.
    files.write_state(&run)?;
    match run.rendering() {
        Some(rendering) => write_finished(render, &scene, outputs, rendering, &pool),
        None => Err(Failure::Request("the run has ended without an image".to_owned())),
    }
}

/// The state of a scene: that of the option, or one in this folder that is named like the scene.
fn state_of(option: Option<&Path>, scene: &Path) -> PathBuf {
    let beside_nothing =
        || PathBuf::from(scene.file_name().unwrap_or("scene".as_ref())).with_extension("state");
    option.map_or_else(beside_nothing, Path::to_owned)
}

/// The files of points and of the state, each with its temporary file.
struct Files {
    format: PointsFormat,
    set: OutputSet,
}

impl Files {
    fn prepare(points: &Path, state: &Path, scene: &Path) -> Result<Self, Failure> {
        let format = PointsFormat::from_path(points)?;
        if let Some(path) = [points, state].into_iter().find(|path| same_file(path, scene)) {
            let path = path.display();
            let why = "is the scene itself: expected another name";
            return Err(Failure::Request(format!("the output {path} {why}")));
        }
        Ok(Self { format, set: OutputSet::create([points, state])? })
    }

    /// Writes the points that a run waits for, and its state, after both have been stored.
    fn write(self, run: &PlannedRun, scene: &Scene, quiet: bool) -> Result<ExitCode, Failure> {
        let Some(points) = run.points() else { return self.write_state(run) };
        let bytes = [self.format.encode(points, scene)?, run.state()?];
        let written = commit_all(self.set.into_iter().zip(bytes))?;
        if let (false, Some(file)) = (quiet, written.first()) {
            let (number, known) = (points.len(), run.evaluations());
            // The files are written: a line without a reader is not a failure.
            let _ = writeln!(
                stdout(),
                "{}: {} points, after {} evaluations in {} rounds",
                file.display(),
                grouped(number as u64),
                grouped(known as u64),
                run.rounds(),
            );
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Writes the state alone.
    fn write_state(self, run: &PlannedRun) -> Result<ExitCode, Failure> {
        commit_all(self.set.into_iter().skip(1).zip([run.state()?]))?;
        Ok(ExitCode::SUCCESS)
    }
}
