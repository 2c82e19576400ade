//! The files of a rendering: all of them prepared before g is called, all written at the end.

use super::frames::{is_frame_of, prepare_folder, write_progression};
use crate::arguments::RenderArguments;
use crate::failure::Failure;
use crate::report::Report;
use emitree::{Image, Method, RenderedTree, Rendering, Steps};
use emitree_io::{
    Card, FitsFile, FitsImage, Format, OutputFile, OutputSet, PictureOptions, Scene, ValueRange,
    encode_npy_image, encode_png,
};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What is to be written, each with its temporary file.
pub(crate) struct Outputs {
    images: Vec<(OutputFile, Format)>,
    error_map: Option<(OutputFile, Format)>,
    report: Option<OutputFile>,
    progressive: Option<PathBuf>,
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
        Ok(Self { images, error_map, report, progressive: arguments.progressive.clone() })
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
            let bytes = match format {
                Format::Fits => fits(scene, rendering)?,
                _ => encode(&rendering.image, format, scene, None)?,
            };
            ready.push((file, bytes));
        }
        if let (Some((file, format)), Some(error)) = (self.error_map, &rendering.error) {
            let bytes = match format {
                Format::Fits => fits_of_error(scene, rendering, error)?,
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

pub(super) fn encode(
    image: &Image,
    format: Format,
    scene: &Scene,
    range: Option<ValueRange>,
) -> Result<Vec<u8>, Failure> {
    if format == Format::Npy {
        return Ok(encode_npy_image(image));
    }
    let unit = Some(scene.emission.image_unit().to_owned()).filter(|unit| !unit.is_empty());
    let options =
        PictureOptions { range, title: Some(scene.name.clone()), unit, ..Default::default() };
    Ok(encode_png(image, &options)?)
}

fn fits(scene: &Scene, rendering: &Rendering) -> Result<Vec<u8>, Failure> {
    let unit = Some(scene.emission.image_unit()).filter(|unit| !unit.is_empty());
    let named = |name, image| FitsImage { name, image, unit };
    let file = FitsFile {
        primary: named("RADIANCE", &rendering.image),
        extensions: rendering.error.iter().map(|error| named("ERROR", error)).collect(),
        ..header(scene, rendering)
    };
    Ok(file.encode()?)
}

fn fits_of_error(scene: &Scene, rendering: &Rendering, error: &Image) -> Result<Vec<u8>, Failure> {
    let unit = Some(scene.emission.image_unit()).filter(|unit| !unit.is_empty());
    let primary = FitsImage { name: "ERROR", image: error, unit };
    Ok(FitsFile { primary, ..header(scene, rendering) }.encode()?)
}

/// Coordinates and provenance, with the radiance as the only image.
fn header<'a>(scene: &Scene, rendering: &'a Rendering) -> FitsFile<'a> {
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
    let mut history = scene.text.trim_end().to_owned() + "\n";
    for change in &scene.overrides {
        history.push_str(&format!("# command line: {change}\n"));
    }
    FitsFile {
        primary: FitsImage { name: "RADIANCE", image: &rendering.image, unit: None },
        extensions: Vec::new(),
        wcs: Some(scene.camera.wcs(scene.height, scene.width)),
        provenance,
        history,
        date: Some(SystemTime::now()),
    }
}

pub(super) fn same_file(a: &Path, b: &Path) -> bool {
    match (std::fs::canonicalize(a), std::fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}
