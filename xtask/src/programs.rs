//! Checks by programs that are not part of Rust's toolchain: spelling, workflows, licences and advisories.
//!
//! They are installed as wheels, each at one version (`xtask/requirements.txt`), so that all machines find the same.

use crate::environment::{Environment, interpreter};
use crate::outcome::Outcome;
use crate::workspace::{Workspace, succeed};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The virtual environment of these programs.
const ENVIRONMENT: Environment<'_> =
    Environment { name: "checks-venv", requirements: "xtask/requirements.txt" };
/// Where `cargo deny` has its advisories from.
const ADVISORIES: &str = "https://github.com/RustSec/advisory-db";

/// The Python of the environment.
pub(crate) fn python(workspace: &Workspace) -> Result<PathBuf, String> {
    interpreter(workspace, ENVIRONMENT)
}

/// The path of a program of the environment.
fn program(workspace: &Workspace, name: &str) -> Result<PathBuf, String> {
    Ok(python(workspace)?.with_file_name(name))
}

/// `cargo xtask spelling`: misspelt words in all files, but those that `_typos.toml` names.
pub(crate) fn spelling(workspace: &Workspace) -> Outcome {
    program(workspace, "typos").and_then(|typos| succeed(&mut workspace.command(typos))).into()
}

/// `cargo xtask workflows`: the workflows are valid, their shell lines are sound, and they have no rights too many.
pub(crate) fn workflows(workspace: &Workspace) -> Outcome {
    check_workflows(workspace).into()
}

fn check_workflows(workspace: &Workspace) -> Result<(), String> {
    let shellcheck = program(workspace, "shellcheck")?;
    let mut actionlint = workspace.command(program(workspace, "actionlint")?);
    succeed(actionlint.arg("-shellcheck").arg(shellcheck))?;
    let mut zizmor = workspace.command(program(workspace, "zizmor")?);
    succeed(zizmor.args(["--offline", "--no-progress", ".github"]))
}

/// `cargo xtask dependencies`: licences, sources and banned crates of all that `Cargo.lock` names.
pub(crate) fn dependencies(workspace: &Workspace) -> Outcome {
    deny(workspace, &["bans", "licenses", "sources"])
        .and_then(|mut command| succeed(&mut command))
        .into()
}

/// `cargo xtask advisories [DATABASE]`: known defects of the crates, from the database of `RustSec`, or from a copy of
/// its repository on this machine.
pub(crate) fn advisories(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    let mut command = deny(workspace, &["advisories"])?;
    match arguments {
        [] => {}
        [copy] if Path::new(copy).is_dir() => {
            let copy = std::path::absolute(copy).map_err(|error| format!("{copy}: {error}"))?;
            command.env("GIT_CONFIG_COUNT", "1");
            command.env("GIT_CONFIG_KEY_0", format!("url.{}.insteadOf", copy.display()));
            command.env("GIT_CONFIG_VALUE_0", ADVISORIES);
        }
        _ => return Err("expected nothing, or the folder of a copy of the database".into()),
    }
    succeed(&mut command).map_err(|error| {
        format!("{error} (without a network: `cargo xtask advisories FOLDER`, with a copy of {ADVISORIES})")
    })
}

fn deny(workspace: &Workspace, checks: &[&str]) -> Result<Command, String> {
    let mut command = workspace.command(program(workspace, "cargo-deny")?);
    command.arg("check").args(checks);
    Ok(command)
}

/// `cargo xtask paper`: the paper about the package as a PDF, with the numbers of the documents.
pub(crate) fn paper(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    if !arguments.is_empty() {
        return Err("expected no argument".into());
    }
    let folder = workspace.target_path("paper");
    let mut script = workspace.command(python(workspace)?);
    script.arg("paper/build.py").arg(&folder);
    succeed(&mut script)?;
    eprintln!("xtask: {}", folder.join("paper.pdf").display());
    Ok(())
}

/// `cargo xtask recipe SDIST`: the recipe for conda-forge of a source distribution, in the target directory.
pub(crate) fn recipe(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    let [sdist] = arguments else {
        return Err("expected a source distribution, as `cargo xtask wheel` makes it".into());
    };
    let sdist = std::path::absolute(sdist).map_err(|error| format!("{sdist}: {error}"))?;
    let folder = workspace.target_path("recipe");
    let mut script = workspace.command(python(workspace)?);
    script.arg("python/conda/recipe.py").arg(sdist).arg(&folder);
    succeed(&mut script)?;
    eprintln!("xtask: {}", folder.join("recipe.yaml").display());
    Ok(())
}
