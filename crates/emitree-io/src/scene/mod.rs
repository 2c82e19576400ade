//! Scene files: the emission, the camera, the number of pixels, and the method.
//!
//! The format is TOML; the guide has all keys. Options of the command line are scenes of one line
//! that are merged into the file, so every value is checked in one place and every error names the
//! place that the value came from.

mod absorption;
mod accuracy;
mod camera;
mod components;
mod document;
mod emission;
mod energy;
mod error;
mod excerpt;
mod feature;
mod instrument;
mod overrides;
mod radiometry;
mod seed;
mod settings;
mod sky;
mod source;
mod sums;
mod table;
mod time;
mod tree;
mod values;

pub use absorption::SceneAbsorption;
pub use camera::{
    Camera, CameraDescription, CameraKey, FitsCoordinates, KeyDefault, KeyUnit, PixelLayout,
    PlotAxis, PlotFrame, PlotScale, cameras,
};
pub use components::SceneComponents;
pub use emission::{
    ComponentEmission, ComponentRates, EmissionFailure, EmissionSource, GridEmission,
};
pub use error::SceneError;
pub use instrument::SceneInstrument;
pub use overrides::Override;
use overrides::is_option;
pub use radiometry::{Quantity, SceneEmission};
pub use settings::RenderSettings;
pub(crate) use sky::SkyView;
pub use sums::SceneSum;
pub use tree::BuildSettings;

use crate::energies::Energies;
use crate::exposure::Exposure;
use crate::fits::Wcs;
use crate::memory::available_memory_bytes;
use crate::sky::Sky;
use crate::units::Unit;
use camera::ShapeTables;
use document::Node;
use emission::Spectrum;
use emitree::radiance::irradiance_of;
use emitree::{
    Cube, Emission, EnergyAxis, Healpix, Image, Projection, RenderError, RenderOptions, Rendering,
    Session, render, render_cube,
};
use emitree_instrument::{Observation, ObservationError};
use instrument::Observer;
use radiometry::{BandUnit, CameraUnits, ImageUnits};
use source::{Place, Source};
use std::borrow::Borrow;
use std::convert::Infallible;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use table::Table;

/// A scene, read and checked.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scene {
    /// The name of the file.
    pub name: String,
    /// The text of the file, as it is.
    pub text: String,
    /// What the command line changed, as `key = value`.
    pub overrides: Vec<String>,
    /// The emission.
    pub emission: SceneEmission,
    /// The camera.
    pub camera: Camera,
    /// The length unit, if the scene or its model has one.
    pub length_unit: Option<String>,
    /// Rows of the image; of a `HEALPix` map, those of all twelve faces one above the other.
    pub height: usize,
    /// Columns of the image; of a `HEALPix` map, those of a face.
    pub width: usize,
    /// What the pixels are.
    pub quantity: Quantity,
    /// The third axis of its image, if that is a cube: energies, or more than one bin of the time.
    pub energy: Option<Energies>,
    /// The times of the image, if the scene says so: pixels are means over them.
    pub exposure: Option<Exposure>,
    /// The camera that counts photons, if the scene has one.
    pub instrument: Option<SceneInstrument>,
    /// Where on the sky the image is, if the scene says so.
    pub sky: Option<Sky>,
    /// The unit of the pixels, FITS grammar; empty if the scene has none.
    unit: String,
    /// The unit of the image of all energies, where there are energies.
    band: BandUnit,
    /// How it is rendered.
    pub render: RenderSettings,
    /// The tree that `emitree build` makes of it, if the scene has `[build]`.
    pub build: Option<BuildSettings>,
}

impl Scene {
    /// The axis along which g is sampled beside space: that of energies, or of times, be it of one bin.
    pub fn axis(&self) -> Option<&EnergyAxis> {
        let times = self.exposure.as_ref().map(Exposure::times);
        times.or(self.energy.as_ref()).map(Energies::axis)
    }

    /// The unit of the image, or of the cube, FITS grammar; empty if the scene has none.
    pub fn image_unit(&self) -> &str {
        &self.unit
    }

    /// The unit of the image of the whole energy band: that of the cube times an energy, FITS
    /// grammar; empty if the scene has no units, or no energies.
    pub fn band_unit(&self) -> &str {
        &self.band.unit
    }

