//! Output files that are whole or absent.
//!
//! A rendering may take hours, so that an output which can't be written must be found before it
//! starts, and a run that is killed must not leave half a file under the name of a result. An
//! [`OutputFile`] therefore opens a temporary file beside its target at once and renames it when
//! the bytes are complete. [`commit_all`] does so for several files: all of them are stored before
//! the first gets its name.
//!
//! The files of this module: `target.rs` is where a path leads, `temporary.rs` the temporary files,
//! `error.rs` what can go wrong.

mod error;
mod target;
mod temporary;

pub use error::OutputError;

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use target::Target;
use tempfile::NamedTempFile;

/// A file to be: until [`commit`](Self::commit), a temporary file beside the target.
///
/// Dropping it removes the temporary file and leaves whatever the target was. A symbolic link is
/// followed: its target is replaced or made, not the link. A run that is killed leaves its temporary
/// file; the next [`create`](Self::create) for the same path removes it.
///
/// A pipe, a device such as `/dev/null`, and what is open already, such as `/dev/stdout`, are written
/// in place. To open a pipe waits for its reader.
///
/// ```
/// use emitree_io::OutputFile;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("image.npy");
/// let output = OutputFile::create(&path)?;
/// assert!(!path.exists()); // no file of that name yet
/// output.commit(b"bytes")?;
/// assert_eq!(std::fs::read(&path)?, b"bytes");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct OutputFile {
    /// As the user wrote it, for messages.
    path: PathBuf,
    place: Place,
}

/// Where the bytes go.
#[derive(Debug)]
enum Place {
    /// Into the temporary file, which gets the name of the target.
    Beside { target: PathBuf, temporary: NamedTempFile },
    /// To the reader of a pipe, or to a device.
    Stream(File),
}

impl OutputFile {
    /// Creates the temporary file for an output at `path`.
    ///
    /// # Errors
    ///
    /// [`OutputError`] if `path` names no file, is a directory or a disk, is write-protected, or
    /// its folder can't be written.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let path = path.as_ref().to_owned();
        let place = match Target::of(&path)? {
            Target::Stream(file) => Place::Stream(file),
            Target::File { folder, name } => match temporary::create(&folder, &name) {
                Ok(temporary) => Place::Beside { target: folder.join(name), temporary },
                Err(source) => return Err(OutputError::Create { path, folder, source }),
            },
        };
        Ok(Self { path, place })
    }

    /// The path as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes all `bytes`, waits until they are stored, and gives the file its name.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] or [`OutputError::Replace`]; the target is then as it was before.
    pub fn commit(self, bytes: &[u8]) -> Result<(), OutputError> {
        commit_all([(self, bytes)]).map(|_| ())
    }

    /// Whether a file of so many bytes can be written piece by piece, before it is begun.
    ///
    /// # Errors
    ///
    /// [`OutputError::NotAFile`] for a pipe or a device, [`OutputError::NoSpace`] if the disk has less left.
    pub fn check_room(&self, bytes: u64) -> Result<(), OutputError> {
        let path = || self.path.clone();
        let Place::Beside { temporary, .. } = &self.place else {
            return Err(OutputError::NotAFile { path: path(), found: "a pipe or a device" });
        };
        match free_bytes(temporary.as_file()) {
            Some(free) if free < bytes => Err(OutputError::NoSpace { path: path(), bytes, free }),
            _ => Ok(()),
        }
    }

    /// The file gets its name when `write` has written it piece by piece, without an error.
    ///
    /// # Errors
    ///
    /// Those of `write`; [`OutputError::NotAFile`] for a pipe or a device; [`OutputError::Write`] and
    /// [`OutputError::Replace`]. The target is then as it was before.
    pub fn commit_with<E: From<OutputError>>(
        self,
        write: impl FnOnce(&mut File) -> Result<(), E>,
    ) -> Result<(), E> {
        let Self { path, place } = self;
        let Place::Beside { target, mut temporary } = place else {
            return Err(OutputError::NotAFile { path, found: "a pipe or a device" }.into());
        };
        write(temporary.as_file_mut())?;
        if let Err(source) = temporary.as_file().sync_all() {
            let length = temporary.as_file().metadata().map_or(0, |of| of.len());
            let length = usize::try_from(length).unwrap_or(usize::MAX);
            return Err(OutputError::Write { path, length, source, written: Vec::new() }.into());
        }
        match temporary.persist(&target) {
            Ok(_) => Ok(()),
            Err(error) => {
                let written = Vec::new();
                Err(OutputError::Replace { path, source: error.error, written }.into())
            }
        }
    }

    /// The file that is replaced, if one is.
    fn target(&self) -> Option<&Path> {
        match &self.place {
            Place::Beside { target, .. } => Some(target),
            Place::Stream(_) => None,
        }
    }
}

