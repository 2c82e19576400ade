//! The checks of emitree: `cargo xtask test` runs them all, the other subcommands one each.
//!
//! Needed: a Rust toolchain with rustfmt and clippy, python3 with venv and pip, and the network for
//! the packages that are not there yet.

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a tool that prints to its terminal"
)]

mod ablate;
mod archive;
mod astropy;
mod circles;
mod environment;
mod errors;
mod features;
mod fuzz;
mod gallery;
// Shared with the messages of the command.
#[expect(unreachable_pub, reason = "it is public there")]
#[path = "../../crates/emitree-io/src/grouped.rs"]
mod grouped;
mod licences;
mod manual;
mod notes;
mod outcome;
mod package;
mod peers;
mod performance;
mod programs;
mod python;
mod quick;
mod site;
mod step;
mod test_files;
mod total;
mod unit;
mod versions;
mod wheel;
mod words;
mod workspace;

use environment::Environment;
use outcome::Outcome;
use std::io::{self, Write};
use std::process::ExitCode;
use std::time::Instant;
use step::{STEPS, Step};
use workspace::Workspace;

/// What takes arguments, returns why it failed, and is no part of `cargo xtask test`.
type Tool = fn(&Workspace, &[&str]) -> Result<(), String>;

const TOOLS: [(&str, Tool); 19] = [
    ("ablate", ablate::run),
    ("advisories", programs::advisories),
    ("archive", archive::run),
    ("compare-peers", peers::run),
    ("errors", errors::run),
    ("fuzz", fuzz::run),
    ("gallery", gallery::run),
    ("licences", licences::run),
    ("manual", manual::run),
    ("msrv", versions::msrv),
    ("notes", notes::run),
    ("oldest", versions::oldest),
    ("paper", programs::paper),
    ("performance", performance::run),
    ("quick", quick::run),
    ("recipe", programs::recipe),
    ("semver", versions::semver),
    ("site", site::run),
    ("wheel", wheel::run),
];

/// The environments of the last steps.
const LATER: [Environment<'_>; 2] = [astropy::ENVIRONMENT, python::ENVIRONMENT];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    if let [name, arguments @ ..] = &words[..]
        && let Some((_, tool)) = TOOLS.iter().find(|(tool, _)| tool == name)
    {
        let done = Workspace::find().and_then(|workspace| tool(&workspace, arguments));
        return done.map_or_else(|message| failure(&message), |()| ExitCode::SUCCESS);
    }
    let step = |name: &str| STEPS.iter().find(|step| step.name == name).map(std::slice::from_ref);
    let steps = match words[..] {
        [] | ["help" | "--help" | "-h"] => {
            print!("{}", help());
            return ExitCode::SUCCESS;
        }
        ["test"] => Some(&STEPS[..]),
        [name] => step(name),
        _ => None,
    };
    let steps = match steps {
        Some(steps) => steps,
        None => {
            eprint!("xtask: unknown command `{}`\n\n{}", words.join(" "), help());
            return ExitCode::from(2);
        }
    };
    let workspace = match Workspace::find() {
        Ok(workspace) => workspace,
        Err(message) => return failure(&message),
    };
    std::thread::scope(|scope| {
        // Made by one processor, beside steps that leave one.
        if let ["test"] = words[..] {
            scope.spawn(|| environment::prepare(&workspace, &LATER));
        }
        run(steps, &workspace)
    })
}

