//! The same rate everywhere: every camera's first test.

use super::radial::AMPLITUDE;
use crate::catalogue::parameter::Values;
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use core::convert::Infallible;
use emitree::{Emission, Samples};
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "uniform",
    title: "The same everywhere",
    summary: "A volume of uniform emission; an image is the depth that it covers times \
              the amplitude.",
    source: "none: a test volume, whose image is exact",
    length_unit: "1",
    image_unit: "",
    energy_unit: None,
    parameters: &[AMPLITUDE],
    singular_points: nowhere,
    build: |values| Ok(std::sync::Arc::new(Uniform::from_values(values))),
};

/// g = amplitude, whatever the position and direction.
///
/// The integral along a line of sight is the amplitude times the length of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uniform {
    amplitude: f64,
}

impl Uniform {
    /// The volume with these parameters: `amplitude` or nothing.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for another parameter, or a negative amplitude.
    ///
    /// ```
    /// use emitree_models::models::Uniform;
    /// use std::collections::BTreeMap;
    ///
    /// let volume = Uniform::new(&BTreeMap::from([("amplitude".to_owned(), 2.5)]))?;
    /// assert_eq!(volume.rate(), 2.5);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Ok(Self::from_values(&DESCRIPTION.values(parameters)?))
    }

    fn from_values(values: &Values) -> Self {
        Self { amplitude: values.of(AMPLITUDE.name) }
    }

    /// The rate g.
    pub fn rate(&self) -> f64 {
        self.amplitude
    }
}

impl Emission for Uniform {
    type Error = Infallible;

    fn emission_rates(&self, _samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Infallible> {
        rates.fill(self.rate());
        Ok(())
    }
}
