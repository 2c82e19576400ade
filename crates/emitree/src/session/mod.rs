//! A session: one rendering that can be held between its batches, inspected, and continued.
//!
//! [`render()`](crate::render()) runs a session to its end.
//!
//! * `course`: the method from one request for rates to the next;
//! * `made`: the rendering, intermediate images, their cost;
//! * `mesh`: the frozen quadrature.

mod course;
mod made;
mod mesh;

pub(crate) use made::Cost;

use crate::absorption::Absorption;
use crate::ahead::{Ahead, Allowed};
use crate::calls::{Calls, check_finite};
use crate::checks::{check_options, limits, refuse_callbacks};
use crate::cube::Cube;
use crate::emission::{Emission, Samples};
use crate::energy::EnergyAxis;
use crate::erased::{AnyEmission, AnyError, Erased, typed};
use crate::error::RenderError;
use crate::exchange::{Batch, MethodError};
use crate::image::Image;
use crate::known::KnownRates;
use crate::meter::{Limits, Meter, RowsWanted, locked};
use crate::method::{self, Running};
use crate::options::{Method, RenderOptions};
use crate::progress::Progress;
use crate::projection::Projection;
use crate::tile::Tile;
use crate::values::Values;
use core::borrow::Borrow;
use core::convert::Infallible;
use core::marker::PhantomData;
use course::{Begin, Course, State};
use std::sync::{Arc, Mutex};

/// One rendering that can be held between its batches (ask and tell): it returns the points at which
/// rates are needed and takes the rates, so that the caller has the loop. The latest image can be read at
/// any time, and a session that has ended can be continued to a tighter tolerance or to more pixels.
///
/// All rates are kept: no point is evaluated twice in one session, unless a step failed at it or the time
/// limit cut its batch short, and a continued session returns, bit by bit, what a rendering to the new
/// tolerance would have returned at once. The time limit counts from [`new`](Self::new) or
/// [`resume`](Self::resume), with the time that the caller takes.
///
/// V is [`Image`] or, of a session [with energies](Session::with_energies), [`Cube`].
///
/// ```
/// use emitree::{Canonical, FromFn, Image, Projection, RenderOptions, Session, VolOptions};
///
/// let peak = |[x, y, z]: [f64; 3]| (-30.0 * (x * x + y * y + z * z)).exp();
/// let options = |tolerance| RenderOptions::new(VolOptions::new(tolerance));
/// let camera: &dyn Projection = &Canonical;
/// let mut session = Session::<Image>::new(camera, [48, 64], &options(0.01))?;
/// while let Some(points) = session.ask() {
///     let rates: Vec<f64> = points.positions().iter().map(|&position| peak(position)).collect();
///     session.tell(&rates)?;
/// }
/// let coarse = session.rendering().ok_or("an image")?;
///
/// session.resume([48, 64], &options(1e-4))?;
/// while !session.is_done() {
///     session.step(&FromFn(|position, _| peak(position)))?;
/// }
/// let fine = session.rendering().ok_or("an image")?;
/// assert!(fine.estimated_error() < Some(1e-4) && fine.stats.evaluations > coarse.stats.evaluations);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Session<'a, V = Image> {
    start: Box<Begin<'a>>,
    view: Arc<dyn SeenThrough<'a> + 'a>,
    /// What is known of the medium, once it has absorbed.
    absorption: Option<Absorption>,
    axis: Option<EnergyAxis>,
    known: Option<Arc<Mutex<KnownRates>>>,
    course: Course<'a>,
    /// What expects the next points, if rounds are to be fewer.
    ahead: Option<Ahead>,
    /// What was done before the session was resumed.
    before: Cost,
    values: PhantomData<fn() -> V>,
}

/// What has a projection.
trait SeenThrough<'a>: Send + Sync {
    fn projection(&self) -> &(dyn Projection + 'a);
}

impl<'a, P: Borrow<dyn Projection + 'a> + Send + Sync> SeenThrough<'a> for (P, Option<EnergyAxis>) {
    fn projection(&self) -> &(dyn Projection + 'a) {
        self.0.borrow()
    }
}

/// What a session stores.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    /// All rates, so that no point is evaluated twice: those that are known already, and new ones.
    pub(crate) rates: Option<Arc<Mutex<KnownRates>>>,
    /// Intermediate images.
    pub(crate) images: bool,
    /// No rates, even if the method asks for some points again.
    pub(crate) repeats: bool,
    /// Nothing but products, for an image that is made row by row.
    pub(crate) rows: Option<RowsWanted>,
}

