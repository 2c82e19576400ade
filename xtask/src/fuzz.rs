//! `cargo xtask fuzz [SECONDS] [SEED]`: more mutants than `cargo xtask test` has time for.

use crate::workspace::{Workspace, succeed};
use std::time::{SystemTime, UNIX_EPOCH};

/// How long each test runs by default.
const SECONDS: &str = "60";
/// The tests that make mutants.
const TESTS: [&str; 2] = ["mutated_files", "mutated_scenes"];

/// Runs the mutation tests for so many seconds each, from a seed on; without one from the clock.
pub(crate) fn run(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    let number = |text: &str| match text.parse::<u64>() {
        Ok(_) => Ok(text.to_owned()),
        Err(_) => Err(format!("fuzz: `{text}`: expected a whole number, as in `fuzz 600 17`")),
    };
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
    let (seconds, seed) = match arguments {
        [] => (SECONDS.to_owned(), now.to_string()),
        [seconds] => (number(seconds)?, now.to_string()),
        [seconds, seed] => (number(seconds)?, number(seed)?),
        _ => return Err("fuzz: expected SECONDS and SEED, and no more".to_owned()),
    };
    println!("xtask: {seconds} s for each test, seeds from {seed} on");
    let mut command = workspace.cargo();
    command.args(["test", "--package", "emitree-cli", "--test", "all", "--"]).args(TESTS);
    command.env("EMITREE_FUZZ_SECONDS", seconds).env("EMITREE_FUZZ_SEED", seed);
    succeed(&mut command)
}
