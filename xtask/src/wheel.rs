//! `cargo xtask wheel`: the source distribution, and from it the wheel for Linux that most systems accept.
//!
//! The wheel is built from the unpacked source distribution, without a network and from crates that are beside it, so
//! that one compilation shows that both are complete. `zig` links against the symbols of an old C library, for which
//! others use a container.

use crate::environment::{Environment, INSTALL, INTERPRETER, empty_folder, interpreter};
use crate::licences;
use crate::python::{self, only_file};
use crate::workspace::{Workspace, spelled, succeed};
use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::Path;

/// The oldest C library of Linux that the wheel accepts: 2.17, that of 2012, as Rust itself does.
const PLATFORM: &str = "manylinux_2_17";
/// In the target directory: distributions, and the sources from which the wheel is built.
const FOLDER: &str = "wheel";

pub(crate) fn run(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    let has_tests = match arguments {
        [] => false,
        ["test"] => true,
        _ => return Err("expected nothing, or `test` for all tests of Python".into()),
    };
    let python = interpreter(
        workspace,
        Environment { name: "wheel-venv", requirements: "python/wheel/requirements.txt" },
    )?;
    licences::run(workspace, &[])?;
    let folder = empty_folder(workspace, FOLDER)?;
    let (sdist, sources, wheels) =
        (folder.join("sdist"), folder.join("sources"), folder.join("dist"));
    let mut pack = workspace.command(&python);
    pack.args(["-m", "maturin", "sdist", "--manifest-path", "python/Cargo.toml", "--out"]);
    succeed(pack.arg(&sdist))?;
    let in_folder = |error| format!("{}: {error}", sources.display());
    fs::create_dir(&sources).map_err(in_folder)?;
    let mut unpack = workspace.command("tar");
    // -m: with the times of the archive cargo would take changed files for those of the last build.
    unpack.arg("-xzmf").arg(only_file(&sdist)?).args(["--strip-components", "1", "-C"]);
    succeed(unpack.arg(&sources))?;
    vendor(workspace, &sources)?;
    let mut build = workspace.command(&python);
    // Not --locked: the lock file names crates of the whole workspace, which cargo leaves out here.
    build.args(["-m", "maturin", "build", "--profile", "dist", "--interpreter"]);
    build.arg(&python).arg("--out").arg(&wheels);
    if cfg!(target_os = "linux") {
        // maturin searches the path for a Python that has `zig`.
        build.args(["--zig", "--compatibility", PLATFORM]).env("PATH", path_with(&python)?);
    }
    let target = workspace.target_path("wheel-build");
    build.env("CARGO_TARGET_DIR", target).env("CARGO_NET_OFFLINE", "true");
    succeed(build.current_dir(&sources))?;
    let wheel = only_file(&wheels)?;
    if cfg!(target_os = "linux") {
        audit(workspace, &python, &wheel)?;
    }
    has_licences(workspace, &python, &wheel)?;
    try_it(workspace, &wheel)?;
    if has_tests {
        python::check(workspace, Some(&wheel))?;
    }
    eprintln!("xtask: {} and {}", only_file(&sdist)?.display(), wheel.display());
    Ok(())
}

/// Puts the sources of all crates beside those of the package, and has cargo take no others.
fn vendor(workspace: &Workspace, sources: &Path) -> Result<(), String> {
    let mut vendor = workspace.cargo();
    vendor.args(["vendor", "--versioned-dirs", "vendor"]).current_dir(sources);
    let line = spelled(&vendor);
    eprintln!("xtask: {line}");
    let output = vendor.output().map_err(|error| format!("`{line}`: {error}"))?;
    if !output.status.success() {
        return Err(format!("`{line}`: {}", String::from_utf8_lossy(&output.stderr)));
    }
    // What it prints is the configuration for these sources.
    let folder = sources.join(".cargo");
    let in_folder = |error| format!("{}: {error}", folder.display());
    fs::create_dir_all(&folder).map_err(in_folder)?;
    fs::write(folder.join("config.toml"), &output.stdout).map_err(in_folder)
}

/// The search path with the folder of an interpreter first.
fn path_with(python: &Path) -> Result<OsString, String> {
    let folders = env::var_os("PATH").unwrap_or_default();
    let first = python.parent().map(Path::to_owned);
    let folders = first.into_iter().chain(env::split_paths(&folders));
    env::join_paths(folders).map_err(|error| format!("PATH: {error}"))
}

/// Whether `auditwheel` finds the platform of the name of the wheel: no newer symbols, no other library.
fn audit(workspace: &Workspace, python: &Path, wheel: &Path) -> Result<(), String> {
    let mut show = workspace.command(python);
    show.args(["-m", "auditwheel", "show"]).arg(wheel);
    let line = spelled(&show);
    let output = show.output().map_err(|error| format!("`{line}`: {error}"))?;
    let found = String::from_utf8_lossy(&output.stdout);
    eprintln!("xtask: {line}{found}");
    let words = found.split_whitespace().collect::<Vec<_>>().join(" ");
    // Had it newer symbols, or other libraries than those of the platform, the tag would be another.
    if output.status.success() && words.contains(&format!("platform tag: \"{PLATFORM}_")) {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(format!("`{line}`: expected {PLATFORM}. {said}"))
}

/// Whether the wheel has the texts of all licences.
fn has_licences(workspace: &Workspace, python: &Path, wheel: &Path) -> Result<(), String> {
    let list = workspace.command(python).args(["-m", "zipfile", "--list"]).arg(wheel).output();
    let list = list.map_err(|error| format!("{}: {error}", wheel.display()))?;
    let list = String::from_utf8_lossy(&list.stdout);
    let own = ["python/LICENSE-APACHE", "python/LICENSE-DEJAVU", "python/LICENSE-MIT"];
    let is_missing = |file: &&str| {
        let name = file.trim_start_matches("python/");
        !list.lines().any(|line| line.split_whitespace().next().is_some_and(|f| f.ends_with(name)))
    };
    let missing: Vec<&str> = licences::FILES.into_iter().chain(own).filter(is_missing).collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(format!("{}: it lacks {}", wheel.display(), missing.join(", ")))
}

/// Installs the wheel in a fresh environment, and renders with it there, far from the sources.
fn try_it(workspace: &Workspace, wheel: &Path) -> Result<(), String> {
    let folder = empty_folder(workspace, "wheel-test")?;
    succeed(workspace.command("python3").args(["-m", "venv"]).arg(folder.join("venv")))?;
    let python = folder.join("venv").join(INTERPRETER);
    succeed(workspace.command(&python).args(INSTALL).arg(wheel))?;
    let script = folder.join("smoke.py");
    fs::copy(workspace.path("python/tests/smoke.py"), &script)
        .map_err(|error| format!("{}: {error}", script.display()))?;
    succeed(workspace.command(&python).args(["-W", "error"]).arg(&script).current_dir(&folder))
}
