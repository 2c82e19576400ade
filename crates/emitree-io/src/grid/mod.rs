//! Cubes of gridded data from files: FITS, NPY, NPZ, HDF5, `NetCDF` and VTK.
//!
//! [`read_grid`] makes a [`Grid`] of a file and a [`GridRequest`], which says where in the file the
//! values and the nodes of the axes are. An array's axes are in the order z, y, x with x varying
//! fastest, as in a FITS image with NAXIS1 = x, unless the request or the file says otherwise; of spherical
//! coordinates the order is φ, θ, r, and of cylindrical ones z, φ, ρ.
//!
//! | format | values by default | nodes by default |
//! | --- | --- | --- |
//! | FITS | the first image | the image extensions `x`, `y`, `z`, by name or, without names, by order; else CRPIX, CRVAL, CDELT |
//! | NPY | the array | none: the request has to give them |
//! | NPZ | `values` | the arrays `x`, `y`, `z` |
//! | HDF5, `NetCDF` | `values` | the coordinate variables of the dimensions; else those of a mesh of openPMD, in m; else `x`, `y`, `z` |
//! | VTK | the only scalar array | the coordinates of the points, or the centres of the cells |
//!
//! No array is read that takes more memory than there is: sizes are compared first, and a file is read
//! in place, so that the values are in memory once (HDF5 and `NetCDF`: with the numbers as they are stored).
//! Of values with one more axis, such as time, the requested [`Step`] alone is read.
//!
//! The files of this module: `request.rs`, `step.rs`, `order.rs`, `angle_unit.rs` and `error.rs` are its interface,
//! `array.rs`, `selection.rs` and `budget.rs` are common to all formats, and each format has a file.

mod angle_unit;
mod angles;
mod array;
mod budget;
mod error;
mod fits;
#[cfg(feature = "hdf5")]
mod hdf5;
mod npy;
mod npz;
#[cfg(feature = "hdf5")]
mod openpmd;
mod order;
mod request;
mod selection;
mod step;
mod vtk;

pub use angle_unit::AngleUnit;
pub(crate) use error::one_of;
pub use error::{GridFileError, GridReadError};
pub use order::{ArrayOrder, NotAnOrder};
pub use request::{AxisNodes, GridFormat, GridRequest};
pub use step::{Step, StepAt};

use angles::{AngleKind, in_radians};
use array::{Array, Container, Nodes};
use budget::Budget;
use emitree::Image;
use emitree_models::grid::{GridAxes, logarithmic_nodes, uniform_nodes};
use emitree_models::{Grid, GridError};
use order::{is_latitude, names_of};
use std::fs::{self, File};
use std::io::{self, BufReader, Cursor, Read, Seek};
use std::path::Path;

/// What a file has: the grid, and the unit of its values if the file has one.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GridFile {
    /// The values at their nodes, times the scale of the request.
    pub grid: Grid,
    /// The unit of the values: BUNIT of FITS, the attribute `units` of HDF5 and `NetCDF`.
    pub unit: Option<String>,
}

/// Reads the grid in the file at `path`.
///
/// ```
/// use emitree_io::encode_npy;
/// use emitree_io::grid::{AxisNodes, GridRequest, read_grid};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("cube.npy");
/// let values: Vec<f64> = (0..24).map(f64::from).collect();
/// std::fs::write(&path, encode_npy(&[2, 3, 4], &values)?)?; // [z, y, x]
///
/// let mut request = GridRequest::default();
/// request.nodes = [
///     AxisNodes::Range { min: -1.0, max: 1.0 },
///     AxisNodes::List(vec![0.0, 1.0, 10.0]),
///     AxisNodes::Range { min: 0.0, max: 1.0 },
/// ];
/// let file = read_grid(&path, &request)?;
/// assert_eq!(file.grid.shape(), [4, 3, 2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`GridFileError`] names the file, what is wrong in it, and what was expected.
pub fn read_grid(path: &Path, request: &GridRequest) -> Result<GridFile, GridFileError> {
    read(path, request, assemble)
}

/// Reads a map of pixels, such as weights: the first image of a FITS file, or the array of an NPY file; row 0
/// is the lowest.
///
/// # Errors
///
/// [`GridFileError`] names the file, what is wrong in it, and what was expected.
pub fn read_map(path: &Path) -> Result<Image, GridFileError> {
    read(path, &GridRequest::default(), map)
}

