//! `cargo xtask licences`: the licences of all code that a wheel links in, as files beside its own.
//!
//! One file has the texts of the crates, those of all systems, each text once; the other is that of the
//! standard library, as the toolchain brings it. Both are made anew for each wheel, and not in the
//! repository: they follow from `Cargo.lock` and from the toolchain.

use crate::workspace::Workspace;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The package whose dependencies are linked into a wheel, and that of the command.
const PACKAGE: &str = "emitree-python";
const COMMAND: &str = "emitree-cli";
/// Where both files are made; `license-files` of `python/pyproject.toml` includes them.
pub(crate) const FILES: [&str; 2] =
    ["python/LICENSE-DEPENDENCIES", "python/LICENSE-RUST-LIBRARY.html"];
/// What file names with licences start with, in capitals.
const NAMES: [&str; 6] = ["LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE"];
/// For crates that have no text of a licence that we may choose, and that our own file has.
const CHOSEN: &str = "Apache-2.0";

pub(crate) fn run(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    if !arguments.is_empty() {
        return Err("expected no argument".into());
    }
    write_both(workspace, PACKAGE, FILES.map(|file| workspace.path(file)))
}

/// The same files of the command, in a folder.
pub(crate) fn of_command(workspace: &Workspace, folder: &Path) -> Result<(), String> {
    let names = FILES.map(|file| Path::new(file).file_name().unwrap_or_default());
    write_both(workspace, COMMAND, names.map(|name| folder.join(name)))
}

/// Writes the licences of the crates of a package to one path, and those of the standard library to another.
fn write_both(workspace: &Workspace, package: &str, paths: [PathBuf; 2]) -> Result<(), String> {
    let apache = read(&workspace.path("LICENSE-APACHE"))?;
    let crates = linked(&metadata(workspace)?, package)?;
    write(&paths[0], &document(&crates, &apache)?)?;
    write(&paths[1], &read(&standard_library(workspace)?)?)?;
    let names = paths.map(|path| path.display().to_string());
    eprintln!("xtask: licences of {} crates in {}", crates.len(), names.join(" and "));
    Ok(())
}

/// A crate that is linked in.
#[derive(Debug)]
struct Crate {
    name: String,
    version: String,
    /// Its SPDX expression.
    licence: String,
    /// The texts of its files, in the order of their names.
    texts: Vec<String>,
}

fn metadata(workspace: &Workspace) -> Result<Value, String> {
    let mut command = workspace.cargo();
    command.args(["metadata", "--format-version", "1", "--locked"]);
    let output = command.output().map_err(|error| format!("cargo metadata: {error}"))?;
    serde_json::from_slice(&output.stdout).map_err(|error| {
        format!("cargo metadata: {error}: {}", String::from_utf8_lossy(&output.stderr))
    })
}

/// The crates that a package needs at run time, without those of the workspace, in the order of
/// their names.
fn linked(metadata: &Value, package: &str) -> Result<Vec<Crate>, String> {
    let by_id = |list: &'static [&'static str]| -> BTreeMap<&str, &Value> {
        let values = list.iter().fold(metadata, |value, key| &value[*key]);
        let values = values.as_array().into_iter().flatten();
        values.filter_map(|value| Some((value["id"].as_str()?, value))).collect()
    };
    let (packages, nodes) = (by_id(&["packages"]), by_id(&["resolve", "nodes"]));
    let start = packages.iter().find(|(_, of)| of["name"] == package);
    let mut open = vec![*start.ok_or_else(|| format!("no package {package}"))?.0];
    let mut found = BTreeSet::new();
    while let Some(id) = open.pop() {
        let node = nodes.get(id).ok_or_else(|| format!("{id}: not resolved"))?;
        for dependency in node["deps"].as_array().into_iter().flatten() {
            let mut kinds = dependency["dep_kinds"].as_array().into_iter().flatten();
            // Null: neither for tests nor for build scripts.
            if kinds.any(|kind| kind["kind"].is_null())
                && let Some(package) = dependency["pkg"].as_str()
                && found.insert(package)
            {
                open.push(package);
            }
        }
    }
    let of_others =
        found.iter().filter_map(|id| packages.get(id)).filter(|p| !p["source"].is_null());
    let mut crates = of_others.map(|package| described(package)).collect::<Result<Vec<_>, _>>()?;
    crates.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    Ok(crates)
}

/// A crate with the texts of its folder.
fn described(package: &Value) -> Result<Crate, String> {
    let text = |key: &str| package[key].as_str().unwrap_or_default().to_owned();
    let manifest = PathBuf::from(text("manifest_path"));
    let folder = manifest.parent().ok_or("a manifest without a folder")?;
    let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let is_licence = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_uppercase();
        path.is_file() && NAMES.iter().any(|start| name.starts_with(start))
    };
    let mut files: Vec<PathBuf> =
        entries.flatten().map(|entry| entry.path()).filter(is_licence).collect();
    if let Some(file) = package["license_file"].as_str() {
        files.push(folder.join(file));
    }
    files.sort();
    files.dedup();
    let mut texts = files.iter().map(|file| read(file)).collect::<Result<Vec<_>, _>>()?;
    if texts.is_empty() && text("license") == "MIT" {
        texts.push(mit(&holders(package)));
    }
    Ok(Crate { name: text("name"), version: text("version"), licence: text("license"), texts })
}

