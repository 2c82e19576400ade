//! Two sides of a rendering: worker threads, and the calling thread, which runs Python.
//!
//! A function that is rendered may rely on the thread that it runs in (the error state of `NumPy`,
//! contexts, a debugger), and only the main thread receives Ctrl-C. So it is always called in the
//! thread that called the renderer: worker threads send it a batch and wait for the rates.
//! Between requests the interpreter is released.
//!
//! Each rendering has a pool of threads of its own. With a shared one, a function that renders
//! something itself would wait for threads that wait for it.

use crate::arrays::array;
use emitree::progress::Frame;
use emitree::{Image, Samples};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// How often the calling thread checks for signals and reports the progress: without a noticeable
/// delay.
const TICK: Duration = Duration::from_millis(50);

/// What is called in Python.
#[derive(Default)]
pub(crate) struct Hooks {
    /// `function(position, direction, energy | None) -> rates`.
    pub(crate) function: Option<Py<PyAny>>,
    /// `absorption(position, direction, energy | None) -> coefficients`.
    pub(crate) absorption: Option<Py<PyAny>>,
    /// `progress(evaluations)`, now and then.
    pub(crate) progress: Option<Py<PyAny>>,
    /// `frame(image, error, evaluations, batches)`, for each intermediate image.
    pub(crate) frame: Option<Py<PyAny>>,
}

/// A function that takes batches.
#[derive(Clone, Copy)]
pub(crate) enum Called {
    Emission,
    Absorption,
}

impl Hooks {
    fn function(&self, called: Called) -> Option<&Py<PyAny>> {
        match called {
            Called::Emission => self.function.as_ref(),
            Called::Absorption => self.absorption.as_ref(),
        }
    }
}

/// The requests of worker threads to the calling one. A missing reply means: stop.
enum Event {
    Batch {
        function: Called,
        positions: Vec<f64>,
        directions: Vec<f64>,
        energies: Vec<f64>,
        reply: SyncSender<Vec<f64>>,
    },
    Frame {
        image: Image,
        error: Image,
        evaluations: u64,
        batches: u64,
        reply: SyncSender<()>,
    },
}

/// The state that both sides share.
#[derive(Default)]
struct Shared {
    evaluations: AtomicU64,
    stop: AtomicBool,
}

/// The interface of worker threads to the calling thread.
pub(crate) struct Caller {
    events: Sender<Event>,
    shared: Arc<Shared>,
}

impl Caller {
    /// The values of a function for a batch; none if it raised an exception.
    pub(crate) fn values(&self, function: Called, samples: &Samples<'_>) -> Option<Vec<f64>> {
        let (reply, answer) = sync_channel(1);
        // The function may keep its arrays: they are its own.
        let batch = Event::Batch {
            function,
            positions: samples.positions().as_flattened().to_vec(),
            directions: samples.directions().as_flattened().to_vec(),
            energies: samples.energies().to_vec(),
            reply,
        };
        self.events.send(batch).ok()?;
        answer.recv().ok()
    }

