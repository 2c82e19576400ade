//! The steps of `cargo xtask test`, in their order: quick ones first, the tests last.

use crate::outcome::Outcome;
use crate::workspace::{Workspace, succeed};
use crate::{astropy, circles, features, package, programs, python, test_files, unit, words};

/// One check, and the subcommand that runs it alone.
pub(crate) struct Step {
    pub(crate) name: &'static str,
    pub(crate) about: &'static str,
    pub(crate) run: fn(&Workspace) -> Outcome,
}

pub(crate) const STEPS: [Step; 14] = [
    Step { name: "fmt", about: "formatting", run: fmt },
    Step { name: "words", about: "texts use the terms of docs/glossary.md", run: terms },
    Step { name: "spelling", about: "misspelt words", run: programs::spelling },
    Step {
        name: "workflows",
        about: "the workflows are valid, and have no rights too many",
        run: programs::workflows,
    },
    Step {
        name: "dependencies",
        about: "licences and sources of all crates",
        run: programs::dependencies,
    },
    Step {
        name: "circles",
        about: "no modules that use each other in a circle",
        run: import_circles,
    },
    Step {
        name: "test-files",
        about: "each file of integration tests is compiled",
        run: test_files::run,
    },
    Step { name: "lint", about: "clippy, warnings are errors", run: lint },
    Step { name: "features", about: "clippy on each feature alone", run: features::run },
    Step {
        name: "package",
        about: "manifests and licences of what is published; packed crates compile",
        run: package::run,
    },
    Step { name: "doc", about: "documentation builds, warnings are errors", run: doc },
    Step { name: "astropy", about: "NumPy and astropy read our files", run: astropy::run },
    Step { name: "python", about: "the Python package: lints, wheel, tests", run: python::run },
    Step {
        name: "unit",
        about: "unit tests, integration tests and doctests, with a total",
        run: unit::run,
    },
];

fn fmt(workspace: &Workspace) -> Outcome {
    succeed(workspace.cargo().args(["fmt", "--all", "--check"])).into()
}

fn terms(workspace: &Workspace) -> Outcome {
    words::run(workspace).into()
}

fn import_circles(workspace: &Workspace) -> Outcome {
    circles::run(workspace).into()
}

fn lint(workspace: &Workspace) -> Outcome {
    let arguments = ["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"];
    succeed(workspace.cargo().args(arguments)).into()
}

fn doc(workspace: &Workspace) -> Outcome {
    let arguments = ["doc", "--workspace", "--no-deps", "--document-private-items"];
    let mut command = workspace.cargo();
    succeed(command.args(arguments).env("RUSTDOCFLAGS", "-D warnings")).into()
}
