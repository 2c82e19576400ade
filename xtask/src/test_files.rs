//! That each file of integration tests is compiled: `tests/all.rs` of its crate has it as a module, or the manifest as a
//! binary. Cargo itself would not report one that neither has.

use crate::outcome::Outcome;
use crate::workspace::Workspace;
use std::fs;
use std::path::{Path, PathBuf};

pub(crate) fn run(workspace: &Workspace) -> Outcome {
    check(workspace).into()
}

/// Checks the crates whose tests are one binary.
fn check(workspace: &Workspace) -> Result<(), String> {
    let folder = workspace.path("crates");
    let crates = fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let folders =
        crates.flatten().map(|of| of.path()).filter(|of| of.join("tests/all.rs").exists());
    let mut missing = Vec::new();
    for folder in folders {
        missing.extend(missing_files(&folder)?);
    }
    missing.sort();
    match missing.is_empty() {
        true => Ok(()),
        false => Err(format!("tests that are not compiled: {}", missing.join(", "))),
    }
}

/// The files of a crate's tests that are not compiled.
fn missing_files(folder: &Path) -> Result<Vec<String>, String> {
    let read = |path: &str| {
        let path = folder.join(path);
        fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    let (all, manifest) = (read("tests/all.rs")?, read("Cargo.toml")?);
    let tests = folder.join("tests");
    let files = fs::read_dir(&tests).map_err(|error| format!("{}: {error}", tests.display()))?;
    let files = files.flatten().map(|file| file.path());
    let files = files.filter(|file| file.extension().is_some_and(|of| of == "rs"));
    let is_missing = |file: &PathBuf| {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        !is_compiled(&name, &all, &manifest)
    };
    Ok(files.filter(is_missing).map(|file| file.display().to_string()).collect())
}

/// Whether a file of tests is a module of `all.rs`, or a binary of its own.
fn is_compiled(name: &str, all: &str, manifest: &str) -> bool {
    let (module, binary) = (format!("mod {name};"), format!("name = \"{name}\""));
    let mut of_tests = manifest.split("[[test]]").skip(1);
    all.lines().any(|line| line == module)
        || of_tests.any(|of| of.lines().nth(1) == Some(binary.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_a_module_or_a_binary() {
        let all = "mod cameras;\nmod paper_cube;\n";
        let manifest = "[package]\nname = \"emitree\"\n\n[[test]]\nname = \"alloc\"\n";
        let is = |name| is_compiled(name, all, manifest);
        assert!(is("cameras") && is("paper_cube") && is("alloc"));
        assert!(!is("paper") && !is("emitree") && !is("cube"));
    }
}
