//! An image or a cube with its estimated error and its cost.

use crate::about::{About, Bins};
use crate::arrays::{array, cube_of, voxels};
use crate::error::{of_counting, of_encoding};
use emitree::result::EvaluationCounts;
use emitree::{Cube, Image, Rendering};
use emitree_instrument::{Channel, Observation};
use emitree_io::{
    Bands, Card, Energies, FitsProduct, PictureOptions, ProductMap, Quantity, Scene, WcsAxis,
    encode_png, picture_of_sky,
};
use numpy::{PyArray1, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple, PyType};
use std::borrow::Cow;
use std::sync::Arc;

/// Rows of the map of a sky in a picture.
const HEIGHT_OF_SKY: usize = 400;

/// The result of a rendering: arrays, the cost, and the bytes of files.
#[pyclass(frozen, module = "emitree._native")]
pub(crate) struct Rendered {
    about: About,
    bands: Cube,
    error: Option<Cube>,
    evaluations_per_pixel: Counted,
    /// The scene, if it has an instrument whose counts are not known yet.
    counting: Option<Arc<Scene>>,
}

/// Evaluations on the lines of sight of each pixel.
enum Counted {
    /// As they were counted, with memory only where there are any.
    Sparse(EvaluationCounts),
    /// Of a rendering that was pickled.
    Map(Image),
}

impl Rendered {
    pub(crate) fn of(scene: &Arc<Scene>, found: Rendering<Cube>) -> Self {
        Self {
            about: About::new(scene, &found),
            bands: scene.cube_in_quantity(&found.values),
            error: found.error.map(|error| scene.cube_in_quantity(&error)),
            evaluations_per_pixel: Counted::Sparse(found.stats.evaluations_per_pixel),
            counting: scene.instrument.is_some().then(|| Arc::clone(scene)),
        }
    }

    fn is_cube(&self) -> bool {
        self.about.bins.is_some()
    }

    fn energies_of_bins(&self) -> PyResult<Option<Energies>> {
        self.about.bins.as_ref().map(Bins::energies).transpose()
    }

    fn array_of<'py>(&self, py: Python<'py>, map: &Cube) -> PyResult<Bound<'py, PyAny>> {
        match map.bands() {
            [image] if !self.is_cube() => array(py, image),
            _ => voxels(py, map),
        }
    }

    /// One image for display: a cube is summed over its energies.
    fn flat(&self) -> PyResult<Image> {
        let Some(energies) = self.energies_of_bins()? else {
            let image = self.bands.bands().first();
            return Ok(image.cloned().unwrap_or_else(|| Image::zeros(0, 0)));
        };
        let mut band = self.bands.sum_over_energy(energies.axis());
        band.pixels_mut().iter_mut().for_each(|pixel| *pixel *= self.about.band_factor);
        Ok(band)
    }

    /// The image as a picture; a sky as a map of this height.
    fn shown(&self, height: usize) -> PyResult<Image> {
        let image = self.flat()?;
        Ok(if self.about.is_sky { picture_of_sky(&image, height) } else { image })
    }

    /// The expected counts of the instrument of the scene; none if there is no instrument.
    fn observation(&self) -> PyResult<Option<Observation>> {
        let Some(scene) = &self.counting else { return Ok(None) };
        if scene.quantity != Quantity::Radiance {
            let why = "`quantity` is \"irradiance\", and an instrument takes radiances";
            return Err(of_counting(format!("{why}: expected \"radiance\"")));
        }
        scene.expected_counts(&self.bands).transpose().map_err(of_counting)
    }

    fn evaluation_map(&self) -> Cow<'_, Image> {
        match &self.evaluations_per_pixel {
            Counted::Sparse(counts) => Cow::Owned(counts.to_image()),
            Counted::Map(map) => Cow::Borrowed(map),
        }
    }
}

#[pymethods]
impl Rendered {
    /// A rendering that was pickled: the arguments of `__reduce__`.
    #[new]
    fn new(
        about: About,
        values: PyReadonlyArray3<'_, f64>,
        errors: Option<PyReadonlyArray3<'_, f64>>,
        evaluations_per_pixel: PyReadonlyArray3<'_, f64>,
    ) -> PyResult<Self> {
        let map = cube_of(&evaluations_per_pixel);
        let map = map.bands().first().cloned().unwrap_or_else(|| Image::zeros(0, 0));
        let found = Self {
            about,
            bands: cube_of(&values),
            error: errors.as_ref().map(cube_of),
            evaluations_per_pixel: Counted::Map(map),
            counting: None,
        };
        let bins = found.energies_of_bins()?.map_or(1, |energies| energies.axis().bins());
        let bands = found.bands.bands().len();
        if bands != bins {
            let message = format!("a rendering of {bands} bands: expected {bins}");
            return Err(PyValueError::new_err(message));
        }
        Ok(found)
    }

