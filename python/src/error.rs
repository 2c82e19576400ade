//! Errors of the library as exceptions.

use crate::emission::EmissionStop;
use emitree::RenderError as CoreError;
use emitree::world_tree::WorldTreeError;
use emitree_io::OutputError;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyMemoryError, PyOSError, PyValueError};
use pyo3::prelude::*;
use std::io;

create_exception!(
    emitree,
    SceneError,
    PyValueError,
    "A scene, a camera or an option is wrong; the message names the key, where, and what was expected."
);
create_exception!(emitree, RenderError, PyException, "A rendering can't be made as requested.");
create_exception!(
    emitree,
    EmissionError,
    RenderError,
    "The emission failed, or is not a finite number: `position`, `direction`, `energy` and `rate` \
     tell where, as far as it is known."
);

/// A scene that can't be read: what is wrong, and what was expected; with the file and the line if
/// there is a file.
///
/// `aliases` are words for names of temporary files.
pub(crate) fn of_scene(
    error: &emitree_io::SceneError,
    is_file: bool,
    aliases: &[(String, String)],
) -> PyErr {
    let mut text = error.to_string();
    if let (true, Some((name, line))) = (is_file, error.line()) {
        text = format!("{name}, line {line}: {text}");
    }
    if !error.expected().is_empty() {
        text.push_str(": ");
        text.push_str(error.expected());
    }
    for (file, alias) in aliases {
        text = text.replace(file, alias);
    }
    SceneError::new_err(text)
}

/// A file that can't be written: the `OSError` of its cause, with the path.
pub(crate) fn of_output(error: OutputError) -> PyErr {
    let kind = match &error {
        OutputError::Create { source, .. }
        | OutputError::Open { source, .. }
        | OutputError::Write { source, .. }
        | OutputError::Replace { source, .. } => source.kind(),
        OutputError::WriteProtected { .. } => io::ErrorKind::PermissionDenied,
        OutputError::NotAFile { found: "a directory", .. } => io::ErrorKind::IsADirectory,
        _ => return PyOSError::new_err(error.to_string()),
    };
    io::Error::new(kind, error.to_string()).into()
}

/// Counts that can't be had.
pub(crate) fn of_counting(error: impl ToString) -> PyErr {
    SceneError::new_err(error.to_string())
}

/// A rendering that failed, for a reason that is not an exception already.
pub(crate) fn of_rendering(py: Python<'_>, error: CoreError<EmissionStop>) -> PyErr {
    match error {
        CoreError::NotFinite { rate, position, direction, energy }
        | CoreError::AbsorptionNotFinite { coefficient: rate, position, direction, energy } => {
            let exception = EmissionError::new_err(error.to_string());
            let value = exception.value(py);
            let set = value
                .setattr("position", position)
                .and_then(|()| value.setattr("direction", direction))
                .and_then(|()| value.setattr("energy", energy))
                .and_then(|()| value.setattr("rate", rate));
            set.err().unwrap_or(exception)
        }
        CoreError::Emission(_) => EmissionError::new_err(error.to_string()),
        CoreError::TooLarge { .. } => PyMemoryError::new_err(error.to_string()),
        CoreError::Option(_)
        | CoreError::Build(_)
        | CoreError::EmptyImage { .. }
        | CoreError::NoSolidAngle => SceneError::new_err(error.to_string()),
        _ => RenderError::new_err(error.to_string()),
    }
}

/// A tree that could not be built.
pub(crate) fn of_tree(py: Python<'_>, error: WorldTreeError<EmissionStop>) -> PyErr {
    match error {
        WorldTreeError::Render(error) => of_rendering(py, error),
        WorldTreeError::Directional { .. } => EmissionError::new_err(error.to_string()),
        _ => SceneError::new_err(error.to_string()),
    }
}

/// What can't be written in a file.
pub(crate) fn of_encoding(error: impl std::error::Error) -> PyErr {
    RenderError::new_err(error.to_string())
}
