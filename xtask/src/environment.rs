//! Virtual environments for the steps that need Python, each with its requirements.

use crate::workspace::{Workspace, succeed};
use std::fs;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// A virtual environment of a step.
#[derive(Clone, Copy)]
pub(crate) struct Environment<'a> {
    /// Its folder in the target directory.
    pub(crate) name: &'a str,
    /// The file with its packages.
    pub(crate) requirements: &'a str,
}

/// Held while environments are prepared.
static PREPARING: Mutex<()> = Mutex::new(());

/// Reports what a machine lacks.
const MISSING: &str = "python3 with the modules venv and ensurepip is needed \
    (Debian, Ubuntu: `apt install python3 python3-venv`; macOS: `brew install python`)";

/// Where a virtual environment has its interpreter.
pub(crate) const INTERPRETER: &str =
    if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" };

/// Makes environments that later steps need, while the first ones compile: one processor unpacks the packages. What fails
/// is tried again, and reported, by the step that needs the environment.
pub(crate) fn prepare(workspace: &Workspace, environments: &[Environment<'_>]) {
    let _until_made = PREPARING.lock().unwrap_or_else(PoisonError::into_inner);
    for environment in environments {
        let _ = interpreter(workspace, *environment);
    }
}

/// The interpreter of an environment that may be in preparation.
pub(crate) fn prepared(
    workspace: &Workspace,
    environment: Environment<'_>,
) -> Result<PathBuf, String> {
    drop(PREPARING.lock());
    interpreter(workspace, environment)
}

/// The interpreter of a virtual environment, which is made anew whenever the requirements
/// are not those that it was made from.
pub(crate) fn interpreter(
    workspace: &Workspace,
    Environment { name, requirements }: Environment<'_>,
) -> Result<PathBuf, String> {
    let requirements = workspace.path(requirements);
    let wanted = fs::read_to_string(&requirements)
        .map_err(|error| format!("{}: {error}", requirements.display()))?;
    let folder = workspace.target_path(name);
    let (python, stamp) = (folder.join(INTERPRETER), folder.join("requirements.stamp"));
    if python.exists() && fs::read_to_string(&stamp).is_ok_and(|made_from| made_from == wanted) {
        return Ok(python);
    }
    let modules = workspace.command("python3").args(["-c", "import venv, ensurepip"]).output();
    if !modules.is_ok_and(|output| output.status.success()) {
        return Err(MISSING.into());
    }
    succeed(workspace.command("python3").args(["-m", "venv", "--clear"]).arg(&folder))?;
    succeed(workspace.command(&python).args(INSTALL).arg("-r").arg(&requirements))?;
    // Last: an installation that was broken off leaves no stamp, and is done again.
    fs::write(&stamp, wanted).map_err(|error| format!("{}: {error}", stamp.display()))?;
    Ok(python)
}

/// What an interpreter is called with to install packages. Modules are compiled when they are first imported: of
/// most packages few are.
pub(crate) const INSTALL: [&str; 6] =
    ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile"];

/// An empty folder in the target directory: files of former runs would be taken for new ones.
pub(crate) fn empty_folder(workspace: &Workspace, name: &str) -> Result<PathBuf, String> {
    let folder = workspace.target_path(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    Ok(folder)
}
