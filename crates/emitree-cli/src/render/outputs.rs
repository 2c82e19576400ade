//! The files of a rendering: all of them prepared before g is called, all written at the end.

use super::counts::{self, Counts};
use super::fits::{self, NamedMap};
use super::frames::{is_frame_of, prepare_folder, write_progression};
use super::map::{Map, Rendered};
use super::picture::{self, Style};
use crate::arguments::RenderArguments;
use crate::failure::Failure;
use crate::report::Report;
use emitree::los::Steps;
use emitree::{Healpix, Method};
use emitree_io::{
    CameraKind, Card, Format, HealpixFile, OutputFile, OutputSet, Quantity, Scene, ValueRange,
    commit_all, encode_npy, encode_npy_cube, encode_npy_image,
};
use std::path::{Path, PathBuf};

/// An output file and the format that its ending chose.
type Target = (OutputFile, Format);

/// What is to be written, each with its temporary file.
pub(crate) struct Outputs {
    images: Vec<Target>,
    bands: Vec<Target>,
    expected_counts: Vec<Target>,
    counts: Vec<Target>,
    error_map: Option<Target>,
    report: Option<OutputFile>,
    progressive: Option<PathBuf>,
    style: Style,
}

impl Outputs {
    pub(crate) fn prepare(arguments: &RenderArguments, scene: &Scene) -> Result<Self, Failure> {
        check_method(arguments, scene)?;
        let images = if arguments.outputs.is_empty() {
            beside_nothing(&arguments.scene)
        } else {
            arguments.outputs.clone()
        };
        let (bands, error_map) = (&arguments.bands, &arguments.error_map);
        let (expected, drawn) = (&arguments.expected_counts, &arguments.counts);
        let lists = [&images, bands, expected, drawn];
        let maps = || lists.into_iter().flatten().chain(error_map);
        let paths = || maps().chain(&arguments.report);
        if let Some(path) = paths().find(|path| same_file(path, &arguments.scene)) {
            let path = path.display();
            let why = "is the scene itself: expected another name";
            return Err(Failure::Request(format!("the output {path} {why}")));
        }
        let formats: Vec<Format> = maps().map(Format::from_path).collect::<Result<_, _>>()?;
        if images.iter().chain(bands).chain(error_map).any(is_fits) {
            check_columns(scene)?;
        }
        let to_fits = expected.iter().chain(drawn).any(is_fits);
        let allowed = scene.render_options().max_memory_bytes;
        counts::check(arguments, scene, to_fits, allowed)?;
        let style = Style::of(arguments);
        if style != Style::Bare && !formats.contains(&Format::Png) {
            let why = "no output is a picture: expected one that ends in .png";
            return Err(Failure::Request(format!("--annotate: {why}")));
        }
        if let Some(folder) = &arguments.progressive {
            prepare_folder(folder)?;
            if let Some(path) = paths().find(|path| is_frame_of(path, folder)) {
                let path = path.display();
                let why = "would be replaced by a frame of --progressive: expected another name";
                return Err(Failure::Request(format!("the output {path} {why}")));
            }
        }
        let lengths = lists.map(Vec::len);
        let mut files = OutputSet::create(paths())?.into_iter();
        let mut targets = files.by_ref().take(formats.len()).zip(formats);
        let [images, bands, expected_counts, counts] =
            lengths.map(|length| targets.by_ref().take(length).collect());
        let error_map = targets.next();
        let report = files.next();
        let progressive = arguments.progressive.clone();
        Ok(Self { images, bands, expected_counts, counts, error_map, report, progressive, style })
    }

