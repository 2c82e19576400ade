//! Equal steps along each line: the midpoint rule.

use super::Lines;
use crate::emission::Emission;
use crate::error::RenderError;
use crate::image::Image;
use crate::meter::{Mapping, Meter};
use crate::quadrature::Points;
use crate::render::Tile;

/// Sample points of one batch: large enough to keep every thread busy, small beside an image.
const SAMPLES_PER_BATCH: usize = 1 << 20;

/// The image by `steps` equal steps along each of `per_side`² lines for each pixel.
pub(crate) fn render<E: Emission>(
    meter: &Meter<'_, E>,
    &Tile { projection, shape: [height, width], place: tile }: &Tile<'_>,
    per_side: usize,
    steps: usize,
    energy: Option<f64>,
) -> Result<Image, RenderError<E::Error>> {
    let lines = Lines { height, width, per_side };
    let needed = (lines.count() as u64).saturating_mul(steps as u64);
    let allowed = meter.evaluations_left();
    if needed > allowed {
        let what = format!("{} lines of {steps} steps", lines.count());
        return Err(RenderError::Budget { what, needed, allowed });
    }
    let map = |u| projection.world_from_canonical(u);
    let mapping = Mapping { map: &map, tile, energy };
    let mut radiances = vec![0.0; lines.count()];
    let steps_at_once = steps.min(SAMPLES_PER_BATCH);
    let lines_at_once = SAMPLES_PER_BATCH / steps_at_once;
    let mut rates = vec![0.0; lines_at_once.min(lines.count()) * steps_at_once];
    for (block, radiances) in radiances.chunks_mut(lines_at_once).enumerate() {
        let first_line = block * lines_at_once;
        for first_step in (0..steps).step_by(steps_at_once) {
            let count = steps_at_once.min(steps - first_step);
            let rates = &mut rates[..radiances.len() * count];
            let point = |i: usize| {
                let [x, y] = lines.position(first_line + i / count);
                [x, y, ((first_step + i % count) as f64 + 0.5) / steps as f64]
            };
            meter.evaluate(Points::new(rates.len(), &point), mapping, rates)?;
            for (radiance, rates) in radiances.iter_mut().zip(rates.chunks_exact(count)) {
                *radiance += rates.iter().sum::<f64>() / steps as f64;
            }
        }
    }
    Ok(lines.image(projection, &radiances))
}
