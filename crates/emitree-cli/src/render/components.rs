//! Scenes with several emission rates: an image for each component, from shared evaluations.

use super::is_of_largest;
use super::outputs::{beside_nothing, check_method, refuse_scene_itself, style};
use super::summary::{method as method_text, size_text};
use crate::arguments::RenderArguments;
use crate::failure::{BUDGET_ENDED, Failure};
use crate::interrupt;
use crate::numbers::seconds;
use crate::progress::{Goal, ProgressLine};
use emitree::RenderError;
use emitree_io::{
    Format, OutputSet, PictureStyle, Product, RenderedComponents, RenderedScene, Scene,
    SceneComponents, commit_all, grouped,
};
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// What a file of the rendering has.
enum Content {
    /// The images of all components.
    Images(Format),
    /// The picture of one component.
    Picture(usize),
    /// The errors of all components.
    Errors(Format),
    /// The picture of the error of one component.
    PictureOfError(usize),
    /// The report.
    Report,
}

/// Renders all components of a scene and writes the files.
pub(super) fn run(
    arguments: &RenderArguments,
    scene: &Scene,
    components: &SceneComponents,
    pool: &rayon::ThreadPool,
) -> Result<ExitCode, Failure> {
    refuse_options(arguments)?;
    check_method(arguments, scene)?;
    let (files, contents, style) = prepare(arguments, scene, components.names())?;
    let mut rendered = Vec::new();
    for (name, scene) in components.names().iter().zip(components.scenes()) {
        let found = rendered_component(arguments, scene, pool);
        let found = found.map_err(|failure| failure.of_image(format!("component {name}")))?;
        rendered.push((name.clone(), found));
    }
    let Some(all) = RenderedComponents::new(rendered, components.evaluations()) else {
        return Err(Failure::Request("the scene has no components".to_owned()));
    };
    let mut ready = Vec::with_capacity(contents.len());
    for (file, content) in files.into_iter().zip(contents) {
        if let Some(bytes) = pool.install(|| bytes_of(&content, &all, components, style))? {
            ready.push((file, bytes));
        }
    }
    let written = commit_all(ready)?;
    if !arguments.running.quiet {
        // The files are written: a summary without a reader is not a failure.
        let _ = print(scene, &all, &written);
    }
    let converged = all.account().converged();
    Ok(if converged { ExitCode::SUCCESS } else { ExitCode::from(BUDGET_ENDED) })
}

/// Refuses what there is of one emission rate alone.
fn refuse_options(arguments: &RenderArguments) -> Result<(), Failure> {
    let of_one = [
        ("--by-rows", arguments.by_rows),
        ("--band", !arguments.bands.is_empty()),
        ("--expected-counts", !arguments.expected_counts.is_empty()),
        ("--counts", !arguments.counts.is_empty()),
        ("--surfaces", !arguments.surfaces.is_empty()),
        ("--progressive", arguments.progressive.is_some()),
    ];
    match of_one.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => Err(Failure::Request(format!(
            "{option}: the scene has several `emission.expressions`: expected a single \
             `emission.expression`"
        ))),
        None => Ok(()),
    }
}

/// The temporary files, what they are to have, and how pictures look. A picture shows one component: its file has the
/// name of the component before the ending.
fn prepare(
    arguments: &RenderArguments,
    scene: &Scene,
    names: &[String],
) -> Result<(OutputSet, Vec<Content>, PictureStyle), Failure> {
    let images: Vec<PathBuf> = match arguments.outputs.is_empty() {
        true => beside_nothing(&arguments.scene),
        false => arguments.outputs.clone(),
    };
    let maps = images.iter().map(|path| (path, false));
    let maps = maps.chain(arguments.error_map.iter().map(|path| (path, true)));
    let (mut paths, mut contents, mut formats) = (Vec::new(), Vec::new(), Vec::new());
    for (path, is_error) in maps {
        let format = Format::from_path(path)?;
        formats.push(format);
        if !format.description().is_picture {
            paths.push(path.clone());
            contents.push(if is_error { Content::Errors(format) } else { Content::Images(format) });
            continue;
        }
        for (number, name) in names.iter().enumerate() {
            paths.push(with_name(path, name));
            contents.push(match is_error {
                true => Content::PictureOfError(number),
                false => Content::Picture(number),
            });
        }
    }
    if let Some(path) = &arguments.report {
        paths.push(path.clone());
        contents.push(Content::Report);
    }
    refuse_scene_itself(paths.iter(), &arguments.scene)?;
    let bins = scene.energy.as_ref().map_or(1, |energies| energies.axis().bins());
    let columns = names.len() * (2 * bins + 2);
    for format in formats.iter().filter(|_| scene.camera.description().is_sky()) {
        if let Some(most) = format.description().most_maps_of_sky.filter(|&most| columns > most) {
            let why = format!(
                "a table of {} has no columns for {} components",
                format.description().name,
                names.len()
            );
            return Err(Failure::Request(format!(
                "output: {why}: expected {most} columns or less instead of {columns}, or .npy"
            )));
        }
    }
    let style = style(arguments, &formats)?;
    Ok((OutputSet::create(paths.iter())?, contents, style))
}

