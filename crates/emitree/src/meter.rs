//! The meter: it passes on the methods' requests for rates, and counts evaluations.

use crate::cube::Cube;
use crate::energy::EnergyAxis;
use crate::error::RenderError;
use crate::exchange::{Batch, Exchange, MethodError};
use crate::known::KnownRates;
use crate::mesh::start::Start;
use crate::parallel::prelude::*;
use crate::projection::{MappedPoint, Projection};
use crate::quadrature::{AsyncIntegrand, Points};
use crate::rendering::RateAt;
use crate::site::{Mapping, Site, SiteSource, Stretch};
use crate::tally::{EvaluationCounts, Tally};
use crate::tree::StopReason;
use core::sync::atomic::{AtomicU64, Ordering};
use core::time::Duration;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Sample points that one thread computes at a time: enough to make the cost of waking it negligible.
const POINTS_PER_TASK: usize = 2048;
/// Sample points of one request, at most, unless g takes whole batches: few enough that points and
/// rates stay in a cache of the processor.
const POINTS_AT_ONCE: usize = 1 << 16;

/// What a method has requested so far, and its limits.
pub(crate) struct Meter {
    limits: Limits,
    exchange: Exchange,
    evaluations: AtomicU64,
    batches: AtomicU64,
    timed_evaluations: AtomicU64,
    emission_nanoseconds: AtomicU64,
    of_pixels: Tally,
    /// The arrays of the last batch, for the next one.
    used: Mutex<Batch>,
    /// The largest |rate| so far.
    largest_rate: Mutex<Option<RateAt>>,
    /// Evaluations that were not known before.
    new_evaluations: AtomicU64,
    /// Evaluations of the absorption coefficient.
    absorption_evaluations: AtomicU64,
    /// Evaluations that were made elsewhere for this rendering.
    given_evaluations: AtomicU64,
    known: Option<Arc<Mutex<KnownRates>>>,
    /// Intermediate images, if they are stored.
    shown: Option<Mutex<Vec<Shown>>>,
    /// The most evaluations after which the method makes a frozen quadrature at its end.
    freezes_up_to: u64,
    /// All rates so far in the order of the requests, as long as a frozen quadrature is made.
    recorded: Mutex<Vec<f64>>,
    /// What the method begins with.
    start: Option<Start>,
    /// Whether the method leaves the function that its image has the means of.
    wants_model: bool,
    /// The number of evaluations up to which g may be called although the time has ended.
    overtime: AtomicU64,
}

/// An intermediate image.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    /// The values and their errors.
    pub(crate) maps: [Cube; 2],
    /// Evaluations and batches so far.
    pub(crate) evaluations: u64,
    pub(crate) batches: u64,
}

/// How often g may be called, and until when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Evaluations altogether.
    pub(crate) max_evaluations: u64,
    /// Evaluations of one batch, 1 or more: a larger one is made in parts.
    pub(crate) batch_size: u64,
    /// Whether a batch is evaluated at once, however large it is.
    pub(crate) whole_batches: bool,
    /// When no call of g may begin any more, if there is a limit.
    pub(crate) deadline: Option<Deadline>,
}

/// The end of the time that a rendering may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deadline {
    at: Instant,
    /// The time that was allowed \[s\].
    pub(crate) seconds: f64,
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
pub(crate) struct CanonicalIntegrand<'a> {
    pub(crate) meter: &'a Meter,
    pub(crate) projection: &'a dyn Projection,
    pub(crate) tile: (usize, usize),
}

/// The canonical integrand with an energy axis, g · ds/dz · dΩ/(dx dy) · dE/du: an integral over the
/// cube of four dimensions is an irradiance in the whole band.
pub(crate) struct SpectralIntegrand<'a> {
    pub(crate) canonical: CanonicalIntegrand<'a>,
    pub(crate) axis: &'a EnergyAxis,
}

impl Meter {
    /// No requests yet; evaluations are counted for the pixels of an image of `shape`. Rates in `known` are
    /// not requested again, and new ones are added to it; intermediate images are stored or not.
    pub(crate) fn new(
        shape: [usize; 2],
        limits: Limits,
        known: Option<Arc<Mutex<KnownRates>>>,
        keeps_images: bool,
    ) -> Self {
        Self {
            limits,
            exchange: Exchange::default(),
            evaluations: AtomicU64::new(0),
            batches: AtomicU64::new(0),
            timed_evaluations: AtomicU64::new(0),
            emission_nanoseconds: AtomicU64::new(0),
            of_pixels: Tally::new(shape),
            used: Mutex::default(),
            largest_rate: Mutex::default(),
            new_evaluations: AtomicU64::new(0),
            absorption_evaluations: AtomicU64::new(0),
            given_evaluations: AtomicU64::new(0),
            known,
            shown: keeps_images.then(Mutex::default),
            freezes_up_to: 0,
            recorded: Mutex::default(),
            start: None,
            wants_model: false,
            overtime: AtomicU64::new(0),
        }
    }

