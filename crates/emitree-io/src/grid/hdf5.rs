//! Cubes in HDF5 and `NetCDF`: datasets and variables by name.
//!
//! Both are read as `NetCDF`: `NetCDF` 4 is HDF5, and an HDF5 file without dimension scales
//! has dimensions without names. What the conventions for `NetCDF` say of missing and packed values
//! holds for both: `_FillValue`, `missing_value` and the valid range, `scale_factor` and
//! `add_offset`.

use super::array::{Array, Container, Described, Nodes};
use super::budget::{Budget, TWO_ORDERS};
use super::error::GridReadError;
use super::openpmd::Mesh;
use super::request::GridFormat;
use netcdf_reader::{
    FileStorage, NcFile, NcGroup, NcMetadataMode, NcOpenOptions, NcSliceInfo, NcSliceInfoElem,
    NcType, NcVariable,
};
use std::fs::File;
use std::io::Read;
use std::sync::Arc;

/// What `NetCDF` fills floating-point variables with that have no fill value of their own:
/// `NC_FILL_FLOAT` and `NC_FILL_DOUBLE`, the same number.
const DEFAULT_FILL: f64 = 9.969_209_968_386_869e36;

/// A file of datasets.
pub(super) struct Hdf5Cube {
    file: NcFile,
    format: GridFormat,
    /// The name of the values.
    values: String,
    /// What of the file is in memory \[bytes\].
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
        let file = NcFile::from_owner(bytes, options(budget))
            .map_err(|error| GridReadError::malformed(format, error))?;
        Ok(Self { file, format, values: String::new(), length, budget })
    }

    /// The file, of which only what is asked for is read.
    pub(super) fn in_file(
        file: File,
        format: GridFormat,
        budget: Budget,
    ) -> Result<Self, GridReadError> {
        let malformed = |reason: String| GridReadError::malformed(format, reason);
        let storage = FileStorage::from_file(file).map_err(|error| malformed(error.to_string()))?;
        let file = NcFile::from_storage_with_options(Arc::new(storage), options(budget))
            .map_err(|error| malformed(error.to_string()))?;
        Ok(Self { file, format, values: String::new(), length: 0, budget })
    }

    /// A variable, or why there is none.
    fn variable(&self, name: &str) -> Result<&NcVariable, GridReadError> {
        let found = self.file.variable(name).ok();
        match found {
            Some(variable) => Ok(variable),
            None => Err(GridReadError::Missing { name: name.to_owned(), available: self.names()? }),
        }
    }

    /// A variable at the chosen places of some dimensions.
    fn read(&self, name: &str, selection: &[Option<usize>]) -> Result<Array, GridReadError> {
        let name = name.trim_start_matches('/');
        let variable = self.variable(name)?;
        let chosen = |place: usize| selection.get(place).copied().flatten();
        let kept = |(place, _): &(usize, &usize)| chosen(*place).is_none();
        let whole = lengths_of(variable);
        let shape: Vec<usize> =
            whole.iter().enumerate().filter(kept).map(|(_, &length)| length).collect();
        self.budget.check(&shape, bytes_each(variable), self.length)?;
        let read = if shape.len() == whole.len() {
            self.file.read_variable_unpacked_masked(name)
        } else {
            let selections = whole.iter().enumerate().map(|(place, &length)| match chosen(place) {
                Some(index) => NcSliceInfoElem::Index(index as u64),
                None => NcSliceInfoElem::Slice { start: 0, end: length as u64, step: 1 },
            });
            let slice = NcSliceInfo { selections: selections.collect() };
            self.file.read_variable_slice_unpacked_masked(name, &slice)
        };
        let values =
            read.map_err(|error| self.malformed(format!("the array `{name}`: {error}")))?;
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
        let names = variable.dimensions().iter().enumerate();
        let names = names.filter(|(place, _)| chosen(*place).is_none());
        array.axis_names = names.map(|(_, dimension)| dimension.name.clone()).collect();
        if let Some(mesh) = Mesh::of(&self.file, name) {
            let labels = mesh.labels.iter().enumerate();
            let labels = labels.filter(|(place, _)| chosen(*place).is_none());
            array.axis_names = labels.map(|(_, label)| label.clone()).collect();
            array.scale(mesh.unit_si);
        }
        Ok(array)
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
    fn coordinate(&self, place: usize, values: &Array) -> Option<String> {
        let dimension = values.axis_names.get(place)?;
        let names = [format!("{}{dimension}", self.group()), dimension.clone()];
        names.into_iter().find(|name| self.file.variable(name).is_ok_and(|found| found.ndim() == 1))
    }
}

impl Container for Hdf5Cube {
    fn describe(&mut self, name: Option<&str>) -> Result<Described, GridReadError> {
        name.unwrap_or("values").trim_start_matches('/').clone_into(&mut self.values);
        let variable = self.variable(&self.values)?;
        let names = variable.dimensions().iter().map(|dimension| dimension.name.clone());
        let labels = Mesh::of(&self.file, &self.values).map(|mesh| mesh.labels);
        let axis_names = labels.unwrap_or_else(|| names.collect());
        Ok(Described { shape: lengths_of(variable), axis_names })
    }

    fn values(
        &mut self,
        name: Option<&str>,
        selection: &[Option<usize>],
    ) -> Result<Array, GridReadError> {
        name.unwrap_or("values").trim_start_matches('/').clone_into(&mut self.values);
        self.read(&self.values, selection)
    }

    fn array_beside(&mut self, name: &str) -> Result<Array, GridReadError> {
        let in_group = format!("{}{name}", self.group());
        let is_there = self.file.variable(&in_group).is_ok();
        self.read(if is_there { &in_group } else { name }, &[])
    }

    fn array(&mut self, name: &str) -> Result<Array, GridReadError> {
        self.read(name, &[])
    }

    fn nodes(
        &mut self,
        _: usize,
        names: &[&str],
        place: usize,
        values: &Array,
    ) -> Result<Nodes, GridReadError> {
        let of_mesh = || Mesh::of(&self.file, &self.values)?.nodes(names, values.shape[place]);
        if let (None, Some(nodes)) = (self.coordinate(place, values), of_mesh()) {
            return Ok(Nodes::plain(nodes));
        }
        let in_group = |name: &&str| format!("{}{name}", self.group());
        let named = || names.iter().map(in_group).find(|name| self.file.variable(name).is_ok());
        let name = self.coordinate(place, values).or_else(named);
        let name = name.or(names.first().map(in_group)).unwrap_or_default();
        let last = name.rsplit('/').next().unwrap_or_default().to_owned();
        Nodes::of(&last, self.array(&name)?)
    }
}

fn options(budget: Budget) -> NcOpenOptions {
    NcOpenOptions {
        // Datasets that are of no use here must not keep the others from being read.
        metadata_mode: NcMetadataMode::Lossy,
        max_read_bytes: usize::try_from(budget.bytes()).unwrap_or(usize::MAX),
        ..NcOpenOptions::default()
    }
}

/// The lengths of the dimensions of a variable.
fn lengths_of(variable: &NcVariable) -> Vec<usize> {
    let length = |size: u64| usize::try_from(size).unwrap_or(usize::MAX);
    variable.dimensions().iter().map(|dimension| length(dimension.size)).collect()
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
