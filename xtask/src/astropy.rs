//! The tests under `tests/astropy`, in a virtual environment of their own.

use crate::environment::{empty_folder, interpreter};
use crate::outcome::Outcome;
use crate::workspace::{Workspace, succeed};

pub(crate) fn run(workspace: &Workspace) -> Outcome {
    check(workspace).into()
}

fn check(workspace: &Workspace) -> Result<(), String> {
    let python = interpreter(workspace, "astropy-venv", "tests/astropy/requirements.txt")?;
    let samples = empty_folder(workspace, "astropy-samples")?;
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
