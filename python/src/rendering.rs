//! An image or a cube with its estimated error and its cost.

use crate::arrays::{array, cube_of, voxels};
use crate::error::{of_counting, of_encoding, of_scene};
use crate::mesh::Mesh;
use crate::surfaces::{ReadSurfaceArrays, SurfaceArrays, arrays_of, encoded, surfaces_of};
use emitree::result::LineValues;
use emitree::{Cube, Image, Rendering};
use emitree_instrument::{Channel, Observation};
use emitree_io::{
    Account, Bands, Card, PictureOptions, ProductMap, Quantity, RenderedComponents, RenderedScene,
    Scene, Sky, WcsAxis, encode_png, picture_of_sky,
};
use numpy::{PyArray1, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple, PyType};
use std::path::PathBuf;
use std::sync::Arc;

/// Rows of the map of a sky in a picture.
const HEIGHT_OF_SKY: usize = 400;

/// The radiances of lines, and their errors.
type LineArrays<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// The result of a rendering: arrays, the cost, and the bytes of files.
#[pyclass(frozen, module = "emitree._native")]
pub(crate) struct Rendered {
    rendered: RenderedScene,
    /// The scene, if it has an instrument whose counts are not known yet.
    counting: Option<Arc<Scene>>,
    /// Its mesh, if it has one.
    mesh: Option<Mesh>,
    /// The radiances of lines of sight that were named.
    lines: Option<LineValues>,
}

impl Rendered {
    pub(crate) fn of(scene: &Arc<Scene>, found: &Rendering<Cube>) -> Self {
        Self {
            rendered: RenderedScene::new(scene, found),
            counting: scene.instrument.is_some().then(|| Arc::clone(scene)),
            mesh: found.mesh.clone().map(|mesh| Mesh { scene: Arc::clone(scene), mesh }),
            lines: found.lines.clone(),
        }
    }

    fn account(&self) -> &Account {
        &self.rendered.account
    }

    fn array_of<'py>(&self, py: Python<'py>, map: &Cube) -> PyResult<Bound<'py, PyAny>> {
        match map.bands() {
            [image] if self.account().bins.is_none() => array(py, image),
            _ => voxels(py, map),
        }
    }

    /// One image for display: a cube is summed over its energies.
    fn flat(&self) -> Image {
        self.rendered.flat().cloned().unwrap_or_else(|| Image::zeros(0, 0))
    }

    /// The image as a picture; a sky as a map of this height.
    fn shown(&self, height: usize) -> Image {
        let image = self.flat();
        if self.account().is_sky { picture_of_sky(&image, height) } else { image }
    }

    /// The expected counts of the instrument of the scene; none if there is no instrument.
    fn observation(&self) -> PyResult<Option<Observation>> {
        let Some(scene) = &self.counting else { return Ok(None) };
        if scene.quantity != Quantity::Radiance {
            let why = "`quantity` is \"irradiance\", and an instrument takes radiances";
            return Err(of_counting(format!("{why}: expected \"radiance\"")));
        }
        scene.expected_counts(&self.rendered.values).transpose().map_err(of_counting)
    }

    fn encoded<'py>(
        &self,
        py: Python<'py>,
        map: ProductMap<'_>,
        others: Vec<ProductMap<'_>>,
        cards: Vec<Card>,
        sky: Option<&Sky>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let sky = sky.or(self.account().sky.as_ref());
        let file = self.rendered.fits_on_sky(map, others, cards, sky).map_err(of_encoding)?;
        Ok(PyBytes::new(py, &file))
    }
}