/// An array of a file with the array of its errors.
pub(crate) struct StoredArray {
    /// The length of each axis, the slowest one first.
    pub(crate) shape: Vec<usize>,
    /// The values in that order.
    pub(crate) values: Vec<f64>,
    pub(crate) unit: Option<String>,
    /// The array `ERROR` of the same shape, if there is one.
    pub(crate) error: Option<Vec<f64>>,
}

/// Reads the first image of a FITS file with its extension `ERROR`, or the array of an NPY file.
pub(crate) fn read_stored(path: &Path) -> Result<StoredArray, GridFileError> {
    read(path, &GridRequest::default(), stored)
}

fn stored(
    container: &mut dyn Container,
    request: &GridRequest,
    _: Budget,
) -> Result<StoredArray, GridReadError> {
    let array = container.values(request.values.as_deref(), &[])?;
    let (shape, unit) = (array.shape.clone(), array.unit.clone());
    // Most files have no such array, and NPY has no names.
    let error = container.array("ERROR").ok().filter(|error| error.shape == shape);
    let error = error.map(Array::into_c_order);
    Ok(StoredArray { shape, values: array.into_c_order(), unit, error })
}

/// What `make` makes of the file at `path`.
fn read<T>(path: &Path, request: &GridRequest, make: Make<T>) -> Result<T, GridFileError> {
    let in_file = |cause| GridFileError { path: path.to_owned(), cause };
    read_with(path, request, |container, budget| make(container, request, budget)).map_err(in_file)
}

/// What `make` makes of arrays of the file at `path`, of which `request` has the format.
pub(crate) fn read_arrays<T>(
    path: &Path,
    request: &GridRequest,
    make: impl FnOnce(&mut dyn Container) -> Result<T, GridReadError>,
) -> Result<T, GridReadError> {
    read_with(path, request, |container, _| make(container))
}

fn read_with<T>(
    path: &Path,
    request: &GridRequest,
    make: impl FnOnce(&mut dyn Container, Budget) -> Result<T, GridReadError>,
) -> Result<T, GridReadError> {
    let format = match request.format {
        Some(format) => format,
        None => GridFormat::from_path(path)?,
    };
    let opened = fs::metadata(path).and_then(|metadata| {
        // A pipe or a device has no length that could be compared with the memory.
        let ordinary = metadata.is_file().then_some(()).ok_or(io::ErrorKind::InvalidInput);
        ordinary.map_err(|kind| io::Error::new(kind, "it is not an ordinary file"))?;
        Ok((File::open(path)?, metadata.len()))
    });
    let (file, length) = opened.map_err(GridReadError::Unreadable)?;
    #[cfg(feature = "hdf5")]
    if matches!(format, GridFormat::Hdf5 | GridFormat::NetCdf) {
        let budget = Budget::of(request);
        return make(&mut hdf5::Hdf5Cube::in_file(file, format, budget)?, budget);
    }
    let file = BufReader::with_capacity(BUFFER, file);
    decode(file, length, format, request, make)
}

/// Bytes that are read from a file at once.
const BUFFER: usize = 1 << 18;

/// Reads the grid in the bytes of a file, whatever format the request names.
///
/// # Errors
///
/// [`GridReadError`] states what is wrong, and what was expected.
pub fn decode_grid(
    bytes: Vec<u8>,
    format: GridFormat,
    request: &GridRequest,
) -> Result<GridFile, GridReadError> {
    let length = bytes.len() as u64;
    let source = Cursor::new(bytes);
    decode(source, length, format, request, |container, budget| {
        assemble(container, request, budget)
    })
}

/// What is made of an opened file.
type Make<T> = fn(&mut dyn Container, &GridRequest, Budget) -> Result<T, GridReadError>;

/// What `make` makes of `length` bytes.
fn decode<R: Read + Seek, T>(
    source: R,
    length: u64,
    format: GridFormat,
    request: &GridRequest,
    make: impl FnOnce(&mut dyn Container, Budget) -> Result<T, GridReadError>,
) -> Result<T, GridReadError> {
    let budget = Budget::of(request);
    let container: &mut dyn Container = match format {
        GridFormat::Fits => &mut fits::FitsCube::open(source, budget)?,
        GridFormat::Npy => &mut npy::NpyCube::open(source, length, budget)?,
        GridFormat::Npz => &mut npz::NpzCube::open(source, budget)?,
        GridFormat::Vtk => &mut vtk::VtkCube::open(source, length, budget)?,
        #[cfg(feature = "hdf5")]
        GridFormat::Hdf5 | GridFormat::NetCdf => {
            &mut hdf5::Hdf5Cube::open(source, length, format, budget)?
        }
        #[cfg(not(feature = "hdf5"))]
        GridFormat::Hdf5 | GridFormat::NetCdf => return Err(GridReadError::NotBuilt(format)),
    };
    make(container, budget)
}

