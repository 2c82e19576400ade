//! The frozen quadrature of a session.

use crate::arrays::{Points, points, voxels};
use crate::error::RenderError;
use emitree::mesh::{MeshError, SparseMatrix};
use emitree::{Cube, Image};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::Arc;

/// Points, and the linear map from rates there to an image.
#[pyclass(frozen, module = "emitree._native")]
#[derive(Clone)]
pub(crate) struct Mesh {
    pub(crate) scene: Arc<emitree_io::Scene>,
    pub(crate) mesh: emitree::mesh::Mesh<Cube>,
}

/// Row borders, columns and weights of a matrix, and its shape.
type Rows<'py> = (
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<f64>>,
    (usize, usize),
);

impl Mesh {
    /// What the rates in the unit of the function are multiplied with.
    fn rate_factor(&self) -> f64 {
        self.scene.emission.rate_factor
    }

    /// What each voxel of the library is multiplied with.
    fn factors(&self) -> Vec<f64> {
        let emitree_io::Scene { height, width, energy, .. } = &*self.scene;
        let bins = energy.as_ref().map_or(1, |energy| energy.axis().bins());
        let one = Image::from_pixels(*height, *width, vec![1.0; height * width]);
        let scaled = self.scene.cube_in_quantity(&Cube::from_bands(vec![one; bins]));
        scaled.voxels().map(|factor| factor * self.rate_factor()).collect()
    }
}

#[pymethods]
impl Mesh {
    /// The number of points.
    fn __len__(&self) -> usize {
        self.mesh.points().len()
    }

    /// Positions, directions, and energies if there is an axis.
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Points<'py>> {
        self.scene.emission.seen(&self.mesh.points(), |samples| points(py, samples))
    }

    /// The weights of the points in the values at nodes.
    fn weights<'py>(&self, py: Python<'py>) -> Rows<'py> {
        rows(py, self.mesh.weights(), self.mesh.weights().data().to_vec())
    }

    /// The weights of the rates, in the unit of the function, in the voxels.
    fn matrix<'py>(&self, py: Python<'py>) -> Rows<'py> {
        let (matrix, data) = py.detach(|| {
            let matrix = self.mesh.matrix();
            // The values of a scene are those of the library times a factor for each pixel.
            let factors = self.factors();
            let entries = matrix.indptr().windows(2).zip(factors);
            let data = entries.flat_map(|(ends, factor)| {
                matrix.data()[ends[0]..ends[1]].iter().map(move |weight| factor * weight)
            });
            let data: Vec<f64> = data.collect();
            (matrix, data)
        });
        rows(py, &matrix, data)
    }

    /// The values (bins, height, width) for rates in the unit of the function.
    fn apply<'py>(
        &self,
        py: Python<'py>,
        rates: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rates = rates.as_array().to_vec();
        let values = py.detach(|| {
            let factor = self.rate_factor();
            let rates: Vec<f64> = rates.iter().map(|rate| rate * factor).collect();
            Ok(self.scene.cube_in_quantity(&self.mesh.apply(&rates)?))
        });
        voxels(py, &values.map_err(raised)?)
    }

    /// Whether the values are a cube.
    #[getter]
    fn is_cube(&self) -> bool {
        self.scene.energy.is_some()
    }
}

fn rows<'py>(py: Python<'py>, matrix: &SparseMatrix, data: Vec<f64>) -> Rows<'py> {
    let borders = matrix.indptr().iter().map(|end| i64::try_from(*end).unwrap_or(i64::MAX));
    let columns = matrix.indices().iter().map(|column| i64::from(*column));
    (
        PyArray1::from_iter(py, borders),
        PyArray1::from_iter(py, columns),
        PyArray1::from_vec(py, data),
        (matrix.rows(), matrix.columns()),
    )
}

/// The error as an exception.
pub(crate) fn raised(error: MeshError) -> PyErr {
    match error {
        MeshError::NotEnded | MeshError::Rates { .. } => PyValueError::new_err(error.to_string()),
        _ => RenderError::new_err(error.to_string()),
    }
}