#[pymethods]
impl Rendered {
    /// A rendering that was pickled: the arguments of `__reduce__`.
    #[new]
    #[pyo3(signature = (account, values, errors, evaluations_per_pixel, surfaces=None))]
    fn new(
        account: &str,
        values: PyReadonlyArray3<'_, f64>,
        errors: Option<PyReadonlyArray3<'_, f64>>,
        evaluations_per_pixel: PyReadonlyArray3<'_, f64>,
        surfaces: Option<ReadSurfaceArrays<'_>>,
    ) -> PyResult<Self> {
        let account = serde_json::from_str(account);
        let account = account.map_err(|error| PyValueError::new_err(error.to_string()))?;
        let (error, evaluations) = (errors.as_ref().map(cube_of), cube_of(&evaluations_per_pixel));
        let rendered = RenderedScene::from_parts(account, cube_of(&values), error, evaluations);
        let mut rendered = rendered.map_err(|error| PyValueError::new_err(error.to_string()))?;
        rendered.surfaces = surfaces.as_ref().map(surfaces_of).transpose()?.map(Arc::new);
        Ok(Self { rendered, counting: None, mesh: None, lines: None })
    }

    /// The radiances of the lines of sight at the places that were named, and their errors; `None` without such.
    fn line_values<'py>(&self, py: Python<'py>) -> Option<LineArrays<'py>> {
        let lines = self.lines.as_ref()?;
        let [values, errors] =
            [&lines.values, &lines.errors].map(|of| PyArray1::from_slice(py, of));
        Some((values, errors))
    }

    /// For pickling and copying: plain data and arrays.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let RenderedScene { account, values, error, .. } = &self.rendered;
        let account = serde_json::to_string(account);
        let account = account.map_err(|error| PyValueError::new_err(error.to_string()))?;
        let errors = error.as_ref().map(|error| voxels(py, error)).transpose()?;
        let evaluations = voxels(py, self.rendered.evaluations_per_pixel())?;
        let surfaces = self.surfaces(py)?;
        let arguments = (account, voxels(py, values)?, errors, evaluations, surfaces);
        Ok((py.get_type::<Self>(), arguments.into_pyobject(py)?))
    }

    /// The image, (height, width), or the cube, (bins, height, width); row 0 is the lowest y.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array_of(py, &self.rendered.values)
    }

    /// The frozen quadrature; `None` if there is none: of found surfaces, of more than a million
    /// evaluations, of a rendering that was pickled.
    #[getter]
    fn plan(&self) -> Option<Mesh> {
        self.mesh.clone()
    }

    /// Positions (n, 3), normals (n, 3), jumps (n,) and uncertainties (n,) of the vertices of the found
    /// surfaces, and the vertices of triangles (m, 3); `None` if the image is not made of such.
    fn surfaces<'py>(&self, py: Python<'py>) -> PyResult<Option<SurfaceArrays<'py>>> {
        self.rendered.surfaces.as_ref().map(|found| arrays_of(py, found)).transpose()
    }

    /// The units of their lengths and of their jumps, or "".
    #[getter]
    fn surface_units(&self) -> (&str, &str) {
        let account = self.account();
        (account.length_unit.as_deref().unwrap_or_default(), &account.rate_unit)
    }

    /// The bytes of a file of them, in the format that the ending of `path` chooses.
    fn surfaces_file<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
    ) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let found = self.rendered.surfaces.as_ref();
        found.map(|found| encoded(py, found, self.account(), &path)).transpose()
    }

    /// The estimated |error| of each value, of the same shape, or `None`.
    fn errors<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.rendered.error.as_ref().map(|error| self.array_of(py, error)).transpose()
    }

    /// A cube summed over its energies, or the image itself, (height, width).
    fn flat_image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.flat())
    }

    /// The unit of `flat_image`, FITS grammar, or "".
    #[getter]
    fn flat_unit(&self) -> &str {
        self.rendered.flat_unit()
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
        self.account().exposure_s.zip(self.account().seed)
    }

    /// The borders of the energy bins, ascending, and their unit; `None` without an energy axis.
    #[getter]
    fn energies<'py>(&self, py: Python<'py>) -> Option<(Bound<'py, PyArray1<f64>>, &str)> {
        let energies = self.rendered.energies.as_ref()?;
        Some((PyArray1::from_vec(py, energies.axis().edges()), energies.unit_name()))
    }

    /// The text of the scene, and what was changed in it.
    #[getter]
    fn scene(&self) -> String {
        self.account().history()
    }

    /// Evaluations on the lines of sight of each pixel, (height, width).
    fn evaluations_per_pixel<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let map = self.rendered.evaluations_per_pixel().bands().first().cloned();
        array(py, &map.unwrap_or_else(|| Image::zeros(0, 0)))
    }

    /// How often the emission was evaluated.
    #[getter]
    fn evaluations(&self) -> u64 {
        self.account().evaluations
    }

    /// How often the absorption coefficient was evaluated; `None` if the medium does not absorb.
    #[getter]
    fn absorption_evaluations(&self) -> Option<u64> {
        self.account().absorption_evaluations
    }

    /// Whether the stopping criterion was met.
    #[getter]
    fn converged(&self) -> bool {
        self.account().converged()
    }

    /// The largest estimated error over the largest |value|, or `None`.
    #[getter]
    fn estimated_error(&self) -> Option<f64> {
        self.account().estimated_error
    }

    /// The unit of the image, FITS grammar, or "".
    #[getter]
    fn unit(&self) -> &str {
        &self.account().unit
    }

    /// The axes of the image, x first: name, unit or `None`, and the coordinates of pixel centres.
    /// They are those of the plane that FITS projects to, angles only where that is linear. Empty
    /// for a `HEALPix` sky.
    fn axes<'py>(&self, py: Python<'py>) -> Vec<AxisOfImage<'py>> {
        let Some(wcs) = &self.account().wcs else { return Vec::new() };
        let [_, height, width] = self.rendered.values.shape();
        let axes = wcs.axes.clone().into_iter().zip([('x', width), ('y', height)]);
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

    /// The cost and the settings: report.json of the command, without the counts of an instrument.
    fn report(&self) -> String {
        self.rendered.report(None).to_json()
    }

    /// `flat_image` for display, row 0 at the bottom: a `HEALPix` sky as a Mollweide map of this
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

    /// The image with its error, its evaluations and, of a cube, the whole band, with units, coordinates
    /// and provenance: the bytes of a FITS file. `sky` is the text of a table `[sky]`, for a scene that has
    /// none.
    #[pyo3(signature = (sky=None))]
    fn fits<'py>(&self, py: Python<'py>, sky: Option<&str>) -> PyResult<Bound<'py, PyBytes>> {
        let sky = sky.map(|text| self.account().read_sky(text)).transpose();
        let sky = sky.map_err(|error| of_scene(&error, false, &[]))?;
        let (map, others) = (self.rendered.values_map(), self.rendered.companions());
        self.encoded(py, map, others, self.account().cards(), sky.as_ref())
    }

    /// The name of the camera, its position, the unit of lengths, and whether the scene has a sky.
    #[getter]
    fn view(&self) -> (&str, [f64; 3], Option<&str>, bool) {
        let Account { camera, pointing, length_unit, sky, .. } = self.account();
        let position = pointing.map_or([0.0; 3], |pointing| pointing.position);
        (camera, position, length_unit.as_deref(), sky.is_some())
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
        let bands = Bands::Counts { channels: &channels };
        let (map, cards) = self.rendered.counts_map(&map, bands, seed);
        self.encoded(py, map, Vec::new(), cards, None)
    }
}

/// The images of components by their names, with their errors and evaluations, units, coordinates and provenance: the
/// bytes of a FITS file. The emission was evaluated at this number of points for all of them.
#[pyfunction]
pub(crate) fn components_fits<'py>(
    py: Python<'py>,
    components: Vec<(String, Bound<'py, Rendered>)>,
    evaluations: u64,
) -> PyResult<Bound<'py, PyBytes>> {
    let of = |(name, found): (String, Bound<'py, Rendered>)| (name, found.get().rendered.clone());
    let all = RenderedComponents::new(components.into_iter().map(of).collect(), evaluations);
    let all =
        all.ok_or_else(|| PyValueError::new_err("components of different shapes, or none"))?;
    Ok(PyBytes::new(py, &all.fits().map_err(of_encoding)?))
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
