//! A scene that was read and checked, and what is made of it.

use crate::bridge::{Caller, Hooks, run};
use crate::emission::AnyEmission;
use crate::error::{
    EmissionError, SceneError, of_encoding, of_output, of_rendering, of_scene, of_tree,
};
use crate::lines::{Lines, lines};
use crate::mesh::Mesh;
use crate::points::vectors as vectors_of;
use crate::rendering::Rendered;
use emitree::progress::Frame;
use emitree::world_tree::{WorldTreeOptions, build_world_tree};
use emitree::{Emission, Image, Method, RenderOptions, Samples, StopReason};
use emitree_io::{EmissionSource, LargeError, OutputFile, Override, TreeFile, write_large};
use emitree_models::Outside;
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use std::sync::Arc;

/// A scene, read and checked: emission, camera, image and method.
#[pyclass(frozen, module = "emitree._native")]
pub(crate) struct Scene(Arc<emitree_io::Scene>);

/// What a rendering, or the build of a tree, may take besides the function: memory that any workstation has.
const MOST_MEMORY_BYTES: u64 = 8 << 30;

/// Keys with values in TOML, as options of the command line: `("render.method", "los")`.
type Changes = Vec<(String, String)>;

impl Scene {
    /// The scene, for what outlives this object.
    pub(crate) fn shared(&self) -> Arc<emitree_io::Scene> {
        Arc::clone(&self.0)
    }
}

#[pymethods]
impl Scene {
    /// Reads the scene file at `path`; `changes` replace values of it. `aliases` are as of `parse`.
    #[staticmethod]
    fn open(path: PathBuf, changes: Changes, aliases: Vec<(String, String)>) -> PyResult<Self> {
        let scene = emitree_io::Scene::open(&path, &overrides(changes));
        let mut scene = scene.map_err(|error| of_scene(&error, true, &aliases))?;
        for (file, alias) in &aliases {
            for change in &mut scene.overrides {
                *change = change.replace(file, alias);
            }
        }
        Ok(Self(Arc::new(scene)))
    }

    /// Reads a scene from its text, which was made from keywords; `name` is what reports call it.
    /// `aliases` are pairs: the name of a temporary file, and what messages and reports call it.
    #[staticmethod]
    fn parse(name: &str, text: &str, aliases: Vec<(String, String)>) -> PyResult<Self> {
        let scene = emitree_io::Scene::parse(name, text, &[]);
        let mut scene = scene.map_err(|error| of_scene(&error, false, &aliases))?;
        for (file, alias) in &aliases {
            scene.text = scene.text.replace(file, alias);
        }
        Ok(Self(Arc::new(scene)))
    }

    /// The name of the file.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// The text, as it was given.
    #[getter]
    fn text(&self) -> &str {
        &self.0.text
    }

    /// The name of the method.
    #[getter]
    fn method(&self) -> &str {
        self.0.render.method.name()
    }

    /// Options that are given and that the method does not use: keys of `[render]`, and `seed`.
    #[getter]
    fn ignored(&self) -> Vec<&str> {
        self.0.render.ignored.clone()
    }

    /// The scene of each component with its name, of `expressions`; `None` of a single emission rate. They share the
    /// rates at points that several of them need.
    fn components(&self) -> Option<Vec<(String, Self)>> {
        let components = self.0.components()?;
        let scenes = components.scenes().iter().map(|scene| Self(Arc::new(scene.clone())));
        Some(components.names().iter().cloned().zip(scenes).collect())
    }

    /// Of the scene of a component: at how many points all components were evaluated so far.
    #[getter]
    fn component_evaluations(&self) -> Option<u64> {
        match &self.0.emission.source {
            EmissionSource::Component(component) => Some(component.evaluations()),
            _ => None,
        }
    }

