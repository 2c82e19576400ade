//! An image or a cube with its error and its bill.

use crate::bridge::array;
use crate::error::{of_counting, of_encoding};
use crate::fits;
use emitree::projection::healpix::pixel_of_direction;
use emitree::{
    Cube, CubeRendering, Ending, EvaluationCounts, Healpix, Image, Method, RenderedTree, Rendering,
    irradiance_of,
};
use emitree_instrument::{Observation, draw_counts};
use emitree_io::{
    CameraKind, Card, East, Energies, PictureOptions, Quantity, Scene, WcsAxis, encode_png,
    mollweide,
};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::sync::Arc;
use std::time::Duration;

/// Rows of the map of a sky in a picture.
const HEIGHT_OF_SKY: usize = 400;

/// What a rendering has found: arrays, the bill, and the bytes of files.
#[pyclass(frozen, module = "emitree._native")]
pub(crate) struct Rendered {
    scene: Arc<Scene>,
    bands: Cube,
    error: Option<Cube>,
    evaluations_of_pixels: EvaluationCounts,
    evaluations: u64,
    batches: u64,
    ending: Ending,
    tree: Option<RenderedTree>,
    energies: Option<usize>,
    base_level: Option<u8>,
    emission_time: Duration,
    total_time: Duration,
}

impl Rendered {
    pub(crate) fn image(scene: Arc<Scene>, found: Rendering) -> Self {
        let one = |image| Cube::from_bands(vec![in_quantity(&scene, image)]);
        Self {
            bands: one(found.image),
            error: found.error.map(one),
            evaluations_of_pixels: found.evaluations_of_pixels,
            evaluations: found.evaluations,
            batches: found.batches,
            ending: found.ending,
            tree: found.tree,
            energies: None,
            base_level: found.base_level,
            emission_time: found.emission_time,
            total_time: found.total_time,
            scene,
        }
    }

    pub(crate) fn cube(scene: Arc<Scene>, found: CubeRendering) -> Self {
        Self {
            bands: bands_in_quantity(&scene, found.cube),
            error: found.error.map(|error| bands_in_quantity(&scene, error)),
            evaluations_of_pixels: found.evaluations_of_pixels,
            evaluations: found.evaluations,
            batches: found.batches,
            ending: found.ending,
            tree: None,
            energies: Some(found.energies.len()),
            base_level: found.base_level,
            emission_time: found.emission_time,
            total_time: found.total_time,
            scene,
        }
    }

    fn is_cube(&self) -> bool {
        self.scene.energy.is_some()
    }

    fn array_of<'py>(&self, py: Python<'py>, map: &Cube) -> PyResult<Bound<'py, PyAny>> {
        match map.bands() {
            [image] if !self.is_cube() => array(py, image),
            _ => voxels(py, map),
        }
    }

    /// One image to look at: a cube is summed over its energies.
    fn flat(&self) -> Image {
        match self.bands.bands() {
            [image] if !self.is_cube() => image.clone(),
            _ => self.scene.band_image(&self.bands).unwrap_or_else(|| Image::zeros(0, 0)),
        }
    }

    /// The image as a picture; a sky as a map of this height.
    fn shown(&self, height: usize) -> Image {
        let image = self.flat();
        if self.scene.camera.kind() != CameraKind::Healpix {
            return image;
        }
        let values = Healpix::nested(&image);
        let nside = u32::try_from(image.width()).unwrap_or(u32::MAX);
        let value = |direction| {
            let pixel = usize::try_from(pixel_of_direction(nside, direction));
            pixel.ok().and_then(|pixel| values.get(pixel)).copied().unwrap_or(f64::NAN)
        };
        mollweide(height, East::Left, value)
    }

    /// What the instrument of the scene is expected to count; none if there is no instrument.
    fn observation(&self) -> PyResult<Option<Observation>> {
        if self.scene.instrument.is_some() && self.scene.quantity != Quantity::Radiance {
            let why = "`quantity` is \"irradiance\", and an instrument takes radiances";
            return Err(of_counting(format!("{why}: expected \"radiance\"")));
        }
        self.scene.expected_counts(&self.bands).transpose().map_err(of_counting)
    }

    fn ending_name(&self) -> &'static str {
        match self.ending {
            Ending::Complete => "complete",
            Ending::DeepestLevel => "deepest level",
            _ => "budget",
        }
    }

    /// How the image came about, as FITS keywords.
    fn provenance(&self) -> Vec<Card> {
        let method = self.scene.render.method.name();
        let mut cards = vec![
            Card::new("METHOD", method, "from the emission to the image"),
            Card::new("NEVAL", self.evaluations, "evaluations of the emission rate"),
            Card::new("CONVERGD", self.ending == Ending::Complete, "the method ended by itself"),
        ];
        if let Some(tolerance) = self.scene.render.tolerance {
            cards.push(Card::new("TOLERANC", tolerance, "error asked for / largest value"));
        }
        if let Some(error) = self.estimated_error() {
            cards.push(Card::new("ESTERROR", error, "estimated error / largest value"));
        }
        if let Some(unit) = &self.scene.length_unit {
            cards.push(Card::new("LENUNIT", unit.as_str(), "unit of length of the scene"));
        }
        cards
    }
}

