//! `cargo xtask quick`: what fails most often while the code is changed, in less than 90 s once all is built.

use crate::step::STEPS;
use crate::workspace::{Workspace, succeed};

/// Steps of `cargo xtask test` that take seconds.
const STEPS_OF_SECONDS: [&str; 4] = ["fmt", "words", "circles", "lint"];
/// Tests that render many scenes.
const SLOW: [&str; 3] = ["vol::tests", "vol::lattice::tests", "vol::engine::tests"];

/// Lints, and the unit tests of the core that take milliseconds, compiled with few optimisations.
pub(crate) fn run(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    if !arguments.is_empty() {
        return Err(format!("quick: `{}`: expected no arguments", arguments.join(" ")));
    }
    for step in STEPS.iter().filter(|step| STEPS_OF_SECONDS.contains(&step.name)) {
        (step.run)(workspace).result?;
    }
    let mut command = workspace.cargo();
    command.args(["test", "--profile", "quick", "--package", "emitree", "--lib", "--"]);
    command.args(SLOW.iter().flat_map(|test| ["--skip", test]));
    succeed(&mut command)
}
