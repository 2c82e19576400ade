//! What can be wrong with the files of a planned run.

use crate::grid::GridReadError;
use crate::scene::SceneError;
use crate::table::TableReadError;
use emitree::RenderError;
use std::convert::Infallible;
use std::path::PathBuf;
use zip::result::ZipError;

/// A planned run that can't begin or go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlannedError {
    /// The options of the scene are out of range, or its image is beyond the memory.
    #[error(transparent)]
    Render(Box<RenderError<Infallible>>),
    /// The scene can't be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The medium absorbs: another program has no optical depths for the rates.
    #[error(
        "the scene has [absorption], whose coefficient is evaluated together with the emission: expected a scene \
         without it, or `emitree render`"
    )]
    Absorption,
    /// The observer moves, or light takes time: points of the camera are not those of the world.
    #[error(
        "the scene has [time.observer] or light_travel_time, and the points of a planned run are those of the camera \
         as it is described: expected a scene without it, or `emitree render`"
    )]
    Events,
    /// The ending of a name stands for no format of points.
    #[error("the points {}: expected a name that ends in .npz, .npy or .csv", path.display())]
    PointsEnding {
        /// The file.
        path: PathBuf,
    },
    /// The archive of points or of a state can't be made.
    #[error("an archive can't be made: {0}")]
    Archive(#[from] ZipError),
    /// The file of a state can't be opened.
    #[error("the state {} can't be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The file is no state, or damaged.
    #[error("the state {}: {reason}: expected a file of `emitree plan`", path.display())]
    State {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The state is one of another version of the format.
    #[error("the state {} has version {found}: expected {expected}", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u64,
        /// The version that is read.
        expected: u64,
    },
    /// The scene is another one than that of the state.
    #[error(
        "the scene is not that of the state {}: {}: expected the scene as it was, or another state; \
         only [image], [render], [seed], [instrument] and [build] may change",
        path.display(),
        changes.join(", ")
    )]
    Changed {
        /// The file of the state.
        path: PathBuf,
        /// The keys that differ, with their former and their present values.
        changes: Vec<String>,
    },
    /// Rates in columns of text that can't be read.
    #[error("the rates {}: {cause}", path.display())]
    Columns {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        cause: Box<TableReadError>,
    },
    /// Rates in arrays that can't be read.
    #[error("the rates {}: {cause}", path.display())]
    Arrays {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        cause: Box<GridReadError>,
    },
    /// A rate that is not finite.
    #[error("the rates {}: row {row} is {rate}: expected a finite number", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// The row, from 1.
        row: usize,
        /// The rate there.
        rate: f64,
    },
    /// The points beside the rates are not those that were asked for.
    #[error(
        "the rates {}: row {row} is of the point {found:?}: expected {expected:?}, as in the file of points",
        path.display()
    )]
    OtherPoint {
        /// The file.
        path: PathBuf,
        /// The row, from 1.
        row: usize,
        /// The position in the file of rates.
        found: [f64; 3],
        /// The position that was asked for.
        expected: [f64; 3],
    },
    /// More or fewer rates than points.
    #[error("{found} rates in {files}: expected {expected}, one for each point")]
    Number {
        /// The number of rates.
        found: usize,
        /// The files.
        files: String,
        /// The number of points.
        expected: usize,
    },
}

impl From<RenderError<Infallible>> for PlannedError {
    fn from(error: RenderError<Infallible>) -> Self {
        Self::Render(Box::new(error))
    }
}