#[pymethods]
impl Rendered {
    /// The image, (height, width), or the cube, (bins, height, width); row 0 is the lowest y.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array_of(py, &self.bands)
    }

    /// The estimated |error| of each value, of the same shape, or `None`.
    fn errors<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.error.as_ref().map(|error| self.array_of(py, error)).transpose()
    }

    /// A cube summed over its energies, or the image itself, (height, width).
    fn flat_image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.flat())
    }

    /// The unit of `flat_image`, FITS grammar, or "".
    #[getter]
    fn flat_unit(&self) -> &str {
        if self.is_cube() { self.scene.band_unit() } else { self.scene.image_unit() }
    }

    /// Expected counts (channels, height, width), and for each step its name and its sums (before,
    /// added, lost, after); `None` without an instrument.
    fn expected_counts<'py>(&self, py: Python<'py>) -> PyResult<Option<CountsAndSteps<'py>>> {
        let Some(Observation { counts, steps, .. }) = self.observation()? else { return Ok(None) };
        let of_step = |sum: &emitree_instrument::StepSum| {
            (sum.step.name().to_owned(), (sum.before, sum.added, sum.lost, sum.after))
        };
        Ok(Some((voxels(py, &counts)?, steps.iter().map(of_step).collect())))
    }

    /// Counts that are drawn with a seed, that of the scene by default; `None` without an instrument.
    #[pyo3(signature = (seed = None))]
    fn draw_counts<'py>(
        &self,
        py: Python<'py>,
        seed: Option<u64>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(observation) = self.observation()? else { return Ok(None) };
        let of_scene = self.scene.instrument.as_ref().map_or(0, |instrument| instrument.seed);
        let drawn = draw_counts(&observation.counts, seed.unwrap_or(of_scene));
        Ok(Some(voxels(py, &drawn.map_err(of_counting)?)?))
    }

    /// Evaluations on the lines of sight of each pixel, (height, width).
    fn evaluations_of_pixels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.evaluations_of_pixels.to_image())
    }

    /// How often the emission was evaluated.
    #[getter]
    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Whether the method did all that it was asked for.
    #[getter]
    fn converged(&self) -> bool {
        self.ending == Ending::Complete
    }

    /// The largest estimated error over the largest |value|, or `None`.
    #[getter]
    fn estimated_error(&self) -> Option<f64> {
        let error = self.error.as_ref()?.largest();
        Some(if error > 0.0 { error / self.bands.largest() } else { 0.0 })
    }

    /// The unit of the image, FITS grammar, or "".
    #[getter]
    fn unit(&self) -> &str {
        self.scene.image_unit()
    }

    /// The axes of the image, x first: name, unit or `None`, and the coordinates of pixel centres.
    /// They are those of the plane that FITS projects to, angles only where that is linear. Empty
    /// for a `HEALPix` sky.
    fn axes<'py>(&self, py: Python<'py>) -> Vec<AxisOfImage<'py>> {
        let Some(wcs) = fits::coordinates(&self.scene) else { return Vec::new() };
        let axes = wcs.axes.into_iter().zip([('x', self.scene.width), ('y', self.scene.height)]);
        let of_axis = |(axis, (letter, pixels)): (WcsAxis, (char, usize))| {
            let place = |i: usize| axis.crval + axis.cdelt * (i as f64 + 1.0 - axis.crpix);
            let places = PyArray1::from_iter(py, (0..pixels).map(place));
            let name = match axis.ctype.rsplit_once('-') {
                Some((_, code @ ("TAN" | "ARC" | "ZEA"))) => {
                    format!("{letter} on the image plane ({code})")
                }
                _ => axis.cname,
            };
            (name, axis.cunit, places)
        };
        axes.map(of_axis).collect()
    }

    /// The bill and the settings, with the keys of the command's report.json but for the memory.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let report = PyDict::new(py);
        let render = &self.scene.render;
        let order = match render.method {
            Method::Paper(options) => Some(options.order),
            _ => None,
        };
        let tree = self.tree.as_ref();
        let leaves = tree.map_or_else(Vec::new, |built| built.tree.leaves_per_level());
        report.set_item("evaluations", self.evaluations)?;
        report.set_item("batches", self.batches)?;
        report.set_item("method", render.method.name())?;
        report.set_item("tolerance", render.tolerance)?;
        report.set_item("estimated_error", self.estimated_error())?;
        report.set_item("converged", self.converged())?;
        report.set_item("ending", self.ending_name())?;
        report.set_item("threshold", tree.map(|built| built.threshold))?;
        report.set_item("order", order)?;
        report.set_item("base_level", self.base_level)?;
        report.set_item("leaves_per_level", leaves)?;
        let seconds = PyDict::new(py);
        seconds.set_item("total", self.total_time.as_secs_f64())?;
        seconds.set_item("emission", self.emission_time.as_secs_f64())?;
        report.set_item("seconds", seconds)?;
        let image = PyDict::new(py);
        let (min, max) = self.bands.min_max();
        image.set_item("height", self.scene.height)?;
        image.set_item("width", self.scene.width)?;
        image.set_item("min", min)?;
        image.set_item("max", max)?;
        image.set_item("quantity", self.scene.quantity.name())?;
        image.set_item("unit", self.scene.image_unit())?;
        report.set_item("image", image)?;
        let energy = self.scene.energy.as_ref().map(|energies| energy_report(py, energies));
        report.set_item("energy", energy.transpose()?)?;
        report.set_item("energies", self.energies.filter(|&energies| energies > 0))?;
        report.set_item("overrides", &self.scene.overrides)?;
        report.set_item("ignored", &render.ignored)?;
        report.set_item("version", env!("CARGO_PKG_VERSION"))?;
        report.set_item("scene", &self.scene.name)?;
        Ok(report)
    }

    /// `flat_image` to look at, row 0 at the bottom: a `HEALPix` sky as a Mollweide map of this
    /// height, NaN outside.
    fn picture<'py>(&self, py: Python<'py>, height: usize) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.shown(height))
    }

    /// That picture, y up: the bytes of a PNG file.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let options = PictureOptions { blank_outside: true, ..PictureOptions::default() };
        let picture = self.shown(HEIGHT_OF_SKY);
        Ok(PyBytes::new(py, &encode_png(&picture, &options).map_err(of_encoding)?))
    }

    /// The image and its error with units, coordinates and provenance: the bytes of a FITS file.
    fn fits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mut maps = vec![(self.scene.quantity.name(), &self.bands)];
        maps.extend(self.error.as_ref().map(|error| ("error", error)));
        let bytes = fits::encode(&self.scene, &maps, self.provenance()).map_err(of_encoding)?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// An array (bands, height, width).
