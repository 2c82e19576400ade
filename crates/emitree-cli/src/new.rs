//! `emitree new`: a commented scene to start from.

use crate::arguments::NewArguments;
use crate::failure::Failure;
use emitree_io::{SceneTemplate, scene_templates};
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The name of a scene without one.
const SCENE: &str = "scene.toml";

pub(crate) fn run(arguments: &NewArguments) -> Result<ExitCode, Failure> {
    let mut stdout = std::io::stdout().lock();
    if arguments.list {
        let width = scene_templates().iter().map(|of| of.name.len()).max().unwrap_or(0);
        for template in scene_templates() {
            writeln!(stdout, "{:width$}  {}", template.name, template.summary())?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let template = template(&arguments.template)?;
    let path = path(arguments.name.as_deref().unwrap_or(SCENE.as_ref()))?;
    let name = path.display();
    write(&path, template.text_for(&name.to_string()).as_bytes())?;
    // The file is written: a hint without a reader is not a failure.
    let _ = writeln!(
        stdout,
        "{name}: {}\n  next         emitree check {name}, emitree render {name}",
        template.summary()
    );
    Ok(ExitCode::SUCCESS)
}

fn template(name: &str) -> Result<&'static SceneTemplate, Failure> {
    scene_templates().iter().find(|template| template.name == name).ok_or_else(|| {
        let names: Vec<&str> = scene_templates().iter().map(|template| template.name).collect();
        let names = names.join(", ");
        Failure::Request(format!("--template: unknown template `{name}`: expected one of {names}"))
    })
}

/// The path with an ending.
fn path(name: &Path) -> Result<PathBuf, Failure> {
    let refuse = |why: &str| {
        let why = format!("`{}`: {why}: expected a name such as {SCENE}", name.display());
        Err(Failure::Request(why))
    };
    match name.extension() {
        None if name.file_name().is_none() || ends_in_separator(name) => refuse("names no file"),
        None => Ok(name.with_extension("toml")),
        Some(ending) if ending.eq_ignore_ascii_case("toml") => Ok(name.to_owned()),
        Some(_) => refuse("scenes are TOML files"),
    }
}

/// Whether a path is written as that of a folder: `scenes/`.
fn ends_in_separator(path: &Path) -> bool {
    path.as_os_str().to_string_lossy().ends_with(std::path::is_separator)
}

/// Writes a file that does not exist yet.
fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let name = path.display();
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    let mut file = file.map_err(|error| {
        Failure::Request(match error.kind() {
            ErrorKind::AlreadyExists => {
                format!("{name} exists, and is left as it is: expected a new name")
            }
            _ => format!("can't write {name}: {error}"),
        })
    })?;
    file.write_all(bytes).map_err(|error| {
        // Half a scene is of no use.
        let _ = std::fs::remove_file(path);
        Failure::Request(format!("can't write {name}: {error}"))
    })
}
