//! What a path leads to: a file that is replaced, or a stream that is written in place.

use super::error::OutputError;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Links that are followed one after the other, as many as Linux follows.
const MOST_LINKS: usize = 40;

/// What a path leads to when all symbolic links are followed.
pub(super) enum Target {
    /// An ordinary file, there or not.
    File {
        /// Its folder, without links.
        folder: PathBuf,
        /// Its name in the folder.
        name: OsString,
    },
    /// A pipe, a device, or what is already open under a number: it has no name to be replaced.
    Stream(File),
}

impl Target {
    pub(super) fn of(path: &Path) -> Result<Self, OutputError> {
        let owned = || path.to_owned();
        let open = |source| OutputError::Open { path: owned(), source };
        let mut end = path.to_owned();
        for _ in 0..MOST_LINKS {
            if let Some(stream) = descriptor(&end) {
                return stream.map(Self::Stream).map_err(open);
            }
            match fs::read_link(&end) {
                // A link is relative to the folder that it is in; its target may not be there yet.
                Ok(next) => end = folder_of(&end).join(next),
                Err(_) => break,
            }
        }
        let folder = folder_of(&end);
        let create =
            |source| OutputError::Create { path: owned(), folder: folder.to_owned(), source };
        match fs::metadata(&end) {
            Ok(metadata) if metadata.is_dir() => {
                return Err(OutputError::NotAFile { path: owned(), found: "a directory" });
            }
            Ok(metadata) if is_disk(&metadata) => {
                return Err(OutputError::NotAFile { path: owned(), found: "a disk" });
            }
            Ok(metadata) if !metadata.is_file() => {
                return File::options().write(true).open(&end).map(Self::Stream).map_err(open);
            }
            Ok(metadata) if metadata.permissions().readonly() => {
                return Err(OutputError::WriteProtected { path: owned() });
            }
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(create(error)),
            _ => {}
        }
        // A slash at the end asks for a directory, but `file_name` overlooks it.
        let slash = end.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
        match end.file_name() {
            Some(name) if !slash => Ok(Self::File {
                folder: fs::canonicalize(folder).map_err(create)?,
                name: name.to_owned(),
            }),
            _ => Err(OutputError::NoFileName { path: owned() }),
        }
    }
}

/// The folder that a path is in; that of a bare name is this one.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

#[cfg(unix)]
fn is_disk(metadata: &fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    metadata.file_type().is_block_device()
}

#[cfg(not(unix))]
fn is_disk(_: &fs::Metadata) -> bool {
    false
}

/// What is open in this process under a number, if the path names it so, as `/dev/stdout` does.
///
/// It may well be an ordinary file, to which a shell has redirected the output. Others write to it,
/// too, so that it must not be replaced, and is written where they are.
#[cfg(unix)]
fn descriptor(path: &Path) -> Option<io::Result<File>> {
    use std::io::Write;
    use std::os::fd::AsFd;
    let folder = fs::canonicalize(folder_of(path)).ok()?;
    let is_ours = |name| fs::canonicalize(name).is_ok_and(|ours| ours == folder);
    if !["/dev/fd", "/proc/self/fd"].into_iter().any(is_ours) {
        return None;
    }
    let number: u32 = path.file_name()?.to_str()?.parse().ok()?;
    Some(match number {
        // A duplicate has the place in common with the original: neither overwrites the other.
        1 => io::stdout()
            .flush()
            .and_then(|()| io::stdout().as_fd().try_clone_to_owned())
            .map(File::from),
        2 => io::stderr().as_fd().try_clone_to_owned().map(File::from),
        _ => File::options().append(true).open(path),
    })
}

#[cfg(not(unix))]
fn descriptor(_: &Path) -> Option<io::Result<File>> {
    None
}
