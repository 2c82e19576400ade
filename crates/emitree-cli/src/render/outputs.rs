//! The files of a rendering: all of them prepared before g is called, all written at the end.

use super::counts::{self, fewest_maps_of_sky};
use super::frames::{is_frame_of, prepare_folder, write_progression};
use super::map::Rendered;
use super::provenance::provenance;
use crate::arguments::RenderArguments;
use crate::failure::Failure;
use crate::report::Report;
use emitree::Method;
use emitree::los::Steps;
use emitree_io::units::Unit;
use emitree_io::{
    Card, Format, OutputFile, OutputSet, PictureStyle, Product, ProductMap, Quantity, Scene,
    commit_all,
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
    style: PictureStyle,
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
        let formats_of = |paths: &mut dyn Iterator<Item = &PathBuf>| -> Vec<Format> {
            paths.filter_map(|path| Format::from_path(path).ok()).collect()
        };
        check_columns(scene, &formats_of(&mut images.iter().chain(bands).chain(error_map)))?;
        let formats_of_counts = formats_of(&mut expected.iter().chain(drawn));
        let allowed = scene.render_options().max_memory_bytes;
        counts::check(arguments, scene, &formats_of_counts, allowed)?;
        let style = style(arguments, &formats)?;
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
        let images = self.images.into_iter().map(|target| (target, image(scene, rendered)));
        let bands = self.bands.into_iter();
        let bands = bands.filter_map(|target| Some((target, whole_band(scene, rendered)?)));
        let expected_counts = self.expected_counts.into_iter();
        let expected_counts =
            expected_counts.filter_map(|target| Some((target, expected(scene, rendered)?)));
        let counts = self.counts.into_iter();
        let counts = counts.filter_map(|target| Some((target, drawn(scene, rendered)?)));
        let errors = self.error_map.into_iter();
        let errors = errors.filter_map(|target| Some((target, error(scene, rendered)?)));
        let encode = |((file, format), product): (Target, Product<'_>)| {
            Ok((file, format.encode(&product, self.style)?))
        };
        let mut ready: Vec<(OutputFile, Vec<u8>)> =
            images.chain(bands).map(encode).collect::<Result<_, Failure>>()?;
        let mut failure = None;
        for target in expected_counts.chain(counts) {
            match encode(target) {
                Ok(file) => ready.push(file),
                Err(error) => {
                    failure.get_or_insert(error);
                }
            }
        }
        for target in errors {
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

/// How pictures look; annotations are refused if no output is a picture.
fn style(arguments: &RenderArguments, formats: &[Format]) -> Result<PictureStyle, Failure> {
    if !arguments.annotate {
        return Ok(PictureStyle::default());
    }
    let is_picture = |format: &Format| format.description().is_picture;
    if formats.iter().any(is_picture) {
        return Ok(PictureStyle::Annotated { logarithmic: arguments.log });
    }
    let pictures = Format::ALL.into_iter().filter(is_picture);
    let endings: Vec<String> = pictures.map(|format| format!(".{}", ending(format))).collect();
    let why = "no output is a picture: expected one that ends in";
    Err(Failure::Request(format!("--annotate: {why} {}", endings.join(" or "))))
}

/// The ending of the names of new files.
fn ending(format: Format) -> &'static str {
    format.description().endings.first().copied().unwrap_or_default()
}

/// The default outputs of a scene: in this folder, named like the scene.
fn beside_nothing(scene: &Path) -> Vec<PathBuf> {
    let name = PathBuf::from(scene.file_name().unwrap_or("image".as_ref()));
    let formats = Format::ALL.into_iter().filter(|format| format.description().is_default);
    formats.map(|format| name.with_extension(ending(format))).collect()
}

/// The image, or the cube.
fn image<'a>(scene: &'a Scene, rendered: &'a Rendered) -> Product<'a> {
    let unit = scene.image_unit();
    let error = rendered.error.iter().map(|error| error.named("ERROR", unit));
    let band = rendered.band.iter().map(|band| band.named("BAND", scene.band_unit()));
    Product {
        meaning: meaning(scene),
        others: error.chain([evaluations(rendered)]).chain(band).collect(),
        ..product(scene, rendered, rendered.map.named(name(scene), unit), [])
    }
}

/// The image of the whole energy band, if there are energies.
fn whole_band<'a>(scene: &'a Scene, rendered: &'a Rendered) -> Option<Product<'a>> {
    let unit = scene.band_unit();
    let map = rendered.band.as_ref()?.named(name(scene), unit);
    let error = rendered.band_error.iter().map(|error| error.named("ERROR", unit));
    let others = error.chain([evaluations(rendered)]).collect();
    Some(Product { others, ..product(scene, rendered, map, []) })
}

/// The expected counts, if there is an instrument.
fn expected<'a>(scene: &'a Scene, rendered: &'a Rendered) -> Option<Product<'a>> {
    let map = rendered.counts.as_ref()?.expected.named("EXPECTED", COUNT);
    let product = product(scene, rendered, map, exposure(scene));
    Some(Product { meaning: "expected counts", ..product })
}

/// The counts that were drawn, if any were.
fn drawn<'a>(scene: &'a Scene, rendered: &'a Rendered) -> Option<Product<'a>> {
    let map = rendered.counts.as_ref()?.drawn.as_ref()?.named("COUNTS", COUNT);
    let seed = scene.instrument.as_ref();
    let seed = seed.map(|found| Card::new("SEED", found.seed, "of the counts that were drawn"));
    let product = product(scene, rendered, map, exposure(scene).into_iter().chain(seed));
    Some(Product { meaning: "counts", ..product })
}

/// The estimated error, if there is one.
fn error<'a>(scene: &'a Scene, rendered: &'a Rendered) -> Option<Product<'a>> {
    let map = rendered.error.as_ref()?.named("ERROR", scene.image_unit());
    Some(Product { meaning: "estimated error", ..product(scene, rendered, map, []) })
}

/// A map of a rendering, with what is true of the whole rendering and with `cards` that are true of it
/// alone.
fn product<'a>(
    scene: &'a Scene,
    rendered: &Rendered,
    map: ProductMap<'a>,
    cards: impl IntoIterator<Item = Card>,
) -> Product<'a> {
    let mut provenance = provenance(scene, rendered).cards();
    provenance.extend(cards);
    Product { provenance, ..Product::new(scene, map) }
}