    /// Height and width of the image.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.0.height, self.0.width)
    }

    /// The unit of lengths, or `None`.
    #[getter]
    fn length_unit(&self) -> Option<&str> {
        self.0.length_unit.as_deref()
    }

    /// The unit of the image, FITS grammar, or "".
    #[getter]
    fn unit(&self) -> &str {
        self.0.image_unit()
    }

    /// The borders of the bins of the energy, or of the time, ascending, and their unit; `None` without such an axis.
    #[getter]
    fn energies<'py>(&self, py: Python<'py>) -> Option<(Bound<'py, PyArray1<f64>>, &str)> {
        let times = self.0.exposure.as_ref().map(emitree_io::Exposure::times);
        let energies = times.or(self.0.energy.as_ref())?;
        Some((PyArray1::from_vec(py, energies.axis().edges()), energies.unit_name()))
    }

    /// Renders the scene, or a function in place of its emission:
    /// `function(position, direction, energy | None) -> rates`, and another one in place of its absorption
    /// coefficient, if it has one. It begins with the functions of the mesh
    /// `start`, and anew where they do not suffice, unless it `is_fixed` to them. `places` (n, 2) on the image plane,
    /// x and y from 0 to 1, are those whose lines of sight have radiances of their own.
    #[pyo3(signature = (
        *, function=None, absorption=None, batch_size=None, threads=None, progress=None, frame=None,
        start=None, is_fixed=false, places=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn render(
        &self,
        py: Python<'_>,
        function: Option<Py<PyAny>>,
        absorption: Option<Py<PyAny>>,
        batch_size: Option<u64>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
        frame: Option<Py<PyAny>>,
        start: Option<Py<Mesh>>,
        is_fixed: bool,
        places: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Rendered> {
        let hooks = Hooks { function, absorption, progress, frame };
        let scene = &self.0;
        let mut options = options_of(scene).with_mesh_up_to(EVALUATIONS_OF_MESHES);
        options.batch_size = batch_size.unwrap_or(options.batch_size);
        if let (Some(places), Method::Vol(vol)) = (&places, &mut options.method) {
            let numbers: Vec<f64> = places.as_array().iter().copied().collect();
            vol.lines = Some(numbers.as_chunks().0.into());
        }
        let options = match start.as_ref().map(|start| &start.get().mesh) {
            Some(mesh) if is_fixed => options.with_fixed_mesh(mesh),
            Some(mesh) => options.with_start(mesh),
            None => options,
        };
        let found = run(py, &hooks, threads, |caller| rendered(scene, &hooks, caller, &options));
        found?.map_err(|error| of_rendering(py, error))
    }

    /// Renders the scene, or a function in place of its emission, and writes the image or the cube to the FITS file
    /// `path` row by row. Returns the report, as JSON.
    #[pyo3(signature = (path, *, function=None, batch_size=None, threads=None, progress=None))]
    fn write_large(
        &self,
        py: Python<'_>,
        path: PathBuf,
        function: Option<Py<PyAny>>,
        batch_size: Option<u64>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let output = OutputFile::create(path).map_err(of_output)?;
        let hooks = Hooks { function, progress, ..Hooks::default() };
        let scene = &*self.0;
        let mut options = options_of(scene);
        options.batch_size = batch_size.unwrap_or(options.batch_size);
        let made = run(py, &hooks, threads, |caller| {
            let progress = |evaluations| caller.progress(evaluations);
            let mut options: RenderOptions<'_> = options.clone();
            options.progress = Some(&progress);
            write_large(scene, &emission(scene, &hooks, caller), &options, output)
        })?;
        match made {
            Ok(made) => Ok(made.report().to_json()),
            Err(LargeError::Render(error)) => Err(of_rendering(py, error)),
            Err(LargeError::Output(error)) => Err(of_output(error)),
            Err(error) => Err(of_encoding(error)),
        }
    }

    /// Builds the tree of the scene's emission, or of a function in its place, in the box of its
    /// `[build]`: the bytes of a tree file, and the cost.
    #[pyo3(signature = (*, function=None, batch_size=None, threads=None, progress=None))]
    fn build_tree<'py>(
        &self,
        py: Python<'py>,
        function: Option<Py<PyAny>>,
        batch_size: Option<u64>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyBytes>, Bound<'py, PyDict>)> {
        let scene = &*self.0;
        let Some(settings) = &scene.build else {
            return Err(SceneError::new_err("the scene has no `[build]`"));
        };
        let hooks = Hooks { function, progress, ..Hooks::default() };
        let built = run(py, &hooks, threads, |caller| {
            let progress = |evaluations| caller.progress(evaluations);
            let defaults = WorldTreeOptions::default();
            let options = WorldTreeOptions::new(settings.tolerance)
                .with_order(settings.order)
                .with_base_level(settings.base_level)
                .with_finest_level(settings.finest_level)
                .with_max_evaluations(settings.max_evaluations.unwrap_or(defaults.max_evaluations))
                .with_batch_size(batch_size.unwrap_or(defaults.batch_size))
                .with_max_memory_bytes(MOST_MEMORY_BYTES)
                .with_progress(&progress);
            build_world_tree(&emission(scene, &hooks, caller), settings.bounds, &options)
        })?;
        let built = built.map_err(|error| of_tree(py, error))?;
        let cost = PyDict::new(py);
        cost.set_item("evaluations", built.evaluations)?;
        cost.set_item("converged", built.ending == StopReason::Complete)?;
        cost.set_item("leaves_per_level", built.tree.leaves_per_level())?;
        cost.set_item("largest_dropped", built.largest_dropped)?;
        cost.set_item("largest_rate", built.largest_rate)?;
        let file = TreeFile::new(built, settings.tolerance)
            .with_units(scene.length_unit.as_deref(), scene.image_unit())
            .with_scene(&scene.text);
        Ok((PyBytes::new(py, &file.encode().map_err(of_encoding)?), cost))
    }

    /// The lines of sight at places (n,), (n,) of the image plane, x and y from 0 to 1: points (n, 3)
    /// on them, unit vectors (n, 3) away from the observer, near and far ends (n,), (n,) as distances
    /// from these points, and dΩ/(dx dy) (n,).
    fn lines<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'py, f64>,
        y: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Lines<'py>> {
        lines(py, self.0.camera.projection(), x.as_slice()?, y.as_slice()?)
    }

    /// Of a grid, the emission of the scene: its coordinates, and the first and the last node of each axis.
    fn grid_ranges(&self) -> PyResult<(String, [[f64; 2]; 3])> {
        let EmissionSource::Grid(emission) = &self.0.emission.source else {
            return Err(SceneError::new_err("the emission of the scene is no grid"));
        };
        let end = |node: Option<&f64>| node.copied().unwrap_or(f64::NAN);
        let ranges = emission.grid.nodes().map(|nodes| [end(nodes.first()), end(nodes.last())]);
        let first = emission.grid.axes().coordinates().names()[0];
        let coordinates = match first {
            "r" => "spherical",
            "rho" => "cylindrical",
            _ => "cartesian",
        };
        Ok((coordinates.to_owned(), ranges))
    }

    /// The values (n,) of a grid, the emission of the scene, at positions (n, 3); NaN outside, unless that is an
    /// error.
    fn grid_values<'py>(
        &self,
        py: Python<'py>,
        position: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let EmissionSource::Grid(emission) = &self.0.emission.source else {
            return Err(SceneError::new_err("the emission of the scene is no grid"));
        };
        let positions = vectors_of(&position, "position")?;
        let grid = &emission.grid;
        let values = py.detach(|| {
            let mut values = vec![f64::NAN; positions.len()];
            grid.values_at(&positions, f64::NAN, &mut values);
            values
        });
        if grid.outside() == Outside::Error && values.iter().any(|value| value.is_nan()) {
            // The grid itself says which position is outside.
            let mut rates = vec![0.0; positions.len()];
            let directions = vec![[0.0, 0.0, 1.0]; positions.len()];
            let samples = Samples::new(&positions, &directions);
            let evaluated = grid.emission_rates(&samples, &mut rates);
            evaluated.map_err(|error| EmissionError::new_err(error.to_string()))?;
        }
        Ok(PyArray1::from_vec(py, values))
    }

    fn __repr__(&self) -> String {
        let (height, width) = self.shape();
        format!("<emitree scene {}: {height} x {width} pixels>", self.0.name)
    }
}

