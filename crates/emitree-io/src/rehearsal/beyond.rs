//! Emission behind the far ends of lines of sight.

use super::Remark;
use crate::scene::{EmissionFailure, Scene};
use emitree::{Cube, Emission, RenderError, Rendering, Samples};

/// Lines of sight along each side of the image, and points on each behind its end.
const LINES: usize = 8;
const POINTS: usize = 8;
/// Samples that the search takes.
const SAMPLES: u64 = (LINES * LINES * POINTS) as u64;

/// The remark that lines of sight of twice the length would have seen more, and the evaluations that it took; none if
/// lines of sight end at bounds or bodies, or the budget does not suffice.
pub(super) fn remark(
    scene: &Scene,
    rendering: &Rendering<Cube>,
    most: u64,
) -> Result<Option<(Option<Remark>, u64)>, RenderError<EmissionFailure>> {
    let largest = rendering.values.voxels().filter(|pixel| pixel.is_finite());
    let largest = largest.fold(0.0, |largest: f64, pixel| largest.max(pixel.abs()));
    let has_far = scene.camera.description().keys.iter().any(|key| key.name == "far");
    if most < SAMPLES || largest == 0.0 || scene.camera.has_shapes() || !has_far {
        return Ok(None);
    }
    let lines = lines_beyond(scene);
    let mut points = Vec::with_capacity(POINTS * lines.len());
    for line in &lines {
        points.extend((0..POINTS).map(|k| {
            let along = (k as f64 + 0.5) / POINTS as f64;
            [0, 1, 2].map(|i| line.from[i] + along * (line.to[i] - line.from[i]))
        }));
    }
    let repeated = |line: &Line| std::iter::repeat_n(line.direction, POINTS);
    let directions: Vec<[f64; 3]> = lines.iter().flat_map(repeated).collect();
    let energies: Vec<f64> =
        scene.axis().iter().flat_map(|axis| vec![axis.energy(0.5); points.len()]).collect();
    let samples = Samples::new(&points, &directions).at_energies(&energies);
    let mut rates = vec![0.0; points.len()];
    if scene.emission.emission_rates(&samples, &mut rates).is_err() {
        // Data and models may end there.
        return Ok(None);
    }
    let light =
        |(line, rates): (&Line, &[f64])| line.length * rates.iter().sum::<f64>() / POINTS as f64;
    let most = lines.iter().zip(rates.chunks_exact(POINTS)).map(light);
    let share = most.fold(0.0, |most: f64, light| most.max(light.abs())) / largest;
    let allowed = scene.render.tolerance.unwrap_or(0.01);
    let remark = (share.is_finite() && share > allowed).then(|| {
        let text = format!(
            "the emission goes on behind `far`: lines of sight of twice the length would have up to {share:.2} of \
             the largest pixel more"
        );
        Remark::new("far", text)
    });
    Ok(Some((remark, points.len() as u64)))
}

/// What continues a line of sight behind its end.
struct Line {
    from: [f64; 3],
    to: [f64; 3],
    direction: [f64; 3],
    length: f64,
}

fn lines_beyond(scene: &Scene) -> Vec<Line> {
    let camera = scene.camera.projection();
    let middle = |k: usize| (k as f64 + 0.5) / LINES as f64;
    let places = (0..LINES).flat_map(|j| (0..LINES).map(move |i| [middle(i), middle(j)]));
    let line = |[x, y]: [f64; 2]| {
        let [near, far] = [0.0, 1.0].map(|z| camera.world_from_canonical([x, y, z]));
        let along = [0, 1, 2].map(|i| far.position[i] - near.position[i]);
        let length = along.iter().map(|d| d * d).sum::<f64>().sqrt();
        let is_line = far.path_per_depth > 0.0 && length.is_finite() && length > 0.0;
        is_line.then(|| Line {
            from: far.position,
            to: [0, 1, 2].map(|i| far.position[i] + along[i]),
            direction: far.direction,
            length,
        })
    };
    places.filter_map(line).collect()
}