impl Kept {
    /// Everything, and no rates yet.
    fn all() -> Self {
        Self { rates: Some(Arc::default()), images: true, repeats: false, rows: None }
    }
}

impl<'a> Session<'a> {
    /// The rendering of an image of `shape` = \[height, width\] pixels. A session calls
    /// no callbacks.
    ///
    /// # Errors
    ///
    /// [`RenderError`]: options out of range, callbacks, an image or a grid beyond the memory allowed.
    pub fn new<P: Borrow<dyn Projection + 'a> + Send + Sync + 'a>(
        projection: P,
        shape: [usize; 2],
        options: &RenderOptions<'_>,
    ) -> Result<Self, RenderError<Infallible>> {
        refuse_callbacks(options)?;
        Self::start(projection, shape, None, options, Kept::all(), true)
    }
}

impl<'a> Session<'a, Cube> {
    /// The same for a cube in the bins of an energy axis; without one the cube has one band, the image.
    ///
    /// # Errors
    ///
    /// As [`Session::new`].
    pub fn with_energies<P: Borrow<dyn Projection + 'a> + Send + Sync + 'a>(
        projection: P,
        shape: [usize; 2],
        axis: Option<EnergyAxis>,
        options: &RenderOptions<'_>,
    ) -> Result<Self, RenderError<Infallible>> {
        refuse_callbacks(options)?;
        Self::start(projection, shape, axis, options, Kept::all(), true)
    }
}