/// The map of pixels in a file.
fn map(
    container: &mut dyn Container,
    request: &GridRequest,
    _: Budget,
) -> Result<Image, GridReadError> {
    let array = container.values(request.values.as_deref(), &[])?;
    let &[height, width] = array.shape.as_slice() else {
        return Err(GridReadError::NotAMap { shape: array.shape });
    };
    Ok(Image::from_pixels(height, width, array.into_rows()))
}

fn assemble(
    container: &mut dyn Container,
    request: &GridRequest,
    budget: Budget,
) -> Result<GridFile, GridReadError> {
    let selection = selection::selection(container, request)?;
    let array = container.values(request.values.as_deref(), &selection)?;
    let &[_, _, _] = array.shape.as_slice() else {
        return Err(GridReadError::NotACube { shape: array.shape });
    };
    let order = array.order(request.coordinates, request.order)?;
    let axes = read_axes(container, request, &array, order)?;
    let unit = array.unit.clone();
    let mut values = array.into_x_fastest(order, budget)?;
    if request.scale.to_bits() != 1.0_f64.to_bits() {
        values.iter_mut().for_each(|value| *value *= request.scale);
    }
    let grid = Grid::on(axes, values).map_err(|error| match error {
        GridError::ValueNotFinite { .. } => GridReadError::NotFinite(error),
        other => GridReadError::Grid(other),
    })?;
    Ok(GridFile { grid, unit })
}

/// The axes of a grid whose values are an array.
fn read_axes(
    container: &mut dyn Container,
    request: &GridRequest,
    array: &Array,
    order: ArrayOrder,
) -> Result<GridAxes, GridReadError> {
    let names = request.coordinates.names();
    let mut nodes = [const { Vec::new() }; 3];
    for (axis, nodes) in nodes.iter_mut().enumerate() {
        *nodes =
            read_nodes(container, request, axis, array, order).map_err(|cause| match cause {
                GridReadError::Grid(error) => GridReadError::Grid(error),
                cause => GridReadError::Axis { axis: names[axis], cause: Box::new(cause) },
            })?;
    }
    let axes = GridAxes::new(request.coordinates, nodes).map_err(GridReadError::Grid)?;
    let chosen = (0..3).filter(|&axis| request.are_logarithmic[axis]);
    chosen.into_iter().try_fold(axes, GridAxes::with_logarithmic).map_err(GridReadError::Grid)
}

/// The nodes along an axis (0 is x), as many as the array has there, angles as grids have them.
fn read_nodes(
    container: &mut dyn Container,
    request: &GridRequest,
    axis: usize,
    array: &Array,
    order: ArrayOrder,
) -> Result<Vec<f64>, GridReadError> {
    let place = order.place_of(axis);
    let length = array.shape[place];
    let nodes = match &request.nodes[axis] {
        AxisNodes::FromFile => {
            container.nodes(axis, names_of(request.coordinates, axis), place, array)?
        }
        AxisNodes::Named(name) => Nodes::of(name, container.array(name)?)?,
        AxisNodes::List(nodes) => Nodes::plain(nodes.clone()),
        &AxisNodes::Range { min, max } if request.are_logarithmic[axis] && min > 0.0 => {
            Nodes::plain(logarithmic_nodes(min, max, length))
        }
        &AxisNodes::Range { min, max } => Nodes::plain(uniform_nodes(min, max, length)),
    };
    if nodes.values.len() != length {
        let (found, shape) = (nodes.values.len(), array.shape.clone());
        return Err(GridReadError::AxisLength { found, length, shape, order });
    }
    if !request.coordinates.are_angles()[axis] {
        return Ok(nodes.values);
    }
    let name = request.coordinates.names()[axis];
    let kind = match name {
        "theta" if request.has_latitudes || is_latitude(&nodes.name) => AngleKind::Latitude,
        "theta" => AngleKind::Colatitude,
        _ => AngleKind::Azimuth,
    };
    let of_file = nodes.unit.as_deref().and_then(AngleUnit::from_attribute);
    let unit = request.angle_unit.or(of_file).ok_or(GridReadError::NoAngleUnit)?;
    in_radians(name, kind, unit, nodes.values)
}

#[cfg(test)]
mod tests;
