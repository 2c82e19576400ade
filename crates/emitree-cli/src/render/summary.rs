//! The summary of a rendering, for people.

use crate::failure::Failure;
use emitree::{Ending, Method, Rendering, Steps, Threshold};
use emitree_io::Scene;
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

pub(crate) fn print(
    scene: &Scene,
    rendering: &Rendering,
    written: &[PathBuf],
) -> Result<(), Failure> {
    let pixels = (scene.height * scene.width) as f64;
    let unit = scene.emission.image_unit();
    let (low, high) = rendering.image.min_max();
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}: {} x {} pixels (width x height)", scene.name, scene.width, scene.height)?;
    writeln!(out, "  method       {}", method(scene))?;
    writeln!(
        out,
        "  evaluations  {} in {} batch{}, {:.2} for each pixel",
        grouped(rendering.evaluations),
        rendering.batches,
        if rendering.batches == 1 { "" } else { "es" },
        rendering.evaluations as f64 / pixels,
    )?;
    writeln!(out, "  error        {}", error(scene, rendering))?;
    writeln!(out, "{}", format!("  radiance     {low:.4e} to {high:.4e} {unit}").trim_end())?;
    let [total, emission] = [rendering.total_time, rendering.emission_time].map(seconds);
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
    match rendering.ending {
        Ending::Complete => {}
        Ending::DeepestLevel => writeln!(
            out,
            "  NOT CONVERGED: stopped at the deepest level; a finest_level would end it earlier"
        )?,
        _ => {
            let evaluations = grouped(rendering.evaluations);
            writeln!(
                out,
                "  NOT CONVERGED: stopped by its budget after {evaluations} evaluations"
            )?;
        }
    }
    Ok(())
}

fn method(scene: &Scene) -> String {
    match scene.render.method {
        Method::Paper(options) => {
            let cells = 1_u32 << options.base_level;
            let threshold = match options.threshold {
                Threshold::Absolute(size) => format!("{size}"),
                Threshold::Relative(fraction) => {
                    format!("{} % of the largest cell average", 100.0 * fraction)
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
                    format!("los: {lines}, adaptive to {} %", 100.0 * tolerance)
                }
            }
        }
        _ => scene.render.method.name().to_owned(),
    }
}

fn error(scene: &Scene, rendering: &Rendering) -> String {
    let Some(error) = rendering.estimated_error() else {
        return "not estimated by this method".to_owned();
    };
    let kind = match scene.render.method {
        Method::Los(_) => "estimated, along the lines only",
        _ => "estimated",
    };
    format!("{error:.2e} of the largest pixel ({kind})")
}

/// A time of a few digits: "13 ms", "2.4 s".
fn seconds(time: Duration) -> String {
    match time.as_secs_f64() {
        short if short < 0.1 => format!("{:.2} ms", 1e3 * short),
        long => format!("{long:.2} s"),
    }
}

/// A count with its thousands set apart: "19,136".
pub(crate) fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn thousands_are_set_apart() {
        assert_eq!([0, 999, 1_000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
    }
}