/// Runs steps until one fails.
fn run(steps: &[Step], workspace: &Workspace) -> ExitCode {
    for step in steps {
        let start = Instant::now();
        let outcome = (step.run)(workspace);
        // Before the total, which is the last line.
        eprintln!("xtask: step `{}` took {:.0} s", step.name, start.elapsed().as_secs_f64());
        if !report(step, outcome) {
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Prints why there was nothing to report.
fn failure(message: &str) -> ExitCode {
    eprintln!("xtask: {message}");
    ExitCode::FAILURE
}

/// Prints how a step ended, its total as the last line; returns whether it passed.
fn report(step: &Step, Outcome { result, total }: Outcome) -> bool {
    let passed = result.is_ok();
    if let Err(message) = result {
        let name = step.name;
        eprintln!("xtask: step `{name}` failed: {message}. To run it alone: cargo xtask {name}");
    }
    if let Some(total) = total {
        println!("\n{total}");
    }
    // A closed terminal is not an error.
    let _ = io::stdout().flush();
    passed
}

fn help() -> String {
    let mut help = String::from(
        "cargo xtask COMMAND\n\n  test          all of the following, in this order\n",
    );
    for Step { name, about, .. } in STEPS {
        help.push_str(&format!("  {name:12}  {about}\n"));
    }
    help.push_str(
        "  help          this text\n\n\
         cargo xtask ablate [GROUP ...]\n\n  \
         renders scenes with each constant of the engine at the ends of its range, and writes\n  \
         docs/results/tuning.md, or prints the rows of the groups named; some 30 minutes\n\n\
         cargo xtask advisories [DATABASE]\n\n  \
         compares the crates with known defects, from the database of RustSec or from a copy of its repository\n\n\
         cargo xtask archive [TARGET]\n\n  \
         builds the command for those who have no Rust toolchain, with its manual and all licences, into\n  \
         target/archive, and tries it\n\n\
         cargo xtask compare-peers [NAME ...]\n\n  \
         compares emitree with other packages (bench/peers), only those or the scenes\n  \
         that are named, or with `users` what the table of users shows, and writes docs/peers.md\n\n\
         cargo xtask errors\n\n  \
         renders scenes with each kind of tolerance, and writes docs/errors.md and its pictures\n\n\
         cargo xtask fuzz [SECONDS] [SEED]\n\n  \
         reads files and renders scenes with something wrong in them, for a minute or so many seconds\n  \
         for each test, from a seed on; one failed case again: its seed, and 0 seconds\n\n\
         cargo xtask gallery [NAME ...]\n\n  \
         renders the pictures of docs/gallery.md, or only those whose headings contain a name, and writes\n  \
         what they cost there\n\n\
         cargo xtask licences\n\n  \
         writes the licences of all crates that a wheel links in, and of the standard library, to python/\n\n\
         cargo xtask manual\n\n  \
         writes the man pages and the completions of shells to target/manual\n\n\
         cargo xtask msrv\n\n  \
         checks everything with the oldest supported Rust, which has to be installed\n\n\
         cargo xtask notes VERSION\n\n  \
         prints the section of a version of CHANGELOG.md; fails if Cargo.toml has another version\n\n\
         cargo xtask oldest\n\n  \
         tries the Python package with the `python3` that is there and the oldest supported NumPy\n\n\
         cargo xtask paper\n\n  \
         builds the paper about emitree, target/paper/paper.pdf, and compares its numbers with the documents\n\n\
         cargo xtask performance [SECTION ...]\n\n  \
         measures what emitree costs beside the emission, or only the sections named, and writes\n  \
         docs/performance.md\n\n\
         cargo xtask quick\n\n  \
         formatting, lints and the short unit tests of the core, for the time between two changes\n\n\
         cargo xtask recipe SDIST\n\n  \
         writes the recipe for conda-forge of a source distribution to target/recipe, and checks it\n\n\
         cargo xtask semver [REVISION]\n\n  \
         compares the interfaces of the crates with those of the last release, or of a revision; needs\n  \
         cargo-semver-checks\n\n\
         cargo xtask site [WHEEL]\n\n  \
         builds the documentation site, target/site/html/index.html, with the package of a wheel or of\n  \
         the sources; warnings are errors\n\n\
         cargo xtask wheel [test]\n\n  \
         builds the source distribution, from it, without a network, the wheel (target/wheel), and tries that\n  \
         in a fresh environment; with `test` it runs all tests of the Python package on it\n",
    );
    help
}
