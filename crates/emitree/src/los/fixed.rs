//! Equal steps along each line: the midpoint rule.

use super::Lines;
use crate::emission::Emission;
use crate::error::RenderError;
use crate::image::Image;
use crate::meter::{Meter, Site, SiteSource};
use crate::projection::Projection;
use crate::render::Tile;
use core::ops::Range;

/// Sample points of one batch: large enough to keep every thread busy, small beside an image.
const SAMPLES_PER_BATCH: usize = 1 << 20;

/// The sample points of some steps on some lines, line after line.
struct StepsOfLines<'a> {
    lines: Lines,
    projection: &'a dyn Projection,
    first_line: usize,
    first_step: usize,
    /// Steps on each line, from the first on, of all steps that make a line.
    count: usize,
    steps: usize,
    tile: (usize, usize),
    energy: Option<f64>,
}

impl SiteSource for StepsOfLines<'_> {
    fn visit(&self, numbers: Range<usize>, mut take: impl FnMut(Site)) {
        let mut line = self.first_line + numbers.start / self.count;
        let mut step = numbers.start % self.count;
        let mut xy = self.lines.position(line);
        for _ in numbers {
            // The line is found once for all of its steps: it takes longer than a cheap g.
            if step == self.count {
                (line, step) = (line + 1, 0);
                xy = self.lines.position(line);
            }
            let depth = ((self.first_step + step) as f64 + 0.5) / self.steps as f64;
            let point = self.projection.world_from_canonical([xy[0], xy[1], depth]);
            take(Site { xy, point, energy: self.energy, tile: self.tile });
            step += 1;
        }
    }
}

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
    let mut radiances = vec![0.0; lines.count()];
    let steps_at_once = steps.min(SAMPLES_PER_BATCH);
    let lines_at_once = SAMPLES_PER_BATCH / steps_at_once;
    let mut rates = vec![0.0; lines_at_once.min(lines.count()) * steps_at_once];
    for (block, radiances) in radiances.chunks_mut(lines_at_once).enumerate() {
        let first_line = block * lines_at_once;
        for first_step in (0..steps).step_by(steps_at_once) {
            let count = steps_at_once.min(steps - first_step);
            let rates = &mut rates[..radiances.len() * count];
            let sites = StepsOfLines {
                lines,
                projection,
                first_line,
                first_step,
                count,
                steps,
                tile,
                energy,
            };
            meter.evaluate_sites(&sites, rates)?;
            for (radiance, rates) in radiances.iter_mut().zip(rates.chunks_exact(count)) {
                *radiance += rates.iter().sum::<f64>() / steps as f64;
            }
        }
    }
    Ok(lines.image(projection, &radiances))
}
