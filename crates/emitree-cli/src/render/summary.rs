//! The summary of a rendering, for people.

use super::counts::{Counts, total};
use super::rendered::Rendered;
use crate::failure::Failure;
use crate::numbers::{percent, seconds};
use emitree::los::Steps;
use emitree::refinement::Threshold;
use emitree::vol::FEATURE_CONTRAST;
use emitree::{Cube, Method, StopReason, VolOptions};
use emitree_io::{Account, Energies, PixelLayout, Scene, SumAccount, grouped};
use std::io::Write;
use std::path::PathBuf;

/// The size of the image of a scene: "64 x 32 pixels (width x height)".
pub(crate) fn size_text(scene: &Scene) -> String {
    match scene.camera.description().pixels {
        PixelLayout::Healpix => format!("12 x {0} x {0} pixels (HEALPix)", scene.width),
        PixelLayout::Rectangle => {
            format!("{} x {} pixels (width x height)", scene.width, scene.height)
        }
    }
}

/// The bins of a cube: "  energies     24 bins of 0.5–8 keV (log)".
pub(crate) fn bins_text(energies: &Energies) -> String {
    let bins = energies.axis().bins();
    let of_bins = format!("{bins} bin{}", if bins == 1 { "" } else { "s" });
    let (noun, label, scale) = (energies.noun(), energies.label(0..bins), energies.scale_name());
    format!("  {noun:11}  {of_bins} of {label} ({scale})")
}

pub(crate) fn print(
    scene: &Scene,
    rendered: &Rendered,
    written: &[PathBuf],
) -> Result<(), Failure> {
    let bins = rendered.values.bands().len();
    let values = (scene.height * scene.width * bins) as f64;
    let value = if scene.energy.is_some() { "voxel" } else { "pixel" };
    let mut out = std::io::stdout().lock();
    let size = size_text(scene);
    writeln!(out, "{}: {size}", scene.name)?;
    if let Some(energies) = &scene.energy {
        writeln!(out, "{}{}", bins_text(energies), evaluated(&rendered.account))?;
    } else if let Some(exposure) = &scene.exposure {
        let label = exposure.times().label(0..1);
        writeln!(
            out,
            "  exposure     {label}{}",
            evaluated(&rendered.account).replace(" evaluated", " times evaluated")
        )?;
    }
    writeln!(out, "  method       {}", method(&scene.render.method, value))?;
    writeln!(
        out,
        "  evaluations  {} in {} batch{}, {:.2} for each {value}",
        grouped(rendered.stats.evaluations),
        rendered.stats.batches,
        if rendered.stats.batches == 1 { "" } else { "es" },
        rendered.stats.evaluations as f64 / values,
    )?;
    if let Some(evaluations) = rendered.account.absorption_evaluations {
        writeln!(out, "  absorption   {} evaluations of its coefficient", grouped(evaluations))?;
    }
    writeln!(out, "  error        {}", error(scene, rendered, value))?;
    for sum in &rendered.account.sums {
        writeln!(out, "  sum          {}", region_sum(sum))?;
    }
    if let Some(steps) = rendered.stats.line_steps {
        writeln!(
            out,
            "  lines        on a lattice of pixels, {steps} steps each, to minimize time"
        )?;
    }
    if let Some(fraction) = rendered.stats.smallest_feature {
        writeln!(out, "  covered      {}", covered(fraction))?;
    }
    let ranges = [
        (scene.quantity.name(), Some(&rendered.values), scene.image_unit()),
        (
            if scene.exposure.is_some() { "all times" } else { "whole band" },
            rendered.band.as_ref(),
            scene.band_unit(),
        ),
    ];
    for (name, map, unit) in ranges {
        let Some((low, high)) = map.map(Cube::min_max) else { continue };
        writeln!(out, "{}", format!("  {name:11}  {low:.4e} to {high:.4e} {unit}").trim_end())?;
    }
    if let Some(surfaces) = &rendered.surfaces {
        writeln!(out, "  surfaces     {} triangles", grouped(surfaces.triangles.len() as u64))?;
    }
    if let Some((counts, instrument)) = rendered.counts.as_ref().zip(scene.instrument.as_ref()) {
        let exposure_s = instrument.instrument.exposure_s;
        writeln!(out, "  counts       {}", counted(counts, exposure_s, instrument.seed))?;
    }
    let [total, emission] = [rendered.stats.total_time, rendered.stats.emission_time].map(seconds);
    writeln!(out, "  time         {total}, of which the emission {emission}")?;
    let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    match names.as_slice() {
        few if few.len() <= 6 => writeln!(out, "  written      {}", few.join(", "))?,
        [first, .., last] => {
            writeln!(out, "  written      {} files: {first} … {last}", names.len())?;
        }
        _ => {}
    }
    if !scene.render.ignored.is_empty() {
        let (names, method) = (scene.render.ignored.join(", "), scene.render.method.name());
        writeln!(out, "  ignored      {names}: the method {method} has no such option")?;
    }
    if let Some(hint) = rendered.hint() {
        writeln!(out, "  hint         {hint}")?;
    }
    if let Some(how) =
        stopped(&scene.render.method, rendered.stats.ending, rendered.stats.evaluations)
    {
        writeln!(out, "  NOT CONVERGED: stopped {how}")?;
    }
    Ok(())
}

