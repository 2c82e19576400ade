//! Outputs in a temporary folder.

use super::*;
use std::fs;
use std::io::Write;
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
fn a_file_that_is_written_piece_by_piece_needs_room_and_replaces_whole() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("image.fits");
    fs::write(&path, "old").unwrap();
    let output = OutputFile::create(&path).unwrap();
    output.check_room(3).unwrap();
    if cfg!(unix) {
        let error = output.check_room(u64::MAX).unwrap_err();
        assert!(matches!(error, OutputError::NoSpace { bytes: u64::MAX, .. }), "{error}");
    }
    let failed = output.commit_with(|file| {
        file.write_all(b"half").unwrap();
        Err(OutputError::NoSpace { path: path.clone(), bytes: 1, free: 0 })
    });
    assert!(failed.is_err());
    assert_eq!((fs::read(&path).unwrap(), names(&folder).len()), (b"old".to_vec(), 1));
    let output = OutputFile::create(&path).unwrap();
    let written = output.commit_with(|file| {
        file.write_all(b"new").unwrap();
        Ok::<(), OutputError>(())
    });
    written.unwrap();
    assert_eq!((fs::read(&path).unwrap(), names(&folder).len()), (b"new".to_vec(), 1));
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
fn protected_files_are_refused_and_links_followed() {
    use std::os::unix::fs::{PermissionsExt, symlink};
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

#[test]
fn several_files_are_replaced_together_or_not_at_all() {
    let folder = tempdir().unwrap();
    let paths = ["a.fits", "b.npy", "c.json"].map(|name| folder.path().join(name));
    for path in &paths {
        fs::write(path, "old").unwrap();
    }
    let outputs = || OutputSet::create(&paths).unwrap().into_iter();
    let written = commit_all(outputs().map(|output| (output, b"new"))).unwrap();
    assert_eq!(written, paths);
    assert!(paths.iter().all(|path| fs::read(path).unwrap() == b"new"));

    // The second can't be replaced any more: the first is, and the message says so.
    let outputs = outputs();
    fs::remove_file(&paths[1]).unwrap();
    fs::create_dir_all(paths[1].join("inner")).unwrap();
    let error = commit_all(outputs.map(|output| (output, b"newest"))).unwrap_err().to_string();
    let [first, second, third] = paths.each_ref().map(|path| path.display().to_string());
    assert!(error.starts_with(&format!("`{second}`: cannot replace it (")), "{error}");
    assert!(error.ends_with(&format!("; written before: `{first}`")), "{error}");
    assert_eq!(fs::read(first).unwrap(), b"newest");
    assert_eq!(fs::read(third).unwrap(), b"new");
    assert_eq!(names(&folder), ["a.fits", "b.npy", "c.json"]);
}

#[cfg(unix)]
#[test]
fn a_file_that_can_not_be_stored_keeps_all_others_as_they_were() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.fits");
    fs::write(&path, "old").unwrap();
    let output = OutputFile::create(&path).unwrap();
    // A device that has no room: bytes are refused as by a full disk, in the place of a file.
    let full = File::options().write(true).open("/dev/full");
    let Ok(full) = full else { return };
    let temporary = tempfile::Builder::new().make(|_| full.try_clone()).unwrap();
    let (file, temporary) = temporary.into_parts();
    let temporary = NamedTempFile::from_parts(file, temporary);
    let at = temporary.path().to_path_buf();
    let place = Place::Beside { target: folder.path().join("b.npy"), temporary };
    let broken = OutputFile { path: "b.npy".into(), place };
    let error = commit_all([(output, b"new"), (broken, b"new")]).unwrap_err();
    let reason = format!("No space left on device (os error 28) at path {at:?}");
    let message = format!("`b.npy`: cannot write 3 bytes ({reason})");
    assert_eq!(error.to_string(), message);
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names(&folder), ["a.fits"]);
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_nowhere_yet_is_followed() {
    use std::os::unix::fs::symlink;
    let folder = tempdir().unwrap();
    fs::create_dir(folder.path().join("sub")).unwrap();
    let [one, two] = ["one.npy", "two.npy"].map(|name| folder.path().join(name));
    symlink("two.npy", &one).unwrap();
    symlink("sub/image.npy", &two).unwrap();
    OutputFile::create(&one).unwrap().commit(b"new").unwrap();
    assert!(one.is_symlink() && two.is_symlink());
    assert_eq!(fs::read(folder.path().join("sub/image.npy")).unwrap(), b"new");

    let ring = folder.path().join("ring.npy");
    symlink("ring.npy", &ring).unwrap();
    assert!(matches!(OutputFile::create(&ring), Err(OutputError::Create { .. })));
    let nowhere = folder.path().join("nowhere.npy");
    symlink("missing/image.npy", &nowhere).unwrap();
    let error = OutputFile::create(&nowhere).unwrap_err().to_string();
    assert!(error.contains("nowhere.npy") && error.contains("/missing`"), "{error}");
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_written_in_place() {
    use std::os::unix::fs::FileTypeExt;
    OutputFile::create("/dev/null").unwrap().commit(b"gone").unwrap();
    let kind = fs::metadata("/dev/null").unwrap().file_type();
    assert!(kind.is_char_device());
    assert_eq!(OutputSet::create(["/dev/null"; 2]).unwrap().into_iter().count(), 2);

    let folder = tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let from = pipe.clone();
    let reader = std::thread::spawn(move || fs::read(from).unwrap());
    OutputFile::create(&pipe).unwrap().commit(b"through").unwrap();
    assert_eq!(reader.join().unwrap(), b"through");
    assert_eq!(names(&folder), ["pipe"]);
}

#[test]
fn names_may_be_as_long_as_the_system_allows() {
    let folder = tempdir().unwrap();
    for letter in ["a", "ä"] {
        let name = letter.repeat(250 / letter.len()) + ".fits";
        assert_eq!(name.len(), 255);
        let path = folder.path().join(&name);
        OutputFile::create(&path).unwrap().commit(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        // Found before the bytes are made, not when the file is to get its name.
        let long = folder.path().join(format!("{letter}{name}"));
        assert!(matches!(OutputFile::create(long), Err(OutputError::Create { .. })));
    }
    assert_eq!(names(&folder).len(), 2);
}

#[test]
fn what_a_killed_run_left_is_removed_by_the_next_one() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("image.fits");
    let abandoned = folder.path().join(".image.fits.AbC123.part");
    fs::write(&abandoned, "half").unwrap();
    // Files of other outputs, and of users.
    let others = [".image.fits.part", ".image.npy.AbC123.part", ".image.fits.AbC123.parts"];
    for other in others {
        fs::write(folder.path().join(other), "kept").unwrap();
    }
    let first = OutputFile::create(&path).unwrap();
    assert!(!abandoned.exists());
    // That of a run that lives stays, and each run commits its own.
    let second = OutputFile::create(&path).unwrap();
    assert_eq!(names(&folder).len(), others.len() + 2);
    first.commit(b"first").unwrap();
    second.commit(b"second").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"second");
    assert_eq!(names(&folder).len(), others.len() + 1);
}
