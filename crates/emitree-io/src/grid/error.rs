//! Why a file has no grid.

use super::angle_unit::AngleUnit;
use super::order::ArrayOrder;
use super::request::GridFormat;
use emitree_models::GridError;
use emitree_models::grid::Coordinates;
use std::path::PathBuf;

/// A file that no grid could be read from.
#[derive(Debug, thiserror::Error)]
#[error("the grid {}: {cause}", path.display())]
#[non_exhaustive]
pub struct GridFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub cause: GridReadError,
}

/// What is wrong with the content of a file, or with the request.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GridReadError {
    /// The file can't be opened or read.
    #[error("it can't be read: {0}")]
    Unreadable(#[source] std::io::Error),
    /// The ending of the name stands for no format.
    #[error(
        "no grid format for this ending: expected .fits, .fit, .npy, .npz, .h5, .hdf5, .nc, .vtk, .vti or .vtr"
    )]
    Ending,
    /// The library was built without this format.
    #[error("this program was built without {0}: expected a build with the feature `hdf5`")]
    NotBuilt(GridFormat),
    /// The bytes are not what the format has, or use a part of it that can't be read.
    #[error("it can't be read as {format}: {reason}")]
    Malformed {
        /// The format.
        format: GridFormat,
        /// What is wrong.
        reason: String,
    },
    /// An array takes more memory than there is; nothing was allocated.
    #[error(
        "to read an array of shape {shape:?} takes {needed} bytes of memory: expected at most \
         {allowed}, which are available"
    )]
    TooLarge {
        /// The length of each axis.
        shape: Vec<usize>,
        /// The memory that it needs \[bytes\].
        needed: u64,
        /// The memory that is allowed \[bytes\].
        allowed: u64,
    },
    /// Nothing of this name is in the file.
    #[error("it has no array `{name}`: expected {}", one_of(available))]
    Missing {
        /// The requested name.
        name: String,
        /// The names that there are.
        available: Vec<String>,
    },
    /// The file does not contain the nodes along an axis.
    #[error("the file does not contain its nodes: expected {0}")]
    NoNodes(String),
    /// The values have one more axis, and no step of it was requested.
    #[error(
        "the values are an array of shape {shape:?}: expected three axes, or `step`, which chooses one \
         of the {count} along the axis {axis}"
    )]
    WithoutStep {
        /// The length of each axis.
        shape: Vec<usize>,
        /// The number of steps.
        count: usize,
        /// The name or the place of their axis.
        axis: String,
    },
    /// A step was requested, and there are none.
    #[error("the values are an array of shape {shape:?}: expected four axes, or no `step`")]
    NoSteps {
        /// The length of each axis.
        shape: Vec<usize>,
    },
    /// There is no step of this number.
    #[error(
        "the step is {index}: expected one of the {count} along the axis {axis}, from 0, or from -1 backwards"
    )]
    StepBeyond {
        /// The requested step.
        index: i64,
        /// The number of steps.
        count: usize,
        /// The name or the place of their axis.
        axis: String,
    },
    /// The requested coordinate is not within those of the steps.
    #[error("the step is that at {value}: expected {min} to {max}, the range of their coordinates")]
    StepOutside {
        /// The requested coordinate.
        value: f64,
        /// The least coordinate of a step.
        min: f64,
        /// The largest.
        max: f64,
    },
    /// The steps have no coordinates in the file.
    #[error(
        "the axis of the steps has no name: expected `step.axis`, the array of their coordinates, or `step.index`"
    )]
    StepWithoutAxis,
    /// The coordinates of the steps are not as many.
    #[error("the axis of the steps has {found} coordinates: expected {count}, one for each step")]
    StepNodes {
        /// The coordinates.
        found: usize,
        /// The number of steps.
        count: usize,
    },
    /// The values are no cube.
    #[error("the values are an array of shape {shape:?}: expected three axes")]
    NotACube {
        /// The length of each axis.
        shape: Vec<usize>,
    },
    /// The values are no map of pixels.
    #[error("the values are an array of shape {shape:?}: expected two axes")]
    NotAMap {
        /// The length of each axis.
        shape: Vec<usize>,
    },
    /// The nodes of an axis are in an array of more than one axis.
    #[error("it is an array of shape {shape:?}: expected one axis")]
    NotALine {
        /// The length of each axis.
        shape: Vec<usize>,
    },
    /// The nodes of an axis are not as many as the values along it.
    #[error(
        "it has {found} nodes: expected {length}, since the values are an array of shape {shape:?}, \
         with axes in the order {order}{}",
        edges(*.found, *.length)
    )]
    AxisLength {
        /// The nodes found or given.
        found: usize,
        /// The values along the axis.
        length: usize,
        /// The shape of the values.
        shape: Vec<usize>,
        /// The order of the axes of the values.
        order: ArrayOrder,
    },
    /// The requested order contradicts the names of the axes.
    #[error(
        "the order of axes is given as {asked}, but the file names them {named}: \
         expected the same"
    )]
    Order {
        /// The requested order.
        asked: ArrayOrder,
        /// The order of the names in the file.
        named: ArrayOrder,
    },
    /// The requested order is one of other coordinates.
    #[error("the order of axes is given as {asked}: expected the axes {}", coordinates.names().join(", "))]
    OrderOfOthers {
        /// The requested order.
        asked: ArrayOrder,
        /// The coordinates of the grid.
        coordinates: Coordinates,
    },
    /// Neither the file nor the request says what unit angles have.
    #[error("the unit of its angles is not known: expected `angle_unit`, \"deg\" or \"rad\"")]
    NoAngleUnit,
    /// An angle that no direction has.
    #[error(
        "node {index} is {value} {unit}: expected a {name} from {low} to {high} {unit} \
         (`angle_unit` is the unit of all angles{})",
        latitudes(*.value, .name)
    )]
    AngleOutOfRange {
        /// The node, from 0.
        index: usize,
        /// Its angle.
        value: f64,
        /// The unit.
        unit: AngleUnit,
        /// What the angle is.
        name: &'static str,
        /// The least one.
        low: f64,
        /// The largest one.
        high: f64,
    },
    /// Azimuths that go round more than once.
    #[error(
        "it goes from {first} to {last} {unit}: expected at most a full turn, {turn} {unit} \
         (`angle_unit` is the unit of all angles)"
    )]
    MoreThanATurn {
        /// The first azimuth.
        first: f64,
        /// The last azimuth.
        last: f64,
        /// The unit.
        unit: AngleUnit,
        /// A full turn.
        turn: f64,
    },
    /// Degrees that end where radians do.
    #[error(
        "it goes from {first} to {last} deg, which are {limit} in radians: expected degrees, or \
         `angle_unit` = \"rad\""
    )]
    RatherRadians {
        /// The first angle.
        first: f64,
        /// The last angle.
        last: f64,
        /// What they would be in radians.
        limit: &'static str,
    },
    /// Something is wrong about one axis.
    #[error("the {axis} axis: {cause}")]
    Axis {
        /// The name of the axis.
        axis: &'static str,
        /// What is wrong.
        #[source]
        cause: Box<Self>,
    },
    /// The nodes and values make no grid.
    #[error(transparent)]
    Grid(GridError),
    /// A value is NaN or infinite, or was missing in the file.
    #[error("{0} (blanks and fill values are read as NaN)")]
    NotFinite(#[source] GridError),
}