    /// Writes everything and returns the names of the files; and why there are no files of counts, if
    /// nothing but counts can't be written.
    pub(crate) fn write(
        self,
        scene: &Scene,
        rendered: &Rendered,
        report: &Report,
    ) -> Result<(Vec<PathBuf>, Option<Failure>), Failure> {
        // All bytes are made before the first file is: a failure leaves none of them, but for one of
        // counts.
        let image = self.images.into_iter().map(|target| (target, Product::image(scene, rendered)));
        let bands = self.bands.into_iter();
        let bands = bands.filter_map(|target| Some((target, Product::band(scene, rendered)?)));
        let of_instrument = rendered.counts.as_ref();
        let expected = self.expected_counts.into_iter();
        let expected =
            expected.filter_map(|target| Some((target, Product::expected(scene, of_instrument?))));
        let drawn = self.counts.into_iter();
        let drawn =
            drawn.filter_map(|target| Some((target, Product::drawn(scene, of_instrument?)?)));
        let error = self.error_map.into_iter();
        let error = error.filter_map(|target| Some((target, Product::error(scene, rendered)?)));
        let encode = |((file, format), product): (Target, Product<'_>)| {
            Ok((file, product.encode(format, self.style, scene, rendered)?))
        };
        let mut ready: Vec<(OutputFile, Vec<u8>)> =
            image.chain(bands).map(encode).collect::<Result<_, Failure>>()?;
        let mut failure = None;
        for target in expected.chain(drawn) {
            match encode(target) {
                Ok(file) => ready.push(file),
                Err(error) => {
                    failure.get_or_insert(error);
                }
            }
        }
        for target in error {
            ready.push(encode(target)?);
        }
        if let Some(file) = self.report {
            ready.push((file, report.to_json()));
        }
        let mut written = commit_all(ready)?;
        if let Some(folder) = &self.progressive {
            written.extend(write_progression(folder, scene, rendered)?);
        }
        Ok((written, failure))
    }
}

fn is_fits(path: &PathBuf) -> bool {
    Format::from_path(path).is_ok_and(|format| format == Format::Fits)
}

/// The outputs of a scene when none is asked for: in this folder, named like the scene.
fn beside_nothing(scene: &Path) -> Vec<PathBuf> {
    let name = PathBuf::from(scene.file_name().unwrap_or("image".as_ref()));
    ["fits", "npy", "png"].map(|ending| name.with_extension(ending)).to_vec()
}

/// One of the things that a rendering makes, and what files say of it.
pub(super) struct Product<'a> {
    /// The name of its HDU or column.
    pub(super) name: &'static str,
    /// What its values are, for people.
    pub(super) meaning: &'static str,
    pub(super) map: &'a Map,
    /// The unit of its values, which may be empty.
    pub(super) unit: &'a str,
    /// What a FITS file has besides.
    pub(super) others: Vec<NamedMap<'a>>,
    /// What its FITS file tells beside what is true of the whole rendering.
    pub(super) provenance: Vec<Card>,
}

impl<'a> Product<'a> {
    /// The image, or the cube.
    fn image(scene: &'a Scene, rendered: &'a Rendered) -> Self {
        let (map, unit) = (&rendered.map, scene.image_unit());
        let error = rendered.error.iter().map(|error| ("ERROR", error, unit));
        let band = rendered.band.iter().map(|band| ("BAND", band, scene.band_unit()));
        let others = error.chain([evaluations(rendered)]).chain(band).collect();
        let meaning = picture::meaning(scene);
        Self { name: name(scene), meaning, map, unit, others, provenance: Vec::new() }
    }

    /// The image of the whole energy band, if there are energies.
    fn band(scene: &'a Scene, rendered: &'a Rendered) -> Option<Self> {
        let (map, unit) = (rendered.band.as_ref()?, scene.band_unit());
        let error = rendered.band_error.iter().map(|error| ("ERROR", error, unit));
        let others = error.chain([evaluations(rendered)]).collect();
        let (name, meaning) = (name(scene), scene.quantity.name());
        Some(Self { name, meaning, map, unit, others, provenance: Vec::new() })
    }

    /// The expected counts.
    fn expected(scene: &Scene, counts: &'a Counts) -> Self {
        Self {
            name: "EXPECTED",
            meaning: "expected counts",
            map: &counts.expected,
            unit: COUNT,
            others: Vec::new(),
            provenance: exposure(scene).into_iter().collect(),
        }
    }

    /// The counts that were drawn, if any were.
    fn drawn(scene: &Scene, counts: &'a Counts) -> Option<Self> {
        let map = counts.drawn.as_ref()?;
        let seed = scene.instrument.as_ref();
        let seed = seed.map(|found| Card::new("SEED", found.seed, "of the counts that were drawn"));
        let provenance = exposure(scene).into_iter().chain(seed).collect();
        Some(Self {
            name: "COUNTS",
            meaning: "counts",
            map,
            unit: COUNT,
            others: Vec::new(),
            provenance,
        })
    }

