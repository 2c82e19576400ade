//! How a step of `cargo xtask test` ended.

use crate::total::Total;

/// How a step ended.
pub(crate) struct Outcome {
    /// What went wrong, if anything did.
    pub(crate) result: Result<(), String>,
    /// The tests that it ran, if it counts them.
    pub(crate) total: Option<Total>,
}

impl From<Result<(), String>> for Outcome {
    fn from(result: Result<(), String>) -> Self {
        Self { result, total: None }
    }
}
