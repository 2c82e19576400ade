//! The meter: the only place where g is called, and where its calls are counted.

use crate::emission::{Emission, Samples};
use crate::error::RenderError;
use crate::projection::Projection;
use crate::quadrature::{Integrand, Points};
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use core::time::Duration;
use rayon::prelude::*;
use std::sync::Mutex;
use std::time::Instant;

/// Sample points that one thread hands to g at a time: enough for a vectorised model to forget the
/// call, few enough that positions, directions and rates stay in its cache.
const SAMPLES_PER_CALL: usize = 2048;

/// Hears how many evaluations have been made so far, and may end the rendering.
pub type Progress<'a> = dyn Fn(u64) -> ControlFlow<()> + Sync + 'a;

/// An emission seen through a projection, with the bill.
pub(crate) struct Meter<'a, E> {
    emission: &'a E,
    projection: &'a dyn Projection,
    progress: Option<&'a Progress<'a>>,
    max_evaluations: u64,
    evaluations: AtomicU64,
    batches: AtomicU64,
    emission_time: Mutex<Duration>,
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
        max_evaluations: u64,
        progress: Option<&'a Progress<'a>>,
    ) -> Self {
        Self {
            emission,
            projection,
            progress,
            max_evaluations,
            evaluations: AtomicU64::new(0),
            batches: AtomicU64::new(0),
            emission_time: Mutex::new(Duration::ZERO),
        }
    }

    pub(crate) fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    pub(crate) fn batches(&self) -> u64 {
        self.batches.load(Ordering::Relaxed)
    }

    /// Time spent in g, the times of parallel calls added up and divided by the number of threads.
    pub(crate) fn emission_time(&self) -> Duration {
        let sum = self.emission_time.lock().map_or(Duration::ZERO, |time| *time);
        sum / u32::try_from(rayon::current_num_threads()).unwrap_or(1).max(1)
    }

    pub(crate) fn evaluations_left(&self) -> u64 {
        self.max_evaluations.saturating_sub(self.evaluations())
    }

    /// Evaluates one batch: weighted rates at canonical points.
    pub(crate) fn evaluate(
        &self,
        points: Points<'_, 3>,
        weight: Weight,
        values: &mut [f64],
    ) -> Result<(), RenderError<E::Error>> {
        if points.is_empty() {
            return Ok(());
        }
        self.batches.fetch_add(1, Ordering::Relaxed);
        let stopped = AtomicBool::new(false);
        let call = |scratch: &mut Scratch, (chunk, values): (usize, &mut [f64])| {
            if stopped.load(Ordering::Relaxed) {
                return Err(RenderError::Interrupted);
            }
            let result = self.call(scratch, points, chunk * SAMPLES_PER_CALL, weight, values);
            if result.is_err() {
                stopped.store(true, Ordering::Relaxed);
            }
            result
        };
        let results: Vec<Result<(), RenderError<E::Error>>> = values
            .par_chunks_mut(SAMPLES_PER_CALL)
            .enumerate()
            .map_init(Scratch::default, call)
            .collect();
        // The model's own complaint comes before the word of the calls that it stopped.
        let mut failures = results.into_iter().filter_map(Result::err);
        let Some(first) = failures.next() else {
            return Ok(());
        };
        let interrupted = matches!(first, RenderError::Interrupted);
        let told = if interrupted {
            failures.find(|error| !matches!(error, RenderError::Interrupted))
        } else {
            None
        };
        Err(told.unwrap_or(first))
    }

    /// One call of g, from point `first` on.
    fn call(
        &self,
        scratch: &mut Scratch,
        points: Points<'_, 3>,
        first: usize,
        weight: Weight,
        rates: &mut [f64],
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
        let spent = start.elapsed();
        if let Ok(mut time) = self.emission_time.lock() {
            *time += spent;
        }
        let evaluations =
            self.evaluations.fetch_add(rates.len() as u64, Ordering::Relaxed) + rates.len() as u64;
        result.map_err(RenderError::Emission)?;
        if let Some(bad) = rates.iter().position(|rate| !rate.is_finite()) {
            return Err(RenderError::NotFinite {
                rate: rates[bad],
                position: scratch.positions[bad],
                direction: scratch.directions[bad],
            });
        }
        for (rate, weight) in rates.iter_mut().zip(&scratch.weights) {
            *rate *= weight;
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
