//! The meter: the only place where g is called, and where its calls are counted.

use crate::emission::{Emission, Samples};
use crate::energy::EnergyAxis;
use crate::error::RenderError;
use crate::projection::{MappedPoint, Projection};
use crate::quadrature::{Integrand, Points};
use crate::site::{Mapping, Site, SiteSource, Stretch};
use crate::tally::{EvaluationCounts, Tally};
use crate::tree::Ending;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use core::time::Duration;
use rayon::prelude::*;
use std::time::Instant;

/// Sample points that one thread hands to g at a time, at the most: enough for a vectorised model to
/// forget the call, few enough that positions, directions and rates stay in its cache.
const MOST_SAMPLES_PER_CALL: usize = 2048;
/// And at the least, if a batch is so small that it is shared out among the threads.
const LEAST_SAMPLES_PER_CALL: usize = 16;

/// The share of the time allowed that one call of g may be expected to take.
const SHARE_OF_TIME_PER_CALL: f64 = 0.05;

/// A batch that is expected to take less than this is not shared out.
const WORTH_A_THREAD_NANOSECONDS: f64 = 3e4;

/// Hears how many evaluations have been made so far, and may end the rendering.
pub type Progress<'a> = dyn Fn(u64) -> ControlFlow<()> + Sync + 'a;

/// The emission, with the bill.
pub(crate) struct Meter<'a, E> {
    emission: &'a E,
    progress: Option<&'a Progress<'a>>,
    limits: Limits,
    evaluations: AtomicU64,
    batches: AtomicU64,
    emission_nanoseconds: AtomicU64,
    of_pixels: Tally,
}

/// How often g may be called, and until when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Evaluations altogether.
    pub(crate) max_evaluations: u64,
    /// Evaluations of one batch, 1 or more: a larger one is made in parts.
    pub(crate) batch_size: u64,
    /// When no call of g may begin any more, if there is a limit.
    pub(crate) deadline: Option<Deadline>,
}

/// The end of the time that a rendering may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deadline {
    at: Instant,
    /// The time that was allowed \[s\].
    seconds: f64,
}

impl Deadline {
    /// So many seconds from now; none if that is beyond all clocks.
    pub(crate) fn after_seconds(seconds: f64) -> Option<Self> {
        let at = Instant::now().checked_add(Duration::try_from_secs_f64(seconds).ok()?)?;
        Some(Self { at, seconds })
    }

    fn has_passed(&self) -> bool {
        Instant::now() >= self.at
    }

    /// The share of the time that is left, 0 to 1.
    fn share_left(&self) -> f64 {
        let left = self.at.saturating_duration_since(Instant::now());
        left.as_secs_f64() / self.seconds
    }
}

/// The canonical integrand of the trees, g · ds/dz · dΩ/(dx dy) on the unit cube: an integral over
/// the cube is an irradiance.
pub(crate) struct CanonicalIntegrand<'a, 'b, E> {
    pub(crate) meter: &'b Meter<'a, E>,
    pub(crate) projection: &'b dyn Projection,
    pub(crate) tile: (usize, usize),
}

/// The canonical integrand with an energy axis, g · ds/dz · dΩ/(dx dy) · dE/du: an integral over the
/// cube of four dimensions is an irradiance in the whole band.
pub(crate) struct SpectralIntegrand<'a, 'b, E> {
    pub(crate) canonical: CanonicalIntegrand<'a, 'b, E>,
    pub(crate) axis: &'b EnergyAxis,
}

impl<'a, E: Emission> Meter<'a, E> {
    pub(crate) fn new(
        emission: &'a E,
        shape: [usize; 2],
        limits: Limits,
        progress: Option<&'a Progress<'a>>,
    ) -> Self {
        Self {
            emission,
            progress,
            limits,
            evaluations: AtomicU64::new(0),
            batches: AtomicU64::new(0),
            emission_nanoseconds: AtomicU64::new(0),
            of_pixels: Tally::new(shape),
        }
    }

    /// How many evaluations were made on the lines of sight of each pixel; those on a border count
    /// for the pixel above or to the right of it.
    pub(crate) fn into_evaluations_of_pixels(self) -> EvaluationCounts {
        self.of_pixels.into_counts()
    }

    pub(crate) fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    pub(crate) fn batches(&self) -> u64 {
        self.batches.load(Ordering::Relaxed)
    }

