//! Cubes in HDF5 and `NetCDF`: datasets and variables by name.
//!
//! Both are read as `NetCDF`: `NetCDF` 4 is HDF5, and an HDF5 file without dimension scales
//! has dimensions without names. What the conventions for `NetCDF` say of missing and packed values
//! holds for both: `_FillValue`, `missing_value` and the valid range, `scale_factor` and
//! `add_offset`.

use super::array::{Array, Container, Nodes};
use super::budget::{Budget, TWO_ORDERS};
use super::error::GridReadError;
use super::request::GridFormat;
use netcdf_reader::{NcFile, NcGroup, NcMetadataMode, NcOpenOptions, NcType, NcVariable};
use std::io::Read;

/// What `NetCDF` fills floating-point variables with that have no fill value of their own:
/// `NC_FILL_FLOAT` and `NC_FILL_DOUBLE`, the same number.
const DEFAULT_FILL: f64 = 9.969_209_968_386_869e36;

/// A file of datasets.
pub(super) struct Hdf5Cube {
    file: NcFile,
    format: GridFormat,
    /// The name of the values.
    values: String,
    /// The length of the file \[bytes\], all of which is in memory.
    length: u64,
    budget: Budget,
}

impl Hdf5Cube {
    /// The file of `length` bytes in a source.
    pub(super) fn open(
        mut source: impl Read,
        length: u64,
        format: GridFormat,
        budget: Budget,
    ) -> Result<Self, GridReadError> {
        let count = usize::try_from(length).unwrap_or(usize::MAX);
        budget.check(&[count], 1, 0)?;
        let mut bytes = Vec::new();
        let reserved = bytes.try_reserve_exact(count);
        reserved.map_err(|error| GridReadError::Unreadable(std::io::Error::other(error)))?;
        source.read_to_end(&mut bytes).map_err(GridReadError::Unreadable)?;
        let most = usize::try_from(budget.bytes()).unwrap_or(usize::MAX);
        let options = NcOpenOptions {
            // Datasets that are of no use here must not keep the others from being read.
            metadata_mode: NcMetadataMode::Lossy,
            max_read_bytes: most,
            ..NcOpenOptions::default()
        };
        let file = NcFile::from_owner(bytes, options)
            .map_err(|error| GridReadError::malformed(format, error))?;
        Ok(Self { file, format, values: String::new(), length, budget })
    }

    fn malformed(&self, reason: impl ToString) -> GridReadError {
        GridReadError::malformed(self.format, reason)
    }

    fn names(&self) -> Result<Vec<String>, GridReadError> {
        let root = self.file.root_group().map_err(|error| self.malformed(error))?;
        let mut names = Vec::new();
        collect_names(root, "", &mut names);
        Ok(names)
    }

    /// The folder of groups that the values are in, with a `/` at its end unless it is the root.
    fn group(&self) -> &str {
        self.values.rfind('/').map_or("", |end| &self.values[..=end])
    }

    /// The variable along a dimension of the values, if there is one of its name.
    fn coordinate(&self, place: usize) -> Option<String> {
        let dimension = self.file.variable(&self.values).ok()?.dimensions().get(place)?;
        let names = [format!("{}{}", self.group(), dimension.name), dimension.name.clone()];
        names.into_iter().find(|name| self.file.variable(name).is_ok_and(|found| found.ndim() == 1))
    }
}

impl Container for Hdf5Cube {
    fn values(&mut self, name: Option<&str>) -> Result<Array, GridReadError> {
        name.unwrap_or("values").trim_start_matches('/').clone_into(&mut self.values);
        let name = self.values.clone();
        self.array(&name)
    }

    fn array(&mut self, name: &str) -> Result<Array, GridReadError> {
        let name = name.trim_start_matches('/');
        let Ok(variable) = self.file.variable(name) else {
            return Err(GridReadError::Missing { name: name.to_owned(), available: self.names()? });
        };
        let shape: Vec<usize> = variable
            .dimensions()
            .iter()
            .map(|dimension| usize::try_from(dimension.size).unwrap_or(usize::MAX))
            .collect();
        self.budget.check(&shape, bytes_each(variable), self.length)?;
        let values = self
            .file
            .read_variable_unpacked_masked(name)
            .map_err(|error| self.malformed(format!("the array `{name}`: {error}")))?;
        let shape = values.shape().to_vec();
        let mut values = if values.is_standard_layout() {
            values.into_raw_vec_and_offset().0
        } else {
            // Chunks may come in any memory order; this is the logical one.
            self.budget.check(&shape, TWO_ORDERS, self.length)?;
            values.iter().copied().collect()
        };
        mask_default_fill(variable, &mut values);
        let mut array = Array::c_order(shape, values);
        let unit = variable.attribute("units").and_then(|unit| unit.value.as_string());
        array.unit = unit.map(|unit| unit.trim().to_owned()).filter(|unit| !unit.is_empty());
        array.axis_names = variable.dimensions().iter().map(|d| d.name.clone()).collect();
        Ok(array)
    }

    fn nodes(
        &mut self,
        _: usize,
        names: &[&str],
        place: usize,
        _: &Array,
    ) -> Result<Nodes, GridReadError> {
        let in_group = |name: &&str| format!("{}{name}", self.group());
        let named = || names.iter().map(in_group).find(|name| self.file.variable(name).is_ok());
        let name = self.coordinate(place).or_else(named);
        let name = name.or(names.first().map(in_group)).unwrap_or_default();
        let last = name.rsplit('/').next().unwrap_or_default().to_owned();
        Nodes::of(&last, self.array(&name)?)
    }
}

/// What a number of a variable takes while it is read: as it is stored and as it is used, which is the
/// same for double precision.
fn bytes_each(variable: &NcVariable) -> u64 {
    let stored = match variable.dtype() {
        NcType::Double => 0,
        NcType::Byte | NcType::UByte | NcType::Char => 1,
        NcType::Short | NcType::UShort => 2,
        NcType::Int | NcType::UInt | NcType::Float => 4,
        _ => 8,
    };
    stored + size_of::<f64>() as u64
}

/// The names of all variables, with the groups that they are in.
fn collect_names(group: &NcGroup, path: &str, names: &mut Vec<String>) {
    names.extend(group.variables.iter().map(|variable| format!("{path}{}", variable.name())));
    for inner in &group.groups {
        collect_names(inner, &format!("{path}{}/", inner.name), names);
    }
}

/// What was never written is missing, even where no attribute says so.
fn mask_default_fill(variable: &NcVariable, values: &mut [f64]) {
    let real = matches!(variable.dtype(), NcType::Float | NcType::Double);
    if real && variable.attribute("_FillValue").is_none() {
        let filled = |value: &&mut f64| value.to_bits() == DEFAULT_FILL.to_bits();
        values.iter_mut().filter(filled).for_each(|value| *value = f64::NAN);
    }
}
