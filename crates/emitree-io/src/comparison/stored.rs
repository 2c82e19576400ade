//! An image, a cube or a sky as a file has it: FITS or NPY, of any origin.

use super::{ComparisonError, components, healpix};
use crate::format::Format;
use crate::grid::read_stored;
use std::path::Path;

/// An image or a cube that was read from a file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StoredImage {
    /// The name of the file.
    pub name: String,
    /// Bands, rows and columns; a sky has one row, of pixels in nested order.
    pub shape: [usize; 3],
    /// Whether the pixels are those of `HEALPix`.
    pub is_sky: bool,
    /// The values, band after band, row after row, the lowest row first.
    pub values: Vec<f64>,
    /// Their unit, if the file has one.
    pub unit: Option<String>,
    /// The estimated |error| of each value, if the file has an array of that name and shape.
    pub error: Option<Vec<f64>>,
}

impl StoredImage {
    /// Values without a unit; none unless there is one for each pixel.
    pub fn new(name: &str, shape: [usize; 3], values: Vec<f64>) -> Option<Self> {
        let count = shape.iter().try_fold(1_usize, |product, &n| product.checked_mul(n))?;
        let name = name.to_owned();
        let (is_sky, unit, error) = (false, None, None);
        (count == values.len()).then_some(Self { name, shape, is_sky, values, unit, error })
    }

    /// Reads a file: the first image of FITS, with its extension `ERROR`, or its `HEALPix` map, with its columns
    /// `ERROR`; the array of NPY. The components of a rendering of several emission rates are bands, one component
    /// after the other. An array of one axis is an image of one row, as a sky is in NPY.
    ///
    /// # Errors
    ///
    /// [`ComparisonError`]: a file that can't be read, or whose array has more than three axes.
    pub fn open(path: &Path) -> Result<Self, ComparisonError> {
        let has_numbers = Format::from_path(path).is_ok_and(|of| !of.description().is_picture);
        if !has_numbers {
            return Err(ComparisonError::Ending { path: path.to_owned() });
        }
        let in_file = |cause| ComparisonError::File { path: path.to_owned(), cause };
        let components = components::names(path);
        if let Some(sky) = healpix::read(path, components.as_deref()).map_err(in_file)? {
            let shape = [sky.bands, 1, sky.values.len() / sky.bands];
            let name = path.display().to_string();
            let (values, unit, error) = (sky.values, sky.unit, sky.error);
            return Ok(Self { name, shape, is_sky: true, values, unit, error });
        }
        if let Some(names) = components {
            let found = components::read(path, &names).map_err(in_file)?;
            let (shape, values, unit, error) = (found.shape, found.values, found.unit, found.error);
            let name = path.display().to_string();
            return Ok(Self { name, shape, is_sky: false, values, unit, error });
        }
        let stored = read_stored(path)
            .map_err(|error| ComparisonError::File { path: error.path, cause: error.cause })?;
        let shape = match *stored.shape.as_slice() {
            [width] => [1, 1, width],
            [height, width] => [1, height, width],
            [bands, height, width] => [bands, height, width],
            _ => [0; 3],
        };
        if shape.contains(&0) {
            return Err(ComparisonError::Axes { path: path.to_owned(), shape: stored.shape });
        }
        Ok(Self {
            name: path.display().to_string(),
            shape,
            is_sky: false,
            values: stored.values,
            unit: stored.unit,
            error: stored.error,
        })
    }

    /// The largest |value| that is finite.
    pub(super) fn largest(&self) -> f64 {
        let sizes = self.values.iter().map(|value| value.abs());
        sizes.filter(|size| size.is_finite()).fold(0.0, f64::max)
    }
}
