//! Uniform steps along each line: the midpoint rule.

use super::Lines;
use crate::error::RenderError;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::Meter;
use crate::parallel::prelude::*;
use crate::projection::{MappedPoint, Projection};
use crate::site::{SiteSource, Stretch};
use crate::tile::Tile;
use core::ops::Range;

/// Sample points of one batch: large enough to keep every thread busy, small beside an image.
const SAMPLES_PER_BATCH: usize = 1 << 20;
/// Lines that one thread adds up at a time, at the least.
const LINES_AT_ONCE: usize = 1024;

/// Points that are computed at a time: enough to make the cost of the virtual call of a projection
/// negligible, few enough to stay in the cache.
const POINTS_AT_ONCE: usize = 32;

/// A line's canonical (x, y), from its number.
pub(crate) type PlaceOfLine<'a> = dyn Fn(usize) -> [f64; 2] + Sync + 'a;

/// The sample points at some depths on some lines, line after line.
struct StepsOfLines<'a> {
    place: &'a PlaceOfLine<'a>,
    projection: &'a dyn Projection,
    first_line: usize,
    depths: &'a [f64],
    tile: (usize, usize),
    energy: Option<f64>,
}

impl SiteSource for StepsOfLines<'_> {
    fn visit(&self, numbers: Range<usize>, mut take: impl FnMut(&Stretch<'_>)) {
        let mut points = [MappedPoint::default(); POINTS_AT_ONCE];
        let steps = self.depths.len();
        let Range { start, end } = numbers;
        let mut number = start;
        while number < end {
            // The line is found once for all of its steps: it takes longer than a cheap g.
            let (line, step) = (number / steps, number % steps);
            let xy = (self.place)(self.first_line + line);
            let count = (steps - step).min(end - number).min(POINTS_AT_ONCE);
            let points = &mut points[..count];
            self.projection.points_of_line(xy, &self.depths[step..][..count], points);
            take(&Stretch { xy, points, energy: self.energy, tile: self.tile });
            number += count;
        }
    }
}

/// Evaluates G at the middles of `steps` uniform steps along each of some lines, and has `add` take the values of a
/// line, with the number of the first of them, for what is `found` of that line.
pub(crate) async fn march<T: Send>(
    meter: &Meter,
    &Tile { projection, place: tile, .. }: &Tile<'_>,
    place: &PlaceOfLine<'_>,
    steps: usize,
    energy: Option<f64>,
    found: &mut [T],
    add: impl Fn(&mut T, usize, &[f64]) + Sync,
) -> Result<(), MethodError> {
    let depths: Vec<f64> = (0..steps).map(|step| (step as f64 + 0.5) / steps as f64).collect();
    let steps_at_once = steps.min(SAMPLES_PER_BATCH);
    let lines_at_once = SAMPLES_PER_BATCH / steps_at_once;
    let mut rates = vec![0.0; lines_at_once.min(found.len()) * steps_at_once];
    for (block, found) in found.chunks_mut(lines_at_once).enumerate() {
        let first_line = block * lines_at_once;
        for first_step in (0..steps).step_by(steps_at_once) {
            let count = steps_at_once.min(steps - first_step);
            let rates = &mut rates[..found.len() * count];
            let depths = &depths[first_step..][..count];
            let sites = StepsOfLines { place, projection, first_line, depths, tile, energy };
            meter.evaluate_sites(&sites, rates).await?;
            let of_lines = found.par_iter_mut().zip(rates.par_chunks_exact(count));
            of_lines
                .with_min_len(LINES_AT_ONCE)
                .for_each(|(found, rates)| add(found, first_step, rates));
        }
    }
    Ok(())
}

/// The image by `steps` uniform steps along each of `per_side`² lines for each pixel.
pub(super) async fn render(
    meter: &Meter,
    tile @ &Tile { projection, shape: [height, width], .. }: &Tile<'_>,
    per_side: usize,
    steps: usize,
    energy: Option<f64>,
) -> Result<Image, MethodError> {
    let lines = Lines { height, width, per_side };
    let needed = (lines.count() as u64).saturating_mul(steps as u64);
    let allowed = meter.evaluations_left();
    if needed > allowed {
        meter.check_time()?;
        let what = format!("{} lines of {steps} steps", lines.count());
        return Err(RenderError::Budget { what, needed, allowed });
    }
    let mut radiances = vec![0.0; lines.count()];
    let place = |line| lines.position(line);
    let add = |radiance: &mut f64, _, rates: &[f64]| {
        *radiance += rates.iter().sum::<f64>() / steps as f64;
    };
    march(meter, tile, &place, steps, energy, &mut radiances, add).await?;
    Ok(lines.image(projection, &radiances))
}
