//! What can be wrong with a grid, and with a position.

/// The names of the axes, in the order of positions and shapes.
pub(super) const AXES: [char; 3] = ['x', 'y', 'z'];

/// Axes or values that make no grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// An axis that spans nothing: a single plane, or none at all.
    #[error(
        "the {axis} axis has {count} node(s): expected at least 2, since a plane has no volume"
    )]
    TooFewNodes {
        /// The axis: `x`, `y` or `z`.
        axis: char,
        /// Its nodes.
        count: usize,
    },
    /// A node that is NaN or infinite.
    #[error("node {index} of the {axis} axis is {value}: expected a finite number")]
    NodeNotFinite {
        /// The axis: `x`, `y` or `z`.
        axis: char,
        /// The node, from 0.
        index: usize,
        /// Its coordinate.
        value: f64,
    },
    /// Two nodes in the wrong order, or at the same place.
    #[error(
        "node {index} of the {axis} axis is {value} and follows {previous}: \
         expected an axis that increases strictly"
    )]
    NotIncreasing {
        /// The axis: `x`, `y` or `z`.
        axis: char,
        /// The later node, from 0.
        index: usize,
        /// The coordinate of the node before.
        previous: f64,
        /// The coordinate of the later node.
        value: f64,
    },
    /// The values are not as many as the nodes.
    #[error(
        "{found} values for a grid of {} x {} x {} nodes (x, y, z): expected one for each node",
        shape[0], shape[1], shape[2]
    )]
    Length {
        /// The nodes along x, y and z.
        shape: [usize; 3],
        /// The values given.
        found: usize,
    },
    /// A value that is NaN or infinite.
    #[error(
        "the value at the node with indices (x, y, z) = {index:?} is {value}: expected a finite number"
    )]
    ValueNotFinite {
        /// The indices along x, y and z, from 0.
        index: (usize, usize, usize),
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
    /// The first axis that it leaves: `x`, `y` or `z`.
    pub axis: char,
    /// Its coordinate along that axis.
    pub value: f64,
    /// The first node of that axis.
    pub min: f64,
    /// The last node of that axis.
    pub max: f64,
}
