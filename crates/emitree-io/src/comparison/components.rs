//! The components of a rendering of several emission rates, as a FITS file has them: an HDU for each.

use crate::grid::{GridReadError, GridRequest, read_arrays};
use crate::rendered_components::NUMBER_OF_COMPONENTS;
use fits_well::FitsReader;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// The images of all components, one after the other; those of cubes band by band.
pub(super) struct StoredComponents {
    /// Bands, rows and columns.
    pub(super) shape: [usize; 3],
    pub(super) values: Vec<f64>,
    pub(super) unit: Option<String>,
    pub(super) error: Option<Vec<f64>>,
}

/// The names of the components in a file; none if it is not of a rendering of several emission rates, or can't be
/// read at all.
pub(super) fn names(path: &Path) -> Option<Vec<String>> {
    let reader = FitsReader::open(BufReader::new(File::open(path).ok()?)).ok()?;
    let header = &reader.hdus().first()?.header;
    let count = header.get_integer(NUMBER_OF_COMPONENTS).ok().flatten()?;
    let name = |number: i64| {
        let found = header.get_text(format!("COMP{number}").as_str()).ok().flatten()?;
        Some(found.trim().to_owned())
    };
    (1..=count).map(name).collect()
}

/// The images of all components, with their errors if all of them have some.
///
/// # Errors
///
/// [`GridReadError`]: a component that is missing, or has another shape than the first one.
pub(super) fn read(path: &Path, names: &[String]) -> Result<StoredComponents, GridReadError> {
    let (mut values, mut errors, mut unit, mut sides) = (Vec::new(), Vec::new(), None, Vec::new());
    let mut has_errors = true;
    read_arrays(path, &GridRequest::default(), |file| {
        for (number, name) in names.iter().enumerate() {
            let array = file.array(name)?;
            if number == 0 {
                (sides, unit) = (array.shape.clone(), array.unit().map(str::to_owned));
            } else if array.shape != sides {
                let reason = format!(
                    "its component {name} has the shape {:?}: expected {sides:?}, that of {}",
                    array.shape, names[0]
                );
                return Err(super::healpix::malformed(reason));
            }
            let error = file.array(&format!("{name}_ERROR")).ok();
            match error.filter(|error| error.shape == sides) {
                Some(error) => errors.extend(error.into_c_order()),
                None => has_errors = false,
            }
            values.extend(array.into_c_order());
        }
        Ok(())
    })?;
    let shape = match *sides.as_slice() {
        [height, width] => [names.len(), height, width],
        [bins, height, width] => [names.len() * bins, height, width],
        _ => {
            let reason = format!("its components have the shape {sides:?}: expected 2 or 3 axes");
            return Err(super::healpix::malformed(reason));
        }
    };
    Ok(StoredComponents { shape, values, unit, error: has_errors.then_some(errors) })
}