    /// For pickling and copying: plain data and arrays.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let errors = self.error.as_ref().map(|error| voxels(py, error)).transpose()?;
        let map = Cube::from_bands(vec![self.evaluation_map().into_owned()]);
        let arguments = (self.about.clone(), voxels(py, &self.bands)?, errors, voxels(py, &map)?);
        Ok((py.get_type::<Self>(), arguments.into_pyobject(py)?))
    }

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
        array(py, &self.flat()?)
    }

    /// The unit of `flat_image`, FITS grammar, or "".
    #[getter]
    fn flat_unit(&self) -> &str {
        if self.is_cube() { &self.about.band_unit } else { &self.about.unit }
    }

    /// Expected counts (channels, height, width); for each step its name and its sums (before, added,
    /// lost, after); and for each channel its number and its nominal energies \[keV\]. `None` without
    /// an instrument, and after pickling.
    fn expected_counts<'py>(&self, py: Python<'py>) -> PyResult<Option<CountsAndSteps<'py>>> {
        let Some(found) = py.detach(|| self.observation())? else { return Ok(None) };
        let of_step = |sum: &emitree_instrument::StepSum| {
            (sum.step.name().to_owned(), (sum.before, sum.added, sum.lost, sum.after))
        };
        let of_channel = |channel: &Channel| {
            let [low, high] = channel.range_kev;
            (channel.number, low, high)
        };
        let steps = found.steps.iter().map(of_step).collect();
        let channels = found.channels.iter().map(of_channel).collect();
        Ok(Some((voxels(py, &found.counts)?, steps, channels)))
    }

    /// Exposure \[s\] and seed of the instrument; `None` without one.
    #[getter]
    fn instrument(&self) -> Option<(f64, u64)> {
        self.about.exposure_s.zip(self.about.seed)
    }

    /// The borders of the energy bins, ascending, and their unit; `None` without an energy axis.
    #[getter]
    fn energies<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(Bound<'py, PyArray1<f64>>, String)>> {
        let energies = self.energies_of_bins()?;
        Ok(energies.map(|energies| {
            (PyArray1::from_vec(py, energies.axis().edges()), energies.unit_name().to_owned())
        }))
    }

    /// The text of the scene, and what was changed in it.
    #[getter]
    fn scene(&self) -> String {
        self.about.history()
    }

    /// Evaluations on the lines of sight of each pixel, (height, width).
    fn evaluations_per_pixel<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.evaluation_map())
    }

    /// How often the emission was evaluated.
    #[getter]
    fn evaluations(&self) -> u64 {
        self.about.evaluations
    }

    /// Whether the stopping criterion was met.
    #[getter]
    fn converged(&self) -> bool {
        self.about.converged()
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
        &self.about.unit
    }

    /// The axes of the image, x first: name, unit or `None`, and the coordinates of pixel centres.
    /// They are those of the plane that FITS projects to, angles only where that is linear. Empty
    /// for a `HEALPix` sky.
    fn axes<'py>(&self, py: Python<'py>) -> Vec<AxisOfImage<'py>> {
        let Some(wcs) = self.about.wcs() else { return Vec::new() };
        let [_, height, width] = self.bands.shape();
        let axes = wcs.axes.into_iter().zip([('x', width), ('y', height)]);
        let of_axis = |(axis, (letter, pixels)): (WcsAxis, (char, usize))| {
            let place = |i: usize| axis.crval + axis.cdelt * (i as f64 + 1.0 - axis.crpix);
            let places = PyArray1::from_iter(py, (0..pixels).map(place));
            let name = match axis.plane() {
                Some(code) => format!("{letter} on the image plane ({code})"),
                None => axis.cname,
            };
            (name, axis.cunit, places)
        };
        axes.map(of_axis).collect()
    }

    /// The cost and the settings, with the keys of the command's report.json except the memory.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (report, about) = (PyDict::new(py), &self.about);
        report.set_item("evaluations", about.evaluations)?;
        report.set_item("batches", about.batches)?;
        report.set_item("method", &about.method)?;
        report.set_item("tolerance", about.tolerance)?;
        report.set_item("estimated_error", self.estimated_error())?;
        report.set_item("converged", self.converged())?;
        report.set_item("ending", &about.ending)?;
        report.set_item("threshold", about.threshold)?;
        report.set_item("order", about.order)?;
        report.set_item("base_level", about.base_level)?;
        report.set_item("smallest_feature", about.smallest_feature)?;
        report.set_item("leaves_per_level", &about.leaves_per_level)?;
        let seconds = PyDict::new(py);
        seconds.set_item("total", about.total_seconds)?;
        seconds.set_item("emission", about.emission_seconds)?;
        report.set_item("seconds", seconds)?;
        let image = PyDict::new(py);
        let ([_, height, width], (min, max)) = (self.bands.shape(), self.bands.min_max());
        image.set_item("height", height)?;
        image.set_item("width", width)?;
        image.set_item("min", min)?;
        image.set_item("max", max)?;
        image.set_item("quantity", &about.quantity)?;
        image.set_item("unit", &about.unit)?;
        report.set_item("image", image)?;
        report.set_item("energy", about.bins.clone())?;
        report.set_item("energies", about.energies)?;
        report.set_item("overrides", &about.overrides)?;
        report.set_item("ignored", &about.ignored)?;
        report.set_item("version", env!("CARGO_PKG_VERSION"))?;
        report.set_item("scene", &about.scene)?;
        Ok(report)
    }

    /// `flat_image` for display, row 0 at the bottom: a `HEALPix` sky as a Mollweide map of this
    /// height, NaN outside.
    fn picture<'py>(&self, py: Python<'py>, height: usize) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.shown(height)?)
    }

    /// That picture, y up: the bytes of a PNG file.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let options = PictureOptions { blank_outside: true, ..PictureOptions::default() };
        let picture = self.shown(HEIGHT_OF_SKY)?;
        Ok(PyBytes::new(py, &encode_png(&picture, &options).map_err(of_encoding)?))
    }

    /// The image with its error, its evaluations and, of a cube, the whole band, with units, coordinates
    /// and provenance: the bytes of a FITS file.
    fn fits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let About { unit, band_unit, quantity, .. } = &self.about;
        let bands = if self.is_cube() { Bands::Energies } else { Bands::Image };
        let quantity = quantity.to_uppercase();
        let evaluations = Cube::from_bands(vec![self.evaluation_map().into_owned()]);
        let band = self.is_cube().then(|| self.flat()).transpose()?;
        let band = band.map(|band| Cube::from_bands(vec![band]));
        let mut maps = vec![ProductMap { name: &quantity, map: &self.bands, unit, bands }];
        maps.extend(self.error.iter().map(|map| ProductMap { name: "ERROR", map, unit, bands }));
        let one = |name, map, unit| ProductMap { name, map, unit, bands: Bands::Image };
        maps.push(one("EVALUATIONS", &evaluations, ""));
        maps.extend(band.iter().map(|band| one("BAND", band, band_unit)));
        self.encoded(py, maps, self.energies_of_bins()?.as_ref(), Vec::new())
    }

    /// Counts (channels, height, width) with the number and the nominal energies \[keV\] of each
    /// channel, and the seed that they were drawn with, if they were: the bytes of a FITS file with
    /// the table `EBOUNDS`.
    #[pyo3(signature = (counts, channels, seed))]
    fn counts_fits<'py>(
        &self,
        py: Python<'py>,
        counts: PyReadonlyArray3<'py, f64>,
        channels: Vec<(i64, f64, f64)>,
        seed: Option<u64>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let map = cube_of(&counts);
        let channels = channels
            .into_iter()
            .map(|(number, low, high)| Channel { number, range_kev: [low, high] });
        let channels: Vec<Channel> = channels.collect();
        let name = if seed.is_some() { "COUNTS" } else { "EXPECTED" };
        let bands = Bands::Counts { channels: &channels, are_bins: false };
        let maps = vec![ProductMap { name, map: &map, unit: "count", bands }];
        let exposure = self.about.exposure_s;
        let exposure = exposure.map(|time| Card::new("EXPOSURE", time, "[s] of the counts"));
        let seed = seed.map(|seed| Card::new("SEED", seed, "of the counts that were drawn"));
        self.encoded(py, maps, None, exposure.into_iter().chain(seed).collect())
    }
}