/// What the pixels of the scene's image are: its quantity, or the column density that the integral
/// of a density is.
fn meaning(scene: &Scene) -> &'static str {
    let is_column = Unit::parse(scene.image_unit())
        .and_then(|unit| unit.factor_to(&Unit::parse("m-2")?))
        .is_ok();
    if is_column { "column density" } else { scene.quantity.name() }
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

/// The evaluations on the lines of sight of each pixel.
fn evaluations(rendered: &Rendered) -> ProductMap<'_> {
    rendered.evaluations_per_pixel.named("EVALUATIONS", "")
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
            refuse("--error-map", "uniform steps have no error estimate", other)
        }
        Method::Paper(_) if arguments.progressive.is_some() && scene.energy.is_some() => {
            refuse("--progressive", "`paper` has no frames of a cube", "the method `vol`")
        }
        _ => Ok(()),
    }
}

/// Refuses a cube of the sky that has more bands and errors than a file has room for.
fn check_columns(scene: &Scene, formats: &[Format]) -> Result<(), Failure> {
    let Some(energies) = &scene.energy else { return Ok(()) };
    let Some((format, columns)) = fewest_maps_of_sky(scene, formats) else { return Ok(()) };
    let has_error = !matches!(scene.render.method, Method::Los(options) if matches!(options.steps, Steps::Fixed(_)));
    // Evaluations and the whole band have a column each.
    let most = columns.saturating_sub(2) / if has_error { 2 } else { 1 };
    let bins = energies.axis().bins();
    if bins > most {
        let why = format!("a table of {format} has no columns for {bins} energy bins of a sky");
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_of_densities_are_column_densities() {
        let meaning = |unit: &str| {
            let text = format!(
                "emission = {{ expression = \"1\", unit = \"{unit}\" }}\nimage = {{ width = 1, \
                 height = 1 }}\nprojection = {{ type = \"perspective\", position = [0, 0, 0], \
                 target = [1, 0, 0], field_of_view = [1, 1], far = 1, length_unit = \"km\" }}"
            );
            meaning(&Scene::parse("scene.toml", &text, &[]).unwrap())
        };
        assert_eq!(meaning("cm-3"), "column density");
        assert_eq!(meaning("W m-3 sr-1"), "radiance");
        assert_eq!(meaning("m-1"), "radiance");
    }
}
