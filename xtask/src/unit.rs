//! `cargo test`, its output streamed, and the total of its binaries and doctests.

use crate::outcome::Outcome;
use crate::total::Total;
use crate::workspace::{Workspace, spelled};
use std::io::{self, BufRead, BufReader, Write};
use std::process::{Command, Stdio};

/// What is tested. Examples and benchmarks are not built: the step `lint` checks them.
const PARTS: [&str; 2] = ["--tests", "--doc"];

pub(crate) fn run(workspace: &Workspace) -> Outcome {
    let mut total = Total::default();
    let mut result = Ok(());
    // Both parts run even if the first one fails: the total is one of everything.
    for part in PARTS {
        result = result.and(of_part(workspace, part, &mut total));
    }
    total.ok &= result.is_ok();
    Outcome { result, total: Some(total) }
}

/// Runs the tests of one part, and adds them to the total.
fn of_part(workspace: &Workspace, part: &str, total: &mut Total) -> Result<(), String> {
    let mut command = workspace.cargo();
    // All binaries run even if one fails.
    command.args(["test", "--workspace", "--no-fail-fast", part]);
    // The same cases in every run: `cargo test` by hand takes new ones.
    command.env("PROPTEST_RNG_SEED", "2026");
    let line = spelled(&command);
    eprintln!("xtask: {line}");
    let before = total.binaries;
    match stream(&mut command, total) {
        Ok(status) if !status.success() => Err(format!("`{line}` ended with {status}")),
        Ok(_) if total.binaries == before => Err(format!("`{line}` reported no tests")),
        Ok(_) => Ok(()),
        Err(error) => Err(format!("`{line}` could not be run: {error}")),
    }
}

/// Runs the command, passes its standard output on line by line, and adds up the totals of its tests.
fn stream(command: &mut Command, total: &mut Total) -> io::Result<std::process::ExitStatus> {
    let mut child = command.stdout(Stdio::piped()).spawn()?;
    if let Some(output) = child.stdout.take() {
        let mut output = BufReader::new(output);
        let mut line = Vec::new();
        while output.read_until(b'\n', &mut line)? > 0 {
            io::stdout().write_all(&line)?;
            if let Some(one) = Total::of_line(&String::from_utf8_lossy(&line)) {
                *total += one;
            }
            line.clear();
        }
    }
    child.wait()
}
