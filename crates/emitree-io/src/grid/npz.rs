//! Several arrays of `numpy` by name: the .npz file, a zip archive of .npy files.

use super::AXES;
use super::array::{Array, Container};
use super::error::GridReadError;
use super::npy;
use super::request::GridFormat;
use std::io::{Cursor, Read};
use zip::ZipArchive;
use zip::result::ZipError;

const ENDING: &str = ".npy";

/// A file of arrays by name.
#[derive(Debug)]
pub(super) struct NpzCube(ZipArchive<Cursor<Vec<u8>>>);

impl NpzCube {
    pub(super) fn open(bytes: Vec<u8>) -> Result<Self, GridReadError> {
        ZipArchive::new(Cursor::new(bytes)).map(Self).map_err(malformed)
    }

    /// The names of all arrays, in the order of the file.
    fn names(&self) -> Vec<String> {
        let files = self.0.file_names().filter_map(Result::ok);
        files.map(|file| file.trim_end_matches(ENDING).to_owned()).collect()
    }
}

impl Container for NpzCube {
    fn values(&mut self, name: Option<&str>) -> Result<Array, GridReadError> {
        self.array(name.unwrap_or("values"))
    }

    fn array(&mut self, name: &str) -> Result<Array, GridReadError> {
        let available = self.names();
        let mut file = match self.0.by_name(&format!("{name}{ENDING}")) {
            Ok(file) => file,
            Err(ZipError::FileNotFound) => {
                return Err(GridReadError::Missing { name: name.to_owned(), available });
            }
            Err(error) => return Err(malformed(error)),
        };
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)
            .map_err(|error| malformed(format!("the array `{name}`: {error}")))?;
        npy::decode(&bytes)
    }

    fn nodes(&mut self, axis: usize, _: usize, _: &Array) -> Result<Vec<f64>, GridReadError> {
        self.array(&AXES[axis].to_string())?.into_line()
    }
}

fn malformed(reason: impl ToString) -> GridReadError {
    GridReadError::malformed(GridFormat::Npz, reason)
}
