//! `cargo xtask manual`: the man pages of the command and the completions of shells, for those who package it.

use crate::environment::empty_folder;
use crate::workspace::{Workspace, succeed};

/// In the target directory.
const FOLDER: &str = "manual";

pub(crate) fn run(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    if !arguments.is_empty() {
        return Err("expected no argument".into());
    }
    succeed(workspace.cargo().args(["build", "--release", "--package", "emitree-cli"]))?;
    let folder = empty_folder(workspace, FOLDER)?;
    let mut program = workspace.command(workspace.target_path("release/emitree"));
    succeed(program.arg("manual").arg(&folder))
}
