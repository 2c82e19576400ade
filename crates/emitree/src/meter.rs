//! The meter: the only place where g is called, and where its calls are counted.

use crate::emission::{Emission, Samples};
use crate::error::RenderError;
use crate::projection::Projection;
use crate::quadrature::{Integrand, Points};
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use core::time::Duration;
use rayon::prelude::*;
use std::time::Instant;

/// Sample points that one thread hands to g at a time, at the most: enough for a vectorised model to
/// forget the call, few enough that positions, directions and rates stay in its cache.
const MOST_SAMPLES_PER_CALL: usize = 2048;
/// And at the least, if a batch is so small that it is shared out among the threads.
const LEAST_SAMPLES_PER_CALL: usize = 64;

/// Hears how many evaluations have been made so far, and may end the rendering.
pub type Progress<'a> = dyn Fn(u64) -> ControlFlow<()> + Sync + 'a;

/// An emission seen through a projection, with the bill.
pub(crate) struct Meter<'a, E> {
    emission: &'a E,
    projection: &'a dyn Projection,
    progress: Option<&'a Progress<'a>>,
    limits: Limits,
    evaluations: AtomicU64,
    batches: AtomicU64,
    emission_nanoseconds: AtomicU64,
}

/// How often g may be called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limits {
    /// Evaluations altogether.
    pub(crate) max_evaluations: u64,
    /// Evaluations of one batch, 1 or more: a larger one is made in parts.
    pub(crate) batch_size: u64,
}

/// What is multiplied into g at a sample point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    /// ds/dz, so that an integral over depth is a radiance.
    Path,
    /// ds/dz · dΩ/(dx dy), so that an integral over the cube is an irradiance.
    PathAndSolidAngle,
}

/// The canonical integrand of the trees: g · ds/dz · dΩ/(dx dy) on the unit cube.
pub(crate) struct CanonicalIntegrand<'a, 'b, E>(pub(crate) &'b Meter<'a, E>);

impl<'a, E: Emission> Meter<'a, E> {
    pub(crate) fn new(
        emission: &'a E,
        projection: &'a dyn Projection,
        limits: Limits,
        progress: Option<&'a Progress<'a>>,
    ) -> Self {
        Self {
            emission,
            projection,
            progress,
            limits,
            evaluations: AtomicU64::new(0),
            batches: AtomicU64::new(0),
            emission_nanoseconds: AtomicU64::new(0),
        }
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

    pub(crate) fn evaluations_left(&self) -> u64 {
        self.limits.max_evaluations.saturating_sub(self.evaluations())
    }

    /// Evaluates weighted rates at canonical points: one batch, or several if it is too large.
    pub(crate) fn evaluate(
        &self,
        points: Points<'_, 3>,
        weight: Weight,
        values: &mut [f64],
    ) -> Result<(), RenderError<E::Error>> {
        let batch_size = usize::try_from(self.limits.batch_size).unwrap_or(usize::MAX).max(1);
        for (batch, values) in values.chunks_mut(batch_size).enumerate() {
            let first = batch * batch_size;
            let point = |i: usize| points.at(first + i);
            self.evaluate_batch(Points::new(values.len(), &point), weight, values)?;
        }
        Ok(())
    }

    fn evaluate_batch(
        &self,
        points: Points<'_, 3>,
        weight: Weight,
        values: &mut [f64],
    ) -> Result<(), RenderError<E::Error>> {
        self.batches.fetch_add(1, Ordering::Relaxed);
        let threads = rayon::current_num_threads();
        let per_call = values.len().div_ceil(threads);
        let per_call = per_call.clamp(LEAST_SAMPLES_PER_CALL, MOST_SAMPLES_PER_CALL);
        let calls = values.len().div_ceil(per_call);
        let in_calls = AtomicU64::new(0);
        // Calls behind one that failed are left out, those before it are made: so the first failure
        // in the order of the points is found, whatever the threads.
        let failed = AtomicUsize::new(usize::MAX);
        let call = |scratch: &mut Scratch, (chunk, values): (usize, &mut [f64])| {
            if chunk > failed.load(Ordering::Relaxed) {
                return Ok(());
            }
            let result = self.call(scratch, points, chunk * per_call, weight, values, &in_calls);
            if result.is_err() {
                failed.fetch_min(chunk, Ordering::Relaxed);
            }
            result
        };
        let results: Vec<Result<(), RenderError<E::Error>>> =
            values.par_chunks_mut(per_call).enumerate().map_init(Scratch::default, call).collect();
        // Parallel calls are not each other's waiting time.
        let spent = in_calls.into_inner() / calls.min(threads) as u64;
        self.emission_nanoseconds.fetch_add(spent, Ordering::Relaxed);
        results.into_iter().collect()
    }

    /// One call of g, from point `first` on.
    fn call(
        &self,
        scratch: &mut Scratch,
        points: Points<'_, 3>,
        first: usize,
        weight: Weight,
        rates: &mut [f64],
        in_calls: &AtomicU64,
    ) -> Result<(), RenderError<E::Error>> {
        scratch.clear();
        for i in first..first + rates.len() {
            let u = points.at(i);
            let mapped = self.projection.world_from_canonical(u);
            let density = match weight {
                Weight::Path => 1.0,
                Weight::PathAndSolidAngle => self.projection.solid_angle_density([u[0], u[1]]),
            };
            scratch.positions.push(mapped.position);
            scratch.directions.push(mapped.direction);
            scratch.weights.push(mapped.path_per_depth * density);
        }
        let samples = Samples::new(&scratch.positions, &scratch.directions);
        let start = Instant::now();
        let result = self.emission.emission_rates(&samples, rates);
        let spent = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        in_calls.fetch_add(spent, Ordering::Relaxed);
        let evaluations =
            self.evaluations.fetch_add(rates.len() as u64, Ordering::Relaxed) + rates.len() as u64;
        result.map_err(RenderError::Emission)?;
        for (i, (rate, weight)) in rates.iter_mut().zip(&scratch.weights).enumerate() {
            // A finite rate may be beyond all numbers once it is weighted.
            let weighted = *rate * weight;
            if !weighted.is_finite() {
                return Err(RenderError::NotFinite {
                    rate: *rate,
                    position: scratch.positions[i],
                    direction: scratch.directions[i],
                });
            }
            *rate = weighted;
        }
        match self.progress.map(|progress| progress(evaluations)) {
            Some(ControlFlow::Break(())) => Err(RenderError::Interrupted),
            _ => Ok(()),
        }
    }
}

impl<E: Emission> Integrand<3> for CanonicalIntegrand<'_, '_, E> {
    type Error = RenderError<E::Error>;

    fn evaluate(&self, points: Points<'_, 3>, values: &mut [f64]) -> Result<(), Self::Error> {
        self.0.evaluate(points, Weight::PathAndSolidAngle, values)
    }

    fn evaluations_left(&self) -> u64 {
        self.0.evaluations_left()
    }
}

/// Sample points of one call, kept from call to call.
#[derive(Default)]
struct Scratch {
    positions: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
    weights: Vec<f64>,
}

impl Scratch {
    fn clear(&mut self) {
        self.positions.clear();
        self.directions.clear();
        self.weights.clear();
    }
}