    /// The same for a method that makes a frozen quadrature at its end, after so many evaluations at most.
    pub(crate) fn with_frozen_quadrature(mut self, up_to_evaluations: u64) -> Self {
        self.freezes_up_to = up_to_evaluations;
        self
    }

    /// The same for a method that begins with the structure of a mesh.
    pub(crate) fn with_start(mut self, start: Option<Start>) -> Self {
        self.start = start;
        self
    }

    /// The same for a method that leaves the function that its image has the means of, if there is one.
    pub(crate) fn with_model(mut self) -> Self {
        self.wants_model = true;
        self
    }

    /// Whether the method leaves that function.
    pub(crate) fn wants_model(&self) -> bool {
        self.wants_model
    }

    /// Whether the method would make a frozen quadrature if it ended now.
    pub(crate) fn freezes(&self) -> bool {
        self.freezes_up_to > 0 && self.evaluations() <= self.freezes_up_to
    }

    /// The structure that the method begins with.
    pub(crate) fn start(&self) -> Option<&Start> {
        self.start.as_ref()
    }

    /// How often g may be called, and until when.
    pub(crate) fn limits(&self) -> Limits {
        self.limits
    }

    /// Whether rates are stored.
    pub(crate) fn keeps_rates(&self) -> bool {
        self.known.is_some()
    }

    /// Whether intermediate images are stored.
    pub(crate) fn keeps_images(&self) -> bool {
        self.shown.is_some()
    }

    /// Stores an intermediate image and its error.
    pub(crate) fn show(&self, maps: [Cube; 2]) {
        if let Some(shown) = &self.shown {
            let (evaluations, batches) = (self.evaluations(), self.batches());
            let mut shown = locked(shown);
            if self.known.is_some() {
                // There is no callback for each image: only the latest one can be read.
                shown.clear();
            }
            shown.push(Shown { maps, evaluations, batches });
        }
    }

    /// Takes the stored images, the first one first.
    pub(crate) fn take_shown(&self) -> Vec<Shown> {
        self.shown.as_ref().map_or_else(Vec::new, |shown| core::mem::take(&mut *locked(shown)))
    }

    /// Evaluations that were not known before.
    pub(crate) fn new_evaluations(&self) -> u64 {
        self.new_evaluations.load(Ordering::Relaxed)
    }

    /// Evaluations that were made for this rendering, here or elsewhere, whether it has requested them or not.
    pub(crate) fn made_evaluations(&self) -> u64 {
        self.new_evaluations() + self.given_evaluations.load(Ordering::Relaxed)
    }

    /// Counts evaluations that were made elsewhere.
    pub(crate) fn count_given(&self, evaluations: usize) {
        self.given_evaluations.fetch_add(evaluations as u64, Ordering::Relaxed);
    }

    /// Where batches are requested.
    pub(crate) fn exchange(&self) -> &Exchange {
        &self.exchange
    }

    /// Counts evaluations that have been made; how many there are now. The method counts those that were
    /// known as well, as if it had made them.
    pub(crate) fn count(&self, evaluations: usize) -> u64 {
        let evaluations = evaluations as u64;
        self.new_evaluations.fetch_add(evaluations, Ordering::Relaxed) + evaluations
    }

    /// Counts evaluations of the absorption coefficient that have been made.
    pub(crate) fn count_absorption(&self, evaluations: usize) {
        self.absorption_evaluations.fetch_add(evaluations as u64, Ordering::Relaxed);
    }

    /// How often the absorption coefficient was evaluated.
    pub(crate) fn absorption_evaluations(&self) -> u64 {
        self.absorption_evaluations.load(Ordering::Relaxed)
    }

    /// Counts time spent waiting for g, which has made so many evaluations.
    pub(crate) fn count_time(&self, evaluations: usize, nanoseconds: u64) {
        self.timed_evaluations.fetch_add(evaluations as u64, Ordering::Relaxed);
        self.emission_nanoseconds.fetch_add(nanoseconds, Ordering::Relaxed);
    }

    /// Evaluations whose time is known.
    pub(crate) fn timed_evaluations(&self) -> u64 {
        self.timed_evaluations.load(Ordering::Relaxed)
    }

    /// How many evaluations were made on the lines of sight of each pixel; those on a border count
    /// for the pixel above or to the right of it.
    pub(crate) fn evaluations_per_pixel(&self) -> EvaluationCounts {
        self.of_pixels.counts()
    }

