//! The tests under `tests/astropy`, in a virtual environment of their own.

use crate::step::Outcome;
use crate::workspace::{Workspace, succeed};
use std::fs;
use std::path::PathBuf;

/// Says what a machine lacks.
const MISSING: &str = "python3 with the modules venv and ensurepip is needed \
    (Debian, Ubuntu: `apt install python3 python3-venv`; macOS: `brew install python`)";

/// Where a virtual environment has its interpreter.
const INTERPRETER: &str = if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" };

pub(crate) fn run(workspace: &Workspace) -> Outcome {
    check(workspace).into()
}

fn check(workspace: &Workspace) -> Result<(), String> {
    let python = environment(workspace)?;
    let samples = workspace.target_path("astropy-samples");
    // Files of former runs would be tested in place of those that are no longer written.
    if samples.exists() {
        fs::remove_dir_all(&samples).map_err(|error| format!("{}: {error}", samples.display()))?;
    }
    fs::create_dir_all(&samples).map_err(|error| format!("{}: {error}", samples.display()))?;
    let example = ["run", "--package", "emitree-io", "--example", "write_samples", "--"];
    succeed(workspace.cargo().args(example).arg(&samples))?;
    succeed(
        workspace
            .command(python)
            .args(["-m", "pytest", "-p", "no:cacheprovider", "-W", "error", "tests/astropy"])
            .env("EMITREE_SAMPLES", &samples)
            .env("PYTHONDONTWRITEBYTECODE", "1"),
    )
}

/// The interpreter of the virtual environment, which is made anew whenever the requirements are
/// not those that it was made from.
fn environment(workspace: &Workspace) -> Result<PathBuf, String> {
    let requirements = workspace.path("tests/astropy/requirements.txt");
    let wanted = fs::read_to_string(&requirements)
        .map_err(|error| format!("{}: {error}", requirements.display()))?;
    let folder = workspace.target_path("astropy-venv");
    let (python, stamp) = (folder.join(INTERPRETER), folder.join("requirements.stamp"));
    if python.exists() && fs::read_to_string(&stamp).is_ok_and(|made_from| made_from == wanted) {
        return Ok(python);
    }
    let modules = workspace.command("python3").args(["-c", "import venv, ensurepip"]).output();
    if !modules.is_ok_and(|output| output.status.success()) {
        return Err(MISSING.into());
    }
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"];
    succeed(workspace.command("python3").args(["-m", "venv", "--clear"]).arg(&folder))?;
    succeed(workspace.command(&python).args(install).arg(&requirements))?;
    // Last: an installation that was broken off leaves no stamp, and is done again.
    fs::write(&stamp, wanted).map_err(|error| format!("{}: {error}", stamp.display()))?;
    Ok(python)
}
