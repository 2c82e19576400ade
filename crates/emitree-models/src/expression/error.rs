//! What is wrong with an expression, and where; and at which points it has no value.

use crate::grid::OutsideGrid;
use crate::table::OutsideTable;
use core::ops::Range;

/// An expression that can't be parsed: what is wrong, where, and what to write instead.
///
/// Its `Display` is the [`message`](Self::message) alone; a scene reader underlines the
/// [`span`](Self::span) and adds the [`help`](Self::help).
///
/// ```
/// use emitree_models::Expression;
/// use std::collections::BTreeMap;
///
/// let error = Expression::parse("1 + cosine(x)", &BTreeMap::new()).unwrap_err();
/// assert_eq!(error.message(), "unknown function `cosine`");
/// assert_eq!(error.span(), 4..10);
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
#[non_exhaustive]
pub struct ExpressionError {
    message: String,
    span: Range<usize>,
    help: Option<String>,
}

impl ExpressionError {
    pub(super) fn new(message: impl Into<String>, span: Range<usize>) -> Self {
        Self { message: message.into(), span, help: None }
    }

    pub(super) fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// What is wrong, in one sentence without its place.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// Where, in bytes of the expression's text; empty at its start if the fault lies in the
    /// constants.
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// What would be right, where that can be said.
    pub fn help(&self) -> Option<&str> {
        self.help.as_deref()
    }
}

/// A point at which an expression of fields and tables has no rate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldFailure {
    /// A position outside of a field with [`Outside::Error`](crate::Outside::Error).
    #[error("the field `{field}`: {cause}")]
    Field {
        /// The name of the field.
        field: String,
        /// The position, and the range of the grid.
        #[source]
        cause: OutsideGrid,
    },
    /// An argument outside of a table with [`BeyondTable::Error`](crate::table::BeyondTable::Error).
    #[error("at the position {position:?}: {cause}")]
    Table {
        /// The position (x, y, z).
        position: [f64; 3],
        /// The table, the argument, and the range.
        #[source]
        cause: OutsideTable,
    },
}
