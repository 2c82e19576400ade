//! The scene and the cost of a rendering as plain data, so that results can be pickled and copied, and
//! need neither the emission nor any file afterwards.

use emitree::{Cube, EnergyAxis, EnergyScale, Image, Method, Rendering, StopReason};
use emitree_io::units::Unit;
use emitree_io::{Energies, Provenance, Scene, Wcs, WcsAxis, scene_history};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The scene that was rendered, as its results need it, and the cost.
#[derive(Clone, Debug, IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct About {
    /// The name of the file.
    pub(crate) scene: String,
    /// The text of the scene, without what was changed.
    pub(crate) text: String,
    /// What was changed, as `key = value`.
    pub(crate) overrides: Vec<String>,
    pub(crate) method: String,
    pub(crate) order: Option<usize>,
    pub(crate) tolerance: Option<f64>,
    pub(crate) ignored: Vec<String>,
    pub(crate) quantity: String,
    pub(crate) unit: String,
    /// The unit of the whole energy band, and what a sum of voxels times bins is multiplied with for it.
    pub(crate) band_unit: String,
    pub(crate) band_factor: f64,
    pub(crate) length_unit: Option<String>,
    /// Whether the pixels are those of `HEALPix`.
    pub(crate) is_sky: bool,
    pub(crate) coordinates: Option<Coordinates>,
    pub(crate) bins: Option<Bins>,
    /// Exposure \[s\] and seed of the instrument, if there is one.
    pub(crate) exposure_s: Option<f64>,
    pub(crate) seed: Option<u64>,
    pub(crate) evaluations: u64,
    pub(crate) batches: u64,
    pub(crate) ending: String,
    pub(crate) threshold: Option<f64>,
    pub(crate) leaves_per_level: Vec<usize>,
    /// How many energies were evaluated.
    pub(crate) energies: Option<usize>,
    pub(crate) base_level: Option<u8>,
    /// The standard deviation of the smallest Gaussian that would have been detected, as a fraction of
    /// the view's cube.
    pub(crate) smallest_feature: Option<f64>,
    pub(crate) emission_seconds: f64,
    pub(crate) total_seconds: f64,
}

/// Coordinates of the pixels: [`Wcs`] as plain data.
#[derive(Clone, Debug, IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Coordinates {
    name: String,
    axes: Vec<Axis>,
    pole_deg: Option<[f64; 2]>,
}

/// One of them: [`WcsAxis`].
#[derive(Clone, Debug, IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
struct Axis {
    ctype: String,
    cunit: Option<String>,
    cname: String,
    crpix: f64,
    crval: f64,
    cdelt: f64,
}

/// The bins of a cube: [`Energies`] as plain data.
#[derive(Clone, Debug, IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Bins {
    pub(crate) min: f64,
    pub(crate) max: f64,
    pub(crate) unit: String,
    pub(crate) bins: usize,
    pub(crate) scale: String,
}

impl About {
    pub(crate) fn new(scene: &Scene, found: &Rendering<Cube>) -> Self {
        let tree = found.tree.as_ref();
        let leaves = tree.map_or_else(Vec::new, |built| built.tree.leaves_per_level());
        let stats = &found.stats;
        Self {
            evaluations: stats.evaluations,
            batches: stats.batches,
            ending: ending(stats.ending).to_owned(),
            threshold: tree.map(|built| built.threshold),
            leaves_per_level: leaves.into_iter().collect(),
            energies: Some(stats.energies.len()).filter(|&energies| energies > 0),
            base_level: stats.base_level,
            smallest_feature: stats.smallest_feature,
            emission_seconds: stats.emission_time.as_secs_f64(),
            total_seconds: stats.total_time.as_secs_f64(),
            ..Self::of_scene(scene)
        }
    }

