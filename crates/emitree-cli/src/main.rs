//! The `emitree` command: from a scene file to an image.

mod arguments;
mod build;
mod failure;
mod interrupt;
mod models;
mod numbers;
mod render;
mod reproduce;
mod sweep;
mod threads;

use arguments::{Arguments, Command};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match &arguments.command {
        Command::Render(options) => render::run(options),
        Command::Sweep(options) => sweep::run(options),
        Command::Build(options) => build::run(options),
        Command::Models { name } => models::run(name.as_deref()),
        Command::Reproduce { output } => reproduce::run(output),
    };
    match result {
        Ok(code) => code,
        Err(failure) => failure.report(),
    }
}
