//! The tests under `tests/astropy`, in a virtual environment of their own.

use crate::environment::{Environment, empty_folder, prepared};
use crate::outcome::Outcome;
use crate::workspace::{Workspace, succeed};
use std::env::consts;

/// The packages that read our files.
pub(crate) const ENVIRONMENT: Environment<'_> =
    Environment { name: "astropy-venv", requirements: "tests/astropy/requirements.txt" };

pub(crate) fn run(workspace: &Workspace) -> Outcome {
    check(workspace).into()
}

fn check(workspace: &Workspace) -> Result<(), String> {
    let python = prepared(workspace, ENVIRONMENT)?;
    let samples = empty_folder(workspace, "astropy-samples")?;
    // With the features that everything has in the step `unit`, which need not compile it again.
    succeed(workspace.cargo().args(["build", "--workspace", "--example", "write_samples"]))?;
    let example = format!("debug/examples/write_samples{}", consts::EXE_SUFFIX);
    succeed(workspace.command(workspace.target_path(&example)).arg(&samples))?;
    succeed(
        workspace
            .command(python)
            .args(["-m", "pytest", "-p", "no:cacheprovider", "-W", "error", "tests/astropy"])
            .env("EMITREE_SAMPLES", &samples),
    )
}
