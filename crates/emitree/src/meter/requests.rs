//! Requests of a method: sample points are collected in batches, and their rates weighted.

use super::{Meter, locked};
use crate::error::RenderError;
use crate::exchange::{Batch, MethodError};
use crate::known::KnownRates;
use crate::parallel::prelude::*;
use crate::quadrature::Points;
use crate::rendering::RateAt;
use crate::site::{Mapping, Site, SiteSource, Stretch};
use core::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

/// Sample points that one thread computes at a time: enough to make the cost of waking it negligible.
const POINTS_PER_TASK: usize = 2048;
/// Sample points of one request, at most, unless g takes whole batches: few enough that points and
/// rates stay in a cache of the processor.
const POINTS_AT_ONCE: usize = 1 << 16;
/// The number of rates from which the first ones are not stored any longer, 10 MiB, nor a list of them, 2 MiB: then an
/// image tree has begun, which hardly ever requests a point again.
const FIRST_RATES: usize = 1 << 16;

impl Meter {
    /// Evaluates weighted rates at canonical points: one batch, or several if it is too large.
    pub(crate) async fn evaluate(
        &self,
        points: Points<'_, 3>,
        mapping: Mapping<'_>,
        values: &mut [f64],
    ) -> Result<(), MethodError> {
        let site = |i: usize| {
            let u = points.at(i);
            let Mapping { map, tile, energy } = mapping;
            Site { xy: [u[0], u[1]], point: map(u), energy, tile }
        };
        self.evaluate_sites(&site, values).await
    }

    /// Evaluates the weighted rates of one site for each value: one batch, or several if it is too
    /// large.
    pub(crate) async fn evaluate_sites<S: SiteSource + ?Sized>(
        &self,
        sites: &S,
        values: &mut [f64],
    ) -> Result<(), MethodError> {
        let batch_size = usize::try_from(self.limits.batch_size).unwrap_or(usize::MAX).max(1);
        let at_once = if self.limits.whole_batches { batch_size } else { POINTS_AT_ONCE };
        let mut first = 0;
        for batch in values.chunks_mut(batch_size) {
            let before = self.new_evaluations();
            for values in batch.chunks_mut(at_once) {
                self.evaluate_part(sites, first, values).await?;
                first += values.len();
            }
            // A batch of which all is known costs nothing.
            let is_new = self.stored().is_none() || self.new_evaluations() > before;
            self.batches.fetch_add(u64::from(is_new), Ordering::Relaxed);
        }
        Ok(())
    }

    /// The sites from `first` on, at once. Where the weight is 0 g is not evaluated, but the request is made
    /// even if it is empty: the caller may end the rendering.
    async fn evaluate_part<S: SiteSource + ?Sized>(
        &self,
        sites: &S,
        first: usize,
        values: &mut [f64],
    ) -> Result<(), MethodError> {
        self.check_time()?;
        let mut batch = core::mem::take(&mut *locked(&self.used));
        let of_pixels = self.collect(sites, first, values, &mut batch);
        let (batch, counted) = self.rates(batch).await?;
        self.evaluations.fetch_add(batch.len() as u64, Ordering::Relaxed);
        let mut first = 0;
        for (pixel, number) in of_pixels {
            let number_counted = counted.as_ref().map_or(number, |counted| {
                counted[first..first + number].iter().filter(|counts| **counts).count()
            });
            self.of_pixels.count(pixel, number_counted);
            first += number;
        }
        self.record(&batch.rates);
        if let Some(k) = weigh(values, &batch.rates) {
            return Err(RenderError::NotFinite {
                rate: batch.rates[k],
                position: batch.positions[k],
                direction: batch.directions[k],
                energy: batch.energies.get(k).copied(),
            });
        }
        self.note_largest(&batch);
        self.note_first(&batch);
        *locked(&self.used) = batch;
        Ok(())
    }

    /// Stores rates for [`recorded`](Self::recorded).
    fn record(&self, rates: &[f64]) {
        let mut recorded = locked(&self.recorded);
        if self.freezes() {
            recorded.extend(rates);
        } else if !recorded.is_empty() {
            *recorded = Vec::new();
        }
    }

    /// Stores the first of the largest |rates| of a batch if it is above all before.
    fn note_largest(&self, batch: &Batch) {
        let mut largest = locked(&self.largest_rate);
        let mut most = largest.map_or(0.0, |of: RateAt| of.rate.abs());
        for (rate, position) in batch.rates.iter().zip(&batch.positions) {
            if rate.abs() > most {
                most = rate.abs();
                *largest = Some(RateAt { rate: *rate, position: *position });
            }
        }
    }

    /// Appends to [`first_requested`](Self::first_requested).
    fn note_first(&self, batch: &Batch) {
        let mut first = locked(&self.first_requested);
        let Some(points) = &mut *first else { return };
        if points.len() + batch.len() > FIRST_RATES {
            *first = None;
        } else {
            let rates = batch.rates.iter().zip(&batch.positions);
            points.extend(rates.map(|(&rate, &position)| RateAt { rate, position }));
        }
    }

