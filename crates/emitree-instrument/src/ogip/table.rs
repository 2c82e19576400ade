//! A table of a response file: its extension, and its columns as numbers.

use super::error::ResponseFileDefect;
use crate::cell::WrongCell;
use crate::units::{AREA_UNITS, ENERGY_UNITS, cm2_per, kev_per};
use fits_well::header::Header;
use fits_well::io::{Hdu, SliceReader};
use fits_well::table::{ColumnReader, Ragged, Storage, Table};

/// What an extension has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Area,
    Matrix,
    Channels,
}

impl Kind {
    fn class(self) -> &'static str {
        match self {
            Self::Area => "SPECRESP",
            Self::Matrix => "RSP_MATRIX",
            Self::Channels => "EBOUNDS",
        }
    }

    fn names(self) -> &'static [&'static str] {
        match self {
            Self::Area => &["SPECRESP"],
            Self::Matrix => &["MATRIX", "SPECRESP MATRIX"],
            Self::Channels => &["EBOUNDS"],
        }
    }

    fn what(self) -> &'static str {
        match self {
            Self::Area => "an effective area",
            Self::Matrix => "a redistribution matrix",
            Self::Channels => "the energies of channels",
        }
    }

    fn expected(self) -> &'static str {
        match self {
            Self::Area => "HDUCLAS2 = 'SPECRESP' or EXTNAME = 'SPECRESP'",
            Self::Matrix => "HDUCLAS2 = 'RSP_MATRIX', or EXTNAME = 'MATRIX' or 'SPECRESP MATRIX'",
            Self::Channels => "HDUCLAS2 = 'EBOUNDS' or EXTNAME = 'EBOUNDS'",
        }
    }
}

/// A binary table of a response file.
#[derive(Debug)]
pub(super) struct ResponseTable {
    /// The name of the extension.
    pub(super) name: String,
    header: Header,
    table: Table,
}

impl ResponseTable {
    /// The one extension of this kind: by its class, or if none has it by its name.
    pub(super) fn open(
        reader: &mut SliceReader<'_>,
        kind: Kind,
    ) -> Result<Self, ResponseFileDefect> {
        let tables = || reader.hdus().iter().filter(|hdu| hdu.table_schema().is_ok());
        let by_class: Vec<usize> =
            tables().filter(|hdu| is_of_class(hdu, kind)).map(|hdu| hdu.index).collect();
        let by_name = || tables().filter(|hdu| is_named(hdu, kind)).map(|hdu| hdu.index).collect();
        let found: Vec<usize> = if by_class.is_empty() { by_name() } else { by_class };
        let index = match *found {
            [index] => index,
            [] => {
                // A header that can't be read hides what comes after it.
                if let Some(defect) = reader.scan_defect() {
                    let name = "the header after the last one that can be read".to_owned();
                    let (value, expected) = (defect.to_string(), "a header of FITS".to_owned());
                    let extension = reader.hdus().last().map(name_of).unwrap_or_default();
                    return Err(ResponseFileDefect::Record { extension, name, value, expected });
                }
                let (what, expected) = (kind.what(), kind.expected());
                let available = reader.hdus().iter().skip(1).map(name_of).collect();
                return Err(ResponseFileDefect::NoExtension { what, expected, available });
            }
            _ => {
                let (what, found) = (kind.what(), found.len());
                return Err(ResponseFileDefect::SeveralExtensions { what, found });
            }
        };
        let table = reader.read_table(index).map_err(ResponseFileDefect::fits)?;
        let hdu = &reader.hdus()[index];
        Ok(Self { name: name_of(hdu), header: hdu.header.clone(), table })
    }

    /// The value of a text record, without blanks around it; `None` if it is absent or empty.
    pub(super) fn text(&self, keyword: &str) -> Option<&str> {
        text(&self.header, keyword)
    }

