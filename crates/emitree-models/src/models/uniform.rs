//! The same rate everywhere: every camera's first test.

use super::radial::AMPLITUDE;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::Values;
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::Scalar;
use emitree::Samples;
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
    jumps_move_with: &[],
    edges: nowhere,
    singular_points: nowhere,
    build: formula!(|values| Uniform::from_values(values)),
};

/// g = amplitude, whatever the position and direction.
///
/// The integral along a line of sight is the amplitude times the length of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uniform<T = f64> {
    amplitude: T,
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

    /// The rate g.
    pub fn rate(&self) -> f64 {
        self.amplitude
    }
}

impl<T: Scalar> Uniform<T> {
    fn from_values(values: &Values<T>) -> Self {
        Self { amplitude: values.of(AMPLITUDE.name) }
    }
}

impl<T: Scalar> Formula<T> for Uniform<T> {
    fn fill(&self, _samples: &Samples<'_>, rates: &mut [T]) {
        rates.fill(self.amplitude);
    }
}

emission_of_formula!(Uniform);
