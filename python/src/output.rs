//! Files that are whole or absent, for all that Python writes.

use crate::error::of_output;
use emitree_io::OutputFile as File;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// A file to be: until `commit` a temporary file beside the target, which keeps what it has.
///
/// Raises `OSError` if no file can be there.
#[pyclass(frozen, module = "emitree._native")]
pub(crate) struct OutputFile(Mutex<Option<File>>);

impl OutputFile {
    fn take(&self) -> Option<File> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

#[pymethods]
impl OutputFile {
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        Ok(Self(Mutex::new(Some(File::create(path).map_err(of_output)?))))
    }

    /// Writes all bytes, waits until they are stored, and gives the file its name.
    fn commit(&self, py: Python<'_>, data: &[u8]) -> PyResult<()> {
        let Some(file) = self.take() else {
            return Err(PyValueError::new_err("the output is done: expected one `commit`"));
        };
        py.detach(|| file.commit(data)).map_err(of_output)
    }

    fn __enter__(this: Py<Self>) -> Py<Self> {
        this
    }

    /// Without a `commit` before, the target stays as it was.
    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, _exception: &Bound<'_, pyo3::types::PyTuple>) {
        drop(self.take());
    }
}
