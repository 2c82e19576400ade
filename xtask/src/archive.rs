//! `cargo xtask archive [TARGET]`: the command for those who have no Rust toolchain: a file with the program, its
//! man pages, the completions of shells and all licences.

use crate::environment::empty_folder;
use crate::licences;
use crate::workspace::{Workspace, spelled, succeed};
use std::env::consts::EXE_SUFFIX;
use std::fs;
use std::path::Path;
use std::process::Command;

/// In the target directory.
const FOLDER: &str = "archive";
/// Files of the repository that go with the program.
const FILES: [&str; 4] = ["CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT", "python/LICENSE-DEJAVU"];

/// Builds for the machine that runs it, or for a target that it can run.
pub(crate) fn run(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    let target = match arguments {
        [] => host(workspace)?,
        [target] => (*target).to_owned(),
        _ => return Err("expected nothing, or a target such as x86_64-unknown-linux-musl".into()),
    };
    let mut build = workspace.cargo();
    build.args(["build", "--locked", "--profile", "dist", "--package", "emitree-cli", "--target"]);
    succeed(build.arg(&target))?;
    let program = format!("emitree{EXE_SUFFIX}");
    let built = workspace.target_path(&format!("{target}/dist/{program}"));
    let version = answer(workspace.command(&built).arg("--version"))?.replace(' ', "-");
    let name = format!("{version}-{target}");
    let folder = empty_folder(workspace, FOLDER)?;
    let inside = folder.join(&name);
    fs::create_dir(&inside).map_err(|error| format!("{}: {error}", inside.display()))?;
    copy(&built, &inside.join(&program))?;
    for file in FILES {
        let place = Path::new(file).file_name().map(|name| inside.join(name));
        copy(&workspace.path(file), &place.unwrap_or_else(|| inside.clone()))?;
    }
    copy(&workspace.path("crates/emitree-cli/README.md"), &inside.join("README.md"))?;
    licences::of_command(workspace, &inside)?;
    let manual = inside.join("manual");
    fs::create_dir(&manual).map_err(|error| format!("{}: {error}", manual.display()))?;
    succeed(workspace.command(&built).arg("manual").arg(manual))?;
    let archive = format!("{name}.tar.gz");
    // Names without a drive of Windows, which `tar` takes for that of a machine.
    let mut pack = workspace.command("tar");
    succeed(pack.args(["-czf", &archive, &name]).current_dir(&folder))?;
    try_it(workspace, &folder, &archive, &format!("{name}/{program}"))?;
    let archive = folder.join(archive);
    eprintln!("xtask: {}", archive.display());
    Ok(())
}

/// Unpacks the archive elsewhere, and renders a new scene with its program.
fn try_it(
    workspace: &Workspace,
    folder: &Path,
    archive: &str,
    program: &str,
) -> Result<(), String> {
    let place = empty_folder(workspace, "archive-test")?;
    copy(&folder.join(archive), &place.join(archive))?;
    succeed(workspace.command("tar").args(["-xzf", archive]).current_dir(&place))?;
    let program = place.join(program);
    for arguments in [&["new"][..], &["check", "scene.toml"], &["render", "scene.toml"]] {
        succeed(workspace.command(&program).args(arguments).current_dir(&place))?;
    }
    Ok(())
}

/// The target of the toolchain.
fn host(workspace: &Workspace) -> Result<String, String> {
    let about = answer(workspace.command("rustc").arg("-vV"))?;
    let host = about.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "`rustc -vV` names no host".to_owned())
}

/// What a command prints.
fn answer(command: &mut Command) -> Result<String, String> {
    let line = spelled(command);
    let output = command.output().map_err(|error| format!("`{line}`: {error}"))?;
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned()),
        false => Err(format!("`{line}` ended with {}", output.status)),
    }
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    fs::copy(from, to).map_err(|error| format!("{}: {error}", from.display()))?;
    Ok(())
}
