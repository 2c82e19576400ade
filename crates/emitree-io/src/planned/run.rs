//! The run: a session whose rates come from files.

use super::changes::{between, lasting};
use super::error::PlannedError;
use super::points::PlannedPoints;
use super::rates;
use super::state::State;
use crate::scene::Scene;
use emitree::{Cube, RenderOptions, Rendering, Session};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A rendering of a scene whose rates another program makes.
///
/// ```
/// use emitree_io::{PlannedRun, PointsFormat, Scene};
/// use std::sync::Arc;
///
/// // No emission: another program has it.
/// let text = "projection.type = \"canonical\"\nimage = { width = 8, height = 8 }";
/// let scene = Arc::new(Scene::parse_planned("example", text, &[])?);
/// let folder = tempfile::tempdir()?;
/// let state = folder.path().join("example.state");
/// std::fs::write(&state, PlannedRun::new(&scene)?.state()?)?;
///
/// let rendering = loop {
///     let mut run = PlannedRun::open(&scene, &state)?;
///     let Some(points) = run.points() else { break run.rendering() };
///     let bytes = PointsFormat::Csv.encode(points, &scene)?; // for another program
///     assert!(bytes.starts_with(b"x,y,z,dx,dy,dz\n"));
///     let rates: Vec<f64> = points.positions.iter().map(|[x, y, z]| x * y + z).collect();
///     run.tell(&rates)?;
///     std::fs::write(&state, run.state()?)?;
/// };
/// assert!(rendering.is_some_and(|rendering| rendering.converged()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PlannedRun {
    scene: Arc<Scene>,
    session: Session<'static, Cube>,
    state: State,
}

impl PlannedRun {
    /// A run from its beginning.
    ///
    /// # Errors
    ///
    /// [`PlannedError::Render`]: options out of range, an image beyond the memory; [`PlannedError::Absorption`],
    /// [`PlannedError::Events`].
    pub fn new(scene: &Arc<Scene>) -> Result<Self, PlannedError> {
        Self::with(scene, State { scene: lasting(scene.values()?), ..State::default() })
    }

    /// The run whose state is in the file at `path`. The scene may have another method, tolerance or number of
    /// pixels than before: known rates serve that as well.
    ///
    /// # Errors
    ///
    /// [`PlannedError`]: a file that is no state, a scene that has changed, and as [`new`](Self::new).
    pub fn open(scene: &Arc<Scene>, path: &Path) -> Result<Self, PlannedError> {
        let state = State::read(path)?;
        let changes = between(&state.scene, &lasting(scene.values()?));
        if !changes.is_empty() {
            return Err(PlannedError::Changed { path: path.to_owned(), changes });
        }
        Self::with(scene, state)
    }

    fn with(scene: &Arc<Scene>, state: State) -> Result<Self, PlannedError> {
        if scene.emission.absorption.is_some() {
            return Err(PlannedError::Absorption);
        }
        if scene.emission.events.is_some() {
            return Err(PlannedError::Events);
        }
        // A limit of time would count the time of this process alone.
        let options: RenderOptions<'_> = scene.render_options().with_max_seconds(f64::INFINITY);
        let session = scene.session(&options)?;
        let mut run = Self { scene: Arc::clone(scene), session, state };
        if !run.state.points.is_empty() {
            let rates = run.scaled(&run.state.rates);
            run.session.tell_known(&run.state.points.samples(), &rates, run.state.rounds)?;
        }
        if run.state.asked.is_empty() {
            run.ask();
        }
        Ok(run)
    }

    /// Rates in the unit of the image per length.
    fn scaled(&self, rates: &[f64]) -> Vec<f64> {
        let factor = self.scene.emission.rate_factor;
        rates.iter().map(|rate| rate * factor).collect()
    }

    /// Stores the points that the session asks for.
    fn ask(&mut self) {
        self.state.asked =
            self.session.ask().map_or_else(PlannedPoints::default, |of| PlannedPoints::of(&of));
    }

    /// The points at which rates are needed: those of the last file until their rates are told; `None` once the
    /// rendering has ended.
    pub fn points(&self) -> Option<&PlannedPoints> {
        (!self.session.is_done() && !self.state.asked.is_empty()).then_some(&self.state.asked)
    }

    /// How often rates have been told.
    pub fn rounds(&self) -> u64 {
        self.state.rounds
    }

    /// The number of known rates.
    pub fn evaluations(&self) -> usize {
        self.state.rates.len()
    }

    /// The rates at the [`points`](Self::points) in the files at `paths`, one part after the other: NPY with one
    /// array, NPZ with the array `rate`, or columns of text, one or with one that is `rate`. Where positions stand
    /// beside the rates they are compared with those of the points.
    ///
    /// # Errors
    ///
    /// [`PlannedError`] names the file and the row.
    pub fn read_rates(&self, paths: &[PathBuf]) -> Result<Vec<f64>, PlannedError> {
        rates::read(paths, &self.state.asked)
    }

    /// Takes the rates at the [`points`](Self::points), in the unit of the emission, and continues to the next
    /// points.
    ///
    /// # Errors
    ///
    /// [`PlannedError::Render`]: a number of rates other than that of the points, a rate that is not finite, an image
    /// that is not finite.
    pub fn tell(&mut self, rates: &[f64]) -> Result<(), PlannedError> {
        let scaled = self.scaled(rates);
        let Self { session, state, .. } = self;
        session.tell_known(&state.asked.samples(), &scaled, 1)?;
        let PlannedPoints { positions, directions, energies } = core::mem::take(&mut state.asked);
        state.points.positions.extend(positions);
        state.points.directions.extend(directions);
        state.points.energies.extend(energies);
        state.rates.extend_from_slice(rates);
        state.rounds += 1;
        self.ask();
        Ok(())
    }

    /// The bytes of a file with which [`open`](Self::open) continues the run.
    ///
    /// # Errors
    ///
    /// [`PlannedError::Archive`] if an archive has no room for them.
    pub fn state(&self) -> Result<Vec<u8>, PlannedError> {
        self.state.encode()
    }

    /// The rendering once it has ended; before that the latest image, if there is one.
    pub fn rendering(&self) -> Option<Rendering<Cube>> {
        self.session.rendering()
    }
}

impl core::fmt::Debug for PlannedRun {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("PlannedRun")
            .field("rounds", &self.state.rounds)
            .field("evaluations", &self.state.rates.len())
            .field("asked", &self.state.asked.len())
            .finish_non_exhaustive()
    }
}
