//! `emitree compare`: how two images differ.

use crate::arguments::CompareArguments;
use crate::failure::{DIFFERS, Failure};
use crate::numbers::{percent, short};
use emitree_io::{Comparison, Difference, OutputFile, StoredImage, grouped};
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

pub(crate) fn run(arguments: &CompareArguments) -> Result<ExitCode, Failure> {
    let tolerance = arguments.tolerance;
    if let Some(wrong) = tolerance.filter(|tolerance| !(*tolerance >= 0.0 && tolerance.is_finite()))
    {
        let why =
            format!("--tolerance: {wrong}: expected a fraction of the largest pixel, 0 or more");
        return Err(Failure::Request(why));
    }
    let output = arguments.output.as_deref().map(|path| prepare(path, arguments)).transpose()?;
    let [first, second] = [&arguments.first, &arguments.second].map(|path| StoredImage::open(path));
    let (first, second) = (first?, second?);
    let found = Comparison::of(&first, &second)?;
    if let Some(output) = output {
        output.commit(&found.picture(&first, &second)?)?;
    }
    let is_within = tolerance.is_none_or(|tolerance| found.is_within(tolerance));
    if !arguments.quiet {
        // The exit code says what matters: a text without a reader is not a failure.
        let _ = print(arguments, [&first, &second], &found);
    }
    Ok(if is_within { ExitCode::SUCCESS } else { ExitCode::from(DIFFERS) })
}

/// The temporary file beside the target of the picture.
fn prepare(path: &Path, arguments: &CompareArguments) -> Result<OutputFile, Failure> {
    let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    if !is_png {
        let why = "the difference is a picture: expected a name that ends in .png";
        return Err(Failure::Request(format!("output: `{}`: {why}", path.display())));
    }
    let same = |image: &Path| {
        std::fs::canonicalize(image)
            .ok()
            .zip(std::fs::canonicalize(path).ok())
            .is_some_and(|(image, path)| image == path)
    };
    if same(&arguments.first) || same(&arguments.second) {
        let why = "is one of the images: expected another name";
        return Err(Failure::Request(format!("the output {} {why}", path.display())));
    }
    Ok(OutputFile::create(path)?)
}

fn print(
    arguments: &CompareArguments,
    [first, second]: [&StoredImage; 2],
    found: &Comparison,
) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let [bands, height, width] = found.shape;
    let (of_bands, value) = match bands {
        1 => (String::new(), "pixel"),
        _ => (format!(", {bands} bands"), "voxel"),
    };
    let unit = if found.unit.is_empty() { String::new() } else { format!(" {}", found.unit) };
    writeln!(
        out,
        "{} and {}: {}{of_bands}",
        first.name,
        second.name,
        match found.is_sky {
            true => format!("{} pixels of the sky (HEALPix)", grouped(width as u64)),
            false => format!("{width} x {height} pixels (width x height)"),
        }
    )?;
    if (found.factor - 1.0).abs() > 0.0 {
        let [to, from] = [first, second].map(|image| image.unit.as_deref().unwrap_or_default());
        writeln!(out, "  unit         {to}; {from} is {:e} of it", found.factor)?;
    }
    match found.largest {
        None => writeln!(out, "  largest      none: no {value} is a number in both")?,
        Some(largest) if largest.amount() == 0.0 => {
            writeln!(out, "  largest      0: all numbers are the same")?;
        }
        Some(largest) => {
            let amount = largest.amount();
            writeln!(
                out,
                "  largest      {:.2e} of the largest {value} ({amount:.3e}{unit}), {}: {:e} and {:e}",
                found.relative(amount),
                place(largest.place, found),
                Rounded(largest.first),
                Rounded(largest.second),
            )?;
            let [rms, mean] = [found.rms, found.mean];
            writeln!(
                out,
                "  rms          {:.2e} of the largest {value} ({rms:.3e}{unit}); mean {:+.2e} ({mean:+.3e}{unit})",
                found.relative(rms),
                found.relative(mean),
            )?;
        }
    }
    writeln!(
        out,
        "  scale        {:.4e}{unit}, the largest {value} of {}",
        found.scale, first.name
    )?;
    let differs = found.largest.is_some_and(|largest| largest.amount() > 0.0);
    if let Some(beside) = found.beside_errors.as_ref().filter(|_| differs) {
        let maps = match beside.maps {
            2 => "sum of both errors",
            _ => "error, which one of them has",
        };
        // Two digits don't tell 1.004 from 1.
        let ratio = match short(beside.largest) {
            one if one == "1" && beside.above > 0 => format!("{:.4}", beside.largest),
            ratio => ratio,
        };
        let share = beside.above as f64 / found.compared.max(1) as f64;
        writeln!(
            out,
            "  errors       at most {} times the {maps}, {}; {} of {} {value}s ({}) are above it",
            ratio,
            place(beside.place, found),
            grouped(beside.above as u64),
            grouped(found.compared as u64),
            percent((1e4 * share).round() / 1e4),
        )?;
    }
    if let Some(at) = found.first_in_one_only {
        writeln!(
            out,
            "  no numbers   {} {value}s are a number in one image only, the first one {}",
            grouped(found.in_one_only as u64),
            place(at, found),
        )?;
    }
    if let Some(path) = &arguments.output {
        writeln!(out, "  written      {}", path.display())?;
    }
    if let Some(tolerance) = arguments.tolerance {
        let amount = found.relative(found.largest.map_or(0.0, Difference::amount));
        match found.is_within(tolerance) {
            true => writeln!(out, "  within {} of the largest {value}", percent(tolerance))?,
            false if amount <= tolerance => {
                writeln!(out, "  DIFFERENT: not all numbers are numbers in both")?;
            }
            false => {
                writeln!(
                    out,
                    "  DIFFERENT: more than {} of the largest {value}",
                    percent(tolerance)
                )?;
            }
        }
    }
    Ok(())
}

/// A number of six digits.
struct Rounded(f64);

impl std::fmt::LowerExp for Rounded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let rounded: f64 = format!("{:.5e}", self.0).parse().unwrap_or(self.0);
        write!(f, "{rounded:e}")
    }
}

fn place([band, row, column]: [usize; 3], found: &Comparison) -> String {
    let of_band = if found.shape[0] == 1 { String::new() } else { format!("band {band}, ") };
    match found.is_sky {
        true => format!("in {of_band}pixel {column} (nested)"),
        false => format!("in {of_band}row {row}, column {column}"),
    }
}
