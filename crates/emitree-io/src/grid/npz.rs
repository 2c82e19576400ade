//! Several arrays of `numpy` by name: the .npz file, a zip archive of .npy files.

use super::array::{Array, Container, Described, Nodes};
use super::budget::Budget;
use super::error::GridReadError;
use super::npy;
use super::request::GridFormat;
use std::io::{Read, Seek};
use zip::ZipArchive;
use zip::read::ZipFile;
use zip::result::ZipError;

const ENDING: &str = ".npy";
/// The array of the values, unless it is named.
const VALUES: &str = "values";

/// A file of arrays by name.
pub(super) struct NpzCube<R> {
    archive: ZipArchive<R>,
    budget: Budget,
}

impl<R: Read + Seek> NpzCube<R> {
    pub(super) fn open(source: R, budget: Budget) -> Result<Self, GridReadError> {
        let archive = ZipArchive::new(source).map_err(malformed)?;
        Ok(Self { archive, budget })
    }

    /// What is made of the file of an array, of so many bytes.
    fn with_file<T>(
        &mut self,
        name: &str,
        make: impl FnOnce(&mut ZipFile<'_, R>, u64, Budget) -> Result<T, GridReadError>,
    ) -> Result<T, GridReadError> {
        let available = self.names();
        let mut file = match self.archive.by_name(&format!("{name}{ENDING}")) {
            Ok(file) => file,
            Err(ZipError::FileNotFound) => {
                return Err(GridReadError::Missing { name: name.to_owned(), available });
            }
            Err(error) => return Err(malformed(error)),
        };
        let length = file.size();
        make(&mut file, length, self.budget).map_err(|error| match error {
            GridReadError::Malformed { reason, .. } => {
                malformed(format!("the array `{name}`: {reason}"))
            }
            error => error,
        })
    }

    /// The names of all arrays, in the order of the file.
    fn names(&self) -> Vec<String> {
        let files = self.archive.file_names().filter_map(Result::ok);
        files.map(|file| file.trim_end_matches(ENDING).to_owned()).collect()
    }
}

impl<R: Read + Seek> Container for NpzCube<R> {
    fn describe(&mut self, name: Option<&str>) -> Result<Described, GridReadError> {
        self.with_file(name.unwrap_or(VALUES), |file, length, _| {
            Ok(npy::Header::read(file, length)?.described())
        })
    }

    fn values(
        &mut self,
        name: Option<&str>,
        selection: &[Option<usize>],
    ) -> Result<Array, GridReadError> {
        self.with_file(name.unwrap_or(VALUES), |file, length, budget| {
            npy::decode(file, length, selection, budget)
        })
    }

    fn array(&mut self, name: &str) -> Result<Array, GridReadError> {
        self.with_file(name, |file, length, budget| npy::decode(file, length, &[], budget))
    }

    fn nodes(
        &mut self,
        _: usize,
        names: &[&str],
        _: usize,
        _: &Array,
    ) -> Result<Nodes, GridReadError> {
        let available = self.names();
        let is_there = |name: &&&str| available.iter().any(|other| other == *name);
        let name = names.iter().find(is_there).or(names.first()).copied().unwrap_or_default();
        Nodes::of(name, self.array(name)?)
    }
}

fn malformed(reason: impl ToString) -> GridReadError {
    GridReadError::malformed(GridFormat::Npz, reason)
}
