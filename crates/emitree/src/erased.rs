//! An emission of any type: what calls g is compiled once, and not again for each emission.

use crate::emission::{Emission, Samples};
use crate::error::RenderError;
use core::error::Error;
use core::fmt;

/// An emission of any type.
pub(crate) type AnyEmission<'a> = dyn Emission<Error = AnyError> + 'a;

/// The error of an emission of any type.
#[derive(Debug)]
pub(crate) struct AnyError(Box<dyn Error + Send + Sync>);

impl fmt::Display for AnyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Error for AnyError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.0.source()
    }
}

/// An emission without its type.
pub(crate) struct Erased<'a, E>(pub(crate) &'a E);

impl<E: Emission> Emission for Erased<'_, E> {
    type Error = AnyError;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), AnyError> {
        self.0.emission_rates(samples, rates).map_err(|error| AnyError(Box::new(error)))
    }

    fn absorbs(&self) -> bool {
        self.0.absorbs()
    }

    fn absorption_coefficients(
        &self,
        samples: &Samples<'_>,
        coefficients: &mut [f64],
    ) -> Result<(), AnyError> {
        let result = self.0.absorption_coefficients(samples, coefficients);
        result.map_err(|error| AnyError(Box::new(error)))
    }

    fn takes_whole_batches(&self) -> bool {
        self.0.takes_whole_batches()
    }
}

/// The error of a rendering of an [`Erased`] emission with the type of the emission's error, `E`.
pub(crate) fn typed<E: Error + Send + Sync + 'static>(
    error: RenderError<AnyError>,
) -> RenderError<E> {
    error.with_emission_error(|AnyError(error)| error.downcast().ok().map(|error| *error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Debug, PartialEq)]
    struct NoFile(u32);

    impl fmt::Display for NoFile {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "no file {}", self.0)
        }
    }

    impl Error for NoFile {}

    struct Fails;

    impl Emission for Fails {
        type Error = NoFile;

        fn emission_rates(&self, _: &Samples<'_>, _: &mut [f64]) -> Result<(), NoFile> {
            Err(NoFile(1))
        }

        fn absorption_coefficients(&self, _: &Samples<'_>, _: &mut [f64]) -> Result<(), NoFile> {
            Err(NoFile(2))
        }

        fn takes_whole_batches(&self) -> bool {
            true
        }
    }

    #[test]
    fn errors_have_their_type_and_text_again() {
        let erased: &AnyEmission<'_> = &Erased(&Fails);
        let samples = Samples::new(&[], &[]);
        let rate = erased.emission_rates(&samples, &mut []).unwrap_err();
        let coefficient = erased.absorption_coefficients(&samples, &mut []).unwrap_err();
        assert_eq!(rate.to_string(), "no file 1");
        assert_eq!(typed(RenderError::Emission(rate)), RenderError::Emission(NoFile(1)));
        assert_eq!(typed(RenderError::Emission(coefficient)), RenderError::Emission(NoFile(2)));
        assert!(erased.takes_whole_batches() && !erased.absorbs());
    }
}
