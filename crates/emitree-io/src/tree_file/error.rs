//! What can be wrong with a tree file.

use emitree::tree::FamilyDefect;
use emitree::world_tree::BoxError;
use fits_well::FitsError;
use std::path::PathBuf;

/// A tree file that can't be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TreeFileError {
    /// The file can't be opened or read.
    #[error("the tree {} can't be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The file is no FITS, or its table is cut off.
    #[error(
        "the tree {} is no whole FITS file ({source}): expected a file of `emitree build`",
        path.display()
    )]
    Fits {
        /// The file.
        path: PathBuf,
        /// The error of the reader.
        source: Box<FitsError>,
    },
    /// There is no table of a tree.
    #[error(
        "the tree {} has no table `TREE`, or it is cut off: expected a file of `emitree build`",
        path.display()
    )]
    NoTable {
        /// The file.
        path: PathBuf,
    },
    /// The bytes are not those that were written.
    #[error(
        "the tree {} has a wrong checksum: expected the bytes that `emitree build` wrote",
        path.display()
    )]
    Checksum {
        /// The file.
        path: PathBuf,
    },
    /// A keyword is missing or has another type.
    #[error("the tree {}: {source}: expected `{keyword}` to be {expected}", path.display())]
    Card {
        /// The file.
        path: PathBuf,
        /// The keyword.
        keyword: String,
        /// The error of the reader.
        source: Box<FitsError>,
        /// What was expected.
        expected: &'static str,
    },
    /// A keyword has a value out of range.
    #[error("the tree {}: `{keyword}` is {value}: expected {expected}", path.display())]
    CardValue {
        /// The file.
        path: PathBuf,
        /// The keyword.
        keyword: String,
        /// Its value.
        value: i64,
        /// What was expected.
        expected: &'static str,
    },
    /// A column is missing or holds something else.
    #[error(
        "the tree {}: the column `{column}` is missing or something else: expected {count} \
         {expected} in each row",
        path.display()
    )]
    Column {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
        /// The type of numbers that was expected.
        expected: &'static str,
        /// How many of them in a row.
        count: usize,
    },
    /// The box is none.
    #[error("the tree {}: {source}", path.display())]
    Box {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: BoxError,
    },
    /// The rows make no tree.
    #[error("the tree {}: {source}", path.display())]
    Families {
        /// The file.
        path: PathBuf,
        /// What is wrong with them; a family is a row.
        source: FamilyDefect,
    },
}
