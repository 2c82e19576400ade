//! Output files that are whole or absent.
//!
//! A rendering may take hours, so that an output which can't be written must be found before it
//! starts, and a run that dies must not leave half a file that looks like a result. An
//! [`OutputFile`] therefore opens a temporary file beside its target at once and renames it when
//! the bytes are complete.

use std::ffi::OsString;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile};

/// An output file that was asked for and can't be had.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The path names no file, such as `..` or an empty path.
    #[error("`{}`: expected the name of a file", path.display())]
    NoFileName {
        /// The path given.
        path: PathBuf,
    },
    /// The path is a directory or a device: renaming a file onto it would fail or do harm.
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
    /// The folder is missing, is no folder, or forbids new files.
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
        /// What the system said.
        source: io::Error,
    },
    /// The bytes could not be stored, for want of space for example.
    #[error("`{}`: cannot write {length} bytes ({source})", path.display())]
    Write {
        /// The path given.
        path: PathBuf,
        /// The length of the whole file.
        length: usize,
        /// What the system said.
        source: io::Error,
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

/// A file to be: until [`commit`](Self::commit), a temporary file beside the target.
///
/// Dropping it removes the temporary file and leaves whatever the target was. A symbolic link is
/// followed: its target is replaced, not the link.
///
/// ```
/// use emitree_io::OutputFile;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("image.npy");
/// let output = OutputFile::create(&path)?;
/// assert!(!path.exists()); // nothing that looks like a result, yet
/// output.commit(b"bytes")?;
/// assert_eq!(std::fs::read(&path)?, b"bytes");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct OutputFile {
    /// As the user wrote it, for messages.
    path: PathBuf,
    target: PathBuf,
    temporary: NamedTempFile,
}

impl OutputFile {
    /// Creates the temporary file for an output at `path`.
    ///
    /// # Errors
    ///
    /// [`OutputError`] if `path` names no file, is something else than an ordinary file, is
    /// write-protected, or its folder can't be written.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let path = path.as_ref().to_owned();
        let target = Target::of(&path)?;
        let create = |source| OutputError::Create {
            path: path.clone(),
            folder: target.folder.clone(),
            source,
        };
        let folder = fs::canonicalize(&target.folder).map_err(create)?;
        let mut prefix = OsString::from(".");
        prefix.push(&target.name);
        prefix.push(".");
        let mut builder = Builder::new();
        builder.prefix(&prefix).suffix(".part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Temporary files are private by default; results get what the umask leaves.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let temporary = builder.tempfile_in(&folder).map_err(create)?;
        Ok(Self { target: folder.join(target.name), temporary, path })
    }

    /// The path as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes all `bytes`, waits until they are stored, and gives the file its name.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`]; the target is then as it was before.
    pub fn commit(self, bytes: &[u8]) -> Result<(), OutputError> {
        let Self { path, target, mut temporary } = self;
        let write = |source| OutputError::Write { path, length: bytes.len(), source };
        let stored = temporary.write_all(bytes).and_then(|()| temporary.as_file().sync_all());
        match stored {
            Ok(()) => temporary.persist(&target).map(|_| ()).map_err(|error| write(error.error)),
            Err(source) => Err(write(source)),
        }
    }
}

