//! Files of emitree: scenes, grids and trees in; images as FITS, `HEALPix` FITS, NPY and PNG out.
//!
//! [`Scene`] reads a scene file and checks everything in it; [`grid`] reads cubes of data, from FITS,
//! NPY, NPZ, HDF5 and `NetCDF`; [`table`] reads tables of functions; [`TreeFile`] keeps a tree of an emission; [`units`] reads units in the
//! grammar of FITS and converts them. Encoders turn an [`Image`](emitree::Image) or a
//! [`Cube`](emitree::Cube) into bytes in memory:
//! [`FitsFile`] with coordinates ([`Wcs`]), [`HealpixFile`] for the whole sky, [`mollweide()`] for a
//! picture of it. An [`OutputFile`] turns bytes into a file that is whole or absent. Numbers leave as
//! FITS or NPY, surfaces as VTP or NPZ ([`SurfaceFormat`]); PNG is for display only.
//!
//! ```
//! use emitree_io::{Format, OutputFile, PictureStyle, RenderedScene, Scene};
//!
//! let text = r#"
//!     emission.expression = "exp(-x)"
//!     projection.type = "canonical"
//!     image = { width = 8, height = 8 }
//! "#;
//! let scene = Scene::parse("example", text, &[])?;
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("image.png");
//! let format = Format::from_path(&path)?;
//! let output = OutputFile::create(&path)?; // fails before the expensive part
//! let found = scene.render(&scene.emission, &scene.render_options())?;
//! let rendered = RenderedScene::new(&scene, &found);
//! let bytes = format.encode(&rendered.product(&scene), PictureStyle::default())?;
//! output.commit(&bytes)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod account;
mod advice;
mod colour;
mod energies;
mod exposure;
#[cfg(feature = "figure")]
pub mod figure;
mod comparison;
mod data_error;
mod fits;
mod forecast;
mod format;
pub mod grid;
mod grouped;
mod large;
mod memory;
mod mollweide;
mod npy;
mod output;
mod planned;
mod png;
mod product;
mod rehearsal;
mod rendered;
mod rendered_components;
mod report;
pub mod scene;
mod sky;
mod surfaces;
mod sweep;
pub mod table;
mod templates;
mod tree_file;
pub mod units;
mod words;

pub use account::{Account, Bins, Exposed, SumAccount};
pub use colour::{ColourMap, ValueRange};
pub use comparison::{Comparison, ComparisonError, Difference, StoredImage};
pub use energies::{Energies, energy_range};
pub use exposure::{Events, Exposure, Motion, Path, PathError};
pub use fits::{
    Card, CardValue, Celestial, FitsEncodeError, FitsFile, FitsImage, HealpixColumn, HealpixFile,
    Wcs, WcsAxis,
};
pub use forecast::CostLaw;
pub use format::{EncodeError, Format, FormatDescription, PictureStyle, UnknownEnding};
pub use grouped::grouped;
pub use large::{LargeError, LargeOutput, write_large};
pub use memory::{available_memory_bytes, peak_memory_bytes};
pub use mollweide::{East, mollweide, picture_of_sky};
pub use npy::{NpyError, encode_npy, encode_npy_cube, encode_npy_image};
pub use output::{OutputError, OutputFile, OutputSet, commit_all};
pub use planned::{PlannedError, PlannedPoints, PlannedRun, PointsFormat};
pub use png::{PictureError, PictureOptions, encode_png};
pub use product::{Bands, FitsProduct, Product, ProductMap, scene_history};
pub use rehearsal::{Forecast, Rehearsal, Remark};
pub use rendered::RenderedScene;
pub use rendered_components::RenderedComponents;
pub use report::{ComponentsReport, CountsReport, Report};
pub use scene::{
    BuildSettings, Camera, CameraDescription, CameraKey, ComponentEmission, ComponentRates,
    EmissionFailure, EmissionSource, FitsCoordinates, GridEmission, KeyDefault, KeyUnit, Override,
    PixelLayout, PlotAxis, PlotFrame, PlotScale, Quantity, RenderSettings, Scene, SceneAbsorption,
    SceneComponents, SceneEmission, SceneError, SceneInstrument, SceneSum, cameras,
};
pub use sky::{Pointing, Sky, SkyCoordinates, SkyCoordinatesDescription, SkyDate, SolarObserver};
pub use surfaces::SurfaceFormat;
pub use sweep::{NameTemplate, SceneSweep, SweepError, SweepReport, SweptImage, SweptKey};
pub use templates::{SceneTemplate, scene_templates};
pub use tree_file::{TreeFile, TreeFileError};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
