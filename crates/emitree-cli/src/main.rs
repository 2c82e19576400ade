//! The `emitree` command: from a scene file to an image.

mod arguments;
mod build;
mod check;
mod compare;
mod failure;
mod interrupt;
mod manual;
mod models;
mod new;
mod numbers;
mod plan;
mod progress;
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
        Command::New(options) => new::run(options),
        Command::Check(options) => check::run(options),
        Command::Render(options) => render::run(options),
        Command::Plan(options) => plan::begin(options),
        Command::Resume(options) => plan::resume(options),
        Command::Sweep(options) => sweep::run(options),
        Command::Build(options) => build::run(options),
        Command::Compare(options) => compare::run(options),
        Command::Models { name } => models::run(name.as_deref()),
        Command::Reproduce { output } => reproduce::run(output),
        Command::Manual { folder } => manual::run(folder),
    };
    match result {
        Ok(code) => code,
        Err(failure) => failure.report(),
    }
}
