//! `cargo xtask package`: what a registry requires of each crate to be published, in its manifest and in
//! its files; and that the files of all packages compile.
//!
//! `cargo package` would build each of them with all of its dependencies, unoptimised and from the start. Here
//! they are one workspace with the profiles of this one, which `cargo check` compiles as far as errors show, with
//! the dependencies that are there from other steps.

use crate::environment::empty_folder;
use crate::outcome::Outcome;
use crate::workspace::{Workspace, succeed};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Files that each crate has of its own: a link to the one in the root, or a copy of it.
const LICENCES: [&str; 2] = ["LICENSE-MIT", "LICENSE-APACHE"];

pub(crate) fn run(workspace: &Workspace) -> Outcome {
    check(workspace).into()
}

fn check(workspace: &Workspace) -> Result<(), String> {
    let mut command = workspace.cargo();
    command.args(["metadata", "--no-deps", "--format-version", "1"]);
    let output = command.output().map_err(|error| format!("cargo metadata: {error}"))?;
    let metadata: Value = serde_json::from_slice(&output.stdout).map_err(|error| {
        format!("cargo metadata: {error}: {}", String::from_utf8_lossy(&output.stderr))
    })?;
    let packages = list(&metadata, "packages");
    let is_published = |package: &&Value| package["publish"].is_null();
    let published: Vec<&Value> = packages.iter().filter(is_published).collect();
    let names: Vec<&str> = published.iter().map(|package| text(package, "name")).collect();
    let mut defects = Vec::new();
    for package in published {
        let of_files = files(workspace, Path::new(text(package, "manifest_path")), package);
        let found = missing_keys(package).into_iter().chain(dependencies(package, &names));
        let name = text(package, "name");
        defects.extend(found.chain(of_files).map(|defect| format!("{name}: {defect}")));
    }
    eprintln!("xtask: manifests and licences of {}", names.join(", "));
    if !defects.is_empty() {
        return Err(defects.join("; "));
    }
    let published = packages.iter().filter(is_published);
    let versions = published.map(|package| (text(package, "name"), text(package, "version")));
    compile(workspace, &versions.collect::<Vec<_>>())
}

/// Packs all crates, given their names and versions, and checks that what was packed compiles, without what
/// else is in the repository.
fn compile(workspace: &Workspace, crates: &[(&str, &str)]) -> Result<(), String> {
    let packed = empty_folder(workspace, "packages")?;
    let mut package = workspace.cargo();
    package.args(["package", "--quiet", "--no-verify", "--offline", "--allow-dirty"]);
    crates.iter().for_each(|(name, _)| {
        package.args(["--package", name]);
    });
    succeed(package.arg("--target-dir").arg(&packed))?;
    let unpacked = empty_folder(workspace, "packages/unpacked")?;
    for (name, version) in crates {
        let archive = packed.join("package").join(format!("{name}-{version}.crate"));
        let mut unpack = workspace.command("tar");
        // With `m` files are as new as they are: those of the archive always have the same time, and cargo would not
        // compile what has changed.
        succeed(unpack.arg("-xmzf").arg(archive).arg("-C").arg(&unpacked))?;
    }
    let in_folder = |error| format!("{}: {error}", unpacked.display());
    let root = workspace.path("Cargo.toml");
    let root = fs::read_to_string(&root).map_err(|error| format!("{}: {error}", root.display()))?;
    fs::write(unpacked.join("Cargo.toml"), manifest(crates, profiles(&root))).map_err(in_folder)?;
    fs::copy(workspace.path("Cargo.lock"), unpacked.join("Cargo.lock")).map_err(in_folder)?;
    let mut check = workspace.cargo();
    check.args(["check", "--quiet", "--workspace", "--offline", "--target-dir"]);
    succeed(check.arg(workspace.target_path("")).current_dir(&unpacked))
}

/// The profiles of a manifest, which has them last: without them cargo would compile all dependencies again.
fn profiles(manifest: &str) -> &str {
    manifest.find("\n[profile.").map_or("", |start| &manifest[start..])
}

/// The manifest of a workspace of unpacked crates, which depend on each other as on crates of a registry.
fn manifest(crates: &[(&str, &str)], profiles: &str) -> String {
    let folders = crates.iter().map(|(name, version)| (name, format!("{name}-{version}")));
    let members: Vec<String> = folders.clone().map(|(_, folder)| format!("{folder:?}")).collect();
    let patches = folders.map(|(name, folder)| format!("{name}.path = {folder:?}\n"));
    let patches: String = patches.collect();
    let members = members.join(", ");
    format!(
        "[workspace]\nresolver = \"3\"\nmembers = [{members}]\n\n[patch.crates-io]\n{patches}{profiles}"
    )
}

