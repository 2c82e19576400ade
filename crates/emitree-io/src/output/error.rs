//! Errors of outputs.

use std::io;
use std::path::PathBuf;

/// An output file that can't be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The path names no file, such as `..` or an empty path.
    #[error("`{}`: expected the name of a file", path.display())]
    NoFileName {
        /// The path given.
        path: PathBuf,
    },
    /// The path is a directory or a disk: writing there would fail or do harm.
    #[error("`{}` is {found}: expected a new or an ordinary file", path.display())]
    NotAFile {
        /// The path given.
        path: PathBuf,
        /// What is there.
        found: &'static str,
    },
    /// The file is there and its owner has write-protected it.
    #[error("`{}` is write-protected: expected a file that may be replaced", path.display())]
    WriteProtected {
        /// The path given.
        path: PathBuf,
    },
    /// The folder is missing, is no folder, or forbids new files; or the name is too long for it.
    #[error(
        "`{}`: cannot create a file in the folder `{}` ({source}): expected a folder that can be \
         written",
        path.display(),
        folder.display()
    )]
    Create {
        /// The path given.
        path: PathBuf,
        /// The folder that the file was to be created in.
        folder: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// A pipe or a device can't be opened.
    #[error("`{}`: cannot open it ({source}): expected a pipe or a device that can be written", path.display())]
    Open {
        /// The path given.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The bytes could not be stored, for lack of space for example.
    #[error("`{}`: cannot write {length} bytes ({source}){}", path.display(), also(written))]
    Write {
        /// The path given.
        path: PathBuf,
        /// The length of the whole file.
        length: usize,
        /// The error of the system.
        source: io::Error,
        /// The outputs of the same run that were complete before; empty unless `path` is a pipe or a
        /// device.
        written: Vec<PathBuf>,
    },
    /// The disk has too little room for a file of known size.
    #[error(
        "`{}`: {bytes} bytes would be written, and the disk has {free} left: expected more room, a compressed \
         file (.fits.gz) or fewer pixels",
        path.display()
    )]
    NoSpace {
        /// The path given.
        path: PathBuf,
        /// The bytes that the file needs.
        bytes: u64,
        /// What the disk has left.
        free: u64,
    },
    /// The bytes are stored, but the temporary file could not be renamed.
    #[error("`{}`: cannot replace it ({source}){}", path.display(), also(written))]
    Replace {
        /// The path given.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
        /// The outputs of the same run that were replaced before.
        written: Vec<PathBuf>,
    },
    /// Two outputs are one file: the second would replace the first.
    #[error(
        "`{}` and `{}` are the same file: expected another name for each output",
        first.display(),
        second.display()
    )]
    Same {
        /// The path given first.
        first: PathBuf,
        /// The path given later.
        second: PathBuf,
    },
}

/// Which outputs of the run are there although another is not.
fn also(written: &[PathBuf]) -> String {
    let names: Vec<String> = written.iter().map(|path| format!("`{}`", path.display())).collect();
    match names.as_slice() {
        [] => String::new(),
        names => format!("; written before: {}", names.join(", ")),
    }
}
