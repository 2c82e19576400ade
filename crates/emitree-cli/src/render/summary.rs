//! The summary of a rendering, for people.

use crate::failure::Failure;
use emitree::{Method, Rendering, Steps, Threshold};
use emitree_io::Scene;
use std::io::Write;
use std::path::PathBuf;

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
        "  evaluations  {} in {} batches, {:.2} for each pixel",
        grouped(rendering.evaluations),
        rendering.batches,
        rendering.evaluations as f64 / pixels,
    )?;
    writeln!(out, "  error        {}", error(scene, rendering))?;
    writeln!(out, "  radiance     {low:.4e} to {high:.4e} {unit}")?;
    writeln!(
        out,
        "  time         {:.3} s, of which the emission {:.3} s",
        rendering.total_time.as_secs_f64(),
        rendering.emission_time.as_secs_f64(),
    )?;
    let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    match names.as_slice() {
        few if few.len() <= 6 => writeln!(out, "  written      {}", few.join(", "))?,
        [first, .., last] => {
            writeln!(out, "  written      {} files: {first} … {last}", names.len())?;
        }
        _ => {}
    }
    if !rendering.converged {
        let budget = grouped(scene.render.max_evaluations);
        writeln!(out, "  NOT CONVERGED: stopped by the budget of {budget} evaluations")?;
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
        _ => scene.render.method_name().to_owned(),
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
