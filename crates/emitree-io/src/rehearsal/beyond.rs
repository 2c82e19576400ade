//! Emission behind the far ends of lines of sight.

use super::Remark;
use super::lines::{LINES, Line, lines, minus, rates};
use crate::scene::Scene;
use emitree::{Cube, Rendering};

/// Points on each line behind its end.
const POINTS: usize = 8;
/// Samples that the search takes.
const SAMPLES: u64 = (LINES * LINES * POINTS) as u64;

/// The remark that lines of sight of twice the length would have seen more, and the evaluations that it took; none if
/// lines of sight end at bounds or bodies, or the budget does not suffice.
pub(super) fn remark(
    scene: &Scene,
    rendering: &Rendering<Cube>,
    most: u64,
) -> Option<(Option<Remark>, u64)> {
    let largest = rendering.values.voxels().filter(|pixel| pixel.is_finite());
    let largest = largest.fold(0.0, |largest: f64, pixel| largest.max(pixel.abs()));
    let has_far = scene.camera.description().keys.iter().any(|key| key.name == "far");
    if most < SAMPLES || largest == 0.0 || scene.camera.has_shapes() || !has_far {
        return None;
    }
    let lines = lines(scene);
    let mut points = Vec::with_capacity(POINTS * lines.len());
    for line in &lines {
        let along = minus(line.far, line.near);
        points.extend((0..POINTS).map(|k| {
            let share = (k as f64 + 0.5) / POINTS as f64;
            [0, 1, 2].map(|i| line.far[i] + share * along[i])
        }));
    }
    let repeated = |line: &Line| std::iter::repeat_n(line.direction, POINTS);
    let directions: Vec<[f64; 3]> = lines.iter().flat_map(repeated).collect();
    let rates = rates(scene, &points, &directions)?;
    let light =
        |(line, rates): (&Line, &[f64])| line.length * rates.iter().sum::<f64>() / POINTS as f64;
    let most = lines.iter().zip(rates.chunks_exact(POINTS)).map(light);
    let share = most.fold(0.0, |most: f64, light| most.max(light.abs())) / largest;
    let allowed = scene.render.tolerance.unwrap_or(0.01);
    let remark = (share.is_finite() && share > allowed).then(|| {
        let text = format!(
            "the emission goes on behind `far`: lines of sight of twice the length would have up to {} of the largest \
             pixel more",
            short(share)
        );
        Remark::new("far", text)
    });
    Some((remark, points.len() as u64))
}

/// A number of two digits or more: "0.034", "1.7", "14000", "3e9".
fn short(number: f64) -> String {
    let rounded: f64 = format!("{number:.1e}").parse().unwrap_or(number);
    if rounded < 1e6 { rounded.to_string() } else { format!("{rounded:e}") }
}
