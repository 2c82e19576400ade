//! Emission that is far brighter outside of the view than anywhere in it: a camera that points elsewhere.

use super::Remark;
use super::lines::{length, lines, minus, rates};
use crate::scene::Scene;
use emitree::{Cube, Rendering};
use std::f64::consts::TAU;

/// Points around the observer.
const POINTS: usize = 256;
/// How many times the largest rate in view a rate outside has to be. Sources fade by less across views on purpose: a
/// coronagraph has 10⁻⁴ of the disc, and an atmosphere four scale heights up 2 %.
const RATIO: f64 = 1e6;
/// The fractional part of the golden ratio: multiples of it are evenly spread on \[0, 1\].
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The remark that the emission is elsewhere, and the evaluations that it took; none if shapes bound lines of sight, or
/// the budget does not suffice.
pub(super) fn remark(
    scene: &Scene,
    rendering: &Rendering<Cube>,
    most: u64,
) -> Option<(Option<Remark>, u64)> {
    let in_view = rendering.stats.largest_rate.map_or(0.0, |of| of.rate.abs());
    if most < POINTS as u64 || in_view == 0.0 || scene.camera.has_shapes() {
        return None;
    }
    let lines = lines(scene);
    let first = lines.first()?;
    let count = lines.len() as f64;
    let middle = [0, 1, 2].map(|i| lines.iter().map(|line| line.near[i]).sum::<f64>() / count);
    let radius =
        lines.iter().fold(0.0, |most: f64, line| most.max(length(minus(line.far, middle))));
    let points: Vec<[f64; 3]> =
        offsets().map(|at| [0, 1, 2].map(|i| middle[i] + radius * at[i])).collect();
    // As on lines of sight: to the observer or from there.
    let along = minus(first.far, first.near);
    let sign: f64 = (0..3).map(|i| along[i] * first.direction[i]).sum();
    let direction = |point: &[f64; 3]| {
        let away = minus(*point, middle);
        away.map(|component| component * sign.signum() / length(away))
    };
    let directions: Vec<[f64; 3]> = points.iter().map(direction).collect();
    let rates = rates(scene, &points, &directions)?;
    let finite = points.iter().zip(rates).filter(|(_, rate)| rate.is_finite());
    let largest = finite.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()))?;
    let remark = (largest.1.abs() > RATIO * in_view).then(|| {
        let [x, y, z] = largest.0.map(|component| format!("{component:.3}"));
        let text = format!(
            "the emission rate is {:.0e} times as large at [{x}, {y}, {z}], which is not in view, as anywhere in view: \
             check `position`, `target`, `near`, `far` and `length_unit`",
            largest.1.abs() / in_view
        );
        Remark::new("view", text)
    });
    Some((remark, POINTS as u64))
}

/// Points in the unit ball: evenly spread directions (the spiral of Fibonacci), and distances with equal volumes
/// between them, in an order without a pattern.
fn offsets() -> impl Iterator<Item = [f64; 3]> {
    (0..POINTS).map(|k| {
        let share = (k as f64 + 0.5) / POINTS as f64;
        let height = 1.0 - 2.0 * share;
        let distance = (k as f64 * 2.0_f64.sqrt() + 0.5).fract().cbrt();
        let (sin, cos) = (TAU * GOLDEN * k as f64).sin_cos();
        let around = (1.0 - height * height).sqrt();
        [around * cos, around * sin, height].map(|component| distance * component)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means over the unit ball: 0 of a coordinate, 1/5 of its square, and half of the volume is beyond 0.5^(1/3).
    #[test]
    fn points_fill_the_ball_evenly() {
        let points: Vec<[f64; 3]> = offsets().collect();
        let mean =
            |of: &dyn Fn(&[f64; 3]) -> f64| points.iter().map(of).sum::<f64>() / POINTS as f64;
        for i in 0..3 {
            assert!(mean(&|p| p[i]).abs() < 0.02 && (mean(&|p| p[i] * p[i]) - 0.2).abs() < 0.02);
        }
        let outer = mean(&|p| f64::from(length(*p) > 0.5_f64.cbrt()));
        assert!((outer - 0.5).abs() < 0.02, "{outer}");
    }
}