/// `image-total.png` of `image.png`.
fn with_name(path: &Path, component: &str) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{component}."));
    name.push(path.extension().map(OsString::from).unwrap_or_default());
    path.with_file_name(name)
}

fn rendered_component(
    arguments: &RenderArguments,
    scene: &Scene,
    pool: &rayon::ThreadPool,
) -> Result<RenderedScene, Failure> {
    let mut options = scene.render_options();
    let tolerance = scene.render.tolerance.filter(|_| is_of_largest(&scene.render.method));
    let line = ProgressLine::towards(Goal::of(&options, tolerance), arguments.running.quiet);
    let progress = |evaluations| line.advance(evaluations);
    options.progress = Some(&progress);
    let found = pool.install(|| {
        let found = scene.render(&scene.emission, &options)?;
        Ok(RenderedScene::new(scene, &found))
    });
    line.finish();
    if interrupt::requested() {
        return Err(Failure::Render(RenderError::Interrupted));
    }
    found
}

/// The bytes of a file; none of errors that the method does not estimate, which are refused before.
fn bytes_of(
    content: &Content,
    all: &RenderedComponents,
    components: &SceneComponents,
    style: PictureStyle,
) -> Result<Option<Vec<u8>>, Failure> {
    let picture = |number: usize, is_error: bool| -> Result<Option<Vec<u8>>, Failure> {
        let scene = components.scenes().get(number);
        let Some((scene, (name, of))) = scene.zip(all.components().nth(number)) else {
            return Ok(None);
        };
        let product = match is_error {
            false => of.product(scene),
            true => {
                let Some(map) = of.error_map() else { return Ok(None) };
                Product { meaning: "estimated error", ..Product::new(scene, map) }
            }
        };
        let meaning = format!("{} of {name}", product.meaning);
        let product = Product { meaning: &meaning, ..product };
        Ok(Some(Format::Png.encode(&product, style)?))
    };
    Ok(match content {
        Content::Images(Format::Npy) => Some(all.npy()?),
        Content::Images(_) => Some(all.fits()?),
        Content::Errors(Format::Npy) => all.error_npy().transpose()?,
        Content::Errors(_) => all.error_fits().transpose()?,
        Content::Picture(number) => picture(*number, false)?,
        Content::PictureOfError(number) => picture(*number, true)?,
        Content::Report => Some(all.report().to_json().into_bytes()),
    })
}

fn print(
    scene: &Scene,
    all: &RenderedComponents,
    written: &[PathBuf],
) -> Result<(), std::io::Error> {
    let mut out = std::io::stdout().lock();
    let size = size_text(scene);
    let value = if scene.energy.is_some() { "voxel" } else { "pixel" };
    let count = all.components().count();
    let components = if count == 1 { "component" } else { "components" };
    writeln!(out, "{}: {size}, {count} {components}", scene.name)?;
    if let Some(energies) = &scene.energy {
        let bins = energies.axis().bins();
        let (label, scale) = (energies.label(0..bins), energies.scale_name());
        writeln!(out, "  {:11}  {bins} bins of {label} ({scale})", energies.noun())?;
    }
    writeln!(out, "  method       {}", method_text(&scene.render.method, value))?;
    let account = all.account();
    let evaluations = grouped(account.evaluations);
    writeln!(out, "  evaluations  {evaluations} of all components together")?;
    if let Some(evaluations) = account.absorption_evaluations {
        writeln!(out, "  absorption   {} evaluations of its coefficient", grouped(evaluations))?;
    }
    for (name, of) in all.components() {
        let ((low, high), unit) = (of.values.min_max(), &of.account.unit);
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let error = of.account.estimated_error.map_or_else(String::new, |error| {
            format!(", error {error:.2e} of its largest {value} (estimated)")
        });
        writeln!(out, "  {name:11}  {low:.4e} to {high:.4e}{unit}{error}")?;
    }
    let [total, emission] = [account.total_seconds, account.emission_seconds]
        .map(|time| seconds(Duration::from_secs_f64(time)));
    writeln!(out, "  time         {total}, of which the emission {emission}")?;
    let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    writeln!(out, "  written      {}", names.join(", "))?;
    if !scene.render.ignored.is_empty() {
        let (names, method) = (scene.render.ignored.join(", "), scene.render.method.name());
        writeln!(out, "  ignored      {names}: the method {method} has no such option")?;
    }
    for (name, of) in all.components() {
        if let Some(hint) = of.hint() {
            writeln!(out, "  hint         {name}: {hint}")?;
        }
    }
    for (name, of) in all.components().filter(|(_, of)| !of.account.converged()) {
        writeln!(out, "  NOT CONVERGED: {name}, ended by {}", of.account.ending)?;
    }
    Ok(())
}
