//! The files of a sweep: all names checked before g is called, those of an image written with it.

use crate::arguments::SweepArguments;
use crate::failure::Failure;
use emitree::Method;
use emitree::los::{LosOptions, Steps};
use emitree_io::{
    Format, NameTemplate, OutputFile, PictureStyle, Product, RenderedScene, Scene, SceneSweep,
    SweepReport, commit_all,
};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The names of all files, image by image.
pub(super) struct Outputs<'a> {
    images: Vec<Named>,
    error_map: Option<Named>,
    report: Option<&'a Path>,
}

/// A format, and the name of the file of each image.
struct Named {
    format: Format,
    names: Vec<PathBuf>,
}

impl<'a> Outputs<'a> {
    pub(super) fn prepare(
        arguments: &'a SweepArguments,
        sweep: &SceneSweep,
    ) -> Result<Self, Failure> {
        let named = |option: &str, text: &PathBuf| -> Result<Named, Failure> {
            let format = Format::from_path(text)?;
            let refuse = |why: &dyn std::fmt::Display| Failure::Request(format!("{option}: {why}"));
            let text = text.to_str().ok_or_else(|| refuse(&"a name that is not Unicode"))?;
            let template = NameTemplate::parse(text, sweep).map_err(|error| refuse(&error))?;
            Ok(Named { format, names: template.names(sweep).map_err(|error| refuse(&error))? })
        };
        let images = arguments.outputs.iter().map(|text| named("--output", text));
        let images: Vec<Named> = images.collect::<Result<_, _>>()?;
        let error_map = arguments.error_map.as_ref().map(|text| named("--error-map", text));
        let error_map = error_map.transpose()?;
        let outputs = Self { images, error_map, report: arguments.report.as_deref() };
        outputs.check(&arguments.scene)?;
        Ok(outputs)
    }

    /// Refuses names that are the same file, or that can't be written.
    fn check(&self, scene: &Path) -> Result<(), Failure> {
        let mut seen: HashMap<PathBuf, &Path> = HashMap::new();
        let scene = std::fs::canonicalize(scene).ok();
        let of_images = self.images.iter().chain(&self.error_map).flat_map(|named| &named.names);
        for path in of_images.map(PathBuf::as_path).chain(self.report) {
            // The temporary file beside the target.
            drop(OutputFile::create(path)?);
            let place = placed(path);
            if Some(&place) == scene.as_ref() {
                let path = path.display();
                let why = "is the scene itself: expected another name";
                return Err(Failure::Request(format!("the output {path} {why}")));
            }
            if let Some(first) = seen.insert(place, path) {
                let (first, second) = (first.display(), path.display());
                let why = "are the same file: expected different names";
                return Err(Failure::Request(format!("the outputs {first} and {second} {why}")));
            }
        }
        Ok(())
    }

    /// Writes the files of an image, all or none, and returns their names.
    pub(super) fn write(
        &self,
        image: usize,
        scene: &Scene,
        rendered: RenderedScene,
    ) -> Result<(RenderedScene, Vec<PathBuf>), Failure> {
        let style = PictureStyle::default();
        let mut ready: Vec<(OutputFile, Vec<u8>)> = Vec::new();
        for (named, is_error) in self.of_image() {
            let Some(path) = named.names.get(image) else { continue };
            let product = match is_error {
                false => Some(rendered.product(scene)),
                true => error(scene, &rendered),
            };
            let Some(product) = product else { continue };
            let bytes = named.format.encode(&product, style)?;
            ready.push((OutputFile::create(path)?, bytes));
        }
        let written = commit_all(ready)?;
        Ok((rendered, written))
    }

    /// The files of an image, and whether each is that of its error.
    fn of_image(&self) -> impl Iterator<Item = (&Named, bool)> {
        let images = self.images.iter().map(|named| (named, false));
        images.chain(self.error_map.iter().map(|named| (named, true)))
    }

    /// Writes the report of all images.
    pub(super) fn write_report(&self, report: &SweepReport) -> Result<(), Failure> {
        let Some(path) = self.report else { return Ok(()) };
        Ok(OutputFile::create(path)?.commit(report.to_json().as_bytes())?)
    }
}

/// The estimated error, if there is one.
fn error<'a>(scene: &'a Scene, rendered: &'a RenderedScene) -> Option<Product<'a>> {
    let provenance = rendered.account.cards();
    let product = Product::new(scene, rendered.error_map()?);
    Some(Product { meaning: "estimated error", provenance, ..product })
}

/// The path with the links of its folder followed.
fn placed(path: &Path) -> PathBuf {
    if let Ok(existing) = std::fs::canonicalize(path) {
        return existing;
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    match (std::fs::canonicalize(folder), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

/// Refuses several emission rates, and what the method of a scene has not.
pub(super) fn check_scene(arguments: &SweepArguments, scene: &Scene) -> Result<(), Failure> {
    if scene.component_names().is_some() {
        let why = "a sweep has one image for each value: expected a single `emission.expression`";
        return Err(Failure::Request(format!("{}: `emission.expressions`: {why}", scene.name)));
    }
    match scene.render.method {
        Method::Los(LosOptions { steps: Steps::Fixed(_), .. }) if arguments.error_map.is_some() => {
            let why = "uniform steps have no error estimate: expected another method";
            Err(Failure::Request(format!("--error-map: {why}")))
        }
        _ => Ok(()),
    }
}