    /// Time spent waiting for g.
    pub(crate) fn emission_time(&self) -> Duration {
        Duration::from_nanos(self.emission_nanoseconds.load(Ordering::Relaxed))
    }

    /// Evaluations that may still be made: none once the time has ended.
    pub(crate) fn evaluations_left(&self) -> u64 {
        if self.time_is_up() {
            return 0;
        }
        self.limits.max_evaluations.saturating_sub(self.evaluations())
    }

    pub(crate) fn time_is_up(&self) -> bool {
        self.limits.deadline.is_some_and(|deadline| deadline.has_passed())
    }

    /// Refuses to go on once the time has ended.
    pub(crate) fn check_time(&self) -> Result<(), RenderError<E::Error>> {
        match self.limits.deadline {
            Some(deadline) if deadline.has_passed() => {
                Err(RenderError::Time { seconds: deadline.seconds })
            }
            _ => Ok(()),
        }
    }

    /// The share of the time allowed that is left, 0 to 1; 1 without a limit.
    pub(crate) fn share_of_time_left(&self) -> f64 {
        self.limits.deadline.map_or(1.0, |deadline| deadline.share_left())
    }

    /// The same limit on the time, for work of the rendering that makes no evaluations of g.
    pub(crate) fn deadline(&self) -> Option<Deadline> {
        self.limits.deadline
    }

    /// What ended a rendering that says that it was a limit.
    pub(crate) fn reason_for(&self, ending: Ending) -> Ending {
        match ending {
            Ending::Budget if self.time_is_up() => Ending::Time,
            ending => ending,
        }
    }

    /// Evaluates weighted rates at canonical points: one batch, or several if it is too large.
    pub(crate) fn evaluate(
        &self,
        points: Points<'_, 3>,
        mapping: Mapping<'_>,
        values: &mut [f64],
    ) -> Result<(), RenderError<E::Error>> {
        let site = |i: usize| {
            let u = points.at(i);
            let Mapping { map, tile, energy } = mapping;
            Site { xy: [u[0], u[1]], point: map(u), energy, tile }
        };
        self.evaluate_sites(&site, values)
    }

    /// Evaluates the weighted rates of one site for each value: one batch, or several if it is too
    /// large.
    pub(crate) fn evaluate_sites<S: SiteSource + ?Sized>(
        &self,
        sites: &S,
        values: &mut [f64],
    ) -> Result<(), RenderError<E::Error>> {
        let batch_size = usize::try_from(self.limits.batch_size).unwrap_or(usize::MAX).max(1);
        for (batch, values) in values.chunks_mut(batch_size).enumerate() {
            self.evaluate_batch(sites, batch * batch_size, values)?;
        }
        Ok(())
    }

    /// One batch, from site `first` on.
    fn evaluate_batch<S: SiteSource + ?Sized>(
        &self,
        sites: &S,
        first: usize,
        values: &mut [f64],
    ) -> Result<(), RenderError<E::Error>> {
        self.batches.fetch_add(1, Ordering::Relaxed);
        let threads = rayon::current_num_threads();
        let per_call = values.len().div_ceil(threads);
        let per_call = match self.emission.takes_whole_batches() {
            true => values.len().max(1),
            false => per_call
                .clamp(LEAST_SAMPLES_PER_CALL, MOST_SAMPLES_PER_CALL)
                .min(self.samples_before_deadline(threads)),
        };
        let calls = values.len().div_ceil(per_call);
        let in_calls = AtomicU64::new(0);
        // Calls behind one that failed are left out, those before it are made: so the first failure
        // in the order of the points is found, whatever the threads.
        let failed = AtomicUsize::new(usize::MAX);
        let call = |scratch: &mut Scratch, (chunk, values): (usize, &mut [f64])| {
            if chunk > failed.load(Ordering::Relaxed) {
                return Ok(());
            }
            let result = self.call(scratch, sites, first + chunk * per_call, values, &in_calls);
            if result.is_err() {
                failed.fetch_min(chunk, Ordering::Relaxed);
            }
            result
        };
        let at_once = if self.is_short(values.len()) { calls } else { 1 };
        let all_calls = values.par_chunks_mut(per_call).enumerate().with_min_len(at_once);
        let results: Vec<Result<(), RenderError<E::Error>>> =
            all_calls.map_init(Scratch::default, call).collect();
        // Parallel calls are not each other's waiting time.
        let spent = in_calls.into_inner() / calls.min(threads) as u64;
        self.emission_nanoseconds.fetch_add(spent, Ordering::Relaxed);
        results.into_iter().collect()
    }

