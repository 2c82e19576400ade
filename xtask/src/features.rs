//! `cargo xtask features`: combinations of features: lints of each library with none, and with each alone.
//!
//! Everything together is what the step `lint` checks.

use crate::outcome::Outcome;
use crate::workspace::{Workspace, succeed};

/// Libraries with features, and their features.
const FEATURES: [(&str, &[&str]); 2] =
    [("emitree", &["ablate", "healpix", "rayon"]), ("emitree-io", &["figure", "hdf5"])];

pub(crate) fn run(workspace: &Workspace) -> Outcome {
    check(workspace).into()
}

fn check(workspace: &Workspace) -> Result<(), String> {
    for (library, features) in FEATURES {
        for feature in std::iter::once(&"").chain(features) {
            let choice = ["--no-default-features", "--features", feature];
            let mut command = workspace.cargo();
            command.args(["clippy", "--package", library, "--lib"]).args(choice);
            succeed(command.args(["--", "-D", "warnings"]))?;
        }
    }
    Ok(())
}
