//! `cargo xtask performance`: the overhead of emitree beside the emission, measured by the example
//! `performance` of the crate `emitree`, and the time beside that of lines of sight, by the example
//! `lines_of_sight` of `emitree-io`.
//!
//! Not a step of `cargo xtask test`: it takes minutes, and its seconds are those of the machine.

use crate::environment::{Environment, interpreter};
use crate::grouped::grouped;
use crate::python::lint;
use crate::workspace::{Workspace, spelled, succeed};
use std::fs;
use std::process::{Command, Stdio};
use std::time::{SystemTime, UNIX_EPOCH};

/// The folder of the plots.
const FOLDER: &str = "bench/performance";
/// Where tables are read.
const DOCUMENT: &str = "docs/performance.md";
/// The section whose numbers are plotted.
const PLOTTED: &str = "scaling";
/// The section of scene files, with their tolerance: images without energies whose tolerance is that of the
/// largest pixel. References are kept.
const SCENES: &str = "scenes";
const TOLERANCE: &str = "0.01";
const REFERENCES: &str = "target/references";
const FILES: [&str; 22] = [
    "examples/airglow.toml",
    "examples/beta_model.toml",
    "examples/ena.toml",
    "examples/geocorona.toml",
    "examples/helix.toml",
    "examples/holmstrom.toml",
    "examples/k_corona.toml",
    "examples/mars_hydrogen.toml",
    "examples/shell_nebula.toml",
    "examples/smile.toml",
    "examples/smile_jorgensen.toml",
    "examples/uniform.toml",
    "bench/scenes/ball.toml",
    "bench/scenes/bar.toml",
    "bench/scenes/cavities.toml",
    "bench/scenes/comet.toml",
    "bench/scenes/loops.toml",
    "bench/scenes/spiral.toml",
    "bench/scenes/supernova.toml",
    "bench/scenes/swcx.toml",
    "bench/scenes/torus_inside.toml",
    "bench/scenes/turbulence.toml",
];

/// Runs the sections named (all of them if none is), keeps their numbers as
/// `bench/runs/performance-SECTION.csv`, writes their tables into `docs/performance.md` and draws the
/// plots.
pub(crate) fn run(workspace: &Workspace, sections: &[&str]) -> Result<(), String> {
    let others: Vec<&str> = sections.iter().copied().filter(|name| *name != SCENES).collect();
    let mut printed = String::new();
    if sections.is_empty() || !others.is_empty() {
        let mut command = workspace.cargo();
        command.args([
            "run",
            "--profile",
            "dist",
            "-p",
            "emitree",
            "--example",
            "performance",
            "--",
        ]);
        printed.push_str(&output_of(command.args(others))?);
    }
    if sections.is_empty() || sections.contains(&SCENES) {
        let mut command = workspace.cargo();
        command.args(["run", "--release", "-p", "emitree-io", "--example", "lines_of_sight", "--"]);
        command.args(["table", TOLERANCE]).arg(workspace.path(REFERENCES)).args(FILES);
        printed.push_str(&output_of(&mut command)?);
    }

    let head = head(workspace, &[&["cargo xtask performance"], sections].concat().join(" "));
    let document = workspace.path(DOCUMENT);
    let in_document = |error| format!("{}: {error}", document.display());
    let mut text = fs::read_to_string(&document).map_err(in_document)?;
    let measured = sections_of(&printed);
    for (name, numbers) in &measured {
        let path = workspace.path(&format!("bench/runs/performance-{name}.csv"));
        let in_file = |error| format!("{}: {error}", path.display());
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(in_file)?;
        }
        fs::write(&path, format!("{head}{numbers}")).map_err(in_file)?;
        text = with_block(DOCUMENT, &text, name, &markdown(numbers))?;
    }
    fs::write(&document, text).map_err(in_document)?;
    if measured.iter().any(|(name, _)| *name == PLOTTED) {
        plot(workspace)?;
    }
    Ok(())
}

/// What a command prints.
fn output_of(command: &mut Command) -> Result<String, String> {
    let line = spelled(command);
    eprintln!("xtask: {line}");
    let output = command.stderr(Stdio::inherit()).output();
    let output = output.map_err(|error| format!("`{line}` could not be run: {error}"))?;
    if !output.status.success() {
        return Err(format!("`{line}` ended with {}", output.status));
    }
    String::from_utf8(output.stdout).map_err(|error| format!("`{line}`: {error}"))
}

/// Draws the plots of the numbers kept.
fn plot(workspace: &Workspace) -> Result<(), String> {
    let requirements = format!("{FOLDER}/requirements.txt");
    let python = interpreter(
        workspace,
        Environment { name: "performance-venv", requirements: &requirements },
    )?;
    lint(workspace, &python, FOLDER)?;
    let mut command = workspace.command(&python);
    command.arg(format!("{FOLDER}/plots.py"));
    command.arg(format!("bench/runs/performance-{PLOTTED}.csv")).arg("docs/images");
    succeed(&mut command)
}

/// The sections in what the example printed, with what is theirs.
fn sections_of(printed: &str) -> Vec<(&str, &str)> {
    let sections = printed.split("# section: ").skip(1);
    sections.filter_map(|section| section.split_once('\n')).collect()
}