    /// The contents of a scene before the rendering.
    fn of_scene(scene: &Scene) -> Self {
        let render = &scene.render;
        let length = scene.length_unit.as_deref().and_then(|unit| Unit::parse(unit).ok());
        let wcs = scene.camera.wcs(scene.height, scene.width, &length.unwrap_or_else(Unit::one));
        let one = scene.in_band_unit(Image::from_pixels(1, 1, vec![1.0]));
        Self {
            scene: scene.name.clone(),
            text: scene.text.clone(),
            overrides: scene.overrides.clone(),
            method: render.method.name().to_owned(),
            order: match &render.method {
                Method::Paper(options) => Some(options.order),
                _ => None,
            },
            tolerance: render.tolerance,
            ignored: render.ignored.iter().map(|&key| key.to_owned()).collect(),
            quantity: scene.quantity.name().to_owned(),
            unit: scene.image_unit().to_owned(),
            band_unit: scene.band_unit().to_owned(),
            band_factor: one[(0, 0)],
            length_unit: scene.length_unit.clone(),
            is_sky: scene.camera.description().is_sky(),
            coordinates: wcs.map(Coordinates::from),
            bins: scene.energy.as_ref().map(Bins::from),
            exposure_s: scene.instrument.as_ref().map(|found| found.instrument.exposure_s),
            seed: scene.instrument.as_ref().map(|found| found.seed),
            evaluations: 0,
            batches: 0,
            ending: String::new(),
            threshold: None,
            leaves_per_level: Vec::new(),
            energies: None,
            base_level: None,
            smallest_feature: None,
            emission_seconds: 0.0,
            total_seconds: 0.0,
        }
    }

    /// Whether the stopping criterion was met.
    pub(crate) fn converged(&self) -> bool {
        self.ending == ending(StopReason::Complete)
    }

    /// The coordinates of the pixels; none for a sky in `HEALPix` pixels.
    pub(crate) fn wcs(&self) -> Option<Wcs> {
        self.coordinates.clone().map(Wcs::from)
    }

    /// The scene with what was changed in it, a line for each change.
    pub(crate) fn history(&self) -> String {
        scene_history(&self.text, &self.overrides)
    }

    /// The provenance of the image; `error` is the estimate of the whole.
    pub(crate) fn provenance(&self, error: Option<f64>) -> Provenance<'_> {
        Provenance {
            scene: &self.scene,
            method: &self.method,
            evaluations: self.evaluations,
            converged: self.converged(),
            energies: self.energies,
            tolerance: self.tolerance,
            estimated_error: error,
            threshold: self.threshold,
            order: self.order,
            base_level: self.base_level,
            length_unit: self.length_unit.as_deref(),
            is_cube: self.bins.is_some(),
        }
    }
}

fn ending(ending: StopReason) -> &'static str {
    match ending {
        StopReason::Complete => "complete",
        StopReason::MaxLevel => "deepest level",
        StopReason::Time => "time",
        StopReason::Unfinished => "unfinished",
        _ => "budget",
    }
}

impl From<Wcs> for Coordinates {
    fn from(Wcs { name, axes, pole_deg }: Wcs) -> Self {
        let axis = |WcsAxis { ctype, cunit, cname, crpix, crval, cdelt }| Axis {
            ctype,
            cunit,
            cname,
            crpix,
            crval,
            cdelt,
        };
        Self { name, axes: axes.into_iter().map(axis).collect(), pole_deg }
    }
}

impl From<Coordinates> for Wcs {
    fn from(Coordinates { name, axes, pole_deg }: Coordinates) -> Self {
        let axis = |Axis { ctype, cunit, cname, crpix, crval, cdelt }| WcsAxis {
            ctype,
            cunit,
            cname,
            crpix,
            crval,
            cdelt,
        };
        Self { name, axes: axes.into_iter().map(axis).collect(), pole_deg }
    }
}

impl From<&Energies> for Bins {
    fn from(energies: &Energies) -> Self {
        let axis = energies.axis();
        Self {
            min: axis.min(),
            max: axis.max(),
            unit: energies.unit_name().to_owned(),
            bins: axis.bins(),
            scale: energies.scale_name().to_owned(),
        }
    }
}

impl Bins {
    /// The energies; an error if the data are not those of any.
    pub(crate) fn energies(&self) -> PyResult<Energies> {
        let wrong = |error: &dyn std::error::Error| PyValueError::new_err(error.to_string());
        let scale = if self.scale == "log" { EnergyScale::Log } else { EnergyScale::Linear };
        let axis = EnergyAxis::new(self.min, self.max, self.bins, scale);
        Energies::new(axis.map_err(|error| wrong(&error))?, &self.unit)
            .map_err(|error| wrong(&error))
    }
}