/// The counts of an instrument, all together.
fn counted(counts: &Counts, exposure_s: f64, seed: u64) -> String {
    let channels = counts.expected.bands().len();
    let in_channels = format!("{channels} channel{}", if channels == 1 { "" } else { "s" });
    let expected =
        format!("{:.6e} expected in {in_channels} over {exposure_s} s", total(&counts.expected));
    match &counts.drawn {
        Some(drawn) => format!("{expected}, {} drawn with seed {seed}", total(drawn)),
        None => expected,
    }
}

/// How many energies were evaluated, where the method takes some.
pub(crate) fn evaluated(account: &Account) -> String {
    account.energies.map_or_else(String::new, |count| format!(", {count} evaluated"))
}

/// Why a rendering stopped before its stopping criterion was met.
fn stopped(method: &Method, ending: StopReason, evaluations: u64) -> Option<String> {
    match (ending, method) {
        (StopReason::Complete, _) => None,
        (StopReason::MaxLevel, Method::Vol(_)) => {
            Some("at the finest level (a sixteenth of a pixel or less)".to_owned())
        }
        (StopReason::MaxLevel, _) => {
            Some("at the deepest level; a finest_level would end it earlier".to_owned())
        }
        (StopReason::Time, _) => {
            Some(format!("by its max_seconds after {} evaluations", grouped(evaluations)))
        }
        _ => Some(format!("by its budget after {} evaluations", grouped(evaluations))),
    }
}

/// The error that is allowed.
fn allowed_error(options: &VolOptions, value: &str) -> String {
    let of_band = if options.per_band { " of its band" } else { "" };
    let weighted = if options.weights.is_some() { ", over its weight" } else { "" };
    let Some(by_pixel) = options.by_pixel else {
        if options.tolerance >= 1.0 {
            return "as its sums need it".to_owned();
        }
        return format!(
            "to {} of the largest {value}{of_band}{weighted}",
            percent(options.tolerance)
        );
    };
    let brightest = match options.per_band {
        true => "the brightest of its band",
        false => "the brightest",
    };
    let floor = match by_pixel.floor > 0.0 {
        true => format!(" or of {:e} of {brightest}", by_pixel.floor),
        false => String::new(),
    };
    let relative =
        (by_pixel.rtol > 0.0).then(|| format!("{} of itself{floor}", percent(by_pixel.rtol)));
    let absolute = (by_pixel.atol > 0.0).then(|| format!("{:e}", by_pixel.atol));
    let allowed: Vec<String> = relative.into_iter().chain(absolute).collect();
    format!("every {value} within {}{weighted}", allowed.join(" plus "))
}

