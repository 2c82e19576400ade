//! The emission for the library: that of a scene, or a function in Python.

use crate::bridge::Caller;
use emitree::{Emission, Samples};
use emitree_io::{EmissionFailure, SceneEmission};

/// An emission.
pub(crate) enum AnyEmission<'a> {
    /// That of a scene.
    Scene(&'a SceneEmission),
    /// A function in Python.
    Function {
        /// The thread that calls it.
        caller: &'a Caller,
        /// What its rates are multiplied with for the unit of the image.
        rate_factor: f64,
    },
}

/// The error of an emission.
#[derive(Debug, thiserror::Error)]
pub(crate) enum EmissionStop {
    /// An emission of a scene failed.
    #[error(transparent)]
    Failure(#[from] EmissionFailure),
    /// The function raised an exception, which the calling thread keeps.
    #[error("an exception was raised")]
    Exception,
}

impl Emission for AnyEmission<'_> {
    type Error = EmissionStop;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), EmissionStop> {
        match self {
            Self::Scene(emission) => Ok(emission.emission_rates(samples, rates)?),
            Self::Function { caller, rate_factor } => {
                let found = caller.rates(samples).ok_or(EmissionStop::Exception)?;
                for (rate, found) in rates.iter_mut().zip(found) {
                    *rate = found * rate_factor;
                }
                Ok(())
            }
        }
    }

    /// Only one thread may call Python at a time, and the function may be parallel itself.
    fn takes_whole_batches(&self) -> bool {
        matches!(self, Self::Function { .. })
    }
}
