//! The Python package: checked as it stands, its wheel built, installed in a virtual environment, and
//! tested there.

use crate::environment::{Environment, INSTALL, empty_folder, prepared};
use crate::outcome::Outcome;
use crate::workspace::{Workspace, succeed};
use std::env::consts;
use std::fs;
use std::path::{Path, PathBuf};

/// Tests and docstrings; the settings, by which warnings are errors, are named, since the folders have none in common.
/// In two processes, since most of them use one core, each file in one of them.
const TESTS: [&str; 12] = [
    "-m",
    "pytest",
    "-c",
    "python/pyproject.toml",
    "--numprocesses",
    "2",
    "--dist",
    "loadfile",
    "--doctest-modules",
    "--pyargs",
    "emitree",
    "python/tests",
];

/// The packages of the tests.
pub(crate) const ENVIRONMENT: Environment<'_> =
    Environment { name: "python-venv", requirements: "python/tests/requirements.txt" };

pub(crate) fn run(workspace: &Workspace) -> Outcome {
    check(workspace, None).into()
}

/// All of that, with a wheel that exists instead of one of the sources.
pub(crate) fn check(workspace: &Workspace, wheel: Option<&Path>) -> Result<(), String> {
    let python = prepared(workspace, ENVIRONMENT)?;
    lint(workspace, &python, "python")?;
    match wheel {
        Some(wheel) => install_wheel(workspace, &python, wheel)?,
        None => install(workspace, &python, "python-wheel", &["--features", "tests"])?,
    }
    // The files of the package are compared with those of the command. Built with an example, it has the features
    // that it has in the step `unit`, which need not compile everything again.
    let build = ["build", "--workspace", "--bin", "emitree", "--example", "write_samples"];
    succeed(workspace.cargo().args(build))?;
    let command = workspace.target_path("debug").join(format!("emitree{}", consts::EXE_SUFFIX));
    let mut tests = workspace.command(&python);
    succeed(tests.args(TESTS).env("EMITREE_COMMAND", command))
}

/// Lints of Python files, and their formatting.
pub(crate) fn lint(workspace: &Workspace, python: &Path, folder: &str) -> Result<(), String> {
    for check in [&["check", "--no-cache"][..], &["format", "--check", "--no-cache"]] {
        succeed(workspace.command(python).args(["-m", "ruff"]).args(check).arg(folder))?;
    }
    Ok(())
}

/// Builds the wheel into a folder of the target directory, and installs it where `python` is.
pub(crate) fn install(
    workspace: &Workspace,
    python: &Path,
    folder: &str,
    options: &[&str],
) -> Result<(), String> {
    let wheels = empty_folder(workspace, folder)?;
    let build = ["-m", "maturin", "build", "--manifest-path", "python/Cargo.toml"];
    succeed(
        workspace
            .command(python)
            .args(build)
            .args(options)
            .arg("--interpreter")
            .arg(python)
            .arg("--out")
            .arg(&wheels),
    )?;
    install_wheel(workspace, python, &only_file(&wheels)?)
}

/// Installs a wheel where `python` is, in place of any other of the same version.
pub(crate) fn install_wheel(
    workspace: &Workspace,
    python: &Path,
    wheel: &Path,
) -> Result<(), String> {
    let install = ["--force-reinstall", "--no-deps"];
    succeed(workspace.command(python).args(INSTALL).args(install).arg(wheel))
}

/// The one file in a folder.
pub(crate) fn only_file(folder: &Path) -> Result<PathBuf, String> {
    let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    match files.as_slice() {
        [file] => Ok(file.clone()),
        _ => Err(format!("{}: {} files: expected one wheel", folder.display(), files.len())),
    }
}
