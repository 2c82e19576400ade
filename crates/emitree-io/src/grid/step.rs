//! Steps: which place along a fourth axis, such as time, is read.

/// Which step of values with one more axis, such as time, is read.
///
/// The axis is the dimension whose name is that of no coordinate, or else the first of the array.
///
/// ```
/// use emitree_io::encode_npy;
/// use emitree_io::grid::{AxisNodes, GridRequest, Step, read_grid};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("run.npy");
/// let values: Vec<f64> = (0..24).map(f64::from).collect();
/// std::fs::write(&path, encode_npy(&[3, 2, 2, 2], &values)?)?; // [t, z, y, x]
///
/// let mut request = GridRequest::default();
/// request.nodes = [const { AxisNodes::Range { min: 0.0, max: 1.0 } }; 3];
/// request.step = Some(Step::index(-1));
/// assert_eq!(read_grid(&path, &request)?.grid.values()[0], 16.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Step {
    /// The name of the axis, and of the array of its coordinates; that of the file if it is not given.
    pub axis: Option<String>,
    /// The place along it.
    pub at: StepAt,
}

impl Step {
    /// The step of this number, from 0, or from −1 backwards.
    pub fn index(index: i64) -> Self {
        Self { axis: None, at: StepAt::Index(index) }
    }

    /// The step whose coordinate is nearest to `value`.
    pub fn value(value: f64) -> Self {
        Self { axis: None, at: StepAt::Value(value) }
    }
}

/// A place along the axis of steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StepAt {
    /// Its number, from 0, or from −1 backwards.
    Index(i64),
    /// The step whose coordinate is nearest to this one, which lies within the range of all.
    Value(f64),
}
