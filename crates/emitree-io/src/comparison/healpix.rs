//! `HEALPix` maps of the whole sphere as files have them: a table with a column for each band, its pixels in order.

use crate::fits::nside_of;
use crate::grid::{GridFormat, GridReadError};
use fits_well::FitsReader;
use fits_well::io::Hdu;
use fits_well::table::Table;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// The values of a map, band after band, each in nested order.
pub(super) struct StoredSky {
    pub(super) bands: usize,
    pub(super) values: Vec<f64>,
    pub(super) unit: Option<String>,
    pub(super) error: Option<Vec<f64>>,
}

/// Columns with estimated errors begin with this.
const ERROR: &str = "ERROR";

/// The map in a FITS file: the columns of its components, if it has some, or else its first column, with those that differ from it by a number, and the columns `ERROR`;
/// none if it has no table of that kind, or can't be read at all.
///
/// # Errors
///
/// [`GridReadError::Malformed`]: a part of the sphere, pixels in the order of rings, and columns of other lengths.
pub(super) fn read(
    path: &Path,
    components: Option<&[String]>,
) -> Result<Option<StoredSky>, GridReadError> {
    let opened = File::open(path).ok().map(BufReader::new);
    let Some(mut reader) = opened.and_then(|file| FitsReader::open(file).ok()) else {
        return Ok(None);
    };
    let Some(at) = reader.hdus().iter().position(|hdu| text(hdu, "PIXTYPE") == "HEALPIX") else {
        return Ok(None);
    };
    let hdu = &reader.hdus()[at];
    let (ordering, scheme) = (text(hdu, "ORDERING").to_owned(), text(hdu, "INDXSCHM").to_owned());
    if ordering != "NESTED" {
        return Err(malformed(format!(
            "its HEALPix pixels have ORDERING = '{ordering}': expected 'NESTED', as `healpy.reorder` makes it"
        )));
    }
    if scheme == "EXPLICIT" {
        return Err(malformed("its HEALPix map is a part of the sphere: expected the whole one"));
    }
    let table = reader.read_table(at).map_err(malformed)?;
    let named = |number: usize| {
        let name = table.schema().columns[number].name().map_err(malformed)?;
        Ok(name.unwrap_or_default().trim().to_owned())
    };
    let names = (0..table.schema().columns.len()).map(named);
    let names: Vec<String> = names.collect::<Result<_, GridReadError>>()?;
    let Some(quantity) = names.first().map(|name| stem(name).to_owned()) else {
        return Err(malformed("its HEALPix table has no column"));
    };
    let of = |stem_of: &str| {
        let same = |number: &usize| stem(&names[*number]) == stem_of;
        (0..names.len()).filter(same).collect::<Vec<usize>>()
    };
    let of_component = |component: &str, ending: &str| {
        let name = format!("{component}{ending}").to_uppercase();
        let is_own = |number: &usize| {
            let after = names[*number].strip_prefix(name.as_str());
            let is_band = |after: &str| {
                let number = after.strip_prefix('_').unwrap_or_default();
                !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())
            };
            after.is_some_and(|after| after.is_empty() || is_band(after))
        };
        (0..names.len()).filter(is_own).collect::<Vec<usize>>()
    };
    let of_all = |components: &[String], ending: &str| {
        let each = components.iter().flat_map(|component| of_component(component, ending));
        each.collect::<Vec<usize>>()
    };
    let (bands, errors) = match components {
        Some(components) => (of_all(components, ""), of_all(components, "_ERROR")),
        None => (of(&quantity), of(ERROR)),
    };
    if bands.is_empty() {
        return Err(malformed("its HEALPix table has no columns of its components"));
    }
    let values = joined(&table, &bands)?;
    let error = match errors.len() == bands.len() && quantity != ERROR {
        true => Some(joined(&table, &errors)?).filter(|error| error.len() == values.len()),
        false => None,
    };
    if values.len() % bands.len() != 0 || nside_of(values.len() / bands.len()).is_none() {
        let (values, bands) = (values.len(), bands.len());
        return Err(malformed(format!(
            "its HEALPix table has {values} values in {bands} columns: expected 12 nside^2 in each"
        )));
    }
    let unit = table.schema().columns[0].unit().map_err(malformed)?.map(str::trim);
    let unit = unit.filter(|unit| !unit.is_empty()).map(str::to_owned);
    Ok(Some(StoredSky { bands: bands.len(), values, unit, error }))
}

/// The values of columns, one column after the other.
fn joined(table: &Table, columns: &[usize]) -> Result<Vec<f64>, GridReadError> {
    let mut values = Vec::new();
    for &number in columns {
        let mut column = Vec::new();
        let reader = table.column(number).map_err(malformed)?;
        reader.physical_into(&mut column).map_err(malformed)?;
        values.append(&mut column);
    }
    Ok(values)
}

/// A name without the number of its band: `RADIANCE` of `RADIANCE_2`.
fn stem(name: &str) -> &str {
    match name.rsplit_once('_') {
        Some((stem, number)) if number.bytes().all(|byte| byte.is_ascii_digit()) => stem,
        _ => name,
    }
}

/// A keyword of an HDU; empty if it has none that is a text.
fn text<'a>(hdu: &'a Hdu, keyword: &str) -> &'a str {
    hdu.header.get_text(keyword).ok().flatten().unwrap_or_default().trim()
}

pub(super) fn malformed(reason: impl ToString) -> GridReadError {
    GridReadError::malformed(GridFormat::Fits, reason)
}
