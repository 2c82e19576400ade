//! Built-in models with their derivatives, for models of Python.

use crate::error::SceneError;
use crate::points::{Points, RatesAndDerivatives, as_arrays};
use emitree_models::DifferentiableModel;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// A built-in model with its derivatives by some of its parameters.
#[pyclass(frozen, module = "emitree._native")]
pub(crate) struct Model(DifferentiableModel);

#[pymethods]
impl Model {
    /// The model of this name with these parameters, and defaults for the others, to be differentiated by the
    /// parameters in `by`.
    #[new]
    fn new(name: &str, parameters: BTreeMap<String, f64>, by: Vec<String>) -> PyResult<Self> {
        let model = DifferentiableModel::new(name, &parameters, &by);
        model.map(Self).map_err(|error| SceneError::new_err(format!("`model`: {error}")))
    }

    /// The values of all parameters, given or not.
    #[getter]
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        self.0.model().parameters().collect()
    }

    /// Those of the parameters in `by` with which a surface moves at which the rate may jump.
    #[getter]
    fn moves_jumps(&self) -> Vec<&'static str> {
        self.0.moves_jumps().to_vec()
    }

    /// The unit of its positions, and of lengths along lines of sight; "1" if it has none.
    #[getter]
    fn length_unit(&self) -> &'static str {
        self.0.model().description().length_unit
    }

    /// The rates (n,) and the derivatives (n, parameters) at positions and directions (n, 3), and at energies
    /// (n,) if there are some.
    fn rates_and_derivatives<'py>(
        &self,
        py: Python<'py>,
        position: PyReadonlyArray2<'py, f64>,
        direction: PyReadonlyArray2<'py, f64>,
        energy: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<RatesAndDerivatives<'py>> {
        let model = self.0.model();
        let why = format!("the model `{}` depends on the energy", model.description().name);
        let needs_energy = model.needs_energy().then_some(why.as_str());
        let points = Points::new(&position, &direction, energy.as_ref(), needs_energy)?;
        let (n, parameters) = (points.len(), self.0.parameters().len());
        let (mut rates, mut derivatives) = (vec![0.0; n], vec![0.0; n * parameters]);
        py.detach(|| {
            self.0.rates_and_derivatives(&points.samples(), &mut rates, &mut derivatives);
        });
        as_arrays(py, rates, &derivatives, parameters)
    }
}
