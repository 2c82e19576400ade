//! The emission for the library: that of a scene, or functions in Python.

use crate::bridge::{Called, Caller};
use emitree::{Emission, Samples};
use emitree_io::{EmissionFailure, SceneEmission};

/// An emission: that of a scene, with functions in the place of g, of the absorption coefficient or of both.
pub(crate) struct AnyEmission<'a> {
    pub(crate) scene: &'a SceneEmission,
    /// The thread that calls functions.
    pub(crate) caller: &'a Caller,
    /// Whether g is a function; the scene's emission is a placeholder then, in the units of the function.
    pub(crate) is_function: bool,
    /// The same of the absorption coefficient.
    pub(crate) absorbs_by_function: bool,
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

impl AnyEmission<'_> {
    /// The values of a function times a factor.
    fn call(
        &self,
        function: Called,
        samples: &Samples<'_>,
        factor: f64,
        values: &mut [f64],
    ) -> Result<(), EmissionStop> {
        let found = self.scene.seen(samples, |samples| self.caller.values(function, samples));
        let found = found.ok_or(EmissionStop::Exception)?;
        values.iter_mut().zip(found).for_each(|(value, found)| *value = found * factor);
        Ok(())
    }
}

impl Emission for AnyEmission<'_> {
    type Error = EmissionStop;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), EmissionStop> {
        match self.is_function {
            true => self.call(Called::Emission, samples, self.scene.rate_factor, rates),
            false => Ok(self.scene.emission_rates(samples, rates)?),
        }
    }

    fn absorbs(&self) -> bool {
        self.scene.absorbs()
    }

    fn absorption_coefficients(
        &self,
        samples: &Samples<'_>,
        coefficients: &mut [f64],
    ) -> Result<(), EmissionStop> {
        match &self.scene.absorption {
            Some(absorption) if self.absorbs_by_function => {
                self.call(Called::Absorption, samples, absorption.factor, coefficients)
            }
            _ => Ok(self.scene.absorption_coefficients(samples, coefficients)?),
        }
    }

    /// Only one thread may call Python at a time, and the function may be parallel itself.
    fn takes_whole_batches(&self) -> bool {
        self.is_function || self.absorbs_by_function
    }
}