fn voxels<'py>(py: Python<'py>, map: &Cube) -> PyResult<Bound<'py, PyAny>> {
    let [bands, height, width] = map.shape();
    PyArray1::from_iter(py, map.voxels()).call_method1("reshape", ((bands, height, width),))
}

/// The bins of a cube, as reports have them.
fn energy_report<'py>(py: Python<'py>, energies: &Energies) -> PyResult<Bound<'py, PyDict>> {
    let (report, axis) = (PyDict::new(py), energies.axis());
    report.set_item("min", axis.min())?;
    report.set_item("max", axis.max())?;
    report.set_item("unit", energies.unit_name())?;
    report.set_item("bins", axis.bins())?;
    report.set_item("scale", energies.scale_name())?;
    Ok(report)
}

/// Counts, and the name and sums of each step that led to them.
type CountsAndSteps<'py> = (Bound<'py, PyAny>, Vec<(String, (f64, f64, f64, f64))>);

/// Name, unit and coordinates of an axis of the image.
type AxisOfImage<'py> = (String, Option<String>, Bound<'py, PyArray1<f64>>);

/// In the quantity that the scene asks for.
pub(crate) fn in_quantity(scene: &Scene, image: Image) -> Image {
    match scene.quantity {
        Quantity::Irradiance => irradiance_of(&image, scene.camera.projection()),
        _ => image,
    }
}

/// All bands in that quantity.
fn bands_in_quantity(scene: &Scene, mut map: Cube) -> Cube {
    for band in map.bands_mut() {
        *band = in_quantity(scene, std::mem::replace(band, Image::zeros(0, 0)));
    }
    map
}