    /// The coordinates of the pixels, as FITS keywords; none for a sky in `HEALPix` pixels.
    pub fn wcs(&self) -> Option<Wcs> {
        let length = self.length_unit.as_deref().and_then(|unit| Unit::parse(unit).ok());
        self.camera.wcs(self.height, self.width, &length.unwrap_or_else(Unit::one))
    }

    /// The same coordinates, those of the sky where the scene has `[sky]`: of files.
    pub fn celestial_wcs(&self) -> Option<Wcs> {
        let wcs = self.wcs()?;
        Some(match (&self.sky, self.camera.pointing()) {
            (Some(sky), Some(pointing)) => wcs.on_sky(sky, pointing),
            _ => wcs,
        })
    }

    /// What a sum of voxels times the widths of their bins is multiplied with, for
    /// [`band_unit`](Self::band_unit).
    pub(crate) fn band_factor(&self) -> f64 {
        self.band.factor
    }

    /// An image of the whole energy band, or of all times, the cube's unit times that of the energies, in
    /// [`band_unit`](Self::band_unit): as for the frames of a rendering.
    ///
    /// ```
    /// use emitree::Image;
    /// use emitree_io::Scene;
    ///
    /// let text = r#"
    ///     emission = { expression = "1", unit = "ph cm-3 s-1 sr-1 keV-1" }
    ///     projection = { type = "canonical", length_unit = "cm" }
    ///     image = { width = 1, height = 1 }
    ///     energy = { min = 100, max = 300, bins = 2, unit = "eV" }
    /// "#;
    /// let scene = Scene::parse("example", text, &[])?;
    /// // 100 eV · 3 + 100 eV · 4, as of `Cube::sum_over_energy`.
    /// let band = scene.in_band_unit(Image::from_pixels(1, 1, vec![700.0]));
    /// assert_eq!((scene.image_unit(), scene.band_unit()), ("ph cm-2 s-1 sr-1 keV-1", "ph cm-2 s-1 sr-1"));
    /// assert!((band[(0, 0)] - 0.7).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn in_band_unit(&self, mut band: Image) -> Image {
        band.pixels_mut().iter_mut().for_each(|pixel| *pixel *= self.band.factor);
        band
    }

    /// The counts that the scene's instrument is expected to make of a cube of radiance as it is
    /// rendered, in [`image_unit`](Self::image_unit), or per steradian of it where the quantity of the scene is
    /// irradiance; none if the scene has no instrument.
    ///
    /// ```
    /// use emitree::{Cube, Image};
    /// use emitree_io::Scene;
    ///
    /// let text = r#"
    ///     emission = { expression = "1", unit = "ph cm-3 s-1 sr-1 keV-1" }
    ///     image = { width = 1, height = 1 }
    ///     energy = { min = 0.5, max = 1.5, bins = 2 }
    ///     instrument = { effective_area = 50.0, exposure = 1e4 }
    ///     [projection]
    ///     type = "equirectangular"
    ///     position = [0, 0, 0]
    ///     target = [1, 0, 0]
    ///     field_of_view = [1, 1]
    ///     far = 1
    ///     length_unit = "cm"
    /// "#;
    /// let scene = Scene::parse("example", text, &[])?;
    /// let radiance = Cube::from_bands(vec![Image::from_pixels(1, 1, vec![3.0]); 2]);
    /// let observation = scene.expected_counts(&radiance).ok_or("no instrument")??;
    /// // 3 · 1 keV · 50 cm² · 1e4 s · (1°)².
    /// let solid_angle_sr = 2.0 * 0.5_f64.to_radians().sin() * 1_f64.to_radians();
    /// let expected = 3.0 * 50.0 * 1e4 * solid_angle_sr;
    /// assert!((observation.counts.voxels().sum::<f64>() / expected - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`ObservationError`] within, if the cube has not the scene's shape or is infinite somewhere.
    pub fn expected_counts(
        &self,
        radiance: &Cube,
    ) -> Option<Result<Observation, ObservationError>> {
        let (instrument, energies) = (self.instrument.as_ref()?, self.energy.as_ref()?);
        let ones = Image::from_pixels(self.height, self.width, vec![1.0; self.height * self.width]);
        let solid_angles_sr = irradiance_of(&ones, self.camera.projection());
        Some(instrument.expected_counts(radiance, energies.axis(), &solid_angles_sr))
    }

    /// The options of the library that render the scene, with the memory that is available now and without
    /// callbacks.
    ///
    /// ```
    /// use emitree_io::Scene;
    ///
    /// let text = r#"
    ///     emission = { expression = "exp(-x)" }
    ///     projection = { type = "canonical" }
    ///     image = { width = 4, height = 4 }
    ///     render = { max_evaluations = 2000 }
    /// "#;
    /// let options = Scene::parse("example", text, &[])?.render_options();
    /// assert_eq!((options.method.name(), options.max_evaluations), ("vol", 2000));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn render_options(&self) -> RenderOptions<'static> {
        let RenderSettings { method, max_evaluations, max_seconds, batch_size, rounds, .. } =
            &self.render;
        let mut options = RenderOptions::new(method.clone());
        options.max_evaluations = max_evaluations.unwrap_or(options.max_evaluations);
        options.max_seconds = max_seconds.unwrap_or(options.max_seconds);
        options.batch_size = batch_size.unwrap_or(options.batch_size);
        options.rounds = *rounds;
        options.max_memory_bytes = available_memory_bytes().unwrap_or(options.max_memory_bytes);
        options
    }

    /// Renders an emission with the settings of the scene: radiances, in one band if the scene has no energies.
    ///
    /// # Errors
    ///
    /// As [`render`].
    pub fn render<E: Emission>(
        &self,
        emission: &E,
        options: &RenderOptions<'_>,
    ) -> Result<Rendering<Cube>, RenderError<E::Error>> {
        let (camera, shape) = (self.camera.projection(), [self.height, self.width]);
        match self.axis() {
            None => render(emission, camera, shape, options).map(Into::into),
            Some(axis) => render_cube(emission, camera, shape, axis, options),
        }
    }

    /// The same rendering as a session, which takes rates in the unit of the image per length.
    ///
    /// # Errors
    ///
    /// As [`Session::new`](emitree::Session::new).
    pub fn session(
        self: &Arc<Self>,
        options: &RenderOptions<'_>,
    ) -> Result<Session<'static, Cube>, RenderError<Infallible>> {
        let (camera, shape) = (SceneCamera(Arc::clone(self)), [self.height, self.width]);
        Session::with_energies(camera, shape, self.axis().copied(), options)
    }

    /// Radiances, or their errors, in the quantity of the scene.
    pub fn in_quantity(&self, radiance: &Image) -> Image {
        match self.quantity {
            Quantity::Irradiance => irradiance_of(radiance, self.camera.projection()),
            Quantity::Radiance => radiance.clone(),
        }
    }

    /// All bands of a cube in that quantity.
    pub fn cube_in_quantity(&self, radiance: &Cube) -> Cube {
        Cube::from_bands(radiance.bands().iter().map(|band| self.in_quantity(band)).collect())
    }

    /// Reads the scene file at `path`, with values replaced by `overrides`, the later ones last.
    ///
    /// # Errors
    ///
    /// [`SceneError`] names the file or the option, the line, the text and what was expected.
    pub fn open(path: &Path, overrides: &[Override]) -> Result<Self, SceneError> {
        let text = read(path).map_err(|cause| SceneError::unreadable(path, &cause))?;
        Self::parse(&path.display().to_string(), &text, overrides)
    }

    /// Reads the scene file at `path` for a [`PlannedRun`](crate::PlannedRun): its `[emission]` may be missing, or
    /// say no more than its unit, since another program makes the rates.
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open).
    pub fn open_planned(path: &Path, overrides: &[Override]) -> Result<Self, SceneError> {
        let text = read(path).map_err(|cause| SceneError::unreadable(path, &cause))?;
        Self::parse_planned(&path.display().to_string(), &text, overrides)
    }

    /// Reads a scene from its text; `name` is what messages call it.
    ///
    /// ```
    /// use emitree_io::Scene;
    ///
    /// let text = r#"
    ///     emission.expression = "exp(-100 * (x - 0.5)^2)"
    ///     projection.type = "canonical"
    ///     image = { width = 32, height = 16 }
    /// "#;
    /// let scene = Scene::parse("example", text, &[])?;
    /// assert_eq!((scene.height, scene.width), (16, 32));
    /// assert_eq!(scene.render.method.name(), "vol");
    /// # Ok::<(), emitree_io::SceneError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open).
    pub fn parse(name: &str, text: &str, overrides: &[Override]) -> Result<Self, SceneError> {
        Self::parse_with(name, text, overrides, true)
    }

    /// Reads a scene from its text as [`open_planned`](Self::open_planned) does.
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open).
    pub fn parse_planned(
        name: &str,
        text: &str,
        overrides: &[Override],
    ) -> Result<Self, SceneError> {
        Self::parse_with(name, text, overrides, false)
    }

    /// Reads a scene, which may have to have an emission.
    fn parse_with(
        name: &str,
        text: &str,
        overrides: &[Override],
        needs_emission: bool,
    ) -> Result<Self, SceneError> {
        let source = Arc::new(Source { name: name.to_owned(), text: text.to_owned() });
        let mut root = Node::parse(&source)?;
        let mut changes = Vec::with_capacity(overrides.len());
        for change in overrides {
            let (node, line) = change.parse()?;
            root.merge(node);
            changes.push(line);
        }
        let whole = root.place.clone();
        let start = Place { span: 0..0, ..whole };
        let mut table = Table::new(root)?;
        let emission = match table.table("emission")? {
            Some(emission) => emission,
            None if !needs_emission => Table::absent("emission", &start),
            None => {
                let expected =
                    "expected a table `[emission]` with `expression`, `model`, `grid` or `tree`";
                let missing = SceneError::at(&start, "the scene has no `[emission]`");
                return Err(table.slip_of("emission").unwrap_or_else(|| missing.label(expected)));
            }
        };
        let energy = table.table("energy")?.map(energy::read).transpose()?;
        let projection = table.table("projection")?;
        if let Some(slip) = table.slip_of("projection").filter(|_| projection.is_none()) {
            return Err(slip);
        }
        let up = camera::up(projection.as_ref())?;
        let time = table.table("time")?.map(|table| time::read(table, up)).transpose()?;
        let spectrum = match (&energy, &time) {
            (Some(_), Some(time)) => return Err(time.refuse_energies()),
            (Some(_), None) => Spectrum::Of,
            (None, Some(_)) => Spectrum::InTime,
            (None, None) => Spectrum::Without,
        };
        let instrument = table.table("instrument")?;
        let (source, of_emission) = emission::read(emission, spectrum, needs_emission)?;
        if let (Some(instrument), EmissionSource::Components(_)) = (&instrument, &source) {
            let message = "the scene has `[instrument]` and `emission.expressions`";
            return Err(SceneError::at(instrument.place(), message)
                .label("expected none: counts are those of a single `emission.expression`"));
        }
        let absorption = table.table("absorption")?;
        let absorption = absorption.map(|table| absorption::read(table, spectrum)).transpose()?;
        let occulters = table.tables("occulter", "tables `[[occulter]]`, each with a `type`")?;
        let bounds = table.table("bounds")?;
        let edges = table.tables("edge", "tables `[[edge]]`, each with a `type`")?;
        let expected = "tables `[[singularity]]`, each with a `type`";
        let singularities = table.tables("singularity", expected)?;
        let shapes = ShapeTables { bounds, occulters, edges, singularities };
        let moves = time.as_ref().is_some_and(time::GivenTime::moves);
        let (camera, length_unit, shapes) =
            camera::read(projection, shapes, &source, moves, &start)?;
        let layout = camera.description().pixels;
        let (shape, of_image) = read_image(table.table("image")?, layout, &start)?;
        let seeds = table.tables("seed", "tables `[[seed]]`, each with `position` and `radius`")?;
        let seeds = seed::read(seeds)?;
        let render = table.table("render")?.unwrap_or_else(|| Table::absent("render", &start));
        let build = table.table("build")?.map(tree::read_build).transpose()?;
        let sky = table.table("sky")?;
        table.finish()?;

        let camera_units = CameraUnits {
            length: length_unit,
            has_solid_angles: camera.description().has_solid_angles,
        };
        let exposure = time.as_ref().map(|time| &time.exposure);
        let mut found = radiometry::resolve(
            source,
            &of_emission,
            &of_image,
            camera_units,
            energy.as_ref(),
            exposure,
        )?;
        if let Some(given) = absorption {
            let of_scene = given.resolve(found.length_unit.as_deref(), energy.as_ref())?;
            found.emission.absorption = Some(of_scene);
        }
        if let Some(time) = &time {
            let length_unit = found.length_unit.as_deref();
            let events = time.events(&camera, &shapes, &seeds, length_unit)?;
            found.emission.events = events.map(Arc::new);
        }
        let has_axis = energy.is_some() || time.is_some();
        let times = exposure.map(Exposure::times).filter(|times| times.axis().bins() > 1);
        let render = {
            let lines = energy.as_ref().map_or_else(Vec::new, |energies| energies.lines().to_vec());
            let view = accuracy::RenderedView {
                shape,
                has_energies: energy.is_some() || times.is_some(),
                quantity: found.quantity,
                length_unit: found.length_unit.as_deref(),
                camera: &camera,
                unit: &found.unit,
                band_unit: if has_axis { &found.band.unit } else { &found.unit },
                band_factor: if has_axis { found.band.factor } else { 1.0 },
            };
            settings::read(render, seeds, lines, &view)?
        };
        let observer = Observer {
            camera: &camera,
            shape,
            energies: energy.as_ref(),
            quantity: found.quantity,
            unit: &found.unit,
        };
        let instrument = instrument.map(|table| instrument::read(table, observer)).transpose()?;
        let view = camera.sky_view(found.length_unit.as_deref());
        let sky = sky.map(|table| sky::read(table, &view)).transpose()?;
        let [height, width] = shape;
        Ok(Self {
            name: name.to_owned(),
            text: text.to_owned(),
            overrides: changes,
            emission: found.emission,
            camera,
            length_unit: found.length_unit,
            height,
            width,
            quantity: found.quantity,
            energy: energy.or(times.cloned()),
            exposure: time.map(|time| time.exposure),
            instrument,
            sky,
            unit: found.unit,
            band: found.band,
            render,
            build,
        })
    }
}