/// Keys that a manifest lacks.
fn missing_keys(package: &Value) -> Vec<String> {
    let keys = ["description", "license", "readme", "rust_version"].into_iter();
    let lacks = |key: &&str| text(package, key).is_empty();
    let mut missing: Vec<String> = keys.filter(lacks).map(|key| format!("no {key}")).collect();
    for key in ["keywords", "categories"] {
        if list(package, key).is_empty() {
            missing.push(format!("no {key}"));
        }
    }
    if package["metadata"]["docs"]["rs"]["all-features"] != true {
        missing.push("no all-features in package.metadata.docs.rs".to_owned());
    }
    missing
}

/// Dependencies in the workspace that a registry would refuse.
fn dependencies(package: &Value, published: &[&str]) -> Vec<String> {
    let of_workspace =
        list(package, "dependencies").iter().filter(|dependency| dependency["path"].is_string());
    let defect = |dependency: &Value| {
        let name = text(dependency, "name");
        let has_version = text(dependency, "req") != "*";
        match dependency["kind"].as_str() {
            // Cargo leaves those without a version out of the package, others must be published before.
            Some("dev") if has_version => Some(format!("dev-dependency {name} has a version")),
            Some("dev") => None,
            _ if !published.contains(&name) => {
                Some(format!("needs {name}, which is not published"))
            }
            _ if !has_version => Some(format!("dependency {name} has no version")),
            _ => None,
        }
    };
    of_workspace.filter_map(defect).collect()
}

/// Files beside a manifest that are missing or not what they should be.
fn files(workspace: &Workspace, manifest: &Path, package: &Value) -> Vec<String> {
    let beside = |file: &str| fs::read(manifest.with_file_name(file)).unwrap_or_default();
    let is_wrong = |licence: &&str| {
        let wanted = fs::read(workspace.path(licence)).unwrap_or_default();
        wanted.is_empty() || beside(licence) != wanted
    };
    let wrong = LICENCES.into_iter().filter(is_wrong);
    let mut defects: Vec<String> =
        wrong.map(|licence| format!("{licence} is not that of the root")).collect();
    if beside(text(package, "readme")).is_empty() {
        defects.push("the readme is missing or empty".to_owned());
    }
    defects
}

/// A text, empty if there is none.
fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_default()
}

/// A list, empty if there is none.
fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn keys_that_are_missing_are_named() {
        let mut package = json!({
            "description": "d", "license": "MIT", "readme": "README.md", "rust_version": "1.93",
            "keywords": ["a"], "categories": ["b"],
            "metadata": { "docs": { "rs": { "all-features": true } } },
        });
        assert!(missing_keys(&package).is_empty());
        package["license"] = Value::Null;
        package["keywords"] = json!([]);
        package["metadata"] = Value::Null;
        let expected = ["no license", "no keywords", "no all-features in package.metadata.docs.rs"];
        assert_eq!(missing_keys(&package), expected);
    }

    #[test]
    fn unpacked_crates_are_a_workspace() {
        let expected = "[workspace]\nresolver = \"3\"\nmembers = [\"a-0.1.0\", \"b-0.2.0\"]\n\n\
                        [patch.crates-io]\na.path = \"a-0.1.0\"\nb.path = \"b-0.2.0\"\n\n\
                        [profile.dev]\nopt-level = 2\n";
        let root = "[workspace]\n\n[profile.dev]\nopt-level = 2\n";
        assert_eq!(manifest(&[("a", "0.1.0"), ("b", "0.2.0")], profiles(root)), expected);
    }

    #[test]
    fn dependencies_that_are_not_published_are_named() {
        let dependency = |name: &str, req: &str, kind: Option<&str>| json!({ "name": name, "req": req, "kind": kind, "path": "/somewhere" });
        let package = json!({ "dependencies": [
            dependency("a", "^0.1.0", None),
            dependency("tests", "*", Some("dev")),
            dependency("a", "^0.1.0", Some("dev")),
            dependency("tests", "^0.1.0", None),
            dependency("a", "*", None),
            { "name": "rayon", "req": "^1", "kind": null },
        ] });
        let expected = [
            "dev-dependency a has a version",
            "needs tests, which is not published",
            "dependency a has no version",
        ];
        assert_eq!(dependencies(&package, &["a"]), expected);
    }
}
