//! Where things are, and how commands are run there.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The workspace that `cargo xtask` was called in.
pub(crate) struct Workspace {
    root: PathBuf,
    /// `CARGO_TARGET_DIR` made absolute, if it is set: commands run in the root, not where the
    /// caller is.
    target: Option<PathBuf>,
}

impl Workspace {
    pub(crate) fn find() -> Result<Self, String> {
        let manifest = env::var_os("CARGO_MANIFEST_DIR").ok_or("call it as `cargo xtask`")?;
        let root = Path::new(&manifest).parent().ok_or("xtask has no folder above it")?;
        let target = env::var_os("CARGO_TARGET_DIR").map(std::path::absolute).transpose();
        Ok(Self {
            root: root.to_owned(),
            target: target.map_err(|error| format!("CARGO_TARGET_DIR: {error}"))?,
        })
    }

    /// A path in the repository.
    pub(crate) fn path(&self, path: &str) -> PathBuf {
        self.root.join(path)
    }

    /// A path in the target directory, for what can be made again.
    pub(crate) fn target_path(&self, path: &str) -> PathBuf {
        let default = || self.root.join("target");
        self.target.clone().unwrap_or_else(default).join(path)
    }

    /// A command that runs in the root. If it is Python, it writes compiled modules into the target directory, and
    /// none beside the files of the repository.
    pub(crate) fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        command.current_dir(&self.root);
        command.env("PYTHONPYCACHEPREFIX", self.target_path("python-bytecode"));
        if let Some(target) = &self.target {
            command.env("CARGO_TARGET_DIR", target);
        }
        command
    }

    /// The cargo that runs us.
    pub(crate) fn cargo(&self) -> Command {
        self.command(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
    }
}

/// The command as a line to read.
pub(crate) fn spelled(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_name();
    let words = program.into_iter().chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

/// Announces and runs a command; anything but success is an error that names it.
pub(crate) fn succeed(command: &mut Command) -> Result<(), String> {
    let line = spelled(command);
    eprintln!("xtask: {line}");
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{line}` ended with {status}")),
        Err(error) => Err(format!("`{line}` could not be run: {error}")),
    }
}
