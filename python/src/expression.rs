//! Expressions with their derivatives, for models of Python.

use crate::error::{EmissionError, SceneError};
use crate::points::{Points, RatesAndDerivatives, as_arrays};
use crate::table::Table;
use emitree_models::DifferentiableExpression;
use emitree_models::expression::Inputs;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// An expression with its derivatives by some of its constants.
#[pyclass(frozen, module = "emitree._native")]
pub(crate) struct Expression(DifferentiableExpression);

#[pymethods]
impl Expression {
    /// The expression with these constants, fields and tables, to be differentiated by the constants in `by`.
    #[new]
    #[pyo3(signature = (text, constants, by, fields=vec![], tables=vec![]))]
    fn new(
        text: &str,
        constants: BTreeMap<String, f64>,
        by: Vec<String>,
        fields: Vec<String>,
        tables: Vec<(String, Py<Table>)>,
    ) -> PyResult<Self> {
        let tables = tables.into_iter().map(|(name, table)| (name, table.get().shared())).collect();
        let inputs = Inputs::new(fields, tables);
        let parsed = DifferentiableExpression::with_inputs(text, &constants, &by, &inputs);
        parsed.map(Self).map_err(|error| {
            let help = error.help().map_or_else(String::new, |help| format!(" ({help})"));
            SceneError::new_err(format!("`expression`: {error}{help}"))
        })
    }

    /// The rates (n,) and the derivatives (n, constants) at positions and directions (n, 3), and at energies
    /// (n,) if there are some, with the values (n,) of each field.
    #[pyo3(signature = (position, direction, energy, fields=vec![]))]
    fn rates_and_derivatives<'py>(
        &self,
        py: Python<'py>,
        position: PyReadonlyArray2<'py, f64>,
        direction: PyReadonlyArray2<'py, f64>,
        energy: Option<PyReadonlyArray1<'py, f64>>,
        fields: Vec<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<RatesAndDerivatives<'py>> {
        let needs_energy = self.0.has_energy().then_some("the expression has the energy `E`");
        let points = Points::new(&position, &direction, energy.as_ref(), needs_energy)?;
        let n = points.len();
        let of_fields: Vec<Vec<f64>> =
            fields.iter().map(|values| values.as_array().to_vec()).collect();
        let expected = self.0.fields().len();
        if of_fields.len() != expected || of_fields.iter().any(|values| values.len() != n) {
            let message = format!("expected the values of {expected} fields at {n} positions");
            return Err(SceneError::new_err(message));
        }
        let constants = self.0.constants().len();
        let (mut rates, mut derivatives) = (vec![0.0; n], vec![0.0; n * constants]);
        let evaluated = py.detach(|| {
            let fields: Vec<&[f64]> = of_fields.iter().map(Vec::as_slice).collect();
            self.0.rates_and_derivatives_of(
                &points.samples(),
                &fields,
                &mut rates,
                &mut derivatives,
            )
        });
        evaluated.map_err(|failure| EmissionError::new_err(failure.to_string()))?;
        as_arrays(py, rates, &derivatives, constants)
    }
}