/// The `text` of a document with `block` between the markers of `name`.
pub(crate) fn with_block(
    document: &str,
    text: &str,
    name: &str,
    block: &str,
) -> Result<String, String> {
    let [begin, end] = ["begin", "end"].map(|which| format!("<!-- {name}: {which} -->"));
    let parts = text.split_once(&begin).and_then(|(before, rest)| {
        let (_, after) = rest.split_once(&end)?;
        Some((before, after))
    });
    let (before, after) =
        parts.ok_or_else(|| format!("{document}: expected `{begin}` and, after it, `{end}`"))?;
    Ok(format!("{before}{begin}\n\n{block}\n{end}{after}"))
}

/// The tables of a section as Markdown.
fn markdown(numbers: &str) -> String {
    let tables = numbers.split("# table: ").skip(1).filter_map(|table| table.split_once('\n'));
    let tables = tables.map(|(title, table)| {
        let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let columns = lines.next().unwrap_or_default();
        let rows: Vec<Vec<&str>> = lines.collect();
        let is_number = |at: usize| {
            let cells = rows.iter().filter_map(|row| row.get(at));
            cells.clone().all(|cell| *cell == "-" || cell.parse::<f64>().is_ok())
        };
        let alignments = (0..columns.len()).map(|at| if is_number(at) { "--:" } else { "---" });
        let mut text = format!("### {title}\n\n{}", row_of(columns.iter().copied()));
        text.push_str(&row_of(alignments));
        for row in &rows {
            let cells: Vec<String> = row.iter().map(|cell| readable(cell)).collect();
            text.push_str(&row_of(cells.iter().map(String::as_str)));
        }
        text
    });
    tables.collect::<Vec<_>>().join("\n")
}

fn row_of<'a>(cells: impl Iterator<Item = &'a str>) -> String {
    let cells: Vec<&str> = cells.collect();
    format!("| {} |\n", cells.join(" | "))
}

/// A whole number with a comma at each thousand; all else as it is.
fn readable(cell: &str) -> String {
    cell.parse().map_or_else(|_| cell.to_owned(), grouped)
}

/// Where, from what, how and when numbers were made, as comments.
fn head(workspace: &Workspace, command: &str) -> String {
    let (machine, commit, date) = (machine(), commit(workspace), date());
    format!("# machine: {machine}\n# commit: {commit}\n# command: {command}\n# date: {date}\n")
}

/// The processor, its cores and the memory, as far as the system reports them.
fn machine() -> String {
    let value = |file: &str, key: &str| {
        let text = fs::read_to_string(file).ok()?;
        let line = text.lines().find(|line| line.starts_with(key))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    let unknown = || "unknown processor".to_owned();
    let processor = value("/proc/cpuinfo", "model name").unwrap_or_else(unknown);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let memory = value("/proc/meminfo", "MemTotal").unwrap_or_else(|| "unknown".to_owned());
    format!("{processor}; {cores} cores; {memory} memory")
}

/// The commit that is checked out, and whether files differ from it.
fn commit(workspace: &Workspace) -> String {
    let git = |arguments: &[&str]| {
        let output =
            workspace.command("git").args(arguments).stderr(Stdio::null()).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| text.trim().to_owned())
    };
    let Some(commit) = git(&["rev-parse", "HEAD"]) else { return "unknown".to_owned() };
    let clean = git(&["status", "--porcelain"]).is_some_and(|changes| changes.is_empty());
    if clean { commit } else { format!("{commit}-dirty") }
}

/// Today, in UTC.
fn date() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let [year, month, day] = date_of(since.as_secs() / 86_400);
    format!("{year}-{month:02}-{day:02}")
}

/// The year, the month and the day that come so many days after 1970-01-01.
fn date_of(days: u64) -> [u64; 3] {
    // Counted from 0000-03-01: years end with their leap day, and 400 of them have 146 097 days.
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    // From March on, five months have 153 days.
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    [400 * era + year + next, month, day]
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRINTED: &str = "# section: one\n# table: First\nname,n\na,1234567\nb,-\n\
        # table: Second\nx\n0.5\n# section: two\n# table: Third\nx\n1\n";

    #[test]
    fn sections_become_tables() {
        let sections = sections_of(PRINTED);
        assert_eq!(sections.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["one", "two"]);
        let expected = "### First\n\n| name | n |\n| --- | --: |\n| a | 1,234,567 |\n| b | - |\n\n\
            ### Second\n\n| x |\n| --: |\n| 0.5 |\n";
        assert_eq!(markdown(sections[0].1), expected);
    }

    #[test]
    fn a_block_is_replaced_and_nothing_else() {
        let text = "before\n<!-- a: begin -->\nold\n<!-- a: end -->\nafter <!-- b: begin -->";
        let expected =
            "before\n<!-- a: begin -->\n\nnew\n\n<!-- a: end -->\nafter <!-- b: begin -->";
        assert_eq!(with_block("d", text, "a", "new\n").unwrap(), expected);
        assert_eq!(with_block("d", expected, "a", "new\n").unwrap(), expected);
        let error = with_block("d", text, "b", "new").unwrap_err();
        assert!(error.contains("`<!-- b: begin -->` and, after it, `<!-- b: end -->`"), "{error}");
    }

    #[test]
    fn whole_numbers_are_grouped() {
        assert_eq!(
            ["999", "1000", "123456", "0.00012", "1e-12"].map(readable),
            ["999", "1,000", "123,456", "0.00012", "1e-12"]
        );
    }

    #[test]
    fn dates_follow_the_calendar() {
        assert_eq!(date_of(0), [1970, 1, 1]);
        assert_eq!(date_of(11_016), [2000, 2, 29]);
        assert_eq!(date_of(11_017), [2000, 3, 1]);
        assert_eq!(date_of(20_453), [2025, 12, 31]);
    }
}
