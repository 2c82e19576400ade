//! `cargo xtask notes VERSION`: the section of a version in CHANGELOG.md, as notes of its release.

use crate::workspace::Workspace;
use std::fs;

const FILE: &str = "CHANGELOG.md";

/// Prints the notes of the version that `Cargo.toml` has.
pub(crate) fn run(workspace: &Workspace, arguments: &[&str]) -> Result<(), String> {
    let [version] = arguments else {
        return Err("expected a version, as in `cargo xtask notes 0.2.0`".into());
    };
    let read = |file: &str| {
        fs::read_to_string(workspace.path(file)).map_err(|error| format!("{file}: {error}"))
    };
    let (manifest, changes) = (read("Cargo.toml")?, read(FILE)?);
    if !manifest.lines().any(|line| line == format!("version = {version:?}")) {
        return Err(format!("version {version}: Cargo.toml has another"));
    }
    println!("{}", section(&changes, version)?);
    Ok(())
}

/// The lines below the heading of a version, such as `## 0.2.0, 2026-01-31`.
fn section<'a>(changes: &'a str, version: &str) -> Result<&'a str, String> {
    let is_of_version = |section: &&str| {
        let title = section.lines().next().unwrap_or_default();
        title.split(|c: char| !c.is_alphanumeric() && !"-+.".contains(c)).next() == Some(version)
    };
    let found = changes.split("\n## ").skip(1).find(is_of_version);
    let found = found.ok_or_else(|| format!("{FILE} has no section {version}"))?;
    let text = found.split_once('\n').map_or("", |(_, text)| text).trim();
    if text.is_empty() { Err(format!("{FILE}: section {version} is empty")) } else { Ok(text) }
}

#[cfg(test)]
mod tests {
    use super::section;

    const CHANGES: &str = "# Changelog\n\n## Unreleased\n\n- A.\n\n## 0.2.0, 2026-01-31\n\n### Added\n\n- B.\n\n\
                           ## 0.2.0-rc.1\n\n- C.\n\n## 0.1.0\n";

    #[test]
    fn a_section_ends_at_the_next() {
        assert_eq!(section(CHANGES, "0.2.0").unwrap(), "### Added\n\n- B.");
        assert_eq!(section(CHANGES, "0.2.0-rc.1").unwrap(), "- C.");
    }

    #[test]
    fn a_version_without_notes_is_refused() {
        assert_eq!(section(CHANGES, "0.3.0").unwrap_err(), "CHANGELOG.md has no section 0.3.0");
        assert_eq!(section(CHANGES, "0.1.0").unwrap_err(), "CHANGELOG.md: section 0.1.0 is empty");
    }
}