/// What is left for files on the disk of a file, if the system reports it.
#[cfg(unix)]
fn free_bytes(file: &File) -> Option<u64> {
    let disk = rustix::fs::fstatvfs(file).ok()?;
    disk.f_bavail.checked_mul(disk.f_frsize)
}

#[cfg(not(unix))]
fn free_bytes(_: &File) -> Option<u64> {
    None
}

/// Writes the bytes of several outputs, waits until all of them are stored, and then gives the files
/// their names. Returns the paths as they were given.
///
/// Where one file can't be stored, none is replaced. Pipes and devices are written last: what has
/// gone there can't be taken back.
///
/// ```
/// use emitree_io::{OutputSet, commit_all};
///
/// let folder = tempfile::tempdir()?;
/// let paths = ["image.fits", "image.png"].map(|name| folder.path().join(name));
/// let outputs = OutputSet::create(&paths)?;
/// let written = commit_all(outputs.into_iter().zip(["bytes of one", "and of the other"]))?;
/// assert_eq!(written, paths);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`OutputError::Write`] if bytes can't be stored: all targets are then as they were before.
/// [`OutputError::Replace`] if a target has been made something that can't be replaced: the message
/// says which others had been replaced by then.
pub fn commit_all<B: AsRef<[u8]>>(
    outputs: impl IntoIterator<Item = (OutputFile, B)>,
) -> Result<Vec<PathBuf>, OutputError> {
    let mut paths = Vec::new();
    let mut stored = Vec::new();
    let mut streams = Vec::new();
    for (OutputFile { path, place }, bytes) in outputs {
        paths.push(path.clone());
        match place {
            Place::Stream(file) => streams.push((path, file, bytes)),
            Place::Beside { target, mut temporary } => {
                let bytes = bytes.as_ref();
                let result =
                    temporary.write_all(bytes).and_then(|()| temporary.as_file().sync_all());
                if let Err(source) = result {
                    let (length, written) = (bytes.len(), Vec::new());
                    return Err(OutputError::Write { path, length, source, written });
                }
                stored.push((path, target, temporary));
            }
        }
    }
    let mut written = Vec::new();
    for (path, target, temporary) in stored {
        if let Err(error) = temporary.persist(&target) {
            return Err(OutputError::Replace { path, source: error.error, written });
        }
        written.push(path);
    }
    for (path, mut file, bytes) in streams {
        let bytes = bytes.as_ref();
        if let Err(source) = file.write_all(bytes).and_then(|()| file.flush()) {
            return Err(OutputError::Write { path, length: bytes.len(), source, written });
        }
        written.push(path);
    }
    Ok(paths)
}

/// Several outputs of one run: all can be written, and no two are the same file.
///
/// ```
/// use emitree_io::OutputSet;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("image.fits");
/// assert_eq!(OutputSet::create([&path])?.into_iter().count(), 1);
/// assert!(OutputSet::create([&path, &path]).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct OutputSet {
    files: Vec<OutputFile>,
}

impl OutputSet {
    /// Creates the temporary files of all `paths`, in their order.
    ///
    /// # Errors
    ///
    /// [`OutputError::Same`] naming both if two paths lead to one file, else as
    /// [`OutputFile::create`]. No file is left behind.
    pub fn create<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) -> Result<Self, OutputError> {
        let mut files: Vec<OutputFile> = Vec::new();
        for path in paths {
            let file = OutputFile::create(path)?;
            let is_same = |first: &&OutputFile| {
                first.target().is_some_and(|target| Some(target) == file.target())
            };
            if let Some(first) = files.iter().find(is_same) {
                return Err(OutputError::Same { first: first.path.clone(), second: file.path });
            }
            files.push(file);
        }
        Ok(Self { files })
    }
}

impl IntoIterator for OutputSet {
    type Item = OutputFile;
    type IntoIter = std::vec::IntoIter<OutputFile>;

    fn into_iter(self) -> Self::IntoIter {
        self.files.into_iter()
    }
}

#[cfg(test)]
mod tests;