    /// The samples of one call that are expected to take a small share of the time allowed, since a call
    /// that has begun is waited for; few as long as nothing is known of g.
    fn samples_before_deadline(&self, threads: usize) -> usize {
        let Some(deadline) = self.limits.deadline else { return usize::MAX };
        let evaluations = self.evaluations() as f64;
        let nanoseconds = self.emission_nanoseconds.load(Ordering::Relaxed) as f64;
        if nanoseconds == 0.0 {
            return LEAST_SAMPLES_PER_CALL;
        }
        let of_one = threads as f64 * nanoseconds / evaluations;
        let samples = SHARE_OF_TIME_PER_CALL * 1e9 * deadline.seconds / of_one;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let samples = samples as usize;
        samples.max(LEAST_SAMPLES_PER_CALL)
    }

    /// Whether so many evaluations take less time than it does to wake another thread, as far as is
    /// known.
    fn is_short(&self, evaluations: usize) -> bool {
        let so_far = self.evaluations() as f64;
        let nanoseconds = self.emission_nanoseconds.load(Ordering::Relaxed) as f64;
        so_far > 0.0 && nanoseconds / so_far * (evaluations as f64) < WORTH_A_THREAD_NANOSECONDS
    }

    /// One call of g, from site `first` on; where nothing can be seen g is not called.
    fn call<S: SiteSource + ?Sized>(
        &self,
        scratch: &mut Scratch,
        sites: &S,
        first: usize,
        values: &mut [f64],
        in_calls: &AtomicU64,
    ) -> Result<(), RenderError<E::Error>> {
        self.check_time()?;
        let count = self.collect(scratch, sites, first, values);
        let Scratch { positions, directions, energies, rates } = scratch;
        let (positions, directions) = (&positions[..count], &directions[..count]);
        let (samples, rates) = (Samples::new(positions, directions), &mut rates[..count]);
        let samples = samples.at_energies(energies);
        let start = Instant::now();
        let result = match count {
            0 => Ok(()),
            _ => self.emission.emission_rates(&samples, rates),
        };
        let spent = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        in_calls.fetch_add(spent, Ordering::Relaxed);
        let evaluations =
            self.evaluations.fetch_add(count as u64, Ordering::Relaxed) + count as u64;
        result.map_err(RenderError::Emission)?;
        if let Some(k) = weigh(values, rates) {
            return Err(RenderError::NotFinite {
                rate: rates[k],
                position: positions[k],
                direction: directions[k],
                energy: energies.get(k).copied(),
            });
        }
        match self.progress.map(|progress| progress(evaluations)) {
            Some(ControlFlow::Break(())) => Err(RenderError::Interrupted),
            _ => Ok(()),
        }
    }

    /// Collects the sample points of a call, counts them for their pixels, and leaves their weights in
    /// `weights`: 0 where nothing can be seen. Returns how many points are left.
    fn collect<S: SiteSource + ?Sized>(
        &self,
        scratch: &mut Scratch,
        sites: &S,
        first: usize,
        weights: &mut [f64],
    ) -> usize {
        scratch.make_room(weights.len());
        let Scratch { positions, directions, energies, .. } = scratch;
        // As slices, whose ends stay in registers.
        let (positions, directions) = (positions.as_mut_slice(), directions.as_mut_slice());
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
                    self.of_pixels.count(of_pixel.pixel, of_pixel.evaluations);
                    of_pixel.evaluations = 0;
                }
                of_pixel = OfPixel { line: stretch.xy, tile: stretch.tile, pixel, ..of_pixel };
            }
            of_pixel.evaluations += count - before;
        });
        self.of_pixels.count(of_pixel.pixel, of_pixel.evaluations);
        count
    }
}

