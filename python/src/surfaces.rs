//! Found surfaces as arrays, and as the bytes of files.

use crate::arrays::{triangles, vectors};
use crate::error::of_encoding;
use emitree::result::FoundSurfaces;
use emitree_io::{Account, SurfaceFormat};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::Path;

/// Positions, normals, jumps, uncertainties, triangles.
pub(crate) type SurfaceArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<i64>>,
);

/// The same, read.
pub(crate) type ReadSurfaceArrays<'py> = (
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray2<'py, i64>,
);

/// Surfaces as arrays.
pub(crate) fn arrays_of<'py>(
    py: Python<'py>,
    found: &FoundSurfaces,
) -> PyResult<SurfaceArrays<'py>> {
    Ok((
        vectors(py, &found.positions)?,
        vectors(py, &found.normals)?,
        PyArray1::from_slice(py, &found.jumps),
        PyArray1::from_slice(py, &found.uncertainties),
        triangles(py, &found.triangles)?,
    ))
}

/// Surfaces from arrays.
pub(crate) fn surfaces_of(
    (positions, normals, jumps, uncertainties, triangles): &ReadSurfaceArrays<'_>,
) -> PyResult<FoundSurfaces> {
    let mut found = FoundSurfaces::default();
    found.positions = rows(positions);
    found.normals = rows(normals);
    found.jumps = jumps.as_array().to_vec();
    found.uncertainties = uncertainties.as_array().to_vec();
    let number = |vertex: i64| {
        let number = u32::try_from(vertex).ok().filter(|&number| (number as usize) < found.len());
        number.ok_or_else(|| {
            let expected = format!("0 or more, and less than {}", found.len());
            PyValueError::new_err(format!("the vertex {vertex} of a triangle: expected {expected}"))
        })
    };
    let of_triangle = |[a, b, c]: [i64; 3]| Ok([number(a)?, number(b)?, number(c)?]);
    found.triangles = rows(triangles).into_iter().map(of_triangle).collect::<PyResult<_>>()?;
    Ok(found)
}

/// The rows of an array (n, 3).
fn rows<T: numpy::Element + Copy>(array: &PyReadonlyArray2<'_, T>) -> Vec<[T; 3]> {
    let values: Vec<T> = array.as_array().iter().copied().collect();
    values.as_chunks().0.to_vec()
}

/// The bytes of a file of surfaces, in the format that the ending of its name chooses.
pub(crate) fn encoded<'py>(
    py: Python<'py>,
    found: &FoundSurfaces,
    account: &Account,
    path: &Path,
) -> PyResult<Bound<'py, PyBytes>> {
    let format = SurfaceFormat::from_path(path);
    let format = format.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let bytes = py.detach(|| format.encode(found, account)).map_err(of_encoding)?;
    Ok(PyBytes::new(py, &bytes))
}
