//! The files of a rendering: all of them prepared before g is called, all written at the end.

use super::counts::{self, fewest_maps_of_sky};
use super::frames::{is_frame_of, prepare_folder, same_file, write_progression};
use super::rendered::Rendered;
use crate::arguments::RenderArguments;
use crate::failure::Failure;
use emitree::Method;
use emitree::los::Steps;
use emitree_io::{
    Format, OutputFile, OutputSet, PictureStyle, Product, Scene, SurfaceFormat, commit_all,
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
    surfaces: Vec<(OutputFile, SurfaceFormat)>,
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
        let paths = || maps().chain(&arguments.surfaces).chain(&arguments.report);
        refuse_scene_itself(paths(), &arguments.scene)?;
        let formats: Vec<Format> = maps().map(Format::from_path).collect::<Result<_, _>>()?;
        let of_surfaces = arguments.surfaces.iter().map(SurfaceFormat::from_path);
        let of_surfaces: Vec<SurfaceFormat> = of_surfaces
            .collect::<Result<_, _>>()
            .map_err(|error| Failure::Request(format!("--surfaces: {error}")))?;
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
        let surfaces = files.by_ref().take(of_surfaces.len()).zip(of_surfaces).collect();
        let report = files.next();
        let progressive = arguments.progressive.clone();
        Ok(Self {
            images,
            bands,
            expected_counts,
            counts,
            error_map,
            surfaces,
            report,
            progressive,
            style,
        })
    }

    /// Writes everything and returns the names of the files; and why there are no files of counts or surfaces,
    /// if nothing else can't be written.
    pub(crate) fn write(
        self,
        scene: &Scene,
        rendered: &Rendered,
    ) -> Result<(Vec<PathBuf>, Option<Failure>), Failure> {
        // All bytes are made before the first file is: a failure leaves none of them, but for one of
        // counts or surfaces.
        let images = self.images.into_iter().map(|target| (target, rendered.product(scene)));
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
        for (file, format) in self.surfaces {
            match surfaces(rendered, format) {
                Ok(bytes) => ready.push((file, bytes)),
                Err(error) => {
                    failure.get_or_insert(error);
                }
            }
        }
        for target in errors {
            ready.push(encode(target)?);
        }
        if let Some(file) = self.report {
            ready.push((file, rendered.report().to_json().into_bytes()));
        }
        let mut written = commit_all(ready)?;
        if let Some(folder) = &self.progressive {
            written.extend(write_progression(folder, scene, rendered)?);
        }
        Ok((written, failure))
    }
}

/// Refuses to replace the scene by an output.
pub(super) fn refuse_scene_itself<'a>(
    mut outputs: impl Iterator<Item = &'a PathBuf>,
    scene: &Path,
) -> Result<(), Failure> {
    let Some(path) = outputs.find(|path| same_file(path, scene)) else { return Ok(()) };
    let why = "is the scene itself: expected another name";
    Err(Failure::Request(format!("the output {} {why}", path.display())))
}

/// How pictures look; annotations are refused if no output is a picture.
pub(super) fn style(
    arguments: &RenderArguments,
    formats: &[Format],
) -> Result<PictureStyle, Failure> {
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
pub(super) fn beside_nothing(scene: &Path) -> Vec<PathBuf> {
    let name = PathBuf::from(scene.file_name().unwrap_or("image".as_ref()));
    let formats = Format::ALL.into_iter().filter(|format| format.description().is_default);
    formats.map(|format| name.with_extension(ending(format))).collect()
}

/// The image of the whole energy band, if there are energies.
fn whole_band<'a>(scene: &'a Scene, rendered: &'a Rendered) -> Option<Product<'a>> {
    let others = rendered.companions_of_band(rendered.band_error.as_ref());
    let provenance = rendered.account.cards();
    Some(Product { others, provenance, ..Product::new(scene, rendered.band_map()?) })
}

/// The expected counts, if there is an instrument.
fn expected<'a>(scene: &'a Scene, rendered: &'a Rendered) -> Option<Product<'a>> {
    let counts = rendered.counts.as_ref()?;
    let bands = counts.bands();
    let (map, provenance) = rendered.counts_map(&counts.expected, bands, None);
    Some(Product { meaning: "expected counts", provenance, ..Product::new(scene, map) })
}

/// The counts that were drawn, if any were.
fn drawn<'a>(scene: &'a Scene, rendered: &'a Rendered) -> Option<Product<'a>> {
    let counts = rendered.counts.as_ref()?;
    let bands = counts.bands();
    let (map, provenance) =
        rendered.counts_map(counts.drawn.as_ref()?, bands, rendered.account.seed);
    Some(Product { meaning: "counts", provenance, ..Product::new(scene, map) })
}

/// A file of the surfaces that were found.
fn surfaces(rendered: &Rendered, format: SurfaceFormat) -> Result<Vec<u8>, Failure> {
    let Some(found) = &rendered.surfaces else {
        return Err(Failure::Request(
            "--surfaces: the image is not made of found surfaces: expected an emission rate that jumps, and no \
             `base_level` above 3, no `smallest_feature`, no seeds and no tolerance below 0.0005"
                .to_owned(),
        ));
    };
    Ok(format.encode(found, &rendered.account)?)
}

/// The estimated error, if there is one.
fn error<'a>(scene: &'a Scene, rendered: &'a Rendered) -> Option<Product<'a>> {
    let provenance = rendered.account.cards();
    let product = Product::new(scene, rendered.error_map()?);
    Some(Product { meaning: "estimated error", provenance, ..product })
}

/// Refuses options that the method, or a scene without energies, can't do.
pub(super) fn check_method(arguments: &RenderArguments, scene: &Scene) -> Result<(), Failure> {
    let refuse = |option: &str, why: &str, expected: &str| {
        Err(Failure::Request(format!("{option}: {why}: expected {expected}")))
    };
    if !arguments.bands.is_empty() && scene.energy.is_none() {
        let why = "the scene has no `[energy]`, and its image no energy band";
        return refuse("--band", why, "a scene with an energy axis");
    }
    if !arguments.surfaces.is_empty() {
        let name = scene.render.method.name();
        if !matches!(scene.render.method, Method::Vol(_)) {
            let why = format!("the method `{name}` finds no surfaces");
            return refuse("--surfaces", &why, "the method `vol`");
        }
        if scene.axis().is_some() {
            let why = "surfaces are not searched for in a cube";
            let table = if scene.exposure.is_some() { "`[time]`" } else { "`[energy]`" };
            return refuse("--surfaces", why, &format!("a scene without {table}"));
        }
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
        Method::Paper(_) if arguments.progressive.is_some() && scene.axis().is_some() => {
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
