//! What can be wrong with a grid, and with a position.

use super::Coordinates;

/// Axes or values that make no grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// An axis that spans nothing: a single plane, or none at all.
    #[error(
        "the {axis} axis has {count} node(s): expected at least 2, since a plane has no volume"
    )]
    TooFewNodes {
        /// The name of the axis.
        axis: &'static str,
        /// Its nodes.
        count: usize,
    },
    /// A node that is NaN or infinite.
    #[error("node {index} of the {axis} axis is {value}: expected a finite number")]
    NodeNotFinite {
        /// The name of the axis.
        axis: &'static str,
        /// The node, from 0.
        index: usize,
        /// Its coordinate.
        value: f64,
    },
    /// A node that is at the place of the one before, or turns back.
    #[error(
        "node {index} of the {axis} axis is {value} and follows {previous}: \
         expected nodes that all increase or all decrease"
    )]
    NotMonotone {
        /// The name of the axis.
        axis: &'static str,
        /// The later node, from 0.
        index: usize,
        /// The coordinate of the node before.
        previous: f64,
        /// The coordinate of the later node.
        value: f64,
    },
    /// A node at a coordinate that the axis does not have.
    #[error("node {index} of the {axis} axis is {value}: expected {expected}")]
    OutOfRange {
        /// The name of the axis.
        axis: &'static str,
        /// The node, from 0.
        index: usize,
        /// Its coordinate.
        value: f64,
        /// What is expected.
        expected: &'static str,
    },
    /// An azimuth that goes round more than once.
    #[error(
        "the {axis} axis spans {span} rad, from {first} to {last}: expected at most a full turn, \
         2 pi (degrees have to be converted)"
    )]
    MoreThanATurn {
        /// The name of the axis.
        axis: &'static str,
        /// The last coordinate less the first \[rad\].
        span: f64,
        /// The first coordinate \[rad\].
        first: f64,
        /// The last coordinate \[rad\].
        last: f64,
    },
    /// An axis of angles that was to be interpolated in its logarithm.
    #[error("the {axis} axis has angles: expected a length to be interpolated in its logarithm")]
    LogarithmOfAngle {
        /// The name of the axis.
        axis: &'static str,
    },
    /// The values are not as many as the nodes.
    #[error(
        "{found} values for a grid of {} x {} x {} nodes ({}): expected one for each node",
        shape[0], shape[1], shape[2], coordinates.names().join(", ")
    )]
    Length {
        /// The nodes along the three axes.
        shape: [usize; 3],
        /// The coordinates along them.
        coordinates: Coordinates,
        /// The values given.
        found: usize,
    },
    /// A value that is NaN or infinite.
    #[error(
        "the value at the node with indices ({}) = {index:?} is {value}: expected a finite number",
        coordinates.names().join(", ")
    )]
    ValueNotFinite {
        /// The indices along the three axes, from 0.
        index: (usize, usize, usize),
        /// The coordinates along them.
        coordinates: Coordinates,
        /// The value.
        value: f64,
    },
}

/// A position outside a grid with [`Outside::Error`](super::Outside::Error).
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the position {position:?} is outside the grid: its {axis} is {value}, expected {min} to {max}"
)]
pub struct OutsideGrid {
    /// The position (x, y, z), in the length unit of the grid.
    pub position: [f64; 3],
    /// The name of the first axis that it leaves.
    pub axis: &'static str,
    /// Its coordinate along that axis, in radians if it is an angle.
    pub value: f64,
    /// The least coordinate of that axis.
    pub min: f64,
    /// The largest coordinate of that axis.
    pub max: f64,
}
