//! Where a value was written: for messages that show the place.

use std::ops::Range;
use std::sync::Arc;

/// A text with a name for messages: a file, or an option of the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Source {
    pub(super) name: String,
    pub(super) text: String,
}

/// A place in a source.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) source: Arc<Source>,
    pub(super) span: Range<usize>,
}
