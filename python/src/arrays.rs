//! Images and cubes as arrays of `NumPy`, and back.

use emitree::{Cube, Image, Samples};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray3};
use pyo3::prelude::*;

/// An image as an array of shape (height, width).
pub(crate) fn array<'py>(py: Python<'py>, image: &Image) -> PyResult<Bound<'py, PyAny>> {
    let pixels = PyArray1::from_slice(py, image.pixels());
    pixels.call_method1("reshape", ((image.height(), image.width()),))
}

/// Vectors as an array of shape (n, 3).
pub(crate) fn vectors<'py>(
    py: Python<'py>,
    vectors: &[[f64; 3]],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    PyArray1::from_slice(py, vectors.as_flattened()).reshape([vectors.len(), 3])
}

/// Numbers of vertices as an array of shape (n, 3).
pub(crate) fn triangles<'py>(
    py: Python<'py>,
    triangles: &[[u32; 3]],
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let numbers = triangles.as_flattened().iter().map(|vertex| i64::from(*vertex));
    PyArray1::from_iter(py, numbers).reshape([triangles.len(), 3])
}

/// An array (bands, height, width).
pub(crate) fn voxels<'py>(py: Python<'py>, map: &Cube) -> PyResult<Bound<'py, PyAny>> {
    let [bands, height, width] = map.shape();
    PyArray1::from_iter(py, map.voxels()).call_method1("reshape", ((bands, height, width),))
}

/// A cube from an array (bands, height, width).
pub(crate) fn cube_of(values: &PyReadonlyArray3<'_, f64>) -> Cube {
    let values = values.as_array();
    let (height, width) = (values.shape()[1], values.shape()[2]);
    let bands = values.outer_iter().map(|band| band.iter().copied().collect());
    Cube::from_bands(bands.map(|band| Image::from_pixels(height, width, band)).collect())
}

/// Positions, directions, and energies if there is an axis.
pub(crate) type Points<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Option<Bound<'py, PyArray1<f64>>>);

/// Points as arrays.
pub(crate) fn points<'py>(py: Python<'py>, samples: &Samples<'_>) -> PyResult<Points<'py>> {
    let energies = samples.energies();
    let energies = (!energies.is_empty()).then(|| PyArray1::from_slice(py, energies));
    Ok((vectors(py, samples.positions())?, vectors(py, samples.directions())?, energies))
}

/// The memory that new allocations could get now \[bytes\], if the system reports it.
#[pyfunction]
pub(crate) fn available_memory_bytes() -> Option<u64> {
    emitree_io::available_memory_bytes()
}
