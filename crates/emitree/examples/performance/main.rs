//! The overhead of emitree beside the emission: time, memory, and how they grow.
//!
//! `cargo run --release -p emitree --example performance -- [SECTION…]` prints the tables of the
//! sections named, or of all of them, as comma-separated values. `cargo xtask performance` runs it and
//! keeps what it prints, docs/performance.md says how it is measured.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that talks")]

mod cheap;
mod heap;
mod profile;
mod scaling;
mod table;
mod threads;
mod trees;

use std::process::ExitCode;
use table::Table;

/// What makes the tables of a section.
type Section = fn() -> Result<Vec<Table>, String>;

const SECTIONS: [(&str, Section); 5] = [
    ("profile", profile::tables),
    ("trees", trees::tables),
    ("cheap", cheap::tables),
    ("threads", threads::tables),
    ("scaling", scaling::tables),
];

fn main() -> ExitCode {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    if let Some(name) = wanted.iter().find(|name| SECTIONS.iter().all(|(known, _)| known != name)) {
        let known = SECTIONS.map(|(name, _)| name).join(", ");
        eprintln!("performance: there is no section `{name}`: expected some of {known}");
        return ExitCode::from(2);
    }
    for (name, tables) in SECTIONS {
        if !wanted.is_empty() && wanted.iter().all(|wanted| wanted != name) {
            continue;
        }
        match tables() {
            Ok(tables) => {
                println!("# section: {name}");
                tables.iter().for_each(|table| print!("{table}"));
            }
            Err(message) => {
                eprintln!("performance: section `{name}`: {message}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}
