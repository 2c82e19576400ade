//! Temporary files beside their targets, and those that killed runs have left behind.
//!
//! A temporary file is locked for as long as its run lives. The system ends the lock with the process,
//! however that ends, so that a file that can be locked has no owner any more.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

const ENDING: &str = ".part";
/// Characters by which temporary files for the same target differ.
const DIFFERENCE: usize = 6;
/// Bytes of the target's name that a temporary file repeats. A name may have 255 bytes, on some file
/// systems 143, and that of a temporary file must not be longer.
const NAME_BYTES: usize = 100;
/// Attempts at a file that no other run takes for an abandoned one before it is locked. One is enough
/// but for two runs that start within microseconds.
const ATTEMPTS: usize = 16;

/// A new temporary file for a target of this name, locked; abandoned ones for the same name are
/// removed.
pub(super) fn create(folder: &Path, name: &OsStr) -> io::Result<NamedTempFile> {
    let prefix = prefix(name);
    remove_abandoned(folder, &prefix);
    let mut last = None;
    for _ in 0..ATTEMPTS {
        let file = unlocked(folder, &prefix)?;
        match file.as_file().try_lock() {
            // Another run is about to remove it.
            Err(TryLockError::WouldBlock) => {}
            // A file system without locks removes nothing that it can't lock either.
            Ok(()) | Err(TryLockError::Error(_)) if file.path().exists() => return Ok(file),
            _ => {}
        }
        last = Some(file);
    }
    last.ok_or_else(|| io::Error::other("no temporary file"))
}

fn unlocked(folder: &Path, prefix: &OsStr) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(prefix).rand_bytes(DIFFERENCE).suffix(ENDING);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Temporary files are private by default; results get what the umask leaves.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// What the names of temporary files for a target start with.
fn prefix(name: &OsStr) -> OsString {
    let mut prefix = OsString::from(".");
    if name.len() <= NAME_BYTES {
        prefix.push(name);
    } else {
        let name = name.to_string_lossy();
        prefix.push(&name[..name.floor_char_boundary(NAME_BYTES)]);
    }
    prefix.push(".");
    prefix
}

/// Removes the temporary files for a target whose runs are no more. Files that can't be read stay.
fn remove_abandoned(folder: &Path, prefix: &OsStr) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let length = prefix.len() + DIFFERENCE + ENDING.len();
        let name = name.as_encoded_bytes();
        let is_one = name.len() == length
            && name.starts_with(prefix.as_encoded_bytes())
            && name.ends_with(ENDING.as_bytes());
        if !is_one || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let path = entry.path();
        if let Ok(file) = File::options().write(true).open(&path)
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(&path);
        }
    }
}
