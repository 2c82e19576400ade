//! An effective area from a text file: two columns, energy and area.
//!
//! Numbers are separated by blanks, commas, semicolons or tabs; what follows a `#` is a comment, and a
//! first line without numbers names the columns. Energies are in keV and areas in cm², unless a header
//! in the style of ECSV (`# - {name: energy, unit: eV}`) names other units.

use crate::effective_area::{AreaError, EffectiveArea};
use crate::units::{AREA_UNITS, ENERGY_UNITS, cm2_per, kev_per};
use std::path::{Path, PathBuf};

/// A text file that no effective area could be read from.
#[derive(Debug, thiserror::Error)]
#[error("the effective area {}: {cause}", path.display())]
#[non_exhaustive]
pub struct AreaFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub cause: AreaFileDefect,
}

/// What is wrong with a text file of an effective area.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AreaFileDefect {
    /// The file can't be read.
    #[error("it can't be read: {0}")]
    Unreadable(#[source] std::io::Error),
    /// A line that is no row.
    #[error("line {line} is `{text}`: expected two numbers, an energy and an area")]
    Line {
        /// The line, from 1.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A unit that is not known.
    #[error("line {line} has the unit `{unit}`: expected {expected}")]
    Unit {
        /// The line, from 1.
        line: usize,
        /// The unit.
        unit: String,
        /// Units that are known.
        expected: &'static str,
    },
    /// The rows make no effective area.
    #[error(transparent)]
    Area(#[from] AreaError),
}

impl EffectiveArea {
    /// Reads a table of points from the text file at `path`; see [the format](crate::area_table).
    ///
    /// ```
    /// use emitree_instrument::EffectiveArea;
    ///
    /// let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("area.csv");
    /// std::fs::write(&path, "energy,area\n0.5,10\n1.0,30 # the peak\n2.0,20\n")?;
    /// assert_eq!(EffectiveArea::read_table(&path)?.mean([0.5, 1.0]), 20.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`AreaFileError`] names the file, the line or row, what is there and what was expected.
    pub fn read_table(path: impl AsRef<Path>) -> Result<Self, AreaFileError> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(AreaFileDefect::Unreadable);
        let area = text.and_then(|text| parse(&text));
        area.map_err(|cause| AreaFileError { path: path.to_owned(), cause })
    }
}

fn parse(text: &str) -> Result<EffectiveArea, AreaFileDefect> {
    let [kev_per_unit, cm2_per_unit] = units(text)?;
    let (mut energies_kev, mut areas_cm2) = (Vec::new(), Vec::new());
    let mut named = false;
    for (index, line) in text.lines().enumerate() {
        let row = line.split('#').next().unwrap_or_default();
        let fields: Vec<&str> =
            row.split([' ', '\t', ',', ';']).filter(|field| !field.is_empty()).collect();
        let numbers: Vec<f64> = fields.iter().filter_map(|field| field.parse().ok()).collect();
        match (&*fields, &*numbers) {
            ([], _) => {}
            ([_, _], &[energy, area]) => {
                energies_kev.push(kev_per_unit * energy);
                areas_cm2.push(cm2_per_unit * area);
            }
            ([_, _], []) if !named && energies_kev.is_empty() => named = true,
            _ => {
                let (line, text) = (index + 1, line.trim().to_owned());
                return Err(AreaFileDefect::Line { line, text });
            }
        }
    }
    Ok(EffectiveArea::from_points(&energies_kev, &areas_cm2)?)
}

/// The units of the two columns in keV and cm²: the first two that an ECSV header names.
fn units(text: &str) -> Result<[f64; 2], AreaFileDefect> {
    let mut factors = [1.0; 2];
    let columns = text
        .lines()
        .enumerate()
        .filter(|(_, line)| line.trim_start().starts_with('#') && line.contains("name:"));
    for (column, (index, line)) in columns.take(factors.len()).enumerate() {
        let Some((_, rest)) = line.split_once("unit:") else { continue };
        let unit = rest.split([',', '}']).next().unwrap_or_default();
        let unit = unit.trim().trim_matches(['\'', '"']);
        let (factor, expected) = match column {
            0 => (kev_per(unit), ENERGY_UNITS),
            _ => (cm2_per(unit), AREA_UNITS),
        };
        let unknown = || AreaFileDefect::Unit { line: index + 1, unit: unit.to_owned(), expected };
        factors[column] = factor.ok_or_else(unknown)?;
    }
    Ok(factors)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ECSV: &str = "# %ECSV 1.0\n# ---\n# datatype:\n\
        # - {name: energy, unit: eV, datatype: float64}\n\
        # - {name: area, unit: m2, datatype: float64}\n\
        energy area\n500 0.001\n1000.0 3e-3\n";

    #[test]
    fn separators_names_comments_and_units_are_read() {
        let expected = EffectiveArea::from_points(&[0.5, 1.0], &[10.0, 30.0]).unwrap();
        for text in [
            "0.5 10\n1 30\n",
            "# made by hand\r\nenergy;area\r\n0.5;10\r\n1;30",
            "  0.5\t, 1e1 # first\n\n1.0\t30",
            ECSV,
        ] {
            assert_eq!(parse(text).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn lines_that_are_no_rows_are_refused() {
        let text = |content: &str| parse(content).unwrap_err().to_string();
        assert_eq!(
            text("energy area\n0.5 10\n1.0 x\n"),
            "line 3 is `1.0 x`: expected two numbers, an energy and an area"
        );
        assert!(text("0.5 10 2\n").starts_with("line 1 is `0.5 10 2`"));
        assert!(text("energy area\nkeV cm2\n0.5 1\n").starts_with("line 2 is `keV cm2`"));
        assert_eq!(text("0.5 1\n"), "the effective area has 1 rows: expected 2 at least");
        assert_eq!(
            text("0.5 1\n1.0 -3\n"),
            "area of row 2 is -3: expected a finite number, 0 or more"
        );
        assert_eq!(
            text(&ECSV.replace("eV", "nm")),
            "line 4 has the unit `nm`: expected keV, eV, MeV or GeV"
        );
    }

    #[test]
    fn the_file_is_named() {
        let error = EffectiveArea::read_table("no/such/area.txt").unwrap_err().to_string();
        assert!(
            error.starts_with("the effective area no/such/area.txt: it can't be read: "),
            "{error}"
        );
    }
}