/// Changes as the scene reader takes them.
fn overrides(changes: Changes) -> Vec<Override> {
    let option = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
    let change = |(key, value): (String, String)| Override { option: option(&key), key, value };
    changes.into_iter().map(change).collect()
}

/// The emission of the scene, or the function in its place.
fn emission<'a>(
    scene: &'a emitree_io::Scene,
    hooks: &Hooks,
    caller: &'a Caller,
) -> AnyEmission<'a> {
    AnyEmission {
        scene: &scene.emission,
        caller,
        is_function: hooks.function.is_some(),
        absorbs_by_function: hooks.absorption.is_some(),
    }
}

fn rendered(
    scene: &Arc<emitree_io::Scene>,
    hooks: &Hooks,
    caller: &Caller,
    options: &RenderOptions<'static>,
) -> Result<Rendered, emitree::RenderError<crate::emission::EmissionStop>> {
    let progress = |evaluations| caller.progress(evaluations);
    let on_frame = |frame: &Frame<'_>| {
        let [image, error] = [frame.image, frame.error].map(|map| on_the_way(scene, map));
        caller.frame(frame, image, error)
    };
    let mut options: RenderOptions<'_> = options.clone();
    options.progress = Some(&progress);
    if hooks.frame.is_some() {
        options.frame = Some(&on_frame);
    }
    let found = scene.render(&emission(scene, hooks, caller), &options)?;
    Ok(Rendered::of(scene, &found))
}

/// The most evaluations with which a rendering has its mesh: some hundred bytes for each.
const EVALUATIONS_OF_MESHES: u64 = 1_000_000;

/// The options of a scene, with the same memory whatever is free: it may decide the way to the image.
pub(crate) fn options_of(scene: &emitree_io::Scene) -> RenderOptions<'static> {
    scene.render_options().with_max_memory_bytes(MOST_MEMORY_BYTES)
}

/// An intermediate image in the unit of the final one; of a cube, the whole band.
fn on_the_way(scene: &emitree_io::Scene, map: &Image) -> Image {
    let map = match scene.axis() {
        Some(_) => scene.in_band_unit(map.clone()),
        None => map.clone(),
    };
    scene.in_quantity(&map)
}
