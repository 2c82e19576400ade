//! The files of a rendering: all of them prepared before g is called, all written at the end.

use super::frames::{is_frame_of, prepare_folder, write_progression};
use super::picture::{self, Style};
use crate::arguments::RenderArguments;
use crate::failure::Failure;
use crate::report::Report;
use emitree::{Healpix, Image, Method, RenderedTree, Rendering, Steps};
use emitree_io::units::Unit;
use emitree_io::{
    CameraKind, Card, FitsFile, FitsImage, Format, HealpixColumn, HealpixFile, OutputFile,
    OutputSet, Quantity, Scene, ValueRange, encode_npy, encode_npy_image,
};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What is to be written, each with its temporary file.
pub(crate) struct Outputs {
    images: Vec<(OutputFile, Format)>,
    error_map: Option<(OutputFile, Format)>,
    report: Option<OutputFile>,
    progressive: Option<PathBuf>,
    style: Style,
}

impl Outputs {
    pub(crate) fn prepare(arguments: &RenderArguments, method: Method) -> Result<Self, Failure> {
        let refuse = |option: &str, why: &str| {
            Err(Failure::Request(format!("{option}: {why}: expected another method")))
        };
        if let Method::Los(options) = method {
            if arguments.progressive.is_some() {
                return refuse("--progressive", "lines of sight have no coefficients");
            }
            if arguments.error_map.is_some() && matches!(options.steps, Steps::Fixed(_)) {
                return refuse("--error-map", "equal steps have no error estimate");
            }
        }
        let images = if arguments.outputs.is_empty() {
            beside_nothing(&arguments.scene)
        } else {
            arguments.outputs.clone()
        };
        let paths = || images.iter().chain(&arguments.error_map).chain(&arguments.report);
        if let Some(path) = paths().find(|path| same_file(path, &arguments.scene)) {
            let path = path.display();
            let why = "is the scene itself: expected another name";
            return Err(Failure::Request(format!("the output {path} {why}")));
        }
        let formats: Vec<Format> =
            images.iter().map(Format::from_path).collect::<Result<_, _>>()?;
        let error_format = arguments.error_map.as_ref().map(Format::from_path).transpose()?;
        let style = Style::of(arguments);
        if style != Style::Bare && !formats.iter().chain(&error_format).any(|f| *f == Format::Png) {
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
        let mut files = OutputSet::create(paths())?.into_iter();
        let images = files.by_ref().take(formats.len()).zip(formats).collect();
        let error_map = error_format.and_then(|format| Some((files.next()?, format)));
        let report = files.next();
        Ok(Self { images, error_map, report, progressive: arguments.progressive.clone(), style })
    }

    /// Writes everything and returns the names of the files.
    pub(crate) fn write(
        self,
        scene: &Scene,
        rendering: &Rendering,
        report: &Report,
    ) -> Result<Vec<PathBuf>, Failure> {
        // All bytes are made before the first file is: a failure leaves none of them.
        let mut ready = Vec::new();
        for (file, format) in self.images {
            let bytes = match (format, self.style) {
                (Format::Fits, _) => fits(scene, rendering)?,
                (Format::Png, Style::Annotated { logarithmic }) => {
                    let meaning = picture::meaning(scene);
                    picture::annotated(&rendering.image, scene, meaning, logarithmic)?
                }
                _ => encode(&rendering.image, format, scene, None)?,
            };
            ready.push((file, bytes));
        }
        if let (Some((file, format)), Some(error)) = (self.error_map, &rendering.error) {
            let bytes = match (format, self.style) {
                (Format::Fits, _) => fits_of_error(scene, rendering, error)?,
                (Format::Png, Style::Annotated { logarithmic }) => {
                    picture::annotated(error, scene, "estimated error", logarithmic)?
                }
                _ => encode(error, format, scene, None)?,
            };
            ready.push((file, bytes));
        }
        if let Some(file) = self.report {
            ready.push((file, report.to_json()));
        }
        let mut written = Vec::new();
        for (file, bytes) in ready {
            written.push(file.path().to_owned());
            file.commit(&bytes)?;
        }
        if let Some(folder) = &self.progressive {
            written.extend(write_progression(folder, scene, rendering)?);
        }
        Ok(written)
    }
}

/// The outputs of a scene when none is asked for: in this folder, named like the scene.
fn beside_nothing(scene: &Path) -> Vec<PathBuf> {
    let name = PathBuf::from(scene.file_name().unwrap_or("image".as_ref()));
    ["fits", "npy", "png"].map(|ending| name.with_extension(ending)).to_vec()
}

/// The bytes of a bare image; colours of a picture in `range`, or in the image's own.
pub(super) fn encode(
    image: &Image,
    format: Format,
    scene: &Scene,
    range: Option<ValueRange>,
) -> Result<Vec<u8>, Failure> {
    if format != Format::Npy {
        return picture::bare(image, scene, range);
    }
    let is_sky = scene.camera.kind() == CameraKind::Healpix;
    let nested = is_sky.then(|| Healpix::nested(image));
    Ok(match nested {
        Some(pixels) => encode_npy(&[pixels.len()], &pixels)?,
        None => encode_npy_image(image),
    })
}

/// The unit of the image, if the scene tells it.
fn unit(scene: &Scene) -> Option<&str> {
    Some(scene.image_unit()).filter(|unit| !unit.is_empty())
}

fn fits(scene: &Scene, rendering: &Rendering) -> Result<Vec<u8>, Failure> {
    let name = match scene.quantity {
        Quantity::Irradiance => "IRRADIANCE",
        _ => "RADIANCE",
    };
    let error = rendering.error.iter().map(|error| ("ERROR", error, unit(scene)));
    let evaluations = ("EVALUATIONS", &rendering.evaluations_of_pixels, None);
    let others = error.chain([evaluations]).collect();
    encode_fits(scene, rendering, (name, &rendering.image, unit(scene)), others)
}

fn fits_of_error(scene: &Scene, rendering: &Rendering, error: &Image) -> Result<Vec<u8>, Failure> {
    encode_fits(scene, rendering, ("ERROR", error, unit(scene)), Vec::new())
}

/// The name, the pixels and the unit of one map.
type Map<'a> = (&'static str, &'a Image, Option<&'a str>);