impl GridReadError {
    /// What of a [`GridRequest`](super::GridRequest) it is about, as scenes name it: `file`,
    /// `values`, `step`, `order`, or the name of an axis.
    pub fn concerns(&self) -> &'static str {
        match self {
            Self::Missing { .. } | Self::NotACube { .. } | Self::NotAMap { .. } => "values",
            Self::WithoutStep { .. }
            | Self::NoSteps { .. }
            | Self::StepBeyond { .. }
            | Self::StepOutside { .. }
            | Self::StepWithoutAxis
            | Self::StepNodes { .. } => "step",
            Self::Order { .. } | Self::OrderOfOthers { .. } => "order",
            Self::Axis { axis, .. }
            | Self::Grid(
                GridError::TooFewNodes { axis, .. }
                | GridError::NodeNotFinite { axis, .. }
                | GridError::NotMonotone { axis, .. }
                | GridError::OutOfRange { axis, .. }
                | GridError::MoreThanATurn { axis, .. },
            ) => axis,
            Self::Grid(GridError::LogarithmOfAngle { .. }) => "logarithmic",
            _ => "file",
        }
    }

    /// Bytes that the format does not allow.
    pub(crate) fn malformed(format: GridFormat, reason: impl ToString) -> Self {
        Self::Malformed { format, reason: reason.to_string() }
    }
}

/// What one node more than there are values may be.
fn edges(found: usize, length: usize) -> &'static str {
    match found == length + 1 {
        true => " (the nodes are the places of the values: the centres of cells, not their edges)",
        false => "",
    }
}

/// What colatitudes below 0 may be.
fn latitudes(value: f64, name: &str) -> &'static str {
    match value < 0.0 && name == "colatitude" {
        true => "; `latitude` instead of `theta` is for latitudes",
        false => "",
    }
}

/// "one of `a`, `b`", at most so many that a line holds them.
pub(crate) fn one_of(names: &[String]) -> String {
    const SHOWN: usize = 12;
    if names.is_empty() {
        return "a file with arrays, but it has none".to_owned();
    }
    let shown: Vec<String> = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect();
    let more = match names.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("one of {}{more}", shown.join(", "))
}
