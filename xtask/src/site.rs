//! `cargo xtask site`: the documentation site, in a folder that opens without a server.
//!
//! Its pages are parts of the documents of the repository (`docs/site/pages.py`), its reference of Python is
//! made of docstrings, its notebooks are executed, and the documentation of the crates is beside them.

use crate::environment::{Environment, empty_folder, interpreter};
use crate::python;
use crate::workspace::{Workspace, succeed};
use std::fs;
use std::path::Path;

/// In the target directory: sources and pages.
const FOLDER: &str = "site";
/// The crates whose documentation the page of Rust links to.
const CRATES: [&str; 4] = ["emitree", "emitree-instrument", "emitree-io", "emitree-models"];

/// Builds the site, with the package of a given wheel or of one that is built from the sources.
pub(crate) fn run(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    let wheel = match arguments {
        [] => None,
        [wheel] => Some(std::path::absolute(wheel).map_err(|error| format!("{wheel}: {error}"))?),
        _ => return Err("expected nothing or the path of a wheel".into()),
    };
    let python = interpreter(
        workspace,
        Environment { name: "site-venv", requirements: "docs/site/requirements.txt" },
    )?;
    python::lint(workspace, &python, "docs/site")?;
    succeed(workspace.command(&python).args([
        "-m",
        "pytest",
        "-p",
        "no:cacheprovider",
        "-W",
        "error",
        "docs/site/tests",
    ]))?;
    match wheel {
        Some(wheel) => python::install_wheel(workspace, &python, &wheel)?,
        None => python::install(workspace, &python, "site-wheel", &[])?,
    }
    let folder = empty_folder(workspace, FOLDER)?;
    let (sources, pages) = (folder.join("sources"), folder.join("html"));
    script(workspace, &python, "docs/site/pages.py", &sources)?;
    // References that lead nowhere are warnings, and warnings are errors.
    let strict = ["-m", "sphinx", "--nitpicky", "--fail-on-warning", "--keep-going", "--quiet"];
    let mut sphinx = workspace.command(&python);
    sphinx.args(strict).args(["--builder", "html", "--conf-dir", "docs/site", "--doctree-dir"]);
    sphinx.arg(folder.join("doctrees")).arg(&sources).arg(&pages);
    succeed(&mut sphinx)?;
    rust(workspace, &pages)?;
    script(workspace, &python, "docs/site/check.py", &pages)?;
    eprintln!("xtask: the site is {}", pages.join("index.html").display());
    Ok(())
}

/// Runs a script of the site on a folder.
fn script(workspace: &Workspace, python: &Path, script: &str, folder: &Path) -> Result<(), String> {
    let mut command = workspace.command(python);
    succeed(command.arg(script).arg(folder))
}

/// The documentation of the crates, moved to a folder of the site.
fn rust(workspace: &Workspace, pages: &Path) -> Result<(), String> {
    // Whatever else was documented before would be in its index.
    let made = empty_folder(workspace, "doc")?;
    let mut doc = workspace.cargo();
    doc.args(["doc", "--no-deps"]);
    CRATES.iter().for_each(|name| {
        doc.args(["--package", name]);
    });
    succeed(doc.env("RUSTDOCFLAGS", "-D warnings"))?;
    let place = pages.join("rust");
    fs::rename(&made, &place).map_err(|error| format!("{}: {error}", place.display()))
}
