//! `cargo xtask ablate`: the influence of each constant of method `vol`.

use crate::workspace::{Workspace, spelled};
use std::fs;

/// The page whose table is replaced.
const DOCUMENT: &str = "docs/results/tuning.md";
/// The table begins after this line.
const MARK: &str = "<!-- cargo xtask ablate -->\n";

/// Renders scenes with each constant at the ends of its range, and writes what that changes.
pub(crate) fn run(workspace: &Workspace, groups: &[&str]) -> Result<(), String> {
    let mut command = workspace.cargo();
    command.args(["run", "--release", "--package", "emitree", "--features", "ablate"]);
    command.args(["--example", "ablate", "--"]).args(groups);
    let line = spelled(&command);
    eprintln!("xtask: {line}");
    let output = command.output().map_err(|error| format!("`{line}` could not be run: {error}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("`{line}` ended with {}: {said}", output.status));
    }
    let table = String::from_utf8_lossy(&output.stdout);
    if !groups.is_empty() {
        print!("{table}");
        return Ok(());
    }
    let document = workspace.path(DOCUMENT);
    let in_document = |error| format!("{}: {error}", document.display());
    let text = fs::read_to_string(&document).map_err(in_document)?;
    let (before, _) =
        text.split_once(MARK).ok_or_else(|| format!("{DOCUMENT}: expected {MARK}"))?;
    fs::write(&document, format!("{before}{MARK}\n{table}")).map_err(in_document)
}
