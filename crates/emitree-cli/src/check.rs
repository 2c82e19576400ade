//! `emitree check`: what a scene would render, what it may cost, and what looks odd.

use crate::arguments::CheckArguments;
use crate::failure::Failure;
use crate::interrupt;
use crate::numbers::roughly;
use crate::progress::ProgressLine;
use crate::render::{method_text, size_text};
use crate::threads;
use emitree::RenderError;
use emitree_io::{EmissionSource, Forecast, Rehearsal, Scene, grouped};
use std::io::Write;
use std::process::ExitCode;

pub(crate) fn run(arguments: &CheckArguments) -> Result<ExitCode, Failure> {
    let scene = Scene::open(&arguments.scene, &arguments.scene_options.overrides())?;
    let pool = threads::pool(arguments.running.threads)?;
    interrupt::catch();
    let line = ProgressLine::new(arguments.running.quiet);
    let progress = |evaluations| line.advance(evaluations);
    let of =
        |scene: &Scene| pool.install(|| Rehearsal::of(scene, arguments.rehearsal, Some(&progress)));
    let found: Result<Vec<Rehearsed>, Failure> = match scene.components() {
        None => of(&scene).map(|rehearsal| vec![(String::new(), rehearsal)]).map_err(Failure::from),
        Some(components) => {
            let each = components.names().iter().zip(components.scenes());
            let rehearsed = each.map(|(name, scene)| match of(scene) {
                Ok(rehearsal) => Ok((name.clone(), rehearsal)),
                Err(error) => Err(Failure::from(error).of_image(format!("component {name}"))),
            });
            rehearsed.collect()
        }
    };
    line.finish();
    let found = found?;
    if interrupt::requested() {
        return Err(Failure::Render(RenderError::Interrupted));
    }
    if !arguments.running.quiet {
        print(&scene, &found)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The rehearsal of a component, by its name, which is empty where there is a single emission rate.
type Rehearsed = (String, Rehearsal);

fn print(scene: &Scene, rehearsed: &[Rehearsed]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let verdict = match rehearsed.iter().map(|(_, of)| of.remarks.len()).sum() {
        0 => "nothing odd".to_owned(),
        1 => "1 remark".to_owned(),
        more => format!("{more} remarks"),
    };
    writeln!(out, "{}: {verdict}", scene.name)?;
    let bins = scene.energy.as_ref().map(|energies| energies.axis().bins());
    let value = if bins.is_some() { "voxel" } else { "pixel" };
    writeln!(out, "  emission     {}", emission(scene))?;
    writeln!(out, "  camera       {}", camera(scene))?;
    writeln!(out, "  image        {}", image(scene))?;
    if let Some((energies, bins)) = scene.energy.as_ref().zip(bins) {
        let (label, scale) = (energies.label(0..bins), energies.scale_name());
        let of_bins = format!("{bins} bin{}", if bins == 1 { "" } else { "s" });
        writeln!(out, "  {:11}  {of_bins} of {label} ({scale})", energies.noun())?;
    } else if let Some(exposure) = &scene.exposure {
        writeln!(out, "  exposure     {}", exposure.times().label(0..1))?;
    }
    if let Some(instrument) = &scene.instrument {
        writeln!(out, "  counts       of {} s", instrument.instrument.exposure_s)?;
    }
    writeln!(out, "  method       {}", method_text(&scene.render.method, value))?;
    for sum in &scene.render.sums {
        let of = if sum.of == "sum" { String::new() } else { format!(" ({})", sum.of) };
        writeln!(out, "  sum          {}{of} to {} of itself", sum.name, sum.tolerance)?;
    }
    for (name, rehearsal) in rehearsed {
        if !name.is_empty() {
            writeln!(out, "  component    {name}, by itself:")?;
        }
        print_rehearsal(&mut out, rehearsal)?;
    }
    Ok(())
}

fn print_rehearsal(out: &mut impl Write, rehearsal: &Rehearsal) -> Result<(), Failure> {
    if let Some(forecast) = &rehearsal.forecast {
        writeln!(out, "  forecast     {}", forecast_text(forecast))?;
    }
    match rehearsal.evaluations {
        0 => writeln!(out, "  rehearsal    none: no forecast")?,
        all => {
            let of_all = format!("; {} evaluations with all tests", grouped(all));
            writeln!(out, "  rehearsal    {}{of_all}", rehearsal.how)?;
            if rehearsal.forecast.is_none() {
                writeln!(out, "  forecast     none: more than {} evaluations", grouped(all))?;
            }
        }
    }
    for remark in &rehearsal.remarks {
        writeln!(out, "  {:11}  {}", remark.about.to_uppercase(), remark.text)?;
    }
    Ok(())
}

/// What emits, with its unit.
fn emission(scene: &Scene) -> String {
    let of_source = match &scene.emission.source {
        EmissionSource::Expression(expression) => {
            let text = expression.text().split_whitespace().collect::<Vec<_>>().join(" ");
            shortened(&text, 70)
        }
        EmissionSource::Components(of_all) => {
            shortened(&format!("expressions of {}", of_all.names().join(", ")), 70)
        }
        EmissionSource::Model(model) => {
            format!("{}: {}", model.description().name, model.description().title)
        }
        EmissionSource::Grid(of) => {
            let [a, b, c] = of.grid.shape();
            let names = of.grid.axes().coordinates().names().join(", ");
            format!("{}: {a} x {b} x {c} data ({names})", of.file.display())
        }
        EmissionSource::Tree(file) => {
            format!("a tree of {} cells", grouped(file.tree.cells() as u64))
        }
        EmissionSource::Function(name) => format!("the function {name}"),
        _ => "an emission".to_owned(),
    };
    match scene.emission.rate_unit.as_str() {
        "" => format!("{of_source} (no unit)"),
        unit => format!("{of_source} [{unit}]"),
    }
}

fn camera(scene: &Scene) -> String {
    let camera = scene.camera.description();
    let unit = scene
        .length_unit
        .as_deref()
        .map_or_else(|| "lengths without a unit".to_owned(), |unit| format!("lengths in {unit}"));
    let ends = match scene.camera.has_shapes() {
        true => ", lines of sight end at bounds or bodies",
        false => "",
    };
    format!("{}, {unit}{ends}", camera.name)
}

fn image(scene: &Scene) -> String {
    let pixels = size_text(scene);
    let unit = match scene.image_unit() {
        "" => "no unit".to_owned(),
        unit => unit.to_owned(),
    };
    format!("{pixels}, {} [{unit}]", scene.quantity.name()).replace("[no unit]", "(no unit)")
}

fn forecast_text(forecast: &Forecast) -> String {
    let Forecast { evaluations, range: [low, high], time, is_exact, .. } = forecast;
    let evaluations = match is_exact {
        true => format!("{} evaluations", grouped(*evaluations)),
        false => format!(
            "some {} evaluations ({} to {})",
            grouped(two_digits(*evaluations)),
            grouped(two_digits(*low)),
            grouped(two_digits(*high))
        ),
    };
    format!("{evaluations}, some {}", roughly(*time))
}

/// A number with two digits that are not 0.
fn two_digits(number: u64) -> u64 {
    let power = 10_u64.pow(number.max(1).ilog10().saturating_sub(1));
    (number / power).saturating_mul(power)
}

/// A text of at most so many characters.
fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let start: String = text.chars().take(most - 2).collect();
    format!("{start} …")
}
