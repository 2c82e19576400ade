//! The versions that are supported: the oldest Rust, the oldest Python and `NumPy`, and the interface of the last
//! release.

use crate::environment::{INSTALL, INTERPRETER, empty_folder};
use crate::python;
use crate::workspace::{Workspace, spelled, succeed};
use std::fs;

/// `cargo xtask msrv`: everything compiles with the oldest supported Rust.
pub(crate) fn msrv(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    if !arguments.is_empty() {
        return Err("expected no argument".into());
    }
    let version = value(workspace, "Cargo.toml", "rust-version = \"")?;
    let mut check = workspace.command("rustup");
    check.args(["run", &version, "cargo", "check", "--workspace", "--all-targets", "--locked"]);
    // In a folder of its own: the other toolchain would take the place of what is there.
    let target = workspace.target_path("msrv");
    succeed(check.env("CARGO_TARGET_DIR", target)).map_err(|error| {
        format!("{error} (`rustup toolchain install {version} --profile minimal` installs it)")
    })
}

/// `cargo xtask oldest`: the Python package works with the `python3` that is there and with the oldest `NumPy`.
pub(crate) fn oldest(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    if !arguments.is_empty() {
        return Err("expected no argument".into());
    }
    let numpy = value(workspace, "python/pyproject.toml", "\"numpy>=")?;
    let folder = empty_folder(workspace, "oldest")?;
    succeed(workspace.command("python3").args(["-m", "venv"]).arg(folder.join("venv")))?;
    let python = folder.join("venv").join(INTERPRETER);
    let packages = [format!("numpy=={numpy}.*"), "maturin>=1.16,<2".to_owned()];
    succeed(workspace.command(&python).args(INSTALL).args(packages))?;
    python::install(workspace, &python, "oldest/wheel", &[])?;
    let script = workspace.path("python/tests/smoke.py");
    succeed(workspace.command(&python).arg(script).current_dir(&folder))
}

/// `cargo xtask semver [REVISION]`: the public interfaces of the crates are those of the last release, or of a
/// revision, unless the version says that they are not.
pub(crate) fn semver(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    let revision = match arguments {
        [] => last_release(workspace)?,
        [revision] => Some((*revision).to_owned()),
        _ => return Err("expected nothing, or a revision of git".into()),
    };
    let Some(revision) = revision else {
        eprintln!("xtask: no release yet (a tag such as v0.1.0): nothing to compare with");
        return Ok(());
    };
    let mut check = workspace.cargo();
    check.args(["semver-checks", "--workspace", "--exclude", "emitree-cli", "--baseline-rev"]);
    succeed(check.arg(revision)).map_err(|error| {
        format!("{error} (`cargo install --locked cargo-semver-checks` installs it)")
    })
}

/// The newest tag of a version that the checkout comes from.
fn last_release(workspace: &Workspace) -> Result<Option<String>, String> {
    let mut describe = workspace.command("git");
    describe.args(["describe", "--tags", "--abbrev=0", "--match", "v[0-9]*"]);
    let line = spelled(&describe);
    let output = describe.output().map_err(|error| format!("`{line}`: {error}"))?;
    let tag = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    Ok(Some(tag).filter(|tag| output.status.success() && !tag.is_empty()))
}

/// What follows a text in a file, up to the quotation mark.
fn value(workspace: &Workspace, file: &str, before: &str) -> Result<String, String> {
    let text =
        fs::read_to_string(workspace.path(file)).map_err(|error| format!("{file}: {error}"))?;
    let after = text.split_once(before).and_then(|(_, after)| after.split('"').next());
    after.map(str::to_owned).ok_or_else(|| format!("{file}: it has no `{before}`"))
}
