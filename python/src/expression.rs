//! Expressions with their derivatives, for models of Python.

use crate::error::{EmissionError, SceneError};
use crate::table::Table;
use emitree::Samples;
use emitree_models::DifferentiableExpression;
use emitree_models::expression::Inputs;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// An expression with its derivatives by some of its constants.
#[pyclass(frozen, module = "emitree._native")]
pub(crate) struct Expression(DifferentiableExpression);

/// Rates (n,) and derivatives (n, constants).
type RatesAndDerivatives<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

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
        let [positions, directions] =
            [vectors(&position, "position")?, vectors(&direction, "direction")?];
        let energies: Vec<f64> = energy.as_ref().map_or_else(Vec::new, |of| of.as_array().to_vec());
        if energy.is_none() && self.0.has_energy() {
            let message =
                "the expression has the energy `E`, and there are no energies: expected `energy`";
            return Err(SceneError::new_err(message));
        }
        let n = positions.len();
        if directions.len() != n || (energy.is_some() && energies.len() != n) {
            let numbers = format!("{n} positions, {} directions", directions.len());
            return Err(SceneError::new_err(format!(
                "there are {numbers} and {} energies: expected as many of each",
                energies.len()
            )));
        }
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
            let samples = Samples::new(&positions, &directions).at_energies(&energies);
            let fields: Vec<&[f64]> = of_fields.iter().map(Vec::as_slice).collect();
            self.0.rates_and_derivatives_of(&samples, &fields, &mut rates, &mut derivatives)
        });
        evaluated.map_err(|failure| EmissionError::new_err(failure.to_string()))?;
        let by_point = (0..n).flat_map(|i| (0..constants).map(move |k| k * n + i));
        let derivatives = PyArray1::from_iter(py, by_point.map(|place| derivatives[place]));
        Ok((PyArray1::from_vec(py, rates), derivatives.reshape([n, constants])?))
    }
}

/// Vectors of an array (n, 3).
pub(crate) fn vectors(array: &PyReadonlyArray2<'_, f64>, name: &str) -> PyResult<Vec<[f64; 3]>> {
    let array = array.as_array();
    if array.ncols() != 3 {
        let [rows, columns] = [array.nrows(), array.ncols()];
        return Err(SceneError::new_err(format!(
            "`{name}` has the shape ({rows}, {columns}): expected (n, 3)"
        )));
    }
    Ok(array.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect())
}
