//! What to read from a file of a table.

use super::error::TableReadError;
use crate::grid::GridFormat;
use emitree_models::table::BeyondTable;
use std::path::Path;

/// A format that tables are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TableFormat {
    /// Rows of text: CSV, ECSV and others.
    Text,
    /// FITS: a binary table, or images.
    Fits,
    /// Arrays of `numpy` by name.
    Npz,
    /// HDF5.
    Hdf5,
    /// `NetCDF`, classic or version 4.
    NetCdf,
}

impl TableFormat {
    /// The endings that choose a format, lower case and without the dot.
    pub const ENDINGS: [(&'static str, Self); 10] = [
        ("csv", Self::Text),
        ("ecsv", Self::Text),
        ("txt", Self::Text),
        ("dat", Self::Text),
        ("fits", Self::Fits),
        ("fit", Self::Fits),
        ("npz", Self::Npz),
        ("h5", Self::Hdf5),
        ("hdf5", Self::Hdf5),
        ("nc", Self::NetCdf),
    ];

    /// The formats by the names that scenes have for them.
    pub const NAMES: [(&'static str, Self); 6] = [
        ("csv", Self::Text),
        ("ecsv", Self::Text),
        ("fits", Self::Fits),
        ("npz", Self::Npz),
        ("hdf5", Self::Hdf5),
        ("netcdf", Self::NetCdf),
    ];

    /// The format that the ending of `path` stands for, upper or lower case.
    ///
    /// # Errors
    ///
    /// [`TableReadError::Ending`] with the endings that there are.
    pub fn from_path(path: &Path) -> Result<Self, TableReadError> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let format = Self::ENDINGS.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(ending));
        format.map(|(_, format)| format).ok_or(TableReadError::Ending)
    }

    /// The same format of arrays; `None` of text.
    pub(super) fn of_arrays(self) -> Option<GridFormat> {
        Some(match self {
            Self::Text => return None,
            Self::Fits => GridFormat::Fits,
            Self::Npz => GridFormat::Npz,
            Self::Hdf5 => GridFormat::Hdf5,
            Self::NetCdf => GridFormat::NetCdf,
        })
    }
}

/// What to read from a file. The default has everything as the format has it, linear in arguments and values.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TableRequest {
    /// The format; by the ending of the file's name if it is not given.
    pub format: Option<TableFormat>,
    /// The name of the extension of a FITS file that has the table; the first table if it is not given.
    pub extension: Option<String>,
    /// The columns, or arrays, of the arguments in their order; those of the format if there are none.
    pub axes: Vec<String>,
    /// The column, or array, of the values.
    pub values: Option<String>,
    /// The names of the axes, and of the values, that are interpolated in their logarithm.
    pub logarithmic: Vec<String>,
    /// What the table is beyond its axes.
    pub beyond: BeyondTable,
    /// What values are multiplied by.
    pub scale: f64,
}

impl Default for TableRequest {
    fn default() -> Self {
        Self {
            format: None,
            extension: None,
            axes: Vec::new(),
            values: None,
            logarithmic: Vec::new(),
            beyond: BeyondTable::default(),
            scale: 1.0,
        }
    }
}

impl TableRequest {
    /// Whether an axis or the values of this name are interpolated in their logarithm.
    pub(super) fn is_logarithmic(&self, name: &str) -> bool {
        self.logarithmic.iter().any(|other| other == name)
    }

    /// Refuses names of what is not in the table.
    pub(super) fn check_logarithmic(
        &self,
        axes: &[String],
        values: &str,
    ) -> Result<(), TableReadError> {
        let known = || axes.iter().map(String::as_str).chain([values]);
        match self.logarithmic.iter().find(|name| !known().any(|other| other == name.as_str())) {
            None => Ok(()),
            Some(name) => {
                let (name, available) = (name.clone(), known().map(str::to_owned).collect());
                Err(TableReadError::NotLogarithmic { name, available })
            }
        }
    }
}
