//! Rates that a program has made of points.

use super::error::PlannedError;
use super::points::PlannedPoints;
use crate::grid::{GridFormat, GridReadError, GridRequest, read_arrays};
use crate::table::{Columns, TableReadError, read_columns};
use std::path::{Path, PathBuf};

/// The array or the column of the rates.
const RATE: &str = "rate";
/// The array of positions beside the rates, if there is one.
const POSITION: &str = "position";

/// Rates, and the positions beside them if the file has some.
struct Rates {
    rates: Vec<f64>,
    positions: Option<Vec<[f64; 3]>>,
}

/// The rates of all `points` in the files at `paths`, one part after the other.
pub(super) fn read(paths: &[PathBuf], points: &PlannedPoints) -> Result<Vec<f64>, PlannedError> {
    let mut all = Vec::with_capacity(points.len());
    for path in paths {
        let Rates { rates, positions } = of_file(path)?;
        if let Some(row) = rates.iter().position(|rate| !rate.is_finite()) {
            let (path, rate) = (path.clone(), rates[row]);
            return Err(PlannedError::NotFinite { path, row: row + 1, rate });
        }
        let expected = points.positions.get(all.len()..).unwrap_or_default();
        let both = positions.iter().flatten().zip(expected);
        if let Some((row, (found, expected))) =
            both.enumerate().find(|(_, (found, expected))| !is_same(found, expected))
        {
            let (path, found, expected) = (path.clone(), *found, *expected);
            return Err(PlannedError::OtherPoint { path, row: row + 1, found, expected });
        }
        all.extend(rates);
    }
    if all.len() == points.len() {
        return Ok(all);
    }
    let files: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let (found, files) = (all.len(), files.join(", "));
    Err(PlannedError::Number { found, files, expected: points.len() })
}

/// Whether two positions are the same; 0 and -0 are.
fn is_same(found: &[f64; 3], expected: &[f64; 3]) -> bool {
    found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 0.0)
}

fn of_file(path: &Path) -> Result<Rates, PlannedError> {
    let of_arrays = |cause| PlannedError::Arrays { path: path.to_owned(), cause: Box::new(cause) };
    let request = GridRequest::default();
    match GridFormat::from_path(path) {
        Ok(GridFormat::Npy) => read_arrays(path, &request, |arrays| {
            let rates = arrays.values(None, &[])?.into_line()?;
            Ok(Rates { rates, positions: None })
        })
        .map_err(of_arrays),
        Ok(GridFormat::Npz) => read_arrays(path, &request, |arrays| {
            let rates = arrays.array(RATE)?.into_line()?;
            let positions = match arrays.array(POSITION) {
                Ok(positions) => Some(positions.into_last_fastest().as_chunks::<3>().0.to_vec()),
                Err(GridReadError::Missing { .. }) => None,
                Err(error) => return Err(error),
            };
            Ok(Rates { rates, positions })
        })
        .map_err(of_arrays),
        _ => {
            let in_columns =
                |cause| PlannedError::Columns { path: path.to_owned(), cause: Box::new(cause) };
            of_columns(&read_columns(path).map_err(in_columns)?).map_err(in_columns)
        }
    }
}

/// The rates in columns of text: the only one, or that of their name.
fn of_columns(columns: &Columns) -> Result<Rates, TableReadError> {
    if let [only] = columns.names().as_slice() {
        return Ok(Rates { rates: columns.numbers(only, RATE)?.to_vec(), positions: None });
    }
    let rates = columns.numbers(RATE, RATE)?.to_vec();
    let names = columns.names();
    let has_positions = ["x", "y", "z"].iter().all(|name| names.iter().any(|of| of == name));
    let positions = match has_positions {
        false => None,
        true => {
            let [x, y, z] = ["x", "y", "z"].map(|name| columns.numbers(name, POSITION));
            let (x, y, z) = (x?, y?, z?);
            Some((0..x.len()).map(|row| [x[row], y[row], z[row]]).collect())
        }
    };
    Ok(Rates { rates, positions })
}