/// Several outputs of one run: all can be written, and no two are the same file.
///
/// ```
/// use emitree_io::OutputSet;
///
/// let folder = tempfile::tempdir()?;
/// let paths = ["image.fits", "image.png"].map(|name| folder.path().join(name));
/// for output in OutputSet::create(&paths)? {
///     let bytes = output.path().display().to_string(); // or an encoded image
///     output.commit(bytes.as_bytes())?;
/// }
/// assert!(OutputSet::create([&paths[0], &paths[0]]).is_err());
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
            if let Some(first) = files.iter().find(|first| first.target == file.target) {
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

/// The folder and the name that a path leads to.
struct Target {
    folder: PathBuf,
    name: OsString,
}

impl Target {
    fn of(path: &Path) -> Result<Self, OutputError> {
        if let Ok(metadata) = fs::metadata(path) {
            let found = if metadata.is_dir() { "a directory" } else { "not an ordinary file" };
            if !metadata.is_file() {
                return Err(OutputError::NotAFile { path: path.to_owned(), found });
            }
            if metadata.permissions().readonly() {
                return Err(OutputError::WriteProtected { path: path.to_owned() });
            }
        }
        let resolved = if path.is_symlink() { fs::canonicalize(path).ok() } else { None };
        let resolved = resolved.as_deref().unwrap_or(path);
        // A trailing slash asks for a directory, but `file_name` overlooks it.
        let slash = path.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
        match (resolved.parent(), resolved.file_name()) {
            (Some(parent), Some(name)) if !slash => {
                let here = parent.as_os_str().is_empty();
                let folder = if here { Path::new(".") } else { parent };
                Ok(Self { folder: folder.to_owned(), name: name.to_owned() })
            }
            _ => Err(OutputError::NoFileName { path: path.to_owned() }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::{TempDir, tempdir};

    fn names(folder: &TempDir) -> Vec<String> {
        let entries = fs::read_dir(folder.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_commit_replaces_the_file_and_leaves_nothing_else() {
        let folder = tempdir().unwrap();
        let path = folder.path().join("image.fits");
        fs::write(&path, "old").unwrap();
        let output = OutputFile::create(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(&folder).len(), 2);
        output.commit(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(&folder), ["image.fits"]);
    }

    #[test]
    fn a_drop_leaves_the_target_as_it_was() {
        let folder = tempdir().unwrap();
        let path = folder.path().join("image.fits");
        drop(OutputFile::create(&path).unwrap());
        assert!(names(&folder).is_empty());
        fs::write(&path, "old").unwrap();
        drop(OutputFile::create(&path).unwrap());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(&folder), ["image.fits"]);
    }

    #[test]
    fn what_is_no_file_is_refused_at_once() {
        let folder = tempdir().unwrap();
        let directory = OutputFile::create(folder.path()).unwrap_err().to_string();
        assert!(directory.ends_with("is a directory: expected a new or an ordinary file"));
        let missing = OutputFile::create(folder.path().join("no/image.fits")).unwrap_err();
        assert!(matches!(missing, OutputError::Create { .. }));
        let message = missing.to_string();
        assert!(message.contains("no/image.fits") && message.contains("folder that can be"));
        for path in ["", "..", "/"] {
            assert!(OutputFile::create(path).is_err(), "{path:?}");
        }
        let slash = folder.path().join("new/");
        assert!(matches!(OutputFile::create(slash), Err(OutputError::NoFileName { .. })));
        assert!(names(&folder).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_protected_files_are_refused_and_links_followed() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        assert!(matches!(OutputFile::create("/dev/null"), Err(OutputError::NotAFile { .. })));

        let folder = tempdir().unwrap();
        let path = folder.path().join("image.npy");
        fs::write(&path, "kept").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
        assert!(matches!(OutputFile::create(&path), Err(OutputError::WriteProtected { .. })));
        fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).unwrap();

        let link = folder.path().join("link.npy");
        symlink("image.npy", &link).unwrap();
        OutputFile::create(&link).unwrap().commit(b"new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert!(matches!(OutputSet::create([&path, &link]), Err(OutputError::Same { .. })));
    }

    #[test]
    fn two_names_of_one_file_are_found() {
        let folder = tempdir().unwrap();
        fs::create_dir(folder.path().join("sub")).unwrap();
        let first = folder.path().join("image.png");
        let second = folder.path().join("sub").join("..").join("image.png");
        let error = OutputSet::create([&first, &second]).unwrap_err().to_string();
        assert!(error.contains(&*first.to_string_lossy()), "{error}");
        assert!(error.contains(&*second.to_string_lossy()), "{error}");
        assert_eq!(names(&folder), ["sub"]);
        let other = folder.path().join("sub").join("image.png");
        assert_eq!(OutputSet::create([&first, &other]).unwrap().into_iter().count(), 2);
    }
}
