//! `cargo xtask gallery`: the pictures of the gallery and what they cost, by the commands that it gives.

use crate::workspace::{Workspace, spelled, succeed};
use std::fs;
use std::path::PathBuf;

/// The page, whose sections each have a picture, what it cost, and the command that makes it.
const DOCUMENT: &str = "docs/gallery.md";
/// Outputs that the page does not show are left here, in the target directory.
const FOLDER: &str = "gallery";
/// What follows the number of evaluations on the page…
const EVALUATIONS: &str = " evaluations, estimated error ";
/// …and what precedes it.
const SCENE: &str = ".toml). ";

/// Renders the sections whose headings contain one of `names`, all of them if there is none, and writes
/// what they cost.
pub(crate) fn run(workspace: &Workspace, names: &[&str]) -> Result<(), String> {
    let document = workspace.path(DOCUMENT);
    let in_document = |error| format!("{}: {error}", document.display());
    let text = fs::read_to_string(&document).map_err(in_document)?;
    let mut program = workspace.cargo();
    succeed(program.args(["build", "--release", "--package", "emitree-cli"]))?;
    let mut sections: Vec<String> = text.split("\n## ").map(str::to_owned).collect();
    for section in sections.iter_mut().skip(1) {
        let heading = section.lines().next().unwrap_or_default();
        if names.is_empty() || names.iter().any(|name| heading.contains(name)) {
            *section = rendered(workspace, section)?;
        }
    }
    fs::write(&document, sections.join("\n## ")).map_err(in_document)
}

/// A section with what its command has printed.
fn rendered(workspace: &Workspace, section: &str) -> Result<String, String> {
    let heading = section.lines().next().unwrap_or_default();
    let missing = |what: &str| format!("{DOCUMENT}, section {heading}: expected {what}");
    let command = section
        .split_once("```sh\nemitree ")
        .and_then(|(_, rest)| rest.split_once("```"))
        .ok_or_else(|| missing("a command that starts with `emitree`"))?
        .0
        .replace("\\\n", " ");
    let folder = workspace.target_path(FOLDER);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut program = workspace.command(workspace.target_path("release/emitree"));
    for word in command.split_whitespace() {
        let is_shown = !(word.ends_with(".fits") || word.ends_with(".npz"));
        program.arg(if is_shown { PathBuf::from(word) } else { folder.join(word) });
    }
    let line = spelled(&program);
    eprintln!("xtask: {line}");
    let output = program.output().map_err(|error| format!("`{line}` could not be run: {error}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("`{line}` ended with {}: {said}", output.status));
    }
    let printed = String::from_utf8_lossy(&output.stdout);
    let printed = |row: &str| {
        let row = printed.lines().find_map(|line| line.trim_start().strip_prefix(row));
        row.and_then(|row| row.split_whitespace().next()).ok_or_else(|| missing("its cost"))
    };
    let (evaluations, error) = (printed("evaluations ")?, printed("error ")?);
    let (before, rest) = section.split_once(SCENE).ok_or_else(|| missing("a scene"))?;
    let (_, rest) = rest.split_once(EVALUATIONS).ok_or_else(|| missing("what it cost"))?;
    let (_, after) = rest.split_once(".\n").ok_or_else(|| missing("an estimated error"))?;
    Ok(format!("{before}{SCENE}{evaluations}{EVALUATIONS}{error}.\n{after}"))
}