    /// The smallest legal value of a column, `TLMINn`, if the file has it.
    pub(super) fn minimum(&self, column: &'static str) -> Result<Option<i64>, ResponseFileDefect> {
        let Some(index) = self.index(column) else { return Err(self.no_column(column)) };
        let keyword = format!("TLMIN{}", index + 1);
        let value = self.header.get_real(keyword.as_str());
        let whole = |value: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "a whole number of this size fits")]
            (value.fract() == 0.0 && value.abs() < 1e9).then_some(value as i64)
        };
        let wrong = |value: String| ResponseFileDefect::Record {
            extension: self.name.clone(),
            name: keyword.clone(),
            value,
            expected: format!("the number of the first channel, since it is that of `{column}`"),
        };
        match value {
            Ok(None) => Ok(None),
            Ok(Some(value)) => Ok(Some(whole(value).ok_or_else(|| wrong(value.to_string()))?)),
            Err(error) => Err(wrong(error.to_string())),
        }
    }

    /// A column of one number a row.
    pub(super) fn scalars(&self, column: &'static str) -> Result<Vec<f64>, ResponseFileDefect> {
        let values = self.vectors(column)?;
        match values.iter().map(<[f64]>::len).find(|&length| length != 1) {
            None => Ok(values.into_values()),
            Some(found) => {
                Err(ResponseFileDefect::NotScalar { extension: self.name.clone(), column, found })
            }
        }
    }

    /// A column of any number of numbers a row, of fixed or of variable length.
    pub(super) fn vectors(
        &self,
        column: &'static str,
    ) -> Result<Ragged<Vec<f64>>, ResponseFileDefect> {
        let reader = self.reader(column)?;
        let form = reader.descriptor().tform;
        let unreadable = |source| ResponseFileDefect::Column {
            extension: self.name.clone(),
            column,
            source: Box::new(source),
            expected: "numbers",
        };
        let mut rows = Ragged::new(Vec::new(), Vec::new());
        match form.storage() {
            Storage::Array(_) => reader.vla_physical_into(&mut rows).map_err(unreadable)?,
            Storage::Fixed => {
                let mut values = Vec::new();
                reader.physical_into(&mut values).map_err(unreadable)?;
                let count = self.table.schema().row_count();
                let ends = (1..=count).map(|row| row * form.repeat()).collect();
                rows = Ragged::<Vec<f64>>::new(values, ends);
            }
        }
        Ok(rows)
    }

    /// A column of energies in keV, the default of files without a unit.
    pub(super) fn energies_kev(
        &self,
        column: &'static str,
    ) -> Result<Vec<f64>, ResponseFileDefect> {
        let factor = match self.unit(column)? {
            None => 1.0,
            Some(unit) => {
                kev_per(unit).ok_or_else(|| self.wrong_unit(column, unit, ENERGY_UNITS))?
            }
        };
        Ok(self.scalars(column)?.iter().map(|energy| factor * energy).collect())
    }

    /// How many cm² the unit of a column is; `None` if it has no unit.
    pub(super) fn cm2_per_unit(
        &self,
        column: &'static str,
    ) -> Result<Option<f64>, ResponseFileDefect> {
        let known =
            |unit: &str| cm2_per(unit).ok_or_else(|| self.wrong_unit(column, unit, AREA_UNITS));
        self.unit(column)?.map(known).transpose()
    }

    /// A number of the table that can't be; the row counts from 0.
    pub(super) fn cell(
        &self,
        column: &'static str,
        row: usize,
        value: f64,
        expected: impl Into<String>,
    ) -> ResponseFileDefect {
        let source = WrongCell::new(column, row, value, expected);
        ResponseFileDefect::Cell { extension: self.name.clone(), source }
    }

    fn unit(&self, column: &'static str) -> Result<Option<&str>, ResponseFileDefect> {
        // A unit that is no text is as good as none.
        let unit = self.reader(column)?.descriptor().unit().ok().flatten().map(str::trim);
        Ok(unit.filter(|unit| !unit.is_empty()))
    }

    fn wrong_unit(&self, column: &str, unit: &str, expected: &str) -> ResponseFileDefect {
        ResponseFileDefect::Record {
            extension: self.name.clone(),
            name: format!("the unit of column `{column}`"),
            value: unit.to_owned(),
            expected: expected.to_owned(),
        }
    }

    fn reader(&self, column: &'static str) -> Result<ColumnReader<'_>, ResponseFileDefect> {
        let reader = self.index(column).and_then(|index| self.table.column(index).ok());
        reader.ok_or_else(|| self.no_column(column))
    }

    /// The place of a column, in either case.
    fn index(&self, column: &str) -> Option<usize> {
        let columns = &self.table.schema().columns;
        columns.iter().position(|other| {
            let name = other.name().ok().flatten().unwrap_or_default();
            name.trim().eq_ignore_ascii_case(column)
        })
    }

    fn no_column(&self, column: &'static str) -> ResponseFileDefect {
        let names = self.table.schema().columns.iter().filter_map(|c| c.name().ok().flatten());
        let available = names.map(|name| name.trim().to_owned()).collect();
        ResponseFileDefect::NoColumn { extension: self.name.clone(), column, available }
    }
}

fn text<'a>(header: &'a Header, keyword: &str) -> Option<&'a str> {
    let text = header.get_text(keyword).ok().flatten().map(str::trim);
    text.filter(|text| !text.is_empty())
}

fn name_of(hdu: &Hdu) -> String {
    let number = || format!("number {}", hdu.index);
    text(&hdu.header, "EXTNAME").map_or_else(number, str::to_owned)
}

fn is_of_class(hdu: &Hdu, kind: Kind) -> bool {
    let has = |keyword, value: &str| {
        text(&hdu.header, keyword).is_some_and(|text| text.eq_ignore_ascii_case(value))
    };
    has("HDUCLAS1", "RESPONSE") && has("HDUCLAS2", kind.class())
}

fn is_named(hdu: &Hdu, kind: Kind) -> bool {
    let name = text(&hdu.header, "EXTNAME").unwrap_or_default();
    kind.names().iter().any(|known| known.eq_ignore_ascii_case(name))
}
