//! A built-in model: its description, and the model itself with its parameters.

use super::edges::SphericalEdge;
use super::error::ModelError;
use super::parameter::{Derivation, ParameterDefault, ParameterDescription, Values};
use super::singular::SingularPoint;
use crate::scalar::{Dual, Scalar};
use crate::spelling::closest;
use core::convert::Infallible;
use core::fmt;
use emitree::{Emission, Samples};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a model computes, in which units, from which parameters, and who published it.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ModelDescription {
    /// The name in scenes.
    pub name: &'static str,
    /// A title of a few words.
    pub title: &'static str,
    /// What it is, in one sentence.
    pub summary: &'static str,
    /// Where it was published.
    pub source: &'static str,
    /// The length unit of its positions, and of the line-of-sight integral; "1" if it has none.
    pub length_unit: &'static str,
    /// The unit of an image of it, in the grammar of FITS; empty if it has none.
    pub image_unit: &'static str,
    /// The unit of the energies that its rate depends on, in the grammar of FITS; `None` if it has
    /// no energy: with an energy axis it has the same rate per unit of energy everywhere on it.
    pub energy_unit: Option<&'static str>,
    /// Its parameters; those with a derived default after the ones that they derive from.
    pub parameters: &'static [ParameterDescription],
    /// Parameters that surfaces depend on at which the rate jumps.
    pub(crate) jumps_move_with: &'static [&'static str],
    pub(crate) edges: fn(&Values) -> Vec<SphericalEdge>,
    pub(crate) singular_points: fn(&Values) -> Vec<SingularPoint>,
    pub(crate) build: Build,
}

/// The formula of a model, or what is wrong with its parameters.
type Built<T> = Result<Arc<dyn Formula<T>>, ModelError>;

/// How a model is made of its parameters: over plain numbers and over dual ones; made by
/// `formula!`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Build {
    pub(crate) plain: fn(&Values<f64>) -> Built<f64>,
    pub(crate) dual: fn(&Values<Dual>) -> Built<Dual>,
}

/// A [`Build`] of one function from [`Values`] of any [`Scalar`] to a [`Formula`] or an error.
macro_rules! formula {
    (|$values:ident| $model:expr) => {
        $crate::catalogue::model::Build {
            plain: |$values| Ok(std::sync::Arc::new($model)),
            dual: |$values| Ok(std::sync::Arc::new($model)),
        }
    };
}
pub(crate) use formula;

impl ModelDescription {
    /// Whether the rate depends on the energy, so that a scene needs an energy axis.
    ///
    /// ```
    /// use emitree_models::catalogue;
    ///
    /// let spectral = catalogue().iter().filter(|model| model.needs_energy());
    /// assert!(spectral.map(|model| model.name).eq(["ena_ring", "bremsstrahlung"]));
    /// ```
    pub fn needs_energy(&self) -> bool {
        self.energy_unit.is_some()
    }

    /// The values of all parameters: as given, else their defaults.
    pub(crate) fn values(&self, given: &BTreeMap<String, f64>) -> Result<Values, ModelError> {
        self.values_of(given, |derivation, values| (derivation.value.plain)(values))
    }

    /// The same with derivatives.
    pub(crate) fn dual_values(
        &self,
        given: &BTreeMap<String, Dual>,
    ) -> Result<Values<Dual>, ModelError> {
        self.values_of(given, |derivation, values| (derivation.value.dual)(values))
    }

    fn values_of<T: Scalar>(
        &self,
        given: &BTreeMap<String, T>,
        derived: fn(&Derivation, &Values<T>) -> T,
    ) -> Result<Values<T>, ModelError> {
        let known = || self.parameters.iter().map(|parameter| parameter.name);
        if let Some(name) = given.keys().find(|name| known().all(|known| known != *name)) {
            return Err(ModelError::UnknownParameter {
                model: self.name,
                name: name.clone(),
                suggestion: closest(name, known()),
                known: known().collect(),
            });
        }
        let mut values = Values::with_capacity(self.parameters.len());
        for parameter in self.parameters {
            let (value, formula) = match (given.get(parameter.name), parameter.default) {
                (Some(&value), _) => (value, None),
                (None, ParameterDefault::Value(value)) => (T::of(value), None),
                (None, ParameterDefault::Derived(derivation)) => {
                    (derived(&derivation, &values), Some(derivation.formula))
                }
            };
            if !parameter.range.contains(value.value()) {
                let number = value.value();
                let expected = parameter.range.to_string();
                let Some(formula) = formula else {
                    return Err(self.out_of_range(parameter.name, number, expected));
                };
                return Err(ModelError::DerivedOutOfRange {
                    model: self.name,
                    parameter: parameter.name,
                    value: number,
                    formula,
                    expected,
                });
            }
            values.push(parameter.name, value);
        }
        Ok(values)
    }

    /// The error for a parameter whose value does not go with the others.
    pub(crate) fn out_of_range(
        &self,
        parameter: &'static str,
        value: f64,
        expected: String,
    ) -> ModelError {
        ModelError::OutOfRange { model: self.name, parameter, value, expected }
    }
}

/// The rates of a model over numbers of one kind.
pub(crate) trait Formula<T>: fmt::Debug + Send + Sync {
    /// Writes the rate of each sample to `rates`.
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]);
}

/// A built-in model with values for all its parameters, made by [`build_model`](super::build_model).
///
/// Clones share the model and cost next to nothing.
#[derive(Clone, Debug)]
pub struct Model {
    description: &'static ModelDescription,
    values: Values,
    formula: Arc<dyn Formula<f64>>,
}

impl Model {
    pub(super) fn new(
        description: &'static ModelDescription,
        parameters: &BTreeMap<String, f64>,
    ) -> Result<Self, ModelError> {
        let values = description.values(parameters)?;
        let formula = (description.build.plain)(&values)?;
        Ok(Self { description, values, formula })
    }

    /// What the model is.
    pub fn description(&self) -> &'static ModelDescription {
        self.description
    }

    /// Whether the rate depends on the energy: it then is one per unit of energy, and not a number
    /// for samples without.
    ///
    /// ```
    /// use emitree_models::build_model;
    /// use std::collections::BTreeMap;
    ///
    /// let needs_energy = |name| build_model(name, &BTreeMap::new()).map(|m| m.needs_energy());
    /// assert!(needs_energy("bremsstrahlung")?);
    /// assert!(!needs_energy("beta_model")?);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn needs_energy(&self) -> bool {
        self.description.needs_energy()
    }

    /// The points at which the rate is infinite or has a sharp peak, for these parameters; most models
    /// have none.
    ///
    /// Everywhere else the rate is finite, except that a square of the distance from such a point may
    /// be below the smallest number.
    pub fn singular_points(&self) -> Vec<SingularPoint> {
        (self.description.singular_points)(&self.values)
    }

    /// The spheres on which the rate jumps or has a kink, for these parameters, as far as they are known: surfaces of
    /// other forms are not declared.
    pub fn edges(&self) -> Vec<SphericalEdge> {
        (self.description.edges)(&self.values)
    }

    /// The names and values of all parameters, given or not, in the order of the description.
    pub fn parameters(&self) -> impl ExactSizeIterator<Item = (&'static str, f64)> {
        self.values.iter()
    }

    /// The value of one parameter, given or not; `None` if the model has no such parameter.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters().find(|(known, _)| *known == name).map(|(_, value)| value)
    }
}

impl Emission for Model {
    type Error = Infallible;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Infallible> {
        self.formula.fill(samples, rates);
        Ok(())
    }
}
