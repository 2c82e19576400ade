//! The course of a rendering: its method runs from one request for rates to the next.

use crate::error::RenderError;
use crate::exchange::{Batch, MethodError};
use crate::mesh::start::Start;
use crate::meter::{Limits, Meter, Shown};
use crate::method::Running;
use crate::options::Method;
use crate::output::MethodOutput;
use crate::polling::advance;
use core::task::Poll;
use core::time::Duration;
use std::sync::Arc;
use std::time::Instant;

/// What starts a method in the view of a session.
pub(super) type Begin<'a> =
    dyn Fn(Arc<Meter>, [usize; 2], Method) -> Running<'a> + Send + Sync + 'a;

/// The current rendering of a session.
pub(super) struct Course<'a> {
    pub(super) shape: [usize; 2],
    pub(super) limits: Limits,
    pub(super) options: Method,
    pub(super) begins_with: Option<Start>,
    pub(super) meter: Arc<Meter>,
    pub(super) method: Running<'a>,
    pub(super) state: State,
    /// The points of the batch that the method itself waits for: they are its first.
    pub(super) needed: usize,
    /// Intermediate images: those that have not been passed on yet, or the latest one.
    pub(super) shown: Vec<Shown>,
    pub(super) started: Instant,
    /// How long it took, once it has ended.
    pub(super) took: Option<Duration>,
}

impl<'a> Course<'a> {
    /// Runs a method up to its first request for rates.
    pub(super) fn begin(
        meter: Meter,
        start: &Begin<'a>,
        shape: [usize; 2],
        options: &Method,
    ) -> Result<Self, MethodError> {
        let meter = Arc::new(meter);
        let mut course = Self {
            shape,
            limits: meter.limits(),
            options: options.clone(),
            begins_with: meter.start().cloned(),
            method: start(Arc::clone(&meter), shape, options.clone()),
            meter,
            state: State::Failed(RenderError::Interrupted),
            needed: 0,
            shown: Vec::new(),
            started: Instant::now(),
            took: None,
        };
        course.advance()?;
        Ok(course)
    }

    pub(super) fn answer(&mut self, answer: Result<Batch, MethodError>) -> Result<(), MethodError> {
        self.meter.exchange().answer(answer);
        self.advance()
    }

    /// Runs the method up to its next request or its end.
    fn advance(&mut self) -> Result<(), MethodError> {
        self.state = match advance(self.method.as_mut()) {
            Poll::Ready(Ok(mut made)) => {
                made.ending = self.meter.reason_for(made.ending);
                if let Some(frozen) = made.frozen.as_mut().and_then(Arc::get_mut) {
                    frozen.recorded = self.meter.recorded();
                }
                self.took = Some(self.started.elapsed());
                State::Ended(Box::new(made))
            }
            Poll::Ready(Err(error)) => State::Failed(error),
            Poll::Pending => {
                let asked = self.meter.exchange().take();
                asked.map_or(State::Failed(RenderError::Interrupted), State::Waiting)
            }
        };
        self.needed = if let State::Waiting(batch) = &self.state { batch.len() } else { 0 };
        let shown = self.meter.take_shown();
        if !shown.is_empty() && self.meter.keeps_rates() {
            self.shown.clear();
        }
        self.shown.extend(shown);
        match &self.state {
            State::Failed(error) => Err(error.clone()),
            State::Waiting(_) | State::Ended(_) => Ok(()),
        }
    }
}

/// The state of a session.
pub(super) enum State {
    /// It waits for the rates at these points.
    Waiting(Batch),
    Ended(Box<MethodOutput>),
    Failed(MethodError),
}
