//! Why a file has no response.

use crate::cell::WrongCell;
use crate::effective_area::AreaError;
use crate::redistribution::RedistributionError;
use fits_well::FitsError;
use std::path::PathBuf;

/// A file that no response could be read from.
#[derive(Debug, thiserror::Error)]
#[error("the response {}: {cause}", path.display())]
#[non_exhaustive]
pub struct ResponseFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub cause: Box<ResponseFileDefect>,
}

/// What is wrong with the file of a response.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResponseFileDefect {
    /// The file can't be read.
    #[error("it can't be read: {0}")]
    Unreadable(#[source] std::io::Error),
    /// The bytes are no FITS, or damaged.
    #[error("it can't be read as FITS: {0}")]
    Fits(#[source] Box<FitsError>),
    /// The extension is missing.
    #[error("it has no extension with {what}: expected {expected}; {}", present(available))]
    NoExtension {
        /// What it should have.
        what: &'static str,
        /// How it is known.
        expected: &'static str,
        /// The names of the extensions that there are.
        available: Vec<String>,
    },
    /// There are several, and each would be part of the response.
    #[error("it has {found} extensions with {what}: expected one")]
    SeveralExtensions {
        /// What they have.
        what: &'static str,
        /// How many there are.
        found: usize,
    },
    /// A column is missing.
    #[error("extension `{extension}` has no column `{column}`; {}", present(available))]
    NoColumn {
        /// The extension.
        extension: String,
        /// The column.
        column: &'static str,
        /// The columns that there are.
        available: Vec<String>,
    },
    /// A column can't be read as numbers.
    #[error("extension `{extension}`: column `{column}`: {source}: expected {expected}")]
    Column {
        /// The extension.
        extension: String,
        /// The column.
        column: &'static str,
        /// Why it can't be read.
        source: Box<FitsError>,
        /// What was expected.
        expected: &'static str,
    },
    /// A column has several numbers in each row.
    #[error("extension `{extension}`: column `{column}` has {found} numbers a row: expected 1")]
    NotScalar {
        /// The extension.
        extension: String,
        /// The column.
        column: &'static str,
        /// Numbers in each row.
        found: usize,
    },
    /// A header record or the unit of a column is something else.
    #[error("extension `{extension}`: {name} is `{value}`: expected {expected}")]
    Record {
        /// The extension.
        extension: String,
        /// The record, or the unit of a column.
        name: String,
        /// Its value.
        value: String,
        /// What was expected.
        expected: String,
    },
    /// A number in the table can't be.
    #[error("extension `{extension}`: {source}")]
    Cell {
        /// The extension.
        extension: String,
        /// The number.
        source: WrongCell,
    },
    /// The table makes no effective area.
    #[error("extension `{extension}`: {source}")]
    Area {
        /// The extension.
        extension: String,
        /// What is wrong.
        source: AreaError,
    },
    /// The tables make no redistribution matrix.
    #[error("extensions `{matrix}` and `{channels}`: {source}")]
    Redistribution {
        /// The extension with the rows.
        matrix: String,
        /// The extension with the channels.
        channels: String,
        /// What is wrong.
        source: RedistributionError,
    },
}

impl ResponseFileDefect {
    pub(super) fn fits(source: FitsError) -> Self {
        Self::Fits(Box::new(source))
    }
}

/// "there are `a` and `b`", at most so many that a line or two hold them.
fn present(names: &[String]) -> String {
    const SHOWN: usize = 12;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect();
    match names.len() {
        0 => "there is none".to_owned(),
        1 => format!("there is {}", shown[0]),
        count if count > SHOWN => {
            format!("there are {} and {} more", shown.join(", "), count - SHOWN)
        }
        count => {
            format!("there are {} and {}", shown[..count - 1].join(", "), shown[count - 1])
        }
    }
}
