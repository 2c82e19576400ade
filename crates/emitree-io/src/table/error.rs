//! Why a file has no table.

use crate::grid::{GridReadError, one_of};
use emitree_models::table::TableError;
use std::path::PathBuf;

/// A file that no table could be read from.
#[derive(Debug, thiserror::Error)]
#[error("the table {}: {cause}", path.display())]
#[non_exhaustive]
pub struct TableFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub cause: TableReadError,
}

/// What is wrong with the content of a file, or with the request.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableReadError {
    /// The file can't be opened or read.
    #[error("it can't be read: {0}")]
    Unreadable(#[source] std::io::Error),
    /// The ending of the name stands for no format.
    #[error(
        "no table format for this ending: expected .csv, .ecsv, .txt, .dat, .fits, .fit, .npz, .h5, \
         .hdf5 or .nc"
    )]
    Ending,
    /// It takes more memory than there is; nothing was allocated.
    #[error(
        "to read it takes {needed} bytes of memory: expected at most {allowed}, which are available"
    )]
    TooLarge {
        /// The memory that it needs \[bytes\].
        needed: u64,
        /// The memory that is available \[bytes\].
        allowed: u64,
    },
    /// A text without a row of numbers.
    #[error("it has no rows: expected {0}")]
    NoRows(&'static str),
    /// A row with more or less fields than the first.
    #[error("{place} has {found} fields: expected {expected}, as in {first}")]
    Fields {
        /// The line or the row.
        place: Place,
        /// The number of its fields.
        found: usize,
        /// The number of fields of the first row.
        expected: usize,
        /// The first row.
        first: Place,
    },
    /// A field that has not the number that is needed.
    #[error("{place}: the column `{column}` is `{value}`: expected {expected}")]
    Cell {
        /// The line or the row.
        place: Place,
        /// The column.
        column: String,
        /// What is there.
        value: String,
        /// What was expected.
        expected: &'static str,
    },
    /// Nothing of this name is in the file.
    #[error("it has no column `{name}`: expected {}", one_of(available))]
    NoColumn {
        /// The requested name.
        name: String,
        /// The names that there are.
        available: Vec<String>,
        /// The key that has the name.
        key: &'static str,
    },
    /// No array of this name is in the file.
    #[error("it has no array `{name}`: expected {}", one_of(available))]
    NoArray {
        /// The requested name.
        name: String,
        /// The names that there are.
        available: Vec<String>,
        /// The key that has the name.
        key: &'static str,
    },
    /// Two columns of this name.
    #[error("it has two columns `{0}`: expected different names")]
    TwoColumns(String),
    /// A file whose columns can't all be axes and values.
    #[error(
        "it has {} column(s), {}: expected 2 to 4, the arguments and then the value, or `axes` and \
         `values`, which choose columns", names.len(), quoted(names)
    )]
    Columns {
        /// Their names.
        names: Vec<String>,
    },
    /// A combination of arguments without a row.
    #[error(
        "no row has {combination}: expected a row for each combination of {counts} (`axes` and \
         `values` choose columns)"
    )]
    MissingCombination {
        /// The arguments.
        combination: String,
        /// How many numbers each column of them has.
        counts: String,
    },
    /// Two rows for the same arguments.
    #[error("{place} has {combination}, as {first} has: expected each combination once")]
    Repeated {
        /// The later row.
        place: Place,
        /// The arguments.
        combination: String,
        /// The earlier row.
        first: Place,
    },
    /// A name to be interpolated in logarithms that is neither of an axis nor of the values.
    #[error("`{name}` is neither an axis nor the values: expected {}", one_of(available))]
    NotLogarithmic {
        /// The name.
        name: String,
        /// The axes and the values.
        available: Vec<String>,
    },
    /// A FITS file can't be read.
    #[error("it can't be read as FITS: {0}")]
    Fits(String),
    /// A FITS file without the table that was requested.
    #[error("it has no table `{name}`: expected {}", one_of(available))]
    NoExtension {
        /// The requested name.
        name: String,
        /// The names of tables that there are.
        available: Vec<String>,
    },
    /// A column with several numbers in each row.
    #[error("the column `{column}` has {found} numbers a row: expected 1")]
    NotScalar {
        /// The column.
        column: String,
        /// The numbers.
        found: usize,
    },
    /// An array of values whose axes have no names in the file.
    #[error(
        "the file does not name the axes of `{values}`, an array of shape {shape:?}: expected \
         `axes`, the names of an array of nodes for each"
    )]
    NoAxes {
        /// The name of the values.
        values: String,
        /// Their shape.
        shape: Vec<usize>,
    },
    /// An array of values that does not have one axis for each of `axes`, or not as many values along it as nodes.
    #[error(
        "the array `{values}` has the shape {shape:?}: expected {expected:?}, the nodes of {}",
        quoted(axes)
    )]
    Shape {
        /// The name of the values.
        values: String,
        /// Their shape.
        shape: Vec<usize>,
        /// The number of nodes of each axis.
        expected: Vec<usize>,
        /// The names of the axes.
        axes: Vec<String>,
    },
    /// The arrays can't be read.
    #[error(transparent)]
    Arrays(GridReadError),
    /// The nodes and values make no table.
    #[error(transparent)]
    Table(TableError),
}

impl TableReadError {
    /// What of a [`TableRequest`](super::TableRequest) it is about, as scenes name it.
    pub fn concerns(&self) -> &'static str {
        match self {
            Self::NoColumn { key, .. } | Self::NoArray { key, .. } => key,
            Self::NotLogarithmic { .. } => "logarithmic",
            Self::NoExtension { .. } => "extension",
            _ => "file",
        }
    }
}

/// Where a row stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// A line of a text, from 1.
    Line(usize),
    /// A row of a FITS table, from 1.
    Row(usize),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Row(row) => write!(f, "row {row}"),
        }
    }
}

/// "`a`, `b`", at most so many that a line holds them.
fn quoted(names: &[String]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect();
    let more = if names.len() > SHOWN { " and others" } else { "" };
    format!("{}{more}", shown.join(", "))
}
