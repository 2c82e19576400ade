//! What to read from a file: its format, and where the values and the nodes are.

use super::angle_unit::AngleUnit;
use super::error::GridReadError;
use super::order::ArrayOrder;
use super::step::Step;
use emitree_models::grid::Coordinates;
use std::fmt;
use std::path::Path;

/// A format that grids are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum GridFormat {
    /// FITS: images.
    Fits,
    /// One array of `numpy`.
    Npy,
    /// Arrays of `numpy` by name, compressed or not.
    Npz,
    /// HDF5.
    Hdf5,
    /// `NetCDF`, classic or version 4.
    NetCdf,
    /// VTK, the legacy format or XML: images (structured points) and rectilinear grids.
    Vtk,
}

impl GridFormat {
    /// The endings that choose a format, lower case and without the dot.
    pub const ENDINGS: [(&'static str, Self); 10] = [
        ("fits", Self::Fits),
        ("fit", Self::Fits),
        ("npy", Self::Npy),
        ("npz", Self::Npz),
        ("h5", Self::Hdf5),
        ("hdf5", Self::Hdf5),
        ("nc", Self::NetCdf),
        ("vtk", Self::Vtk),
        ("vti", Self::Vtk),
        ("vtr", Self::Vtk),
    ];

    /// The formats by the names that scenes have for them.
    pub const NAMES: [(&'static str, Self); 6] = [
        ("fits", Self::Fits),
        ("npy", Self::Npy),
        ("npz", Self::Npz),
        ("hdf5", Self::Hdf5),
        ("netcdf", Self::NetCdf),
        ("vtk", Self::Vtk),
    ];

    /// The format that the ending of `path` stands for, upper or lower case.
    ///
    /// ```
    /// use emitree_io::grid::GridFormat;
    ///
    /// assert_eq!(GridFormat::from_path("cubes/run7.FITS".as_ref())?, GridFormat::Fits);
    /// let error = GridFormat::from_path("run7.dat".as_ref()).unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "no grid format for this ending: expected .fits, .fit, .npy, .npz, .h5, .hdf5, .nc, .vtk, .vti or .vtr"
    /// );
    /// # Ok::<(), emitree_io::grid::GridReadError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`GridReadError::Ending`] with the endings that there are.
    pub fn from_path(path: &Path) -> Result<Self, GridReadError> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let format = Self::ENDINGS.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(ending));
        match format {
            Some((_, format)) => Ok(format),
            // No grid, but the reader says what does read it.
            None if ["vts", "vtu"].iter().any(|name| name.eq_ignore_ascii_case(ending)) => {
                Ok(Self::Vtk)
            }
            None => Err(GridReadError::Ending),
        }
    }
}

impl fmt::Display for GridFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fits => "FITS",
            Self::Npy => "NPY",
            Self::Npz => "NPZ",
            Self::Hdf5 => "HDF5",
            Self::NetCdf => "NetCDF",
            Self::Vtk => "VTK",
        })
    }
}

/// Where the nodes along an axis come from.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum AxisNodes {
    /// From where the format has them by default.
    #[default]
    FromFile,
    /// An array of the file, by its name: a FITS extension, an array, a dataset.
    Named(String),
    /// These.
    List(Vec<f64>),
    /// At equal distances; at equal ratios where the axis is interpolated in its logarithm.
    Range {
        /// The first node.
        min: f64,
        /// The last node.
        max: f64,
    },
}

/// What to read from a file. The default has everything as the format has it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GridRequest {
    /// The format; by the ending of the file's name if it is not given.
    pub format: Option<GridFormat>,
    /// The name of the values: a FITS extension, an array, a dataset.
    pub values: Option<String>,
    /// What the axes are.
    pub coordinates: Coordinates,
    /// The nodes along the axes, in the order of their [names](Coordinates::names): lengths in the length unit of the
    /// scene, and angles.
    pub nodes: [AxisNodes; 3],
    /// Whether the nodes along θ are latitudes, from the plane of x and y; arrays of files that are named so have them
    /// anyway.
    pub has_latitudes: bool,
    /// The unit of the nodes that are angles; what the file says if it is not given.
    pub angle_unit: Option<AngleUnit>,
    /// Which axes are interpolated in the logarithm of their coordinate.
    pub are_logarithmic: [bool; 3],
    /// The order of the array's axes; what the file says, or z, y, x, or else phi, theta, r, or z, phi, rho, if it is
    /// not given.
    pub order: Option<ArrayOrder>,
    /// The step of values with a fourth axis.
    pub step: Option<Step>,
    /// What values are multiplied by.
    pub scale: f64,
    /// The memory that reading one array may take \[bytes\]; what is available if it is not given.
    pub max_memory_bytes: Option<u64>,
}

impl Default for GridRequest {
    fn default() -> Self {
        let nodes = [AxisNodes::FromFile, AxisNodes::FromFile, AxisNodes::FromFile];
        Self {
            format: None,
            values: None,
            coordinates: Coordinates::Cartesian,
            nodes,
            has_latitudes: false,
            angle_unit: None,
            are_logarithmic: [false; 3],
            order: None,
            step: None,
            scale: 1.0,
            max_memory_bytes: None,
        }
    }
}
