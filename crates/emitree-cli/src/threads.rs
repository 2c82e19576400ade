//! The threads of a command.

use crate::failure::Failure;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// As many threads as the option `--threads` says; one for each core without it.
pub(crate) fn pool(threads: Option<u16>) -> Result<ThreadPool, Failure> {
    let pool = ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from));
    pool.build().map_err(|error| Failure::Request(format!("--threads: can't start them: {error}")))
}