/// Those whom a crate without a text names: its authors, or else those of its repository.
fn holders(package: &Value) -> String {
    let authors = package["authors"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let authors: Vec<&str> = authors.collect();
    let name = package["name"].as_str().unwrap_or_default();
    if authors.is_empty() { format!("the authors of {name}") } else { authors.join(", ") }
}

/// The licence of MIT (<https://spdx.org/licenses/MIT.html>), for crates that bring no text of it.
fn mit(holders: &str) -> String {
    let own = include_str!("../../LICENSE-MIT");
    let lines = own.lines().map(|line| match line.strip_prefix("Copyright") {
        Some(_) => format!("Copyright (c) {holders}"),
        None => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A list of all crates, and each text once, below the names of the crates that have it.
fn document(crates: &[Crate], apache: &str) -> Result<String, String> {
    let mut list = String::new();
    let mut texts = BTreeMap::<&str, Vec<&str>>::new();
    for Crate { name, version, licence, texts: of_crate } in crates {
        list.push_str(&format!("{name} {version}: {licence}\n"));
        let is_choice = licence.split([' ', '/']).any(|word| word == CHOSEN);
        let is_ours_enough = is_choice && !licence.contains("AND");
        if of_crate.is_empty() && !is_ours_enough {
            return Err(format!("{name} {version}: no text of its licence `{licence}`"));
        }
        let of_crate = of_crate.iter().map(|text| text.trim());
        let none = std::iter::once(apache.trim()).filter(|_| of_crate.len() == 0);
        for text in of_crate.clone().chain(none) {
            texts.entry(text).or_default().push(name);
        }
    }
    let mut blocks: Vec<(Vec<&str>, &str)> =
        texts.into_iter().map(|(text, names)| (names, text)).collect();
    blocks.sort();
    let line = "=".repeat(80);
    let mut document = format!(
        "Crates that are linked into emitree, on any system, and their licences.\n\
         Where there is a choice and a crate brings no text, it is {CHOSEN}. The texts follow the list.\n\n{list}"
    );
    for (mut names, text) in blocks {
        names.dedup();
        document.push_str(&format!("\n{line}\n{}\n{line}\n\n{text}\n", names.join(", ")));
    }
    Ok(document)
}

/// The notices of the standard library, where the toolchain has them.
fn standard_library(workspace: &Workspace) -> Result<PathBuf, String> {
    let output = workspace.command("rustc").args(["--print", "sysroot"]).output();
    let output = output.map_err(|error| format!("rustc --print sysroot: {error}"))?;
    let folder = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    Ok(folder.join("share/doc/rust/COPYRIGHT-library.html"))
}

/// A text; of old files, what is UTF-8 of it.
fn read(path: &Path) -> Result<String, String> {
    let bytes = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(String::from_utf8_lossy(&bytes).replace("\r\n", "\n"))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn with_texts(name: &str, licence: &str, texts: &[&str]) -> Crate {
        let texts = texts.iter().map(|&text| text.to_owned()).collect();
        Crate { name: name.into(), version: "1.0.0".into(), licence: licence.into(), texts }
    }

    #[test]
    fn each_text_is_there_once_below_the_names_of_its_crates() {
        let crates = [
            with_texts("a", "MIT", &["Same.\n"]),
            with_texts("b", "MIT OR Apache-2.0", &[]),
            with_texts("c", "MIT", &["Same."]),
        ];
        let document = document(&crates, "Apache.\n").unwrap();
        assert!(document.contains("\na 1.0.0: MIT\nb 1.0.0: MIT OR Apache-2.0\nc 1.0.0: MIT\n"));
        assert_eq!(document.matches("Same.").count(), 1);
        assert!(document.contains("\na, c\n") && document.contains("\nb\n"));
        assert!(document.ends_with("\n\nApache.\n"));
    }

    #[test]
    fn a_crate_without_a_text_is_refused_unless_there_is_a_choice() {
        for licence in ["BSD-3-Clause", "(MIT OR Apache-2.0) AND Unicode-3.0"] {
            let refused = document(&[with_texts("a", licence, &[])], "Apache.").unwrap_err();
            assert_eq!(refused, format!("a 1.0.0: no text of its licence `{licence}`"));
        }
    }

    #[test]
    fn dependencies_for_tests_and_our_own_crates_are_not_linked_in() {
        let folder = std::env::temp_dir().join(format!("xtask-licences-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("LICENSE-MIT"), "Text.\r\n").unwrap();
        let package = |name: &str, source: Value| {
            json!({ "id": name, "name": name, "version": "1.0.0", "license": "MIT", "source": source,
                "manifest_path": folder.join("Cargo.toml") })
        };
        let needs =
            |name: &str, kind: Value| json!({ "pkg": name, "dep_kinds": [{ "kind": kind }] });
        let metadata = json!({
            "packages": [package(PACKAGE, Value::Null), package("ours", Value::Null),
                package("linked", json!("there")), package("tests", json!("there"))],
            "resolve": { "nodes": [
                { "id": PACKAGE, "deps": [needs("ours", Value::Null), needs("tests", json!("dev"))] },
                { "id": "ours", "deps": [needs("linked", Value::Null)] },
                { "id": "linked", "deps": [] },
            ] },
        });
        let found = linked(&metadata, PACKAGE);
        fs::remove_dir_all(&folder).unwrap();
        let found = found.unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].name.as_str(), &found[0].texts[..]),
            ("linked", &["Text.\n".into()][..])
        );
    }
}
