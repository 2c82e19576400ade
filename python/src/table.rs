//! Tables of functions, for expressions in Python.

use crate::error::SceneError;
use emitree_io::table::{TableFormat, TableRequest, read_table};
use emitree_models::table::{BeyondTable, Table as Values, TableAxis};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A function of one to three numbers, interpolated between the nodes of a table.
#[pyclass(frozen, module = "emitree._native")]
pub(crate) struct Table(Arc<Values>);

impl Table {
    pub(crate) fn shared(&self) -> Arc<Values> {
        Arc::clone(&self.0)
    }
}

#[pymethods]
impl Table {
    /// The table of `values` at the combinations of `nodes` of axes with these names, the last varying fastest.
    #[new]
    fn new(
        names: Vec<String>,
        nodes: Vec<Vec<f64>>,
        values: Vec<f64>,
        are_logarithmic: Vec<bool>,
        has_logarithmic_values: bool,
        outside: &str,
    ) -> PyResult<Self> {
        let axes = names.into_iter().zip(nodes).zip(are_logarithmic);
        let axes = axes.map(|((name, nodes), is_logarithmic)| {
            let axis = TableAxis::new(name, nodes);
            if is_logarithmic { axis.logarithmic() } else { axis }
        });
        let table = Values::new(axes.collect(), values);
        let table = match has_logarithmic_values {
            true => table.and_then(Values::with_logarithmic_values),
            false => table,
        };
        let table = table.map_err(|error| SceneError::new_err(error.to_string()))?;
        Ok(Self(Arc::new(table.with_beyond(beyond(outside)?))))
    }

    /// The table in a file.
    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "they are the keys of a scene")]
    fn read(
        path: PathBuf,
        format: Option<&str>,
        extension: Option<String>,
        axes: Vec<String>,
        values: Option<String>,
        logarithmic: Vec<String>,
        outside: &str,
        scale: f64,
    ) -> PyResult<Self> {
        let mut request = TableRequest::default();
        if let Some(name) = format {
            let known = TableFormat::NAMES.into_iter().find(|(known, _)| *known == name);
            request.format = Some(known.map(|(_, format)| format).ok_or_else(|| {
                let names = TableFormat::NAMES.map(|(known, _)| format!("'{known}'")).join(", ");
                SceneError::new_err(format!("`format` is '{name}': expected one of {names}"))
            })?);
        }
        (request.extension, request.axes, request.values) = (extension, axes, values);
        (request.logarithmic, request.scale) = (logarithmic, scale);
        request.beyond = beyond(outside)?;
        let table = read_table(&path, &request);
        let table = table.map_err(|error| SceneError::new_err(error.to_string()))?;
        Ok(Self(Arc::new(table)))
    }

    /// The names of the axes.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.0.names().to_vec()
    }

    /// The nodes along an axis, from 0, in increasing order.
    fn nodes<'py>(&self, py: Python<'py>, axis: usize) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.0.nodes(axis))
    }

    /// The values (n,) at numbers (n,) for each axis.
    fn values<'py>(
        &self,
        py: Python<'py>,
        arguments: Vec<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let count = self.0.names().len();
        if arguments.len() != count {
            let (found, names) = (arguments.len(), self.0.names().join(", "));
            let message = format!("there are {found} arguments: expected {count}, {names}");
            return Err(SceneError::new_err(message));
        }
        let arguments: Vec<_> = arguments.iter().map(|values| values.as_array()).collect();
        let n = match arguments.first() {
            Some(values) => values.len(),
            None => 0,
        };
        let value = |i: usize| {
            let point: Vec<f64> = arguments.iter().filter_map(|of| of.get(i).copied()).collect();
            if point.len() != count {
                return Err(SceneError::new_err("the arguments have not the same length"));
            }
            self.0.value(&point).map_err(|error| SceneError::new_err(error.to_string()))
        };
        let values = (0..n).map(value).collect::<PyResult<Vec<f64>>>()?;
        Ok(PyArray1::from_vec(py, values))
    }
}

fn beyond(outside: &str) -> PyResult<BeyondTable> {
    match outside {
        "error" => Ok(BeyondTable::Error),
        "zero" => Ok(BeyondTable::Zero),
        "edge" => Ok(BeyondTable::Edge),
        other => Err(SceneError::new_err(format!(
            "`outside` is '{other}': expected one of 'error', 'zero', 'edge'"
        ))),
    }
}
