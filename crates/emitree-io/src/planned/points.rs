//! Points at which rates are needed, and the files that they are written to.

use super::error::PlannedError;
use crate::npy::{encode, encode_npy_text};
use crate::scene::Scene;
use emitree::Samples;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use std::path::Path;
use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Points at which rates are needed.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PlannedPoints {
    /// In world coordinates and the length unit of the scene.
    pub positions: Vec<[f64; 3]>,
    /// Unit vectors of emission, from the point to the observer.
    pub directions: Vec<[f64; 3]>,
    /// One for each point in the unit of the energy axis, or none without energies.
    pub energies: Vec<f64>,
}

impl PlannedPoints {
    /// The points of a batch.
    pub(super) fn of(samples: &Samples<'_>) -> Self {
        Self {
            positions: samples.positions().to_vec(),
            directions: samples.directions().to_vec(),
            energies: samples.energies().to_vec(),
        }
    }

    /// The number of points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The points as a batch.
    pub fn samples(&self) -> Samples<'_> {
        Samples::new(&self.positions, &self.directions).at_energies(&self.energies)
    }

    /// The numbers of a point: position, direction, and the energy if there are energies.
    pub(super) fn row(&self, number: usize) -> impl Iterator<Item = f64> + '_ {
        let vectors = [self.positions[number], self.directions[number]];
        vectors.into_iter().flatten().chain(self.energies.get(number).copied())
    }

    /// The names of the columns of a row.
    pub(super) fn columns(&self) -> &'static [&'static str] {
        const COLUMNS: [&str; 7] = ["x", "y", "z", "dx", "dy", "dz", "energy"];
        if self.energies.is_empty() { &COLUMNS[..6] } else { &COLUMNS }
    }
}

/// A format of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PointsFormat {
    /// Arrays of `numpy` by name: `position` and `direction` (n, 3), `energy` (n) if there are energies, and the
    /// texts `length_unit`, `energy_unit` and `rate_unit`, empty without a unit.
    Npz,
    /// One array of `numpy`: x, y, z, the direction, and the energy if there are energies, in each row.
    Npy,
    /// The same as text, with a row of names: x, y, z, dx, dy, dz, energy. Each number has the digits that make
    /// it again, bit by bit.
    Csv,
}

impl PointsFormat {
    /// The format of a file, by the ending of its name.
    ///
    /// # Errors
    ///
    /// [`PlannedError::PointsEnding`] for any other ending.
    pub fn from_path(path: &Path) -> Result<Self, PlannedError> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        match ending.to_ascii_lowercase().as_str() {
            "npz" => Ok(Self::Npz),
            "npy" => Ok(Self::Npy),
            "csv" => Ok(Self::Csv),
            _ => Err(PlannedError::PointsEnding { path: path.to_owned() }),
        }
    }

    /// The bytes of a file of points in the units of a scene.
    ///
    /// # Errors
    ///
    /// [`PlannedError::Archive`] if an archive has no room for them.
    pub fn encode(self, points: &PlannedPoints, scene: &Scene) -> Result<Vec<u8>, PlannedError> {
        match self {
            Self::Npz => Ok(archive(&arrays(points, scene))?),
            Self::Npy => Ok(rows(points)),
            Self::Csv => Ok(text(points).into_bytes()),
        }
    }
}

/// All rows as one array.
fn rows(points: &PlannedPoints) -> Vec<u8> {
    let numbers: Vec<f64> = (0..points.len()).flat_map(|number| points.row(number)).collect();
    encode(&[points.len(), points.columns().len()], numbers.into_iter())
}

fn text(points: &PlannedPoints) -> String {
    let mut text = points.columns().join(",");
    text.push('\n');
    for number in 0..points.len() {
        for (column, value) in points.row(number).enumerate() {
            let separator = if column == 0 { "" } else { "," };
            // A text has room for everything.
            let _ = write!(text, "{separator}{value:?}");
        }
        text.push('\n');
    }
    text
}

fn arrays(points: &PlannedPoints, scene: &Scene) -> Vec<(&'static str, Vec<u8>)> {
    let vectors =
        |vectors: &[[f64; 3]]| encode(&[vectors.len(), 3], vectors.as_flattened().iter().copied());
    let mut arrays = vec![
        ("position.npy", vectors(&points.positions)),
        ("direction.npy", vectors(&points.directions)),
    ];
    let energies = scene.energy.as_ref();
    if energies.is_some() {
        let energies = points.energies.iter().copied();
        arrays.push(("energy.npy", encode(&[points.energies.len()], energies)));
    }
    arrays.extend([
        ("length_unit.npy", encode_npy_text(scene.length_unit.as_deref().unwrap_or_default())),
        ("energy_unit.npy", encode_npy_text(energies.map_or("", |of| of.unit_name()))),
        ("rate_unit.npy", encode_npy_text(&scene.emission.rate_unit)),
    ]);
    arrays
}

/// An archive of files by name.
pub(super) fn archive(files: &[(&str, Vec<u8>)]) -> ZipResult<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (name, bytes) in files {
        archive.start_file(*name, options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}
