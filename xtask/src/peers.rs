//! `cargo xtask compare-peers`: emitree beside other packages, in `bench/peers`.
//!
//! Not a step of `cargo xtask test`: it takes minutes, gigabytes of packages, and its seconds are those
//! of the machine.

use crate::environment::{Environment, interpreter};
use crate::python::{install, lint};
use crate::workspace::{Workspace, succeed};

/// The folder of the comparison.
const FOLDER: &str = "bench/peers";

/// Tests the comparison, measures the contestants and scenes named (all if none is; `users` is what
/// users would pick), and writes `bench/runs/peers.csv`, `docs/peers.md` and its pictures.
pub(crate) fn run(workspace: &Workspace, names: &[&str]) -> Result<(), String> {
    let python = interpreter(
        workspace,
        Environment { name: "peers-venv", requirements: &format!("{FOLDER}/requirements.txt") },
    )?;
    lint(workspace, &python, FOLDER)?;
    // Optimised as users have it: seconds are compared too.
    install(workspace, &python, "peers-wheel", &["--profile", "dist"])?;
    let module = |arguments: &[&str]| {
        let mut command = workspace.command(&python);
        command.arg("-m").args(arguments);
        command.env("PYTHONPATH", workspace.path("bench"));
        command
    };
    succeed(&mut module(&["pytest", "-q", "-p", "no:cacheprovider", FOLDER]))?;
    succeed(module(&["peers"]).args(names))
}