/// The bytes of a FITS file: images in HDUs, or columns of one table for a sky.
fn encode_fits(
    scene: &Scene,
    rendering: &Rendering,
    first: Map<'_>,
    others: Vec<Map<'_>>,
) -> Result<Vec<u8>, Failure> {
    let (provenance, history) = (provenance(scene, rendering), history(scene));
    let date = Some(SystemTime::now());
    if scene.camera.kind() == CameraKind::Healpix {
        let maps: Vec<Map<'_>> = std::iter::once(first).chain(others).collect();
        let nested: Vec<Vec<f64>> = maps.iter().map(|map| Healpix::nested(map.1)).collect();
        let columns = maps.iter().zip(&nested);
        let columns = columns
            .map(|((name, _, unit), values)| HealpixColumn { name, unit: *unit, values })
            .collect();
        return Ok(HealpixFile { columns, coordinates: None, provenance, history, date }.encode()?);
    }
    let image = |(name, image, unit)| FitsImage { name, image, unit };
    let length = scene.length_unit.as_deref().and_then(|unit| Unit::parse(unit).ok());
    let wcs = scene.camera.wcs(scene.height, scene.width, &length.unwrap_or_else(Unit::one));
    let file = FitsFile {
        primary: image(first),
        extensions: others.into_iter().map(image).collect(),
        wcs,
        provenance,
        history,
        date,
    };
    Ok(file.encode()?)
}

/// How the image came about.
fn provenance(scene: &Scene, rendering: &Rendering) -> Vec<Card> {
    let mut provenance = vec![
        Card::new("SCENE", scene.name.as_str(), "scene file, in full under HISTORY"),
        Card::new("METHOD", scene.render.method.name(), "from the emission to the image"),
        Card::new("NEVAL", rendering.evaluations, "evaluations of the emission rate"),
        Card::new("CONVERGD", rendering.converged(), "the method ended by itself"),
    ];
    if let Some(tolerance) = scene.render.tolerance {
        provenance.push(Card::new("TOLERANC", tolerance, "error asked for / largest pixel"));
    }
    if let Some(error) = rendering.estimated_error() {
        provenance.push(Card::new("ESTERROR", error, "estimated error / largest pixel"));
    }
    if let Some(RenderedTree { tree, threshold }) = &rendering.tree {
        provenance.push(Card::new("THRESHLD", *threshold, "details below it were dropped"));
        provenance.push(Card::new("ORDER", tree.order(), "order of the prediction"));
    }
    if let Some(base_level) = rendering.base_level {
        let base_level = i32::from(base_level);
        provenance.push(Card::new("BASELEVL", base_level, "2^this base intervals along each axis"));
    }
    if let Some(unit) = &scene.length_unit {
        provenance.push(Card::new("LENUNIT", unit.as_str(), "unit of length of the scene"));
    }
    provenance
}

/// The scene with what the command line changed.
pub(crate) fn history(scene: &Scene) -> String {
    let mut history = scene.text.trim_end().to_owned() + "\n";
    for change in &scene.overrides {
        history.push_str(&format!("# command line: {change}\n"));
    }
    history
}

pub(super) fn same_file(a: &Path, b: &Path) -> bool {
    match (std::fs::canonicalize(a), std::fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}
