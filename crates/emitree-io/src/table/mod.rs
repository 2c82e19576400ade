//! Tables of functions from files: CSV and text, ECSV, FITS tables, NPZ, HDF5 and `NetCDF`.
//!
//! [`read_table`] makes a [`Table`], such as an emissivity against temperature, of a file and a
//! [`TableRequest`]. There are two layouts:
//!
//! | format | layout | axes by default | values by default |
//! | --- | --- | --- | --- |
//! | CSV and text, ECSV, FITS tables | a row for each combination of the arguments, in any order | all columns but the last | the last column |
//! | NPZ, HDF5, `NetCDF`, FITS images | the values as an array, and an array of nodes for each of its axes | the names of its dimensions | `values`; of FITS the first image |
//!
//! The fields of a text are separated by commas, or by semicolons, or by blanks; a `#` starts a comment; a first
//! row that is no row of numbers names the columns, which are named `1`, `2`, … without one. ECSV is such a text.
//!
//! The files of this module: `request.rs` and `error.rs` are its interface, `columns.rs` makes tables of columns,
//! `text.rs` and `fits.rs` read columns, and `arrays.rs` makes tables of arrays.

mod arrays;
mod columns;
mod error;
mod fits;
mod request;
mod text;

pub(crate) use columns::Columns;
pub use error::{Place, TableFileError, TableReadError};
pub use request::{TableFormat, TableRequest};

use crate::memory::available_memory_bytes;
use emitree_models::table::Table;
use std::fs;
use std::io;
use std::path::Path;

/// Reads the table in the file at `path`.
///
/// ```
/// use emitree_io::table::{TableRequest, read_table};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("cooling.csv");
/// std::fs::write(&path, "# after a fit\nT,Lambda\n1e5,4e-22\n1e6,1e-22\n1e7,2e-23\n")?;
///
/// let mut request = TableRequest::default();
/// request.logarithmic = vec!["T".to_owned(), "Lambda".to_owned()];
/// let table = read_table(&path, &request)?;
/// assert!((table.value(&[10.0_f64.powf(5.5)])? / 2e-22 - 1.0).abs() < 1e-12);
///
/// std::fs::write(&path, "T,Lambda\n1e5,4e-22\n1e6,none\n")?;
/// let error = read_table(&path, &request).unwrap_err().to_string();
/// assert!(error.ends_with("line 3: the column `Lambda` is `none`: expected a finite number"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`TableFileError`] names the file, the line or row, the column, what is there and what was expected.
pub fn read_table(path: &Path, request: &TableRequest) -> Result<Table, TableFileError> {
    let in_file = |cause| TableFileError { path: path.to_owned(), cause };
    read(path, request).map_err(in_file)
}

fn read(path: &Path, request: &TableRequest) -> Result<Table, TableReadError> {
    let format = match request.format {
        Some(format) => format,
        None => TableFormat::from_path(path)?,
    };
    let table = match format {
        TableFormat::Text => columns::table(text::columns(&whole(path)?)?, request)?,
        TableFormat::Fits => {
            // A file of images has no tables, and is read in place.
            match fits::columns(whole(path)?, request)? {
                Some(columns) => columns::table(columns, request)?,
                None => arrays::table(path, format, request)?,
            }
        }
        TableFormat::Npz | TableFormat::Hdf5 | TableFormat::NetCdf => {
            arrays::table(path, format, request)?
        }
    };
    Ok(table.with_beyond(request.beyond))
}

/// The columns of the text in the file at `path`.
pub(crate) fn read_columns(path: &Path) -> Result<Columns, TableReadError> {
    text::columns(&whole(path)?)
}

/// The bytes of a file, whose length is compared with the memory first.
fn whole(path: &Path) -> Result<Vec<u8>, TableReadError> {
    // Numbers take less in memory than as text.
    const COPIES: u64 = 2;
    let metadata = fs::metadata(path).map_err(TableReadError::Unreadable)?;
    if !metadata.is_file() {
        let error = io::Error::new(io::ErrorKind::InvalidInput, "it is not an ordinary file");
        return Err(TableReadError::Unreadable(error));
    }
    let needed = metadata.len().saturating_mul(COPIES);
    let allowed = available_memory_bytes().unwrap_or(u64::MAX);
    if needed > allowed {
        return Err(TableReadError::TooLarge { needed, allowed });
    }
    fs::read(path).map_err(TableReadError::Unreadable)
}

#[cfg(test)]
mod tests;
