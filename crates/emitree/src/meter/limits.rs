//! How often g may be called, and until when.

use core::time::Duration;
use std::time::Instant;

/// How often g may be called, and until when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Evaluations altogether.
    pub(crate) max_evaluations: u64,
    /// Evaluations whose rates are kept in memory.
    pub(crate) max_kept: u64,
    /// Evaluations of one batch, 1 or more: a larger one is made in parts.
    pub(crate) batch_size: u64,
    /// Whether a batch is evaluated at once, however large it is.
    pub(crate) whole_batches: bool,
    /// When no call of g may begin any more, if there is a limit.
    pub(crate) deadline: Option<Deadline>,
}

/// The end of the time that a rendering may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deadline {
    at: Instant,
    /// The time that was allowed \[s\].
    pub(crate) seconds: f64,
}

impl Deadline {
    /// So many seconds from now; none if that is beyond all clocks.
    pub(crate) fn after_seconds(seconds: f64) -> Option<Self> {
        let at = Instant::now().checked_add(Duration::try_from_secs_f64(seconds).ok()?)?;
        Some(Self { at, seconds })
    }

    pub(super) fn has_passed(&self) -> bool {
        Instant::now() >= self.at
    }

    /// The share of the time that is left, 0 to 1.
    pub(super) fn share_left(&self) -> f64 {
        let left = self.at.saturating_duration_since(Instant::now());
        left.as_secs_f64() / self.seconds
    }
}
