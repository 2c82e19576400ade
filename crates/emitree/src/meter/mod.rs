//! The meter: it passes on the methods' requests for rates, and counts evaluations.
//!
//! * `limits`: how often g may be called, and until when;
//! * `requests`: batches of sample points, and their weighted rates;
//! * `integrand`: the integrands of trees.

mod integrand;
mod limits;
mod requests;

pub(crate) use integrand::{CanonicalIntegrand, SpectralIntegrand};
pub(crate) use limits::{Deadline, Limits};

use crate::cube::Cube;
use crate::error::RenderError;
use crate::exchange::{Batch, Exchange};
use crate::known::KnownRates;
use crate::mesh::start::Start;
use crate::rendering::RateAt;
use crate::tally::{EvaluationCounts, Tally};
use crate::tree::StopReason;
use core::sync::atomic::{AtomicU64, Ordering};
use core::time::Duration;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

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
    /// The first rates of this rendering in the order of the requests; `None` once there are too many.
    first_requested: Mutex<Option<Vec<RateAt>>>,
    /// Evaluations that were not known before.
    new_evaluations: AtomicU64,
    /// Evaluations of the absorption coefficient.
    absorption_evaluations: AtomicU64,
    /// Evaluations that were made elsewhere for this rendering.
    given_evaluations: AtomicU64,
    /// Evaluations of which no rate is kept.
    unkept_evaluations: AtomicU64,
    known: Option<Arc<Mutex<KnownRates>>>,
    /// The first rates of a method that is not continued later, and does not store all of them.
    first: Mutex<Option<Arc<Mutex<KnownRates>>>>,
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
    /// The image that is to be made of products row by row, if one is.
    rows_wanted: Option<RowsWanted>,
    /// The number of evaluations up to which g may be called although the time has ended.
    overtime: AtomicU64,
}

/// An image that is to be made row by row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowsWanted {
    /// Its height and width.
    pub(crate) shape: [usize; 2],
    /// Those of the largest image of the same proportions that fits in the memory as a whole.
    pub(crate) fits: [usize; 2],
}

impl RowsWanted {
    /// The error of a view whose image can't be made so.
    pub(crate) fn refused<E>(self, reason: impl Into<String>) -> RenderError<E> {
        RenderError::NotByRows { reason: reason.into(), shape: self.shape, fits: self.fits }
    }
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

/// What a meter had kept before evaluations of which it keeps none.
#[derive(Debug)]
pub(crate) struct BeforeUnkept {
    evaluations: u64,
    first: Option<Arc<Mutex<KnownRates>>>,
    first_requested: Option<Vec<RateAt>>,
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
            first_requested: Mutex::new(Some(Vec::new())),
            new_evaluations: AtomicU64::new(0),
            absorption_evaluations: AtomicU64::new(0),
            given_evaluations: AtomicU64::new(0),
            unkept_evaluations: AtomicU64::new(0),
            known,
            first: Mutex::default(),
            shown: keeps_images.then(Mutex::default),
            freezes_up_to: 0,
            recorded: Mutex::default(),
            start: None,
            wants_model: false,
            rows_wanted: None,
            overtime: AtomicU64::new(0),
        }
    }

    /// The same for a method that makes a frozen quadrature at its end, after so many evaluations at most.
    pub(crate) fn with_frozen_quadrature(mut self, up_to_evaluations: u64) -> Self {
        self.freezes_up_to = up_to_evaluations;
        self
    }

    /// The same for a method that requests some of its first points again: searches with other charts and fibers through
    /// points of others do.
    pub(crate) fn with_first_rates(mut self) -> Self {
        self.first = Mutex::new(Some(Arc::default()));
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

    /// The same for a method that leaves its products alone, for an image that is made row by row.
    pub(crate) fn with_rows(mut self, wanted: Option<RowsWanted>) -> Self {
        self.rows_wanted = wanted;
        self
    }

    /// The image that is to be made of products row by row, if one is.
    pub(crate) fn rows_wanted(&self) -> Option<RowsWanted> {
        self.rows_wanted
    }

    /// Whether the method leaves that function.
    pub(crate) fn wants_model(&self) -> bool {
        self.wants_model
    }

    /// Whether the method would make a frozen quadrature if it ended now.
    pub(crate) fn freezes(&self) -> bool {
        self.freezes_up_to > 0 && self.reported_evaluations() <= self.freezes_up_to
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
            let (evaluations, batches) = (self.reported_evaluations(), self.batches());
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

    /// The evaluations of a rendering, and of a session as if nothing had been known.
    fn reported_evaluations(&self) -> u64 {
        if self.known.is_some() { self.evaluations() } else { self.new_evaluations() }
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
        let kept = made.saturating_sub(self.unkept_evaluations.load(Ordering::Relaxed));
        let kept_left = self.limits.max_kept.saturating_sub(kept);
        self.unkept_evaluations_left().min(kept_left)
    }

    /// The same if no rate of them is kept.
    pub(crate) fn unkept_evaluations_left(&self) -> u64 {
        let made = self.evaluations().max(self.made_evaluations());
        let left = self.limits.max_evaluations.saturating_sub(made);
        if self.time_is_up() { left.min(self.overtime_left()) } else { left }
    }

    /// Evaluations without those of which no rate is kept.
    pub(crate) fn kept_evaluations(&self) -> u64 {
        self.evaluations().saturating_sub(self.unkept_evaluations.load(Ordering::Relaxed))
    }

    /// All rates of this rendering in the order of the requests, also those that a session knew before; none once there
    /// are too many.
    pub(crate) fn first_requested(&self) -> Vec<RateAt> {
        locked(&self.first_requested).clone().unwrap_or_default()
    }

    /// No rate is kept from here on, until [`keeps_again`](Self::keeps_again).
    pub(crate) fn keeps_none(&self) -> BeforeUnkept {
        BeforeUnkept {
            evaluations: self.evaluations(),
            first: locked(&self.first).take(),
            first_requested: locked(&self.first_requested).take(),
        }
    }

    /// Rates are kept again as before.
    pub(crate) fn keeps_again(&self, before: BeforeUnkept) {
        let unkept = self.evaluations().saturating_sub(before.evaluations);
        self.unkept_evaluations.fetch_add(unkept, Ordering::Relaxed);
        *locked(&self.first) = before.first;
        *locked(&self.first_requested) = before.first_requested;
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

    /// The time that is left \[s\]; infinite without a limit.
    pub(crate) fn seconds_left(&self) -> f64 {
        self.limits
            .deadline
            .map_or(f64::INFINITY, |deadline| deadline.share_left() * deadline.seconds)
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

    /// All rates in the order of the requests, if a frozen quadrature is made: the method is repeated with them.
    pub(crate) fn recorded(&self) -> Vec<f64> {
        core::mem::take(&mut *locked(&self.recorded))
    }

    /// The largest |rate| so far.
    pub(crate) fn largest_rate(&self) -> Option<RateAt> {
        *locked(&self.largest_rate)
    }
}

/// Locks a mutex, also after a thread has panicked with it.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
