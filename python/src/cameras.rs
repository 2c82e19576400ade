//! The kinds of cameras that scenes have, for the classes in Python.

use emitree_io::{KeyDefault, KeyUnit, SkyCoordinates};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A kind of camera.
#[derive(Debug, IntoPyObject)]
pub(crate) struct CameraRow {
    /// What scenes call it.
    name: &'static str,
    /// The name of its class.
    python_class: &'static str,
    /// Whether an image is a whole sky.
    is_sky: bool,
    keys: Vec<KeyRow>,
}

/// One of its keys.
#[derive(Debug, IntoPyObject)]
struct KeyRow {
    name: &'static str,
    /// `length`, `deg`, or none.
    unit: Option<&'static str>,
    /// Whether it must be given, in a scene with bounds too.
    required: bool,
}

/// The kinds of cameras: for each the name in scenes, the name of its class, whether it is a sky, and
/// its keys with their units.
#[pyfunction]
pub(crate) fn cameras() -> Vec<CameraRow> {
    let key = |key: &emitree_io::CameraKey| KeyRow {
        name: key.name,
        unit: match key.unit {
            KeyUnit::Length => Some("length"),
            KeyUnit::Degrees => Some("deg"),
            KeyUnit::None => None,
        },
        required: match key.default {
            KeyDefault::Required => true,
            KeyDefault::InBounds(_) | KeyDefault::Value(_) => false,
        },
    };
    let camera = |camera: &emitree_io::CameraDescription| CameraRow {
        name: camera.name,
        python_class: camera.python_class,
        is_sky: camera.is_sky(),
        keys: camera.keys.iter().map(key).collect(),
    };
    emitree_io::cameras().iter().map(camera).collect()
}

/// The coordinates of the sky that scenes have, by name, and whether they depend on an equinox.
#[pyfunction]
pub(crate) fn sky_coordinates(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let found = PyDict::new(py);
    for of in SkyCoordinates::ALL.map(SkyCoordinates::description) {
        found.set_item(of.name, of.has_equinox)?;
    }
    Ok(found)
}
