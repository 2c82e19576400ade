//! Columns of a FITS table.

use super::columns::{Column, Columns};
use super::error::{Place, TableReadError};
use super::request::TableRequest;
use fits_well::FitsReader;
use fits_well::io::Hdu;
use fits_well::table::Storage;

/// The columns of one number a row; `None` of a file without tables, unless one is named.
pub(super) fn columns(
    bytes: Vec<u8>,
    request: &TableRequest,
) -> Result<Option<Columns>, TableReadError> {
    let fits = |error: fits_well::FitsError| TableReadError::Fits(error.to_string());
    let mut reader = FitsReader::open(std::io::Cursor::new(bytes)).map_err(fits)?;
    let tables = || reader.hdus().iter().filter(|hdu| hdu.table_schema().is_ok());
    let chosen = match &request.extension {
        Some(name) => {
            let found = tables().find(|hdu| name_of(hdu).eq_ignore_ascii_case(name));
            Some(found.map(|hdu| hdu.index).ok_or_else(|| {
                let names = tables().map(name_of).filter(|name| !name.is_empty());
                let available = names.map(str::to_owned).collect();
                TableReadError::NoExtension { name: name.clone(), available }
            })?)
        }
        None => tables().next().map(|hdu| hdu.index),
    };
    let Some(index) = chosen else {
        return match reader.scan_defect() {
            Some(defect) => Err(TableReadError::Fits(defect.to_string())),
            None => Ok(None),
        };
    };
    let table = reader.read_table(index).map_err(fits)?;
    let rows = table.schema().row_count();
    let wanted = |name: &str| {
        let is_all = request.axes.is_empty() || request.values.is_none();
        is_all || request.axes.iter().chain(&request.values).any(|other| other == name)
    };
    let mut columns = Vec::new();
    let mut others = Vec::new();
    for (number, descriptor) in table.schema().columns.iter().enumerate() {
        let name = match descriptor.name().map_err(fits)? {
            Some(name) => name.trim().to_owned(),
            None => (number + 1).to_string(),
        };
        if !wanted(&name) {
            others.push(Column::new(name));
            continue;
        }
        let repeat = descriptor.tform.repeat();
        if descriptor.tform.storage() != Storage::Fixed || repeat != 1 {
            return Err(TableReadError::NotScalar { column: name, found: repeat });
        }
        let mut values: Vec<f64> = Vec::with_capacity(rows);
        let reader = table.column(number).map_err(fits)?;
        reader
            .physical_into(&mut values)
            .map_err(|error| TableReadError::Fits(format!("the column `{name}`: {error}")))?;
        let mut column = Column::new(name);
        for (row, value) in values.into_iter().enumerate() {
            column.push(Some(value), &value.to_string(), Place::Row(row + 1));
        }
        columns.push(column);
    }
    if rows == 0 {
        return Err(TableReadError::NoRows("rows of numbers"));
    }
    // Those that are not read are known by their names, for messages.
    columns.extend(others);
    Ok(Some(Columns { columns, places: (1..=rows).map(Place::Row).collect() }))
}

/// The name of an HDU; empty if there is none to be read.
fn name_of(hdu: &Hdu) -> &str {
    hdu.extname().ok().flatten().unwrap_or_default().trim()
}
