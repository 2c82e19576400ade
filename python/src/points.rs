//! Points of arrays: positions, directions and energies as samples, and derivatives at them as arrays.

use crate::error::SceneError;
use emitree::Samples;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// Rates (n,) and derivatives (n, p).
pub(crate) type RatesAndDerivatives<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// Positions, directions and, if there are some, energies of n points.
pub(crate) struct Points {
    positions: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
    energies: Vec<f64>,
}

impl Points {
    /// The points of arrays (n, 3), (n, 3) and (n,). `needs_energy` is what depends on the energy, if
    /// something does.
    pub(crate) fn new(
        position: &PyReadonlyArray2<'_, f64>,
        direction: &PyReadonlyArray2<'_, f64>,
        energy: Option<&PyReadonlyArray1<'_, f64>>,
        needs_energy: Option<&str>,
    ) -> PyResult<Self> {
        let [positions, directions] =
            [vectors(position, "position")?, vectors(direction, "direction")?];
        let energies: Vec<f64> = energy.map_or_else(Vec::new, |of| of.as_array().to_vec());
        if let (None, Some(what)) = (energy, needs_energy) {
            return Err(SceneError::new_err(format!(
                "{what}, and there are no energies: expected `energy`"
            )));
        }
        let n = positions.len();
        if directions.len() != n || (energy.is_some() && energies.len() != n) {
            let numbers = format!("{n} positions, {} directions", directions.len());
            return Err(SceneError::new_err(format!(
                "there are {numbers} and {} energies: expected as many of each",
                energies.len()
            )));
        }
        Ok(Self { positions, directions, energies })
    }

    /// The number n of points.
    pub(crate) fn len(&self) -> usize {
        self.positions.len()
    }

    pub(crate) fn samples(&self) -> Samples<'_> {
        Samples::new(&self.positions, &self.directions).at_energies(&self.energies)
    }
}

/// Rates and derivatives, one parameter after the other, as arrays.
pub(crate) fn as_arrays<'py>(
    py: Python<'py>,
    rates: Vec<f64>,
    derivatives: &[f64],
    parameters: usize,
) -> PyResult<RatesAndDerivatives<'py>> {
    let n = rates.len();
    let by_point = (0..n).flat_map(|i| (0..parameters).map(move |k| k * n + i));
    let derivatives = PyArray1::from_iter(py, by_point.map(|place| derivatives[place]));
    Ok((PyArray1::from_vec(py, rates), derivatives.reshape([n, parameters])?))
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
