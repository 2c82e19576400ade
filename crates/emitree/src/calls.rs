//! The calls of g: batches are shared out among threads, timed, and ended with the time allowed.

use crate::emission::Samples;
use crate::erased::{AnyEmission, AnyError};
use crate::error::RenderError;
use crate::exchange::{Batch, EmissionFailed, MethodError, drive};
use crate::meter::Meter;
use crate::parallel::prelude::*;
use crate::progress::Progress;
use core::future::Future;
use core::ops::ControlFlow;
use core::pin::Pin;
use core::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

/// Sample points of one call of g, at most: enough to make the overhead of a call negligible for a
/// vectorised model, few enough that positions, directions and rates stay in a cache.
const MOST_SAMPLES_PER_CALL: usize = 2048;
/// And at least, if a batch is so small that it is divided among the threads.
const LEAST_SAMPLES_PER_CALL: usize = 16;

/// The share of the time allowed that one call of g may be expected to take.
const SHARE_OF_TIME_PER_CALL: f64 = 0.05;

/// A batch that is expected to take less than this is not divided.
const WORTH_A_THREAD_NANOSECONDS: f64 = 3e4;

/// An emission that is evaluated for a method.
pub(crate) struct Calls<'a> {
    emission: &'a AnyEmission<'a>,
    meter: &'a Meter,
    progress: Option<&'a Progress<'a>>,
}

impl<'a> Calls<'a> {
    /// Calls of `emission`, counted by `meter`; `progress` is called after each.
    pub(crate) fn new(
        emission: &'a AnyEmission<'a>,
        meter: &'a Meter,
        progress: Option<&'a Progress<'a>>,
    ) -> Self {
        Self { emission, meter, progress }
    }

    pub(crate) fn emission(&self) -> &'a AnyEmission<'a> {
        self.emission
    }

