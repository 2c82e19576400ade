//! `cargo xtask errors`: the pictures and the tables of docs/errors.md, by the command line.
//!
//! Not a step of `cargo xtask test`: it draws pictures.

use crate::environment::{Environment, empty_folder, interpreter};
use crate::performance::with_block;
use crate::python::lint;
use crate::workspace::{Workspace, spelled, succeed};
use std::fs;

/// The folder of the scenes, and of what renders and draws them.
const FOLDER: &str = "bench/errors";
/// Where the tables are read.
const DOCUMENT: &str = "docs/errors.md";
/// Where the pictures are.
const PICTURES: &str = "docs/images";
/// What precedes the name of a table.
const TABLE: &str = "# table: ";

/// Renders each scene with each kind of tolerance, and writes pictures and tables.
pub(crate) fn run(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    if let [first, ..] = arguments {
        return Err(format!("`{first}` after `errors`: expected nothing"));
    }
    succeed(workspace.cargo().args(["build", "--release", "--package", "emitree-cli"]))?;
    let python = interpreter(
        workspace,
        Environment { name: "errors-venv", requirements: &format!("{FOLDER}/requirements.txt") },
    )?;
    lint(workspace, &python, FOLDER)?;
    let mut command = workspace.command(&python);
    command.arg(format!("{FOLDER}/errors.py")).arg(workspace.target_path("release/emitree"));
    command.arg(FOLDER).arg(empty_folder(workspace, "errors")?).arg(PICTURES);
    let line = spelled(&command);
    let output = command.output().map_err(|error| format!("`{line}` could not be run: {error}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("`{line}` ended with {}: {said}", output.status));
    }
    let printed = String::from_utf8(output.stdout).map_err(|error| format!("`{line}`: {error}"))?;
    let document = workspace.path(DOCUMENT);
    let in_document = |error| format!("{}: {error}", document.display());
    let mut text = fs::read_to_string(&document).map_err(in_document)?;
    for (name, table) in tables(&printed) {
        text = with_block(DOCUMENT, &text, name, table)?;
    }
    fs::write(&document, text).map_err(in_document)
}

/// The tables in what was printed, with their names.
fn tables(printed: &str) -> impl Iterator<Item = (&str, &str)> {
    printed.split(TABLE).skip(1).filter_map(|table| table.split_once('\n'))
}

#[cfg(test)]
mod tests {
    use super::tables;

    #[test]
    fn tables_have_names() {
        let printed = "# table: one\n| a |\n| b |\n# table: two\n| c |\n";
        let found: Vec<_> = tables(printed).collect();
        assert_eq!(found, [("one", "| a |\n| b |\n"), ("two", "| c |\n")]);
    }
}