    /// Counts the evaluations on lines of each pixel from 0 again: those of another image follow.
    pub(crate) fn restart_evaluations_per_pixel(&self) {
        self.of_pixels.restart();
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

    /// Evaluations that may still be made: none once the time has ended, or those of the overtime.
    pub(crate) fn evaluations_left(&self) -> u64 {
        // Points that were evaluated ahead count as well.
        let made = self.evaluations().max(self.made_evaluations());
        let left = self.limits.max_evaluations.saturating_sub(made);
        if self.time_is_up() { left.min(self.overtime_left()) } else { left }
    }

    /// Allows so many more evaluations although the time has ended.
    pub(crate) fn allow_overtime(&self, evaluations: u64) {
        self.overtime.store(self.evaluations().saturating_add(evaluations), Ordering::Relaxed);
    }

    fn overtime_left(&self) -> u64 {
        self.overtime.load(Ordering::Relaxed).saturating_sub(self.evaluations())
    }

    pub(crate) fn time_is_up(&self) -> bool {
        self.limits.deadline.is_some_and(|deadline| deadline.has_passed())
    }

    /// An error once the time has ended, and the overtime with it.
    pub(crate) fn check_time<E>(&self) -> Result<(), RenderError<E>> {
        match self.limits.deadline {
            Some(deadline) if deadline.has_passed() && self.overtime_left() == 0 => {
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

    /// Which limit ended a rendering that was ended by one.
    pub(crate) fn reason_for(&self, ending: StopReason) -> StopReason {
        match ending {
            StopReason::Budget if self.time_is_up() => StopReason::Time,
            ending => ending,
        }
    }

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
            let is_new = self.known.is_none() || self.new_evaluations() > before;
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
        batch = self.rates(batch).await?;
        self.evaluations.fetch_add(batch.len() as u64, Ordering::Relaxed);
        of_pixels.into_iter().for_each(|(pixel, number)| self.of_pixels.count(pixel, number));
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

    /// All rates in the order of the requests, if a frozen quadrature is made: the method is repeated with them.
    pub(crate) fn recorded(&self) -> Vec<f64> {
        core::mem::take(&mut *locked(&self.recorded))
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

    /// The largest |rate| so far.
    pub(crate) fn largest_rate(&self) -> Option<RateAt> {
        *locked(&self.largest_rate)
    }

    /// The rates at all points of a batch; those that are not stored are requested.
    async fn rates(&self, mut batch: Batch) -> Result<Batch, MethodError> {
        let Some(known) = &self.known else { return self.exchange.ask(batch).await };
        let unknown = locked(known).unknown(&batch);
        if unknown.len() > 0 {
            let answered = self.exchange.ask(unknown).await?;
            locked(known).insert(&answered);
        }
        locked(known).fill(&mut batch);
        Ok(batch)
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

/// Locks a mutex, also after a thread has panicked with it.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
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

impl CanonicalIntegrand<'_> {
    /// The world point at `u`, with the weight ds/dz · dΩ/(dx dy) of g in place of ds/dz.
    fn weighted(&self, u: [f64; 3]) -> MappedPoint {
        let mapped = self.projection.world_from_canonical(u);
        let density = self.projection.solid_angle_density([u[0], u[1]]);
        MappedPoint { path_per_depth: mapped.path_per_depth * density, ..mapped }
    }

    /// One sample point.
    pub(crate) fn site(&self, u: [f64; 3]) -> Site {
        Site { xy: [u[0], u[1]], tile: self.tile, point: self.weighted(u), energy: None }
    }
}

impl SpectralIntegrand<'_> {
    /// One sample point.
    pub(crate) fn site(&self, [x, y, z, u]: [f64; 4]) -> Site {
        let mut site = self.canonical.site([x, y, z]);
        site.point.path_per_depth *= self.axis.energy_per_canonical(u);
        Site { energy: Some(self.axis.energy(u)), ..site }
    }
}

impl AsyncIntegrand<3> for CanonicalIntegrand<'_> {
    type Error = MethodError;

    async fn evaluate(&self, points: Points<'_, 3>, values: &mut [f64]) -> Result<(), Self::Error> {
        let weighted = |u: [f64; 3]| self.weighted(u);
        let mapping = Mapping { map: &weighted, tile: self.tile, energy: None };
        self.meter.evaluate(points, mapping, values).await
    }

    fn evaluations_left(&self) -> u64 {
        self.meter.evaluations_left()
    }

    fn is_out_of_time(error: &Self::Error) -> bool {
        matches!(error, RenderError::Time { .. })
    }
}

impl AsyncIntegrand<4> for SpectralIntegrand<'_> {
    type Error = MethodError;

    async fn evaluate(&self, points: Points<'_, 4>, values: &mut [f64]) -> Result<(), Self::Error> {
        let site = |i: usize| self.site(points.at(i));
        self.canonical.meter.evaluate_sites(&site, values).await
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
