//! An emission behind a pointer: the methods are compiled once, and not for each type of emission.
//!
//! g is called in batches, so that the pointer costs nothing, while a program that renders a dozen
//! closures would have a dozen engines to compile.

use crate::emission::{Emission, Samples};
use crate::error::RenderError;
use core::fmt;
use std::sync::{Mutex, PoisonError};

/// An emission of any type, whose errors are kept aside.
pub(crate) struct Erased<'a> {
    rates: &'a Rates<'a>,
    takes_whole_batches: bool,
}

type Rates<'a> = dyn Fn(&Samples<'_>, &mut [f64]) -> Result<(), Failure> + Sync + 'a;

/// The number of an error that is kept aside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Failure(usize);

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error {} of the emission", self.0)
    }
}

impl core::error::Error for Failure {}

impl Emission for Erased<'_> {
    type Error = Failure;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Failure> {
        (self.rates)(samples, rates)
    }

    fn takes_whole_batches(&self) -> bool {
        self.takes_whole_batches
    }
}

/// What `render` makes of an emission of any type, with the errors of that type.
pub(crate) fn with_erased<E: Emission, T>(
    emission: &E,
    render: impl FnOnce(&Erased<'_>) -> Result<T, RenderError<Failure>>,
) -> Result<T, RenderError<E::Error>> {
    let errors: Mutex<Vec<Option<E::Error>>> = Mutex::default();
    let keep = |error: E::Error| {
        let mut errors = errors.lock().unwrap_or_else(PoisonError::into_inner);
        errors.push(Some(error));
        Failure(errors.len() - 1)
    };
    let rates = |samples: &Samples<'_>, rates: &mut [f64]| {
        emission.emission_rates(samples, rates).map_err(keep)
    };
    let takes_whole_batches = emission.takes_whole_batches();
    let rendered = render(&Erased { rates: &rates, takes_whole_batches });
    let mut errors = errors.into_inner().unwrap_or_else(PoisonError::into_inner);
    rendered.map_err(|error| {
        let kept = |Failure(number): Failure| errors.get_mut(number).and_then(Option::take);
        error.with_emission_error(kept)
    })
}
