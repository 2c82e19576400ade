//! The built-in models by name: what there is, with which parameters, and how to build one.

mod differentiable;
pub(crate) mod edges;
mod error;
pub(crate) mod model;
pub(crate) mod parameter;
pub(crate) mod singular;

pub use differentiable::DifferentiableModel;
pub use edges::SphericalEdge;
pub use error::ModelError;
pub use model::{Model, ModelDescription};
pub use parameter::{AcceptedRange, Derivation, ParameterDefault, ParameterDescription};
pub use singular::SingularPoint;

use crate::models;
use crate::spelling::closest;
use std::collections::BTreeMap;

/// All models, one line each.
static CATALOGUE: [ModelDescription; 23] = [
    models::CMEM,
    models::JORGENSEN,
    models::GEOCORONA,
    models::CHAMBERLAIN,
    models::AIRGLOW,
    models::MARS_HYDROGEN,
    models::MARS_OXYGEN,
    models::ENA,
    models::ENA_RING,
    models::K_CORONA,
    models::K_CORONA_POLARISED,
    models::BETA_MODEL,
    models::BREMSSTRAHLUNG,
    models::NFW,
    models::NFW_DECAY,
    models::EINASTO,
    models::EINASTO_DECAY,
    models::BURKERT,
    models::BURKERT_DECAY,
    models::SHELL_NEBULA,
    models::POWER_LAW,
    models::UNIFORM,
    models::HOLMSTROM,
];

/// The descriptions of all built-in models.
///
/// ```
/// use emitree_models::catalogue;
///
/// for model in catalogue() {
///     println!("{}: {} [{}]", model.name, model.title, model.image_unit);
///     for parameter in model.parameters {
///         println!("    {} = {} {}", parameter.name, parameter.default, parameter.unit);
///     }
/// }
/// ```
pub fn catalogue() -> &'static [ModelDescription] {
    &CATALOGUE
}

/// The model of this name with these parameters, and defaults for the others.
///
/// # Errors
///
/// [`ModelError`] if there is no such model or parameter, or a value is not accepted.
///
/// ```
/// use emitree_models::build_model;
/// use std::collections::BTreeMap;
///
/// let model = build_model("cmem", &BTreeMap::from([("density".to_owned(), 10.0)]))?;
/// assert_eq!(model.description().image_unit, "keV cm-2 s-1 sr-1");
/// assert_eq!(model.parameter("density"), Some(10.0));
///
/// let error = build_model("cmem", &BTreeMap::from([("density".to_owned(), -1.0)])).unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "parameter `density` of model `cmem` is -1.0: expected a finite number more than 0",
/// );
/// # Ok::<(), emitree_models::ModelError>(())
/// ```
pub fn build_model(name: &str, parameters: &BTreeMap<String, f64>) -> Result<Model, ModelError> {
    Model::new(description(name)?, parameters)
}

/// The description of the model of this name.
fn description(name: &str) -> Result<&'static ModelDescription, ModelError> {
    CATALOGUE.iter().find(|description| description.name == name).ok_or_else(|| {
        let known: Vec<_> = CATALOGUE.iter().map(|description| description.name).collect();
        let suggestion = closest(name, known.iter().copied());
        ModelError::UnknownModel { name: name.to_owned(), suggestion, known }
    })
}

#[cfg(test)]
mod tests;
