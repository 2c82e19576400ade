//! From arrays, the values and the nodes of each of their axes, to a table.

use super::columns::finished;
use super::error::TableReadError;
use super::request::{TableFormat, TableRequest};
use crate::grid::{GridReadError, GridRequest, read_arrays};
use emitree_models::table::{Table, TableAxis};
use std::path::Path;

/// The table in a file of arrays.
pub(super) fn table(
    path: &Path,
    format: TableFormat,
    request: &TableRequest,
) -> Result<Table, TableReadError> {
    let mut of_arrays = GridRequest::default();
    of_arrays.format = format.of_arrays();
    let made = read_arrays(path, &of_arrays, |arrays| {
        let name = request.values.clone().unwrap_or_else(|| "values".to_owned());
        let values = arrays.values(request.values.as_deref(), &[])?;
        let shape = values.shape.clone();
        let names = match request.axes.as_slice() {
            [] => values.axis_names.clone(),
            names => names.to_vec(),
        };
        let is_named = !names.is_empty() && names.iter().all(|name| !name.is_empty());
        if !is_named {
            return Ok(Err(TableReadError::NoAxes { values: name, shape }));
        }
        let mut nodes = Vec::with_capacity(names.len());
        for (place, name) in names.iter().enumerate() {
            nodes.push(if request.axes.is_empty() {
                // Of HDF5 they are in the group of the values, or above.
                arrays.nodes(place, &[name], place, &values)?.values
            } else {
                arrays.array(name)?.into_line()?
            });
        }
        let expected: Vec<usize> = nodes.iter().map(Vec::len).collect();
        if shape != expected {
            return Ok(Err(TableReadError::Shape { values: name, shape, expected, axes: names }));
        }
        let values = values.into_last_fastest();
        Ok(made(names, nodes, values, request, &name))
    });
    made.map_err(|error| match error {
        GridReadError::Unreadable(error) => TableReadError::Unreadable(error),
        GridReadError::Missing { name, available } => {
            let key = if request.axes.contains(&name) { "axes" } else { "values" };
            TableReadError::NoArray { name, available, key }
        }
        error => TableReadError::Arrays(error),
    })?
}

fn made(
    names: Vec<String>,
    nodes: Vec<Vec<f64>>,
    values: Vec<f64>,
    request: &TableRequest,
    name: &str,
) -> Result<Table, TableReadError> {
    request.check_logarithmic(&names, name)?;
    let axes = names.into_iter().zip(nodes).map(|(name, nodes)| {
        let is_logarithmic = request.is_logarithmic(&name);
        let axis = TableAxis::new(name, nodes);
        if is_logarithmic { axis.logarithmic() } else { axis }
    });
    finished(axes.collect(), values, request, name)
}