/// The method, of an image of pixels or a cube of voxels.
pub(crate) fn method(method: &Method, value: &str) -> String {
    match method {
        Method::Vol(options) => {
            let lines = (1_u32 << options.base_level) + 1;
            format!("vol: {}, base {lines} x {lines} lines", allowed_error(options, value))
        }
        Method::Paper(options) => {
            let cells = 1_u32 << options.base_level;
            let threshold = match options.threshold {
                Threshold::Absolute(size) => format!("{size}"),
                Threshold::Relative(fraction) => {
                    format!("{} of the largest cell average", percent(fraction))
                }
            };
            let order = options.order;
            format!("paper: order {order}, base grid {cells}^3, threshold {threshold}")
        }
        Method::Los(options) => {
            let lines = format!("{0} x {0} lines of sight for each pixel", options.lines);
            match options.steps {
                Steps::Fixed(steps) => format!("los: {lines}, {steps} steps each"),
                Steps::Adaptive(tolerance) => {
                    format!("los: {lines}, adaptive to {}", percent(tolerance))
                }
            }
        }
        _ => method.name().to_owned(),
    }
}

fn error(scene: &Scene, rendered: &Rendered, value: &str) -> String {
    let Some(error) = rendered.account.estimated_error else {
        return "not estimated by this method".to_owned();
    };
    let kind = match scene.render.method {
        Method::Los(_) => "estimated, along the lines only",
        _ => "estimated",
    };
    let of_largest = format!("{error:.2e} of the largest {value} ({kind})");
    let is_uniform = match &scene.render.method {
        Method::Vol(vol) => vol.by_pixel.is_none() && vol.weights.is_none() && !vol.per_band,
        _ => true,
    };
    match rendered.account.error_over_allowed.filter(|_| !is_uniform) {
        Some(share) => format!("{of_largest}, at most {share:.2} of the error allowed"),
        None => of_largest,
    }
}

/// A sum over a region with its error: `on = 1.2345e2 +- 1.2e-1 erg (0.1 % of it, 0.2 % allowed)`.
fn region_sum(sum: &SumAccount) -> String {
    let SumAccount { name, of, value, error, allowed, unit, .. } = sum;
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let of = if of == "sum" { String::new() } else { format!(" ({of})") };
    let missed = if error > allowed { ", NOT MET" } else { "" };
    format!("{name}{of} = {value:.6e} +- {error:.1e}{unit}, {allowed:.1e} allowed{missed}")
}

/// The smallest feature that would have been detected.
fn covered(fraction: f64) -> String {
    format!(
        "Gaussians down to {fraction:.2e} of the view's cube (99 % probability, {FEATURE_CONTRAST} \
         times the tolerance)"
    )
}

#[cfg(test)]
mod tests {
    use super::{method, stopped};
    use crate::numbers::percent;
    use emitree::tree::BuildOptions;
    use emitree::{Method, StopReason, VolOptions};

    #[test]
    fn methods_are_summarised_with_their_options() {
        let vol = |tolerance, base_level| {
            method(&Method::Vol(VolOptions::new(tolerance).with_base_level(base_level)), "pixel")
        };
        assert_eq!(vol(0.01, 3), "vol: to 1 % of the largest pixel, base 9 x 9 lines");
        assert_eq!(vol(0.007, 7), "vol: to 0.7 % of the largest pixel, base 129 x 129 lines");
        assert_eq!([1e-6, 2.0, 1.0 / 3.0].map(percent), ["0.0001 %", "200 %", "33.33333333 %"]);
        assert_eq!([1e-9, 0.0].map(percent), ["1e-9", "0 %"]);
        let paper = method(&Method::Paper(BuildOptions::default()), "pixel");
        assert_eq!(
            paper,
            "paper: order 3, base grid 8^3, threshold 1 % of the largest cell average"
        );
    }

    #[test]
    fn stop_reasons_are_in_the_terms_of_the_method() {
        let vol = |ending| stopped(&Method::Vol(VolOptions::default()), ending, 1_234);
        assert_eq!(vol(StopReason::Complete), None);
        let budget = "by its budget after 1,234 evaluations";
        assert_eq!(vol(StopReason::Budget).unwrap(), budget);
        let finest = "at the finest level (a sixteenth of a pixel or less)";
        assert_eq!(vol(StopReason::MaxLevel).unwrap(), finest);
        let paper = |ending| stopped(&Method::Paper(BuildOptions::default()), ending, 1_234);
        assert_eq!(paper(StopReason::Budget).unwrap(), budget);
        let deepest = "at the deepest level; a finest_level would end it earlier";
        assert_eq!(paper(StopReason::MaxLevel).unwrap(), deepest);
    }
}
