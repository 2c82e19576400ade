//! What can be wrong with a table, and with an argument.

/// Axes or values that make no table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// No axis, or too many.
    #[error("the table has {count} axes: expected 1 to 3")]
    Axes {
        /// The number of axes.
        count: usize,
    },
    /// An axis with less than two nodes.
    #[error("the axis `{axis}` has {count} node(s): expected at least 2")]
    TooFewNodes {
        /// The name of the axis.
        axis: String,
        /// Its nodes.
        count: usize,
    },
    /// A node that is NaN or infinite.
    #[error("node {index} of the axis `{axis}` is {value}: expected a finite number")]
    NodeNotFinite {
        /// The name of the axis.
        axis: String,
        /// The node, from 0.
        index: usize,
        /// The node.
        value: f64,
    },
    /// A node that is that before, or turns back.
    #[error(
        "node {index} of the axis `{axis}` is {value} and follows {previous}: expected nodes that \
         all increase or all decrease"
    )]
    NotMonotone {
        /// The name of the axis.
        axis: String,
        /// The later node, from 0.
        index: usize,
        /// The node before.
        previous: f64,
        /// The later node.
        value: f64,
    },
    /// A node of a logarithmic axis that has no logarithm, or the same one as the node before.
    #[error(
        "node {index} of the axis `{axis}` is {value}: expected a number above 0 and apart from the \
         others, which has a logarithm"
    )]
    NodeWithoutLogarithm {
        /// The name of the axis.
        axis: String,
        /// The node, from 0.
        index: usize,
        /// The node.
        value: f64,
    },
    /// The values are not as many as the combinations of nodes.
    #[error("{found} values for axes of {shape:?} nodes: expected one for each combination")]
    Length {
        /// The nodes along the axes.
        shape: Vec<usize>,
        /// The values given.
        found: usize,
    },
    /// A value that is NaN or infinite.
    #[error("the value at the nodes {index:?} is {value}: expected a finite number")]
    Value {
        /// The nodes along the axes, from 0.
        index: Vec<usize>,
        /// The value.
        value: f64,
    },
    /// A value that has no logarithm, in a table that is interpolated in logarithms of its values.
    #[error(
        "the value at the nodes {index:?} is {value}: expected a number above 0, which has a logarithm"
    )]
    ValueWithoutLogarithm {
        /// The nodes along the axes, from 0, where nodes increase.
        index: Vec<usize>,
        /// The value.
        value: f64,
    },
}

/// An argument beyond an axis of a table with [`BeyondTable::Error`](super::BeyondTable::Error).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "the argument `{argument}`{} is {value}: expected {min} to {max}, the range of the table",
    of_table(self.table.as_deref())
)]
#[non_exhaustive]
pub struct OutsideTable {
    /// The name of the table in an expression.
    pub table: Option<String>,
    /// The name of the axis.
    pub argument: String,
    /// The argument.
    pub value: f64,
    /// The least node of the axis.
    pub min: f64,
    /// The largest node of the axis.
    pub max: f64,
}

fn of_table(name: Option<&str>) -> String {
    name.map_or_else(String::new, |name| format!(" of `{name}`"))
}