/// Multiplies the weights that are not 0 with the rates; the number of the first rate that is beyond
/// all numbers once it is weighted, or was so before.
fn weigh(weights: &mut [f64], rates: &[f64]) -> Option<usize> {
    if rates.len() == weights.len() {
        // All can be seen: no weight is asked whether it is 0.
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

impl<E> CanonicalIntegrand<'_, '_, E> {
    /// The world point at `u`, with the weight ds/dz · dΩ/(dx dy) of g in place of ds/dz.
    fn weighted(&self, u: [f64; 3]) -> MappedPoint {
        let mapped = self.projection.world_from_canonical(u);
        let density = self.projection.solid_angle_density([u[0], u[1]]);
        MappedPoint { path_per_depth: mapped.path_per_depth * density, ..mapped }
    }
}

impl<E: Emission> Integrand<3> for CanonicalIntegrand<'_, '_, E> {
    type Error = RenderError<E::Error>;

    fn evaluate(&self, points: Points<'_, 3>, values: &mut [f64]) -> Result<(), Self::Error> {
        let weighted = |u: [f64; 3]| self.weighted(u);
        let mapping = Mapping { map: &weighted, tile: self.tile, energy: None };
        self.meter.evaluate(points, mapping, values)
    }

    fn evaluations_left(&self) -> u64 {
        self.meter.evaluations_left()
    }

    fn is_out_of_time(error: &Self::Error) -> bool {
        matches!(error, RenderError::Time { .. })
    }
}

impl<E: Emission> Integrand<4> for SpectralIntegrand<'_, '_, E> {
    type Error = RenderError<E::Error>;

    fn evaluate(&self, points: Points<'_, 4>, values: &mut [f64]) -> Result<(), Self::Error> {
        let site = |i: usize| {
            let [x, y, z, u] = points.at(i);
            let mut point = self.canonical.weighted([x, y, z]);
            point.path_per_depth *= self.axis.energy_per_canonical(u);
            let (tile, energy) = (self.canonical.tile, Some(self.axis.energy(u)));
            Site { xy: [x, y], tile, point, energy }
        };
        self.canonical.meter.evaluate_sites(&site, values)
    }

    fn evaluations_left(&self) -> u64 {
        self.canonical.meter.evaluations_left()
    }

    fn is_out_of_time(error: &Self::Error) -> bool {
        matches!(error, RenderError::Time { .. })
    }
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

/// Sample points of one call, kept from call to call.
#[derive(Default)]
struct Scratch {
    positions: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
    energies: Vec<f64>,
    rates: Vec<f64>,
}

impl Scratch {
    /// Room for so many points; energies are none.
    fn make_room(&mut self, points: usize) {
        if self.rates.len() < points {
            self.positions.resize(points, [0.0; 3]);
            self.directions.resize(points, [0.0; 3]);
            self.rates.resize(points, 0.0);
        }
        self.energies.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::Canonical;
    use crate::render::{Method, RenderOptions, render};
    use crate::{LosOptions, Steps};
    use core::convert::Infallible;
    use std::sync::Mutex;

    /// 1 everywhere; keeps the sizes of its calls.
    struct Calls {
        whole: bool,
        sizes: Mutex<Vec<usize>>,
    }

    impl Emission for Calls {
        type Error = Infallible;

        fn emission_rates(
            &self,
            samples: &Samples<'_>,
            rates: &mut [f64],
        ) -> Result<(), Infallible> {
            self.sizes
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner)
                .push(samples.len());
            rates.fill(1.0);
            Ok(())
        }

        fn takes_whole_batches(&self) -> bool {
            self.whole
        }
    }

    /// The sizes of all calls for 16 × 16 pixels, 64 steps each, in batches of 10 000 at the most.
    fn sizes(whole: bool) -> Vec<usize> {
        let calls = Calls { whole, sizes: Mutex::default() };
        let los = LosOptions { lines: 1, steps: Steps::Fixed(64) };
        let options = RenderOptions { batch_size: 10_000, ..RenderOptions::new(Method::Los(los)) };
        let rendering = render(&&calls, &Canonical, [16, 16], &options).unwrap();
        assert_eq!((rendering.evaluations, rendering.batches), (16_384, 2));
        calls.sizes.into_inner().unwrap()
    }

    #[test]
    fn a_batch_comes_in_one_call_or_in_many() {
        assert_eq!(sizes(true), [10_000, 6_384]);
        let shared = sizes(false);
        assert_eq!(shared.iter().sum::<usize>(), 16_384);
        assert!(shared.iter().all(|&size| size <= MOST_SAMPLES_PER_CALL));
    }
}
