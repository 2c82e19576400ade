//! The file of a state: an archive of what the scene says, of the points that were asked for, and of all
//! rates.
//!
//! `about.json` has the version of the format, the number of rounds and the values of the scene; `known.npy` has a row
//! of x, y, z, direction, energy (NaN without energies) and rate for each evaluation, so that `numpy.load` reads
//! it; `asked.npy` has the same without the rates for the points whose rates are awaited.

use super::changes::Values;
use super::error::PlannedError;
use super::points::{PlannedPoints, archive};
use crate::grid::{GridFormat, GridReadError, GridRequest, read_arrays};
use crate::npy::encode;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use zip::ZipArchive;

/// The version of the format, which readers refuse if it is another one.
const VERSION: u64 = 1;
const FORMAT: &str = "emitree state";
const ABOUT: &str = "about.json";
/// The longest `about.json` that is read \[bytes\]: four times the longest scene.
const LONGEST_ABOUT: u64 = 1 << 28;
/// The numbers of a point in each row: position, direction, energy.
const NUMBERS: usize = 7;

/// What a file has of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct State {
    /// The values that the rates depend on.
    pub(super) scene: Values,
    /// How often rates have been told.
    pub(super) rounds: u64,
    /// The points that were asked for last.
    pub(super) asked: PlannedPoints,
    /// Points whose rates are known…
    pub(super) points: PlannedPoints,
    /// …and these, in the unit of the emission.
    pub(super) rates: Vec<f64>,
}

impl State {
    /// The bytes of the file.
    pub(super) fn encode(&self) -> Result<Vec<u8>, PlannedError> {
        let about = json!({
            "format": FORMAT,
            "version": VERSION,
            "program": concat!("emitree ", env!("CARGO_PKG_VERSION")),
            "rounds": self.rounds,
            "scene": self.scene,
        });
        let files = [
            (ABOUT, format!("{about:#}\n").into_bytes()),
            ("asked.npy", rows(&self.asked, None)),
            ("known.npy", rows(&self.points, Some(&self.rates))),
        ];
        Ok(archive(&files)?)
    }

    /// The state in a file.
    pub(super) fn read(path: &Path) -> Result<Self, PlannedError> {
        let refuse = |reason: String| PlannedError::State { path: path.to_owned(), reason };
        let about = about(path)?;
        if about["format"] != FORMAT {
            return Err(refuse(format!("its `{ABOUT}` is not that of a state")));
        }
        match about["version"].as_u64() {
            Some(VERSION) => {}
            Some(found) => {
                let path = path.to_owned();
                return Err(PlannedError::Version { path, found, expected: VERSION });
            }
            None => return Err(refuse(format!("its `{ABOUT}` has no `version`"))),
        }
        let scene: Option<Values> = about["scene"].as_object().and_then(|scene| {
            scene.iter().map(|(key, value)| Some((key.clone(), value.as_str()?.into()))).collect()
        });
        let scene = scene.ok_or_else(|| refuse(format!("its `{ABOUT}` has no `scene`")))?;
        let rounds = about["rounds"].as_u64().unwrap_or_default();
        let request = GridRequest { format: Some(GridFormat::Npz), ..GridRequest::default() };
        let of_arrays = |error: GridReadError| refuse(error.to_string());
        let (asked, known) = read_arrays(path, &request, |arrays| {
            Ok((arrays.array("asked")?, arrays.array("known")?))
        })
        .map_err(of_arrays)?;
        let columns = |name: &str, shape: &[usize], expected: usize| match shape {
            [_, columns] if *columns == expected => Ok(()),
            _ => Err(refuse(format!("its `{name}` has the shape {shape:?}"))),
        };
        columns("asked", &asked.shape, NUMBERS)?;
        columns("known", &known.shape, NUMBERS + 1)?;
        let (asked, known) = (asked.into_last_fastest(), known.into_last_fastest());
        let known = known.as_chunks::<{ NUMBERS + 1 }>().0;
        if let Some(row) = known.iter().position(|row| !row[NUMBERS].is_finite()) {
            return Err(refuse(format!("row {} of its `known` has no rate", row + 1)));
        }
        Ok(Self {
            scene,
            rounds,
            asked: points(asked.as_chunks::<NUMBERS>().0.iter().map(|row| &row[..])),
            points: points(known.iter().map(|row| &row[..])),
            rates: known.iter().map(|row| row[NUMBERS]).collect(),
        })
    }
}

/// `about.json` of an archive.
fn about(path: &Path) -> Result<Value, PlannedError> {
    let refuse = |reason: String| PlannedError::State { path: path.to_owned(), reason };
    let file = File::open(path)
        .map_err(|source| PlannedError::Unreadable { path: path.to_owned(), source })?;
    let mut archive = ZipArchive::new(BufReader::new(file))
        .map_err(|error| refuse(format!("it is no whole archive ({error})")))?;
    let about = archive.by_name(ABOUT);
    let about = about.map_err(|_| refuse(format!("it has no `{ABOUT}`")))?;
    let mut text = String::new();
    let read = about.take(LONGEST_ABOUT).read_to_string(&mut text);
    read.map_err(|error| refuse(format!("its `{ABOUT}` can't be read ({error})")))?;
    serde_json::from_str(&text)
        .map_err(|error| refuse(format!("its `{ABOUT}` is no JSON ({error})")))
}

/// The rows of points, with their rates if there are some.
fn rows(points: &PlannedPoints, rates: Option<&[f64]>) -> Vec<u8> {
    let row = |number: usize| {
        let energy = points.energies.is_empty().then_some(f64::NAN);
        points.row(number).chain(energy).chain(rates.map(|rates| rates[number]))
    };
    let numbers: Vec<f64> = (0..points.len()).flat_map(row).collect();
    let columns = if rates.is_some() { NUMBERS + 1 } else { NUMBERS };
    encode(&[points.len(), columns], numbers.into_iter())
}

fn points<'a>(rows: impl Iterator<Item = &'a [f64]>) -> PlannedPoints {
    let mut points = PlannedPoints::default();
    for row in rows {
        points.positions.push([row[0], row[1], row[2]]);
        points.directions.push([row[3], row[4], row[5]]);
        points.energies.push(row[6]);
    }
    if points.energies.iter().all(|energy| energy.is_nan()) {
        points.energies.clear();
    }
    points
}
