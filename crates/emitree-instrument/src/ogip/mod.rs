//! Areas and matrices from the FITS files of missions: ARF, RMF and RSP.
//!
//! The format is that of George et al. 1998, OGIP memo CAL/GEN/92-002, with its addendum 92-002a. An
//! extension is found by its class (`HDUCLAS1 = 'RESPONSE'`, and `HDUCLAS2` `'SPECRESP'`,
//! `'RSP_MATRIX'` or `'EBOUNDS'`), or else by its name (`SPECRESP`; `MATRIX` or `SPECRESP MATRIX`;
//! `EBOUNDS`). Columns may be of any type of number, of fixed or of variable length; energies are in
//! `keV`, `eV`, `MeV` or `GeV`, keV if the file has no unit, and areas in cm², m² or mm².
//!
//! A matrix includes the effective area if `HDUCLAS3` is `'FULL'`; in files without that keyword, if
//! its unit is an area, or if a row has a sum above 1.5, which no probability has.

mod error;
mod matrix;
mod table;

pub use error::{ResponseFileDefect, ResponseFileError};

use crate::effective_area::EffectiveArea;
use crate::redistribution::Redistribution;
use fits_well::FitsReader;
use std::path::Path;
use table::{Kind, ResponseTable};

impl EffectiveArea {
    /// Reads the effective area of the ancillary response file (ARF) at `path`; see
    /// [the format](crate::ogip).
    ///
    /// ```no_run
    /// use emitree_instrument::EffectiveArea;
    ///
    /// let area = EffectiveArea::read_arf("camera.arf")?;
    /// println!("{} cm²", area.mean([0.5, 2.0]));
    /// # Ok::<(), emitree_instrument::ResponseFileError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`ResponseFileError`] names the file, and in it the extension, column, row and value that is
    /// missing or wrong, and what was expected.
    pub fn read_arf(path: impl AsRef<Path>) -> Result<Self, ResponseFileError> {
        read(path.as_ref(), area)
    }
}

impl Redistribution {
    /// Reads the matrix and the channels of the redistribution matrix file (RMF), or of the response
    /// file with the area folded in (RSP), at `path`; see [the format](crate::ogip).
    ///
    /// ```no_run
    /// use emitree_instrument::Redistribution;
    ///
    /// let matrix = Redistribution::read_rmf("camera.rmf")?;
    /// println!("{} channels", matrix.channels().len());
    /// # Ok::<(), emitree_instrument::ResponseFileError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`ResponseFileError`] names the file, and in it the extension, column, row and value that is
    /// missing or wrong, and what was expected.
    pub fn read_rmf(path: impl AsRef<Path>) -> Result<Self, ResponseFileError> {
        read(path.as_ref(), matrix::redistribution)
    }
}

fn read<T>(
    path: &Path,
    decode: impl FnOnce(&[u8]) -> Result<T, ResponseFileDefect>,
) -> Result<T, ResponseFileError> {
    let bytes = std::fs::read(path).map_err(ResponseFileDefect::Unreadable);
    let found = bytes.and_then(|bytes| decode(&bytes));
    found.map_err(|cause| ResponseFileError { path: path.to_owned(), cause: Box::new(cause) })
}

fn area(bytes: &[u8]) -> Result<EffectiveArea, ResponseFileDefect> {
    let mut reader = FitsReader::from_bytes(bytes).map_err(ResponseFileDefect::fits)?;
    let table = ResponseTable::open(&mut reader, Kind::Area)?;
    let low = table.energies_kev("ENERG_LO")?;
    let high = table.energies_kev("ENERG_HI")?;
    let factor = table.cm2_per_unit("SPECRESP")?.unwrap_or(1.0);
    let areas: Vec<f64> = table.scalars("SPECRESP")?.iter().map(|area| factor * area).collect();
    let area = EffectiveArea::from_bins(&low, &high, &areas);
    area.map_err(|source| ResponseFileDefect::Area { extension: table.name, source })
}

#[cfg(test)]
mod tests;