    /// The rates at all points of a batch; those that are not stored are requested. Returns which points count for
    /// pixels, if not all: in a session also those whose rates are stored.
    async fn rates(&self, mut batch: Batch) -> Result<(Batch, Option<Vec<bool>>), MethodError> {
        let Some(stored) = self.stored() else {
            return Ok((self.exchange.ask(batch).await?, None));
        };
        let are_new = locked(&stored).are_new(&batch);
        let unknown = KnownRates::points_that(&are_new, &batch);
        // A session answers with other points, too, and with none of those that it was told before.
        if unknown.len() > 0 {
            let answered = self.exchange.ask(unknown).await?;
            locked(&stored).insert(&answered);
        }
        locked(&stored).fill(&mut batch);
        if locked(&stored).len() > FIRST_RATES {
            *locked(&self.first) = None;
        }
        Ok((batch, self.known.is_none().then_some(are_new)))
    }

    /// Where rates are stored: all of them, or the first ones as long as there are not too many.
    fn stored(&self) -> Option<Arc<Mutex<KnownRates>>> {
        self.known.clone().or_else(|| locked(&self.first).clone())
    }

    /// Collects the sample points of a part of a batch whose weight is not 0, and writes all weights to
    /// `weights`. Returns how many there are in pixels, one after the other.
    fn collect<S: SiteSource + ?Sized>(
        &self,
        sites: &S,
        first: usize,
        weights: &mut [f64],
        batch: &mut Batch,
    ) -> Vec<([usize; 2], usize)> {
        let number = weights.len();
        batch.make_room(number);
        let arrays = weights
            .par_chunks_mut(POINTS_PER_TASK)
            .zip(batch.positions.par_chunks_mut(POINTS_PER_TASK))
            .zip(batch.directions.par_chunks_mut(POINTS_PER_TASK));
        let part = |(number, ((weights, positions), directions))| {
            let first = first + number * POINTS_PER_TASK;
            self.collect_part(sites, first, weights, [positions, directions])
        };
        let parts: Vec<Collected> = arrays.enumerate().map(part).collect();
        // Parts without omitted points are in place already.
        let (mut seen, mut of_pixels) = (0, Vec::new());
        for (number, part) in parts.into_iter().enumerate() {
            let of_part = part.seen;
            let from = number * POINTS_PER_TASK;
            if from > seen {
                batch.positions.copy_within(from..from + of_part, seen);
                batch.directions.copy_within(from..from + of_part, seen);
            }
            batch.energies.extend(part.energies);
            of_pixels.extend(part.of_pixels);
            seen += of_part;
        }
        batch.truncate(seen);
        of_pixels
    }

    /// The points of one task whose weight is not 0.
    fn collect_part<S: SiteSource + ?Sized>(
        &self,
        sites: &S,
        first: usize,
        weights: &mut [f64],
        [positions, directions]: [&mut [[f64; 3]]; 2],
    ) -> Collected {
        let (mut energies, mut of_pixels) = (Vec::new(), Vec::new());
        let mut of_pixel =
            OfPixel { line: [f64::NAN; 2], tile: (0, 1), pixel: [0; 2], evaluations: 0 };
        let (mut weights, mut count) = (weights.iter_mut(), 0);
        sites.visit(first..first + weights.len(), |stretch| {
            let before = count;
            for (point, weight) in stretch.points.iter().zip(&mut weights) {
                *weight = point.path_per_depth;
                positions[count] = point.position;
                directions[count] = point.direction;
                count += usize::from(point.path_per_depth != 0.0);
            }
            if let Some(energy) = stretch.energy {
                energies.resize(count, energy);
            }
            if !of_pixel.has(stretch) {
                let pixel = self.of_pixels.pixel(stretch.xy, stretch.tile);
                if pixel != of_pixel.pixel {
                    of_pixels.push((of_pixel.pixel, of_pixel.evaluations));
                    of_pixel.evaluations = 0;
                }
                of_pixel = OfPixel { line: stretch.xy, tile: stretch.tile, pixel, ..of_pixel };
            }
            of_pixel.evaluations += count - before;
        });
        of_pixels.push((of_pixel.pixel, of_pixel.evaluations));
        Collected { seen: count, energies, of_pixels }
    }
}

/// What one task has collected.
struct Collected {
    /// Points whose weight is not 0.
    seen: usize,
    /// Their energies, if there is an axis.
    energies: Vec<f64>,
    /// How many of them are in pixels, one after the other.
    of_pixels: Vec<([usize; 2], usize)>,
}

/// Multiplies the weights that are not 0 with the rates; returns the index of the first rate that is
/// not finite, before or after weighting.
fn weigh(weights: &mut [f64], rates: &[f64]) -> Option<usize> {
    if rates.len() == weights.len() {
        // No weight is 0: none is tested.
        weights.iter_mut().zip(rates).for_each(|(weight, rate)| *weight *= rate);
        return weights.iter().position(|weighted| !weighted.is_finite());
    }
    let lit = weights.iter_mut().filter(|weight| **weight != 0.0);
    for (k, (weight, rate)) in lit.zip(rates).enumerate() {
        *weight *= rate;
        if !weight.is_finite() {
            return Some(k);
        }
    }
    None
}

/// Evaluations that follow each other on lines of sight of one pixel, counted at once.
struct OfPixel {
    /// The last of the lines…
    line: [f64; 2],
    /// …and its tile.
    tile: (usize, usize),
    pixel: [usize; 2],
    evaluations: usize,
}

impl OfPixel {
    /// Whether a stretch is on the last of the lines.
    #[expect(clippy::float_cmp, reason = "another line has other numbers")]
    fn has(&self, stretch: &Stretch<'_>) -> bool {
        self.line == stretch.xy && self.tile == stretch.tile
    }
}