    /// The estimated error, if there is one.
    fn error(scene: &'a Scene, rendered: &'a Rendered) -> Option<Self> {
        let (map, unit) = (rendered.error.as_ref()?, scene.image_unit());
        let (others, provenance) = (Vec::new(), Vec::new());
        Some(Self { name: "ERROR", meaning: "estimated error", map, unit, others, provenance })
    }

    fn encode(
        &self,
        format: Format,
        style: Style,
        scene: &Scene,
        rendered: &Rendered,
    ) -> Result<Vec<u8>, Failure> {
        match (format, style) {
            (Format::Fits, _) => fits::encode(scene, rendered, self),
            (Format::Png, Style::Annotated { logarithmic }) => {
                picture::annotated(self, scene, logarithmic)
            }
            _ => encode(self.map, self.unit, format, scene, None),
        }
    }
}

/// The unit of counts, in the grammar of FITS.
const COUNT: &str = "count";

/// The exposure of the scene's instrument.
fn exposure(scene: &Scene) -> Option<Card> {
    let exposure_s = scene.instrument.as_ref()?.instrument.exposure_s;
    Some(Card::new("EXPOSURE", exposure_s, "[s] of the counts"))
}

/// The name of the image among the parts of a FITS file.
fn name(scene: &Scene) -> &'static str {
    match scene.quantity {
        Quantity::Irradiance => "IRRADIANCE",
        _ => "RADIANCE",
    }
}

fn evaluations(rendered: &Rendered) -> NamedMap<'_> {
    ("EVALUATIONS", &rendered.evaluations_per_pixel, "")
}

/// The bytes of a bare map; colours of a picture in `range`, or in the map's own.
pub(super) fn encode(
    map: &Map,
    unit: &str,
    format: Format,
    scene: &Scene,
    range: Option<ValueRange>,
) -> Result<Vec<u8>, Failure> {
    if format != Format::Npy {
        return picture::bare(map, unit, scene, range);
    }
    if scene.camera.kind() == CameraKind::Healpix {
        let nested: Vec<f64> = map.bands().iter().flat_map(Healpix::nested).collect();
        let bins = map.bands().len();
        let shape = [bins, nested.len() / bins.max(1)];
        let shape = if map.is_cube() { &shape[..] } else { &shape[1..] };
        return Ok(encode_npy(shape, &nested)?);
    }
    Ok(match map.bands() {
        [image] if !map.is_cube() => encode_npy_image(image),
        _ => encode_npy_cube(map.cube()),
    })
}

/// Refuses options that the method, or a scene without energies, can't do.
fn check_method(arguments: &RenderArguments, scene: &Scene) -> Result<(), Failure> {
    let refuse = |option: &str, why: &str, expected: &str| {
        Err(Failure::Request(format!("{option}: {why}: expected {expected}")))
    };
    if !arguments.bands.is_empty() && scene.energy.is_none() {
        let why = "the scene has no `[energy]`, and its image no energy band";
        return refuse("--band", why, "a scene with an energy axis");
    }
    let other = "another method";
    match scene.render.method {
        Method::Los(_) if arguments.progressive.is_some() => {
            refuse("--progressive", "lines of sight have no coefficients", other)
        }
        Method::Los(options)
            if arguments.error_map.is_some() && matches!(options.steps, Steps::Fixed(_)) =>
        {
            refuse("--error-map", "equal steps have no error estimate", other)
        }
        Method::Paper(_) if arguments.progressive.is_some() && scene.energy.is_some() => {
            refuse("--progressive", "`paper` has no frames of a cube", "the method `vol`")
        }
        _ => Ok(()),
    }
}

/// Refuses a cube of the sky that has more bands and errors than a table of FITS has columns.
fn check_columns(scene: &Scene) -> Result<(), Failure> {
    let Some(energies) = &scene.energy else { return Ok(()) };
    let has_error = !matches!(scene.render.method, Method::Los(options) if matches!(options.steps, Steps::Fixed(_)));
    // Evaluations and the whole band have a column each.
    let most = (HealpixFile::MOST_COLUMNS - 2) / if has_error { 2 } else { 1 };
    let bins = energies.axis().bins();
    if scene.camera.kind() == CameraKind::Healpix && bins > most {
        let why = format!("a table of FITS has no columns for {bins} energy bins of a sky");
        return Err(Failure::Request(format!("output: {why}: expected {most} or less, or .npy")));
    }
    Ok(())
}

pub(super) fn same_file(a: &Path, b: &Path) -> bool {
    match (std::fs::canonicalize(a), std::fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}