    pub(crate) fn meter(&self) -> &'a Meter {
        self.meter
    }

    pub(crate) fn progress(&self) -> Option<&'a Progress<'a>> {
        self.progress
    }

    /// Runs a method with the rates of the emission.
    pub(crate) fn drive<T>(
        &self,
        method: Pin<&mut (dyn Future<Output = Result<T, MethodError>> + '_)>,
    ) -> Result<T, RenderError<AnyError>> {
        let mut failure = None;
        let result = drive(self.meter.exchange(), method, |batch| {
            self.evaluate(batch).map_err(|error| {
                error.with_emission_error(|error| {
                    failure = Some(error);
                    Some(EmissionFailed)
                })
            })
        });
        result.map_err(|error| error.with_emission_error(|EmissionFailed| failure.take()))
    }

    /// The rates of one batch.
    pub(crate) fn evaluate(&self, batch: &mut Batch) -> Result<(), RenderError<AnyError>> {
        self.evaluate_function(batch, Function::Rate)
    }

    /// The absorption coefficients at the points of one batch, in place of rates.
    pub(crate) fn absorption_coefficients(
        &self,
        batch: &mut Batch,
    ) -> Result<(), RenderError<AnyError>> {
        self.evaluate_function(batch, Function::AbsorptionCoefficient)
    }

    fn evaluate_function(
        &self,
        batch: &mut Batch,
        function: Function,
    ) -> Result<(), RenderError<AnyError>> {
        let Batch { positions, directions, energies, rates } = batch;
        if rates.is_empty() {
            self.meter.check_time()?;
            return self.tell_progress(self.meter.new_evaluations());
        }
        let threads = crate::parallel::current_num_threads();
        let per_call = rates.len().div_ceil(threads);
        let per_call = match self.emission.takes_whole_batches() {
            true => rates.len().max(1),
            false => per_call
                .clamp(LEAST_SAMPLES_PER_CALL, MOST_SAMPLES_PER_CALL)
                .min(self.samples_before_deadline(threads)),
        };
        let calls = rates.len().div_ceil(per_call);
        let in_calls = AtomicU64::new(0);
        // Calls behind one that failed are left out, those before it are made: so the first failure
        // in the order of the points is found, whatever the threads.
        let failed = AtomicUsize::new(usize::MAX);
        let call = |(number, rates): (usize, &mut [f64])| {
            if number > failed.load(Ordering::Relaxed) {
                return Ok(());
            }
            let points = number * per_call..number * per_call + rates.len();
            let samples = Samples::new(&positions[points.clone()], &directions[points.clone()]);
            let samples = samples.at_energies(energies.get(points).unwrap_or_default());
            let result = self.call(function, &samples, rates, &in_calls);
            if result.is_err() {
                failed.fetch_min(number, Ordering::Relaxed);
            }
            result
        };
        let at_once = if self.is_short(rates.len()) { calls } else { 1 };
        let all_calls = rates.par_chunks_mut(per_call).enumerate().with_min_len(at_once);
        let results: Vec<Result<(), RenderError<AnyError>>> = all_calls.map(call).collect();
        // Parallel calls are not each other's waiting time.
        let waited = in_calls.into_inner() / calls.min(threads).max(1) as u64;
        match function {
            Function::Rate => self.meter.count_time(rates.len(), waited),
            Function::AbsorptionCoefficient => self.meter.count_time(0, waited),
        }
        results.into_iter().collect()
    }

    /// The samples of one call that are expected to take a small share of the time allowed, since a call
    /// that has begun is waited for; few as long as the time of an evaluation is unknown.
    fn samples_before_deadline(&self, threads: usize) -> usize {
        let Some(deadline) = self.meter.deadline() else { return usize::MAX };
        let evaluations = self.meter.timed_evaluations() as f64;
        let nanoseconds = self.meter.emission_time().as_nanos() as f64;
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
        let so_far = self.meter.timed_evaluations() as f64;
        let nanoseconds = self.meter.emission_time().as_nanos() as f64;
        so_far > 0.0 && nanoseconds / so_far * (evaluations as f64) < WORTH_A_THREAD_NANOSECONDS
    }

    /// One call of g, or of the absorption coefficient.
    fn call(
        &self,
        function: Function,
        samples: &Samples<'_>,
        rates: &mut [f64],
        in_calls: &AtomicU64,
    ) -> Result<(), RenderError<AnyError>> {
        self.meter.check_time()?;
        let start = Instant::now();
        let result = match function {
            Function::Rate => self.emission.emission_rates(samples, rates),
            Function::AbsorptionCoefficient => {
                self.emission.absorption_coefficients(samples, rates)
            }
        };
        let spent = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        in_calls.fetch_add(spent, Ordering::Relaxed);
        let evaluations = match function {
            Function::Rate => self.meter.count(samples.len()),
            Function::AbsorptionCoefficient => {
                self.meter.count_absorption(samples.len());
                self.meter.new_evaluations()
            }
        };
        result.map_err(RenderError::Emission)?;
        match function {
            Function::Rate => check_finite(samples, rates)?,
            Function::AbsorptionCoefficient => check_coefficients(samples, rates)?,
        }
        self.tell_progress(evaluations)
    }

    /// Reports the number of evaluations to the callback, which may end the rendering.
    fn tell_progress(&self, evaluations: u64) -> Result<(), RenderError<AnyError>> {
        match self.progress.map(|progress| progress(evaluations)) {
            Some(ControlFlow::Break(())) => Err(RenderError::Interrupted),
            _ => Ok(()),
        }
    }
}

/// What is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Function {
    Rate,
    AbsorptionCoefficient,
}

/// Refuses absorption coefficients that are not finite.
fn check_coefficients(samples: &Samples<'_>, found: &[f64]) -> Result<(), RenderError<AnyError>> {
    match found.iter().position(|coefficient| !coefficient.is_finite()) {
        None => Ok(()),
        Some(k) => Err(RenderError::AbsorptionNotFinite {
            coefficient: found[k],
            position: samples.positions()[k],
            direction: samples.directions()[k],
            energy: samples.energies().get(k).copied(),
        }),
    }
}

/// Refuses rates that are not finite.
pub(crate) fn check_finite<E>(samples: &Samples<'_>, rates: &[f64]) -> Result<(), RenderError<E>> {
    match rates.iter().position(|rate| !rate.is_finite()) {
        None => Ok(()),
        Some(k) => Err(RenderError::NotFinite {
            rate: rates[k],
            position: samples.positions()[k],
            direction: samples.directions()[k],
            energy: samples.energies().get(k).copied(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emission::Emission;
    use crate::los::{LosOptions, Steps};
    use crate::options::RenderOptions;
    use crate::projection::Canonical;
    use crate::render::render;
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
        let options = RenderOptions { batch_size: 10_000, ..RenderOptions::new(los) };
        let rendering = render(&&calls, &Canonical, [16, 16], &options).unwrap();
        assert_eq!((rendering.stats.evaluations, rendering.stats.batches), (16_384, 2));
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