impl Rendered {
    /// The bytes of a FITS file with these maps, and `cards` that are true of it alone.
    fn encoded<'py>(
        &self,
        py: Python<'py>,
        maps: Vec<ProductMap<'_>>,
        energies: Option<&Energies>,
        cards: Vec<Card>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let mut provenance = self.about.provenance(self.estimated_error()).cards();
        provenance.extend(cards);
        let file = FitsProduct {
            maps,
            is_sky: self.about.is_sky,
            wcs: self.about.wcs(),
            energies,
            provenance,
            history: self.about.history(),
        };
        Ok(PyBytes::new(py, &file.encode().map_err(of_encoding)?))
    }
}

/// Counts (channels, height, width) drawn from expected ones with a seed.
#[pyfunction]
pub(crate) fn draw_counts<'py>(
    py: Python<'py>,
    expected: PyReadonlyArray3<'py, f64>,
    seed: u64,
) -> PyResult<Bound<'py, PyAny>> {
    let drawn = emitree_instrument::draw_counts(&cube_of(&expected), seed);
    voxels(py, &drawn.map_err(of_counting)?)
}

/// Counts, the name and sums of each step that led to them, and the channels.
type CountsAndSteps<'py> =
    (Bound<'py, PyAny>, Vec<(String, (f64, f64, f64, f64))>, Vec<(i64, f64, f64)>);

/// A type and what it is called with.
type Reduced<'py> = (Bound<'py, PyType>, Bound<'py, PyTuple>);

/// Name, unit and coordinates of an axis of the image.
type AxisOfImage<'py> = (String, Option<String>, Bound<'py, PyArray1<f64>>);
