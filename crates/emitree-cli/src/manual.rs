//! The man pages and the completions of shells, made of the options themselves.

use crate::arguments::Arguments;
use crate::failure::Failure;
use clap::{Command, CommandFactory};
use clap_complete::Shell;
use emitree_io::{OutputFile, commit_all};
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

const SHELLS: [Shell; 5] = [Shell::Bash, Shell::Elvish, Shell::Fish, Shell::PowerShell, Shell::Zsh];

/// What follows in the page of the command itself.
const EXIT_CODES: &str = "\
.SH \"EXIT STATUS\"
.TP
0
done
.TP
1
`emitree compare`: the images differ by more than the tolerance
.TP
2
the scene, the options or an output is wrong
.TP
3
the emission rate could not be evaluated at a point, or is not finite there
.TP
4
the budget, the time or the finest level ended the method; the image was written
.TP
130
interrupted
";

/// Writes all files into a folder.
pub(crate) fn run(folder: &Path) -> Result<ExitCode, Failure> {
    std::fs::create_dir_all(folder).map_err(|error| {
        Failure::Request(format!("can't make the folder {}: {error}", folder.display()))
    })?;
    let mut command = Arguments::command();
    // Names of subcommands and options that all of them have.
    command.build();
    let mut files = Vec::new();
    let mut add = |name: String, bytes: Vec<u8>| -> Result<(), Failure> {
        files.push((OutputFile::create(folder.join(name))?, bytes));
        Ok(())
    };
    add("emitree.1".to_owned(), page(command.clone(), EXIT_CODES)?)?;
    for of in command.get_subcommands().filter(|of| !of.is_hide_set() && of.get_name() != "help") {
        let name = format!("emitree-{}", of.get_name());
        add(format!("{name}.1"), page(of.clone(), "")?)?;
    }
    for shell in SHELLS {
        let mut bytes = Vec::new();
        clap_complete::generate(shell, &mut Arguments::command(), "emitree", &mut bytes);
        add(file_name(shell), bytes)?;
    }
    let written = commit_all(files)?;
    let _ = writeln!(std::io::stdout(), "{} files in {}", written.len(), folder.display());
    Ok(ExitCode::SUCCESS)
}

/// A page, with what follows.
fn page(command: Command, end: &str) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    clap_mangen::Man::new(command).render(&mut bytes)?;
    bytes.extend_from_slice(end.as_bytes());
    Ok(bytes)
}

/// The name by which the shell finds the file.
fn file_name(shell: Shell) -> String {
    match shell {
        Shell::Bash => "emitree.bash".to_owned(),
        Shell::Elvish => "emitree.elv".to_owned(),
        Shell::Fish => "emitree.fish".to_owned(),
        Shell::PowerShell => "_emitree.ps1".to_owned(),
        _ => "_emitree".to_owned(),
    }
}