    /// Passes on an intermediate image.
    pub(crate) fn frame(&self, frame: &Frame<'_>, image: Image, error: Image) -> ControlFlow<()> {
        let (reply, answer) = sync_channel(1);
        let (evaluations, batches) = (frame.evaluations, frame.batches);
        let event = Event::Frame { image, error, evaluations, batches, reply };
        let answered = self.events.send(event).is_ok() && answer.recv().is_ok();
        if answered { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    /// Stores the evaluations so far; returns whether to continue.
    pub(crate) fn progress(&self, evaluations: u64) -> ControlFlow<()> {
        self.shared.evaluations.fetch_max(evaluations, Ordering::Relaxed);
        match self.shared.stop.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

/// Does `work` on `threads` threads (none: as many as there are processors), and answers its requests to
/// Python here.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    hooks: &Hooks,
    threads: Option<usize>,
    work: impl FnOnce(&Caller) -> T + Send,
) -> PyResult<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
    let pool = pool.map_err(|error| PyOSError::new_err(format!("no threads: {error}")))?;
    let (sender, events) = channel();
    let shared = Arc::new(Shared::default());
    // It goes with the work: the channel is closed when that ends, however it ends.
    let caller = Caller { events: sender, shared: Arc::clone(&shared) };
    let (done, failure) = py.detach(move || {
        thread::scope(|scope| {
            let worker = scope.spawn(move || pool.install(|| work(&caller)));
            let failure = serve(&events, &shared, hooks);
            (worker.join(), failure)
        })
    });
    match (done, failure) {
        (_, Some(exception)) => Err(exception),
        (Ok(found), None) => Ok(found),
        (Err(panic), None) => std::panic::resume_unwind(panic),
    }
}

/// Answers until the work is done; the first exception ends it.
fn serve(events: &Receiver<Event>, shared: &Shared, hooks: &Hooks) -> Option<PyErr> {
    let mut failure: Option<PyErr> = None;
    let (mut checked, mut reported) = (Instant::now(), 0);
    loop {
        let event = match events.recv_timeout(TICK) {
            Ok(event) => Some(event),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => break,
        };
        if failure.is_some() {
            continue;
        }
        let is_due = checked.elapsed() >= TICK;
        if event.is_none() && !is_due {
            continue;
        }
        let result = Python::attach(|py| {
            event.map_or(Ok(()), |event| answer(py, event, hooks))?;
            if is_due {
                checked = Instant::now();
                py.check_signals()?;
                report(py, shared, hooks, &mut reported)?;
            }
            Ok(())
        });
        if let Err(exception) = result {
            shared.stop.store(true, Ordering::Relaxed);
            failure = Some(exception);
        }
    }
    if failure.is_none() {
        failure = Python::attach(|py| report(py, shared, hooks, &mut reported)).err();
    }
    failure
}

/// Reports the progress, if there was any.
fn report(py: Python<'_>, shared: &Shared, hooks: &Hooks, reported: &mut u64) -> PyResult<()> {
    let evaluations = shared.evaluations.load(Ordering::Relaxed);
    if let Some(progress) = &hooks.progress
        && evaluations != *reported
    {
        *reported = evaluations;
        progress.call1(py, (evaluations,))?;
    }
    Ok(())
}

fn answer(py: Python<'_>, event: Event, hooks: &Hooks) -> PyResult<()> {
    // The other side waits for each answer: if it can't be sent there is no receiver any more.
    match event {
        Event::Batch { function, positions, directions, energies, reply } => {
            let Some(function) = hooks.function(function) else { return Ok(()) };
            let first = First::of(&positions, &directions, &energies);
            let rates = call(function.bind(py), positions, directions, energies);
            let _ = reply.send(rates.map_err(|exception| first.note(py, exception))?);
        }
        Event::Frame { image, error, evaluations, batches, reply } => {
            if let Some(frame) = &hooks.frame {
                frame.call1(py, (array(py, &image)?, array(py, &error)?, evaluations, batches))?;
            }
            let _ = reply.send(());
        }
    }
    Ok(())
}

/// Calls the function with one batch.
fn call(
    function: &Bound<'_, PyAny>,
    positions: Vec<f64>,
    directions: Vec<f64>,
    energies: Vec<f64>,
) -> PyResult<Vec<f64>> {
    let py = function.py();
    let count = positions.len() / 3;
    let energies = Some(energies).filter(|energies| !energies.is_empty());
    let energies = energies.map(|energies| energies.into_pyarray(py));
    let result = function.call1((rows(py, positions)?, rows(py, directions)?, energies))?;
    let rates: PyReadonlyArray1<'_, f64> = result.extract()?;
    if rates.len() != count {
        let message = format!("{} rates for {count} points: expected one each", rates.len());
        return Err(PyValueError::new_err(message));
    }
    Ok(rates.as_array().to_vec())
}

/// An array of shape (n, 3), without a copy.
fn rows<'py>(py: Python<'py>, values: Vec<f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let shape = (values.len() / 3, 3);
    let rows = Array2::from_shape_vec(shape, values);
    Ok(rows.map_err(|error| PyValueError::new_err(error.to_string()))?.into_pyarray(py))
}

/// The first point of a batch, for the note of an exception.
struct First {
    count: usize,
    position: Vec<f64>,
    direction: Vec<f64>,
    energy: Option<f64>,
}

impl First {
    fn of(positions: &[f64], directions: &[f64], energies: &[f64]) -> Self {
        let head = |values: &[f64]| values.iter().take(3).copied().collect();
        Self {
            count: positions.len() / 3,
            position: head(positions),
            direction: head(directions),
            energy: energies.first().copied(),
        }
    }

    /// The exception of the function, with a note of the points that it was called with.
    fn note(&self, py: Python<'_>, exception: PyErr) -> PyErr {
        let Self { count, position, direction, energy } = self;
        let energy = energy.map(|energy| format!(", energy {energy}")).unwrap_or_default();
        let note = format!(
            "emitree: in a batch of {count} points, the first at position {position:?}, emission \
             direction {direction:?}{energy}"
        );
        // Not every exception takes notes; it matters more than they do.
        let _ = exception.value(py).call_method1("add_note", (note,));
        exception
    }
}