impl<'a, V: Values> Session<'a, V> {
    /// A session up to its first request for rates.
    pub(crate) fn start<P: Borrow<dyn Projection + 'a> + Send + Sync + 'a, E>(
        projection: P,
        shape: [usize; 2],
        axis: Option<EnergyAxis>,
        options: &RenderOptions<'_>,
        kept: Kept,
        whole_batches: bool,
    ) -> Result<Self, RenderError<E>> {
        let view = Arc::new((projection, axis));
        let seen_through: Arc<dyn SeenThrough<'a> + 'a> =
            Arc::<(P, Option<EnergyAxis>)>::clone(&view);
        let start = move |meter: Arc<Meter>, shape: [usize; 2], method: Method| -> Running<'a> {
            let view = Arc::clone(&view);
            Box::pin(async move {
                let (projection, axis) = &*view;
                run(&meter, projection.borrow(), shape, axis.as_ref(), &method).await
            })
        };
        // Before anything is allocated.
        check_options(shape, axis.as_ref().map(EnergyAxis::bins), options)?;
        let is_ahead = options.rounds.is_some();
        let stores = (options.method.repeats_points() && !kept.repeats) || is_ahead;
        let known = kept.rates.or_else(|| stores.then(Arc::default));
        let limits = limits(options, whole_batches, known.is_some());
        let meter = Meter::new(shape, limits, known.clone(), kept.images);
        let meter =
            meter.with_frozen_quadrature(options.mesh_up_to).with_start(options.start.clone());
        let meter = meter.with_rows(kept.rows);
        let is_vol = matches!(options.method, Method::Vol(_));
        let meter = if is_vol && !kept.repeats { meter.with_first_rates() } else { meter };
        let course = Course::begin(meter, &start, shape, &options.method);
        let mut session = Self {
            start: Box::new(start),
            view: seen_through,
            absorption: None,
            axis,
            known,
            course: course.map_err(of_method)?,
            ahead: options.rounds.map(Ahead::new),
            before: Cost::default(),
            values: PhantomData,
        };
        session.look_ahead();
        Ok(session)
    }

    /// Adds points that the method is expected to need next to the batch that it waits for, if rounds are to be
    /// fewer.
    fn look_ahead(&mut self) {
        let (Some(ahead), Some(known)) = (&self.ahead, &self.known) else { return };
        let Course { shape, limits, options, begins_with, meter, state, .. } = &mut self.course;
        let State::Waiting(batch) = state else { return };
        // A repetition has no limit of time: its points do not depend on the machine.
        let limits = Limits { deadline: None, ..*limits };
        let repeat = |known: Arc<Mutex<KnownRates>>| {
            let repeated = Meter::new(*shape, limits, Some(known), false);
            let repeated = Arc::new(repeated.with_start(begins_with.clone()));
            let method = (self.start)(Arc::clone(&repeated), *shape, options.clone());
            (repeated, method)
        };
        let altogether = limits.max_evaluations.min(limits.max_kept);
        let allowed = Allowed { now: meter.evaluations_left(), altogether };
        let asked = core::mem::take(batch);
        *batch = ahead.extended(asked, &locked(known), meter.evaluations(), allowed, repeat);
    }

    /// Answers the method, and continues to its next request.
    fn answer(&mut self, answer: Result<Batch, MethodError>) -> Result<(), MethodError> {
        if let (Some(ahead), Ok(batch)) = (&mut self.ahead, &answer) {
            ahead.add(batch);
        }
        self.course.answer(answer)?;
        self.look_ahead();
        Ok(())
    }

    /// Continues a session with other options or another `shape` = \[height, width\], in the same view: to a
    /// tighter tolerance, to more pixels, with a larger budget. Stored rates are reused without a new
    /// evaluation, but count for `max_evaluations` as if they had been made now. Points that
    /// [`ask`](Self::ask) returned before are void.
    ///
    /// # Errors
    ///
    /// As [`Session::new`]; then the session is as it was.
    pub fn resume(
        &mut self,
        shape: [usize; 2],
        options: &RenderOptions<'_>,
    ) -> Result<(), RenderError<Infallible>> {
        refuse_callbacks(options)?;
        check_options(shape, self.axis.as_ref().map(EnergyAxis::bins), options)?;
        // Only a caller with the loop can resume a session, and then all rates are stored.
        let meter = Meter::new(shape, limits(options, true, true), self.known.clone(), true);
        let meter =
            meter.with_frozen_quadrature(options.mesh_up_to).with_start(options.start.clone());
        let course = Course::begin(meter, &*self.start, shape, &options.method);
        let course = course.map_err(of_method)?;
        self.before = self.cost();
        self.course = course;
        self.ahead = match (self.ahead.take(), options.rounds) {
            (Some(ahead), Some(rounds)) => Some(ahead.with_rounds(rounds)),
            (_, rounds) => rounds.map(Ahead::new),
        };
        self.look_ahead();
        Ok(())
    }

    /// The points at which rates are needed next; `None` once the rendering has ended.
    pub fn ask(&self) -> Option<Samples<'_>> {
        match &self.course.state {
            State::Waiting(batch) => Some(batch.samples()),
            State::Ended(_) | State::Failed(_) => None,
        }
    }

    /// Takes the rates at the points of [`ask`](Self::ask), in their order and in the unit of g, and
    /// continues to the next points.
    ///
    /// # Errors
    ///
    /// [`RenderError`]: a number of rates other than that of the points, or a rate that is not finite: then
    /// the session still waits. An image that is not finite.
    pub fn tell(&mut self, rates: &[f64]) -> Result<(), RenderError<Infallible>> {
        let State::Waiting(batch) = &mut self.course.state else {
            return Err(wrong_number(
                rates.len(),
                "none, as the session waits for no rates".into(),
            ));
        };
        if batch.len() != rates.len() {
            let expected = format!("{}, one for each point of `ask`", batch.len());
            return Err(wrong_number(rates.len(), expected));
        }
        check_finite(&batch.samples(), rates)?;
        batch.rates.copy_from_slice(rates);
        self.course.meter.count(rates.len());
        let batch = core::mem::take(batch);
        self.answer(Ok(batch)).map_err(of_method)
    }

    /// Takes rates that are known from elsewhere, such as those of a session in another process, at any points
    /// in any order, and continues to the first points without a rate. They count as evaluations, made in so many
    /// `batches`. So a session that is told all rates of another one is where that one was, and its result has the
    /// same bits.
    ///
    /// ```
    /// use emitree::{Canonical, Image, Projection, RenderOptions, Samples, Session, VolOptions};
    ///
    /// let options = RenderOptions::new(VolOptions::new(0.01));
    /// let camera: &dyn Projection = &Canonical;
    /// let mut first = Session::<Image>::new(camera, [8, 8], &options)?;
    /// let points = first.ask().ok_or("points")?;
    /// let (positions, directions) = (points.positions().to_vec(), points.directions().to_vec());
    /// let rates: Vec<f64> = positions.iter().map(|[x, y, z]| x * y + z).collect();
    /// first.tell(&rates)?;
    ///
    /// let mut second = Session::<Image>::new(camera, [8, 8], &options)?;
    /// second.tell_known(&Samples::new(&positions, &directions), &rates, 1)?;
    /// assert_eq!(first.ask().map(|points| points.len()), second.ask().map(|points| points.len()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`RenderError`] as of [`tell`](Self::tell); then nothing has been taken.
    pub fn tell_known(
        &mut self,
        points: &Samples<'_>,
        rates: &[f64],
        batches: u64,
    ) -> Result<(), RenderError<Infallible>> {
        if points.len() != rates.len() {
            let expected = format!("{}, one for each point", points.len());
            return Err(wrong_number(rates.len(), expected));
        }
        check_finite(points, rates)?;
        // Only a caller with the loop has this method, and then all rates are stored.
        let Some(known) = &self.known else { return Ok(()) };
        let told = Batch {
            positions: points.positions().to_vec(),
            directions: points.directions().to_vec(),
            energies: points.energies().to_vec(),
            rates: rates.to_vec(),
        };
        let mut known = locked(known);
        let new = known.insert_new(&told).len();
        self.course.meter.count_given(new);
        self.before.batches += batches;
        if let Some(ahead) = &mut self.ahead {
            ahead.add(&told);
        }
        let State::Waiting(batch) = &mut self.course.state else { return Ok(()) };
        // Others follow from more rates than before.
        batch.truncate(self.course.needed);
        *batch = known.unknown(batch);
        self.course.needed = batch.len();
        let is_known = batch.len() == 0;
        drop(known);
        if is_known {
            return self.answer(Ok(Batch::default())).map_err(of_method);
        }
        self.look_ahead();
        Ok(())
    }

    /// Evaluates an emission at the points of [`ask`](Self::ask), and continues to the next ones; does
    /// nothing if the rendering has ended.
    ///
    /// # Errors
    ///
    /// [`RenderError`] as of [`tell`](Self::tell), or an emission that failed: then the session still waits.
    pub fn step<E: Emission>(&mut self, emission: &E) -> Result<(), RenderError<E::Error>> {
        self.evaluate(&Erased(emission), None).map_err(typed)
    }

    /// One [`step`](Self::step); `progress` is called after each call of g.
    pub(crate) fn evaluate(
        &mut self,
        emission: &AnyEmission<'_>,
        progress: Option<&Progress<'_>>,
    ) -> Result<(), RenderError<AnyError>> {
        let State::Waiting(batch) = &mut self.course.state else { return Ok(()) };
        let calls = Calls::new(emission, &self.course.meter, progress);
        let mut evaluated = calls.evaluate(batch);
        if evaluated.is_ok() && emission.absorbs() {
            let (method, keeps_rates) = (&self.course.options, self.known.is_some());
            let absorption =
                self.absorption.get_or_insert_with(|| Absorption::new(method, keeps_rates));
            evaluated = absorption.attenuate(&calls, self.view.projection(), batch);
        }
        let answer = match evaluated {
            Ok(()) => Ok(core::mem::take(batch)),
            // The method may still have an image.
            Err(RenderError::Time { seconds }) => Err(RenderError::Time { seconds }),
            Err(error) => return Err(error),
        };
        self.answer(answer).map_err(of_method)
    }

    /// How many rates the method has had and waits for, whether they were known or not.
    pub(crate) fn requested(&self) -> u64 {
        let waiting = self.ask().map_or(0, |points| points.len() as u64);
        self.course.meter.evaluations() + waiting
    }

    /// Whether the rendering has ended.
    pub fn is_done(&self) -> bool {
        !matches!(self.course.state, State::Waiting(_))
    }
}

impl<V> core::fmt::Debug for Session<'_, V> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let state = match &self.course.state {
            State::Waiting(batch) => format!("waits for {} rates", batch.len()),
            State::Ended(_) => "has ended".to_owned(),
            State::Failed(error) => format!("has failed: {error}"),
        };
        f.debug_struct("Session")
            .field("shape", &self.course.shape)
            .field("evaluations", &self.course.meter.new_evaluations())
            .field("state", &state)
            .finish_non_exhaustive()
    }
}

/// Compiled here, once, and not for each type of projection.
fn run<'b>(
    meter: &'b Meter,
    projection: &'b dyn Projection,
    shape: [usize; 2],
    axis: Option<&'b EnergyAxis>,
    method: &'b Method,
) -> Running<'b> {
    Box::pin(async move {
        let tiles = Tile::of(projection, shape)?;
        method::run(meter, &tiles, axis, method).await
    })
}

/// The error of a method as one of a rendering: the emission is not evaluated in it.
fn of_method<E>(error: MethodError) -> RenderError<E> {
    error.with_emission_error(|_| None)
}

fn wrong_number<E>(number: usize, expected: String) -> RenderError<E> {
    RenderError::Rates { number, expected }
}