/// The sky of the text of a table `[sky]`.
pub(crate) fn read_sky(text: &str, view: &SkyView<'_>) -> Result<Sky, SceneError> {
    let source = Arc::new(Source { name: "sky".to_owned(), text: text.to_owned() });
    let mut root = Table::new(Node::parse(&source)?)?;
    let place = Place { source, span: 0..0 };
    let table = root.table("sky")?.unwrap_or_else(|| Table::absent("sky", &place));
    root.finish()?;
    sky::read(table, view)
}

/// The camera of a scene that a session shares.
struct SceneCamera(Arc<Scene>);

impl Borrow<dyn Projection> for SceneCamera {
    fn borrow(&self) -> &(dyn Projection + 'static) {
        self.0.camera.projection()
    }
}

/// The longest scene that is read \[bytes\]: devices have no end.
const LONGEST_SCENE: u64 = 1 << 26;

/// The text of a scene file.
fn read(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(LONGEST_SCENE + 1).read_to_string(&mut text)?;
    if text.len() as u64 > LONGEST_SCENE {
        return Err(io::Error::other(format!("it is longer than {LONGEST_SCENE} bytes")));
    }
    Ok(text)
}

/// Height and width of the image, and the settings of its unit.
fn read_image(
    table: Option<Table>,
    layout: PixelLayout,
    start: &Place,
) -> Result<([usize; 2], ImageUnits), SceneError> {
    const PIXELS: &str = "a number of pixels, 1 to 2^24";
    const NSIDE: &str = "a power of two, 1 to 2^13: pixels along the edge of a face";
    let keys = match layout {
        PixelLayout::Rectangle => "`width` and `height`",
        PixelLayout::Healpix => "`nside`",
    };
    let Some(mut table) = table else {
        return Err(SceneError::at(start, "the scene has no `[image]`")
            .label(format!("expected a table `[image]` with {keys}")));
    };
    let mut pixels = |key, expected, most, power_of_two: bool| {
        let node = table.require(key, expected)?;
        match node.count::<usize>(expected)? {
            pixels
                if (1..=most).contains(&pixels) && (!power_of_two || pixels.is_power_of_two()) =>
            {
                Ok(pixels)
            }
            other => Err(node.refuse(&other.to_string(), expected)),
        }
    };
    let shape = match layout {
        PixelLayout::Healpix => Healpix::shape(pixels("nside", NSIDE, 1 << 13, true)?),
        PixelLayout::Rectangle => {
            let width = pixels("width", PIXELS, 1 << 24, false)?;
            [pixels("height", PIXELS, 1 << 24, false)?, width]
        }
    };
    let units = ImageUnits::read(&mut table)?;
    table.finish()?;
    Ok((shape, units))
}

/// A file that a scene names is beside the scene; one that an option names is where the command
/// was given.
fn beside_scene(file: &str, place: &Place) -> PathBuf {
    if is_option(&place.source) {
        return PathBuf::from(file);
    }
    let folder = Path::new(&place.source.name).parent().unwrap_or(Path::new(""));
    folder.join(file)
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_of_guide;
