//! A rendering in ask-and-tell form: the caller has the loop.

use crate::arrays::{Points, points};
use crate::emission::EmissionStop;
use crate::error::{SceneError, of_rendering};
use crate::mesh::{self, Mesh};
use crate::rendering::Rendered;
use crate::scene::{Scene, options_of};
use emitree::{Cube, RenderError, Samples};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use std::convert::Infallible;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// One rendering of a scene, held between its batches.
#[pyclass(frozen, module = "emitree._native")]
pub(crate) struct Session(Mutex<State>);

struct State {
    scene: Arc<emitree_io::Scene>,
    session: emitree::Session<'static, Cube>,
}

impl Session {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Refuses a medium that absorbs: a session takes rates, and its caller would have to know the optical depths.
fn refuse_absorption(scene: &emitree_io::Scene) -> PyResult<()> {
    match scene.emission.absorption {
        None => Ok(()),
        Some(_) => Err(SceneError::new_err(
            "the scene has `[absorption]`, and a session takes rates alone: expected none, or \
             `emitree.render`",
        )),
    }
}

#[pymethods]
impl Session {
    #[new]
    fn new(py: Python<'_>, scene: &Scene) -> PyResult<Self> {
        let scene = scene.shared();
        refuse_absorption(&scene)?;
        let session = py.detach(|| scene.session(&options_of(&scene)));
        let session = session.map_err(|error| raised(py, error))?;
        Ok(Self(Mutex::new(State { scene, session })))
    }

    /// The number of rates that are needed next; `None` once the rendering has ended.
    fn waits_for(&self, py: Python<'_>) -> Option<usize> {
        py.detach(|| self.state().session.ask().map(|samples| samples.len()))
    }

    /// The points at which rates are needed; `None` once the rendering has ended.
    fn ask<'py>(&self, py: Python<'py>) -> PyResult<Option<Points<'py>>> {
        // While one thread holds the session no other one waits for it with the interpreter.
        let asked = py.detach(|| {
            let state = self.state();
            let samples = state.session.ask()?;
            Some(state.scene.emission.seen(&samples, |samples| {
                let energies = samples.energies().to_vec();
                (samples.positions().to_vec(), samples.directions().to_vec(), energies)
            }))
        });
        let Some((positions, directions, energies)) = asked else { return Ok(None) };
        let samples = Samples::new(&positions, &directions).at_energies(&energies);
        points(py, &samples).map(Some)
    }

    /// Takes the rates at these points, in the unit of the function.
    fn tell(&self, py: Python<'_>, rates: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        let rates = rates.as_array().to_vec();
        let taken = py.detach(|| {
            let State { scene, session } = &mut *self.state();
            let factor = scene.emission.rate_factor;
            let rates: Vec<f64> = rates.iter().map(|rate| rate * factor).collect();
            session.tell(&rates)
        });
        taken.map_err(|error| raised(py, error))
    }

    /// Continues with the options and the shape of another scene of the same view.
    fn resume(&self, py: Python<'_>, scene: &Scene) -> PyResult<()> {
        let scene = scene.shared();
        let resumed = py.detach(|| {
            let mut state = self.state();
            state.session.resume([scene.height, scene.width], &options_of(&scene))?;
            state.scene = scene;
            Ok(())
        });
        resumed.map_err(|error| raised(py, error))
    }

    /// The latest image; `None` if there is none.
    fn rendering(&self, py: Python<'_>) -> Option<Rendered> {
        py.detach(|| {
            let state = self.state();
            Some(Rendered::of(&state.scene, &state.session.rendering()?))
        })
    }

    /// The frozen quadrature of a rendering that has ended.
    fn mesh(&self, py: Python<'_>) -> PyResult<Mesh> {
        let mesh = py.detach(|| {
            let state = self.state();
            Ok(Mesh { scene: Arc::clone(&state.scene), mesh: state.session.mesh()? })
        });
        mesh.map_err(mesh::raised)
    }
}

/// The error as an exception.
fn raised(py: Python<'_>, error: RenderError<Infallible>) -> PyErr {
    of_rendering(py, error.map_emission::<EmissionStop>(|never| match never {}))
}
