//! The exchange between a method, which requests rates at points, and a caller, which evaluates g there.
//!
//! A method is an asynchronous function that waits for rates and for nothing else. So it can be held while
//! it waits, and the caller has the loop: [`drive`] is the shortest one.

use crate::emission::Samples;
use crate::error::RenderError;
use crate::polling::advance;
use core::fmt;
use core::future::{Future, poll_fn};
use core::pin::Pin;
use core::task::Poll;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The emission failed; the caller has its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EmissionFailed;

impl fmt::Display for EmissionFailed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the emission failed")
    }
}

impl core::error::Error for EmissionFailed {}

/// The error of a method, independent of the type of the emission.
pub(crate) type MethodError = RenderError<EmissionFailed>;

/// Points at which rates are requested, and the rates once they are known.
#[derive(Clone, Debug, Default)]
pub(crate) struct Batch {
    /// In world coordinates and the scene's length unit.
    pub(crate) positions: Vec<[f64; 3]>,
    /// Unit vectors of emission.
    pub(crate) directions: Vec<[f64; 3]>,
    /// One for each point, or none without an energy axis.
    pub(crate) energies: Vec<f64>,
    /// One for each point.
    pub(crate) rates: Vec<f64>,
}

impl Batch {
    /// The number of points.
    pub(crate) fn len(&self) -> usize {
        self.positions.len()
    }

    /// The points, as an emission takes them.
    pub(crate) fn samples(&self) -> Samples<'_> {
        Samples::new(&self.positions, &self.directions).at_energies(&self.energies)
    }

    /// The points of these numbers, with rates of 0.
    pub(crate) fn some(&self, numbers: &[usize]) -> Self {
        let of_points = |of: &[[f64; 3]]| numbers.iter().map(|&i| of[i]).collect();
        Self {
            positions: of_points(&self.positions),
            directions: of_points(&self.directions),
            energies: numbers.iter().filter_map(|&i| self.energies.get(i).copied()).collect(),
            rates: vec![0.0; numbers.len()],
        }
    }

    /// Adds the points and rates of another batch, with energies if this one has them.
    pub(crate) fn append(&mut self, other: Self) {
        self.positions.extend(other.positions);
        self.directions.extend(other.directions);
        self.energies.extend(other.energies);
        self.rates.extend(other.rates);
    }

    /// Room for so many points; energies are none.
    pub(crate) fn make_room(&mut self, points: usize) {
        self.positions.resize(points, [0.0; 3]);
        self.directions.resize(points, [0.0; 3]);
        self.energies.clear();
    }

    /// Keeps the first `points`, whose rates are still missing.
    pub(crate) fn truncate(&mut self, points: usize) {
        self.positions.truncate(points);
        self.directions.truncate(points);
        self.energies.truncate(points);
        self.rates.clear();
        self.rates.resize(points, 0.0);
    }
}

/// The place of a method's request and of the caller's answer.
#[derive(Debug, Default)]
pub(crate) struct Exchange(Mutex<State>);

#[derive(Debug, Default)]
enum State {
    #[default]
    Idle,
    Asked(Batch),
    Answered(Result<Batch, MethodError>),
}

impl Exchange {
    /// Requests the rates of a batch, and waits for them.
    pub(crate) async fn ask(&self, batch: Batch) -> Result<Batch, MethodError> {
        *self.state() = State::Asked(batch);
        poll_fn(|_| {
            let mut state = self.state();
            match core::mem::take(&mut *state) {
                State::Answered(answer) => Poll::Ready(answer),
                waiting => {
                    *state = waiting;
                    Poll::Pending
                }
            }
        })
        .await
    }

    /// Takes the requested batch, if there is one.
    pub(crate) fn take(&self) -> Option<Batch> {
        match core::mem::take(&mut *self.state()) {
            State::Asked(batch) => Some(batch),
            State::Idle | State::Answered(_) => None,
        }
    }

    /// Answers the request.
    pub(crate) fn answer(&self, answer: Result<Batch, MethodError>) {
        *self.state() = State::Answered(answer);
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The result of a method whose requests are all answered by `evaluate`.
pub(crate) fn drive<T>(
    exchange: &Exchange,
    mut method: Pin<&mut (dyn Future<Output = T> + '_)>,
    mut evaluate: impl FnMut(&mut Batch) -> Result<(), MethodError>,
) -> T {
    loop {
        if let Poll::Ready(result) = advance(method.as_mut()) {
            return result;
        }
        if let Some(mut batch) = exchange.take() {
            let evaluated = evaluate(&mut batch);
            exchange.answer(evaluated.map(|()| batch));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::pin::pin;

    /// Requests the rates at 0, 1, 2 and so on until their sum is above 10.
    async fn adds_up(exchange: &Exchange) -> Result<f64, MethodError> {
        let mut sum = 0.0;
        for k in 0.. {
            let positions = vec![[f64::from(k), 0.0, 0.0]];
            let batch = Batch { positions, rates: vec![0.0], ..Batch::default() };
            sum += exchange.ask(batch).await?.rates[0];
            if sum > 10.0 {
                break;
            }
        }
        Ok(sum)
    }

    #[test]
    fn a_method_waits_until_it_is_answered() {
        let exchange = Exchange::default();
        let mut method = pin!(adds_up(&exchange));
        assert!(advance(method.as_mut()).is_pending());
        assert!(advance(method.as_mut()).is_pending(), "there is no answer yet");
        let mut batch = exchange.take().unwrap();
        assert!(exchange.take().is_none(), "what was taken is there once");
        batch.rates[0] = 11.0;
        exchange.answer(Ok(batch));
        assert_eq!(advance(method.as_mut()), Poll::Ready(Ok(11.0)));
    }

    #[test]
    fn a_loop_answers_all_questions_and_ends_at_an_error() {
        let exchange = Exchange::default();
        let square = |batch: &mut Batch| {
            batch.rates[0] = batch.positions[0][0].powi(2);
            Ok(())
        };
        assert_eq!(drive(&exchange, pin!(adds_up(&exchange)), square), Ok(14.0));
        let fails = |_: &mut Batch| Err(RenderError::Emission(EmissionFailed));
        let failed = drive(&exchange, pin!(adds_up(&exchange)), fails);
        assert_eq!(failed, Err(RenderError::Emission(EmissionFailed)));
    }
}
