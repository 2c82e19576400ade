//! A session: one rendering that can be held while it waits for rates.

use crate::calls::{Calls, Progress};
use crate::emission::Emission;
use crate::energy::EnergyAxis;
use crate::error::RenderError;
use crate::exchange::MethodError;
use crate::memory::evaluations_in_memory;
use crate::meter::{Deadline, Limits, Meter};
use crate::method::{self, Made};
use crate::projection::Projection;
use crate::render::{RenderOptions, check_options};
use crate::tally::EvaluationCounts;
use crate::tile::Tile;
use core::future::Future;
use core::pin::Pin;
use core::time::Duration;
use std::sync::Arc;
use std::time::Instant;

/// A method on its way, which waits for rates.
type Waiting<'a> = Pin<Box<dyn Future<Output = Result<Made, MethodError>> + Send + 'a>>;

/// One rendering.
pub(crate) struct Session<'a> {
    meter: Arc<Meter>,
    method: Waiting<'a>,
    start: Instant,
}

/// What a session has made, and what it has cost.
pub(crate) struct Ended {
    pub(crate) made: Made,
    pub(crate) cost: Cost,
}

/// What a rendering has cost.
pub(crate) struct Cost {
    pub(crate) evaluations: u64,
    pub(crate) evaluations_of_pixels: EvaluationCounts,
    pub(crate) batches: u64,
    pub(crate) emission_time: Duration,
    pub(crate) total_time: Duration,
}

impl<'a> Session<'a> {
    /// A rendering of `shape` = \[height, width\] pixels and, with an energy axis, its bins.
    pub(crate) fn new<E>(
        projection: &'a dyn Projection,
        shape: [usize; 2],
        axis: Option<&'a EnergyAxis>,
        options: &RenderOptions<'a>,
        whole_batches: bool,
    ) -> Result<Self, RenderError<E>> {
        check_options(shape, axis.map(EnergyAxis::bins), options)?;
        let tiles = Tile::of(projection, shape)?;
        let meter = Arc::new(Meter::new(shape, limits(options, whole_batches)));
        let method = run(Arc::clone(&meter), tiles, axis, *options);
        Ok(Self { meter, method, start: Instant::now() })
    }

    /// Evaluates the emission for the method until that has ended.
    pub(crate) fn run<E: Emission>(
        mut self,
        emission: &E,
        progress: Option<&Progress<'_>>,
    ) -> Result<Ended, RenderError<E::Error>> {
        let calls = Calls::new(emission, &self.meter, progress);
        let mut made = calls.drive(self.method.as_mut())?;
        made.ending = self.meter.reason_for(made.ending);
        let cost = Cost {
            evaluations: self.meter.evaluations(),
            evaluations_of_pixels: self.meter.evaluations_of_pixels(),
            batches: self.meter.batches(),
            emission_time: self.meter.emission_time(),
            total_time: self.start.elapsed(),
        };
        Ok(Ended { made, cost })
    }
}

/// The method of the options. It is compiled here, once, and not for each type of emission.
fn run<'a>(
    meter: Arc<Meter>,
    tiles: Vec<Tile<'a>>,
    axis: Option<&'a EnergyAxis>,
    options: RenderOptions<'a>,
) -> Waiting<'a> {
    Box::pin(async move { method::run(&meter, &tiles, axis, &options).await })
}

/// How often g may be called, and until when, counted from now.
fn limits(options: &RenderOptions<'_>, whole_batches: bool) -> Limits {
    let max_evaluations = options.max_evaluations.min(evaluations_in_memory(options));
    let deadline = Deadline::after_seconds(options.max_seconds);
    Limits { max_evaluations, batch_size: options.batch_size, whole_batches, deadline }
}
