//! What is wrong with a model's name or parameters.

use crate::spelling::did_you_mean;

/// A model that can't be built from its name and parameters.
///
/// ```
/// use emitree_models::build_model;
/// use std::collections::BTreeMap;
///
/// let error = build_model("cmen", &BTreeMap::new()).unwrap_err();
/// let message = error.to_string();
/// assert!(message.starts_with("unknown model `cmen`: did you mean `cmem`? (known: cmem, "));
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// There is no model of this name.
    #[error("unknown model `{name}`{} (known: {})", did_you_mean(*.suggestion), .known.join(", "))]
    UnknownModel {
        /// The name given.
        name: String,
        /// The model that was likely meant.
        suggestion: Option<&'static str>,
        /// All models.
        known: Vec<&'static str>,
    },
    /// The model has no parameter of this name.
    #[error(
        "model `{model}` has no parameter `{name}`{} (known: {})",
        did_you_mean(*.suggestion), .known.join(", ")
    )]
    UnknownParameter {
        /// The model.
        model: &'static str,
        /// The name given.
        name: String,
        /// The parameter that was likely meant.
        suggestion: Option<&'static str>,
        /// All parameters of the model.
        known: Vec<&'static str>,
    },
    /// A derivative by the same parameter is asked for twice.
    #[error(
        "parameter `{parameter}` of model `{model}` is differentiated by twice: expected each once"
    )]
    Repeated {
        /// The model.
        model: &'static str,
        /// The parameter.
        parameter: &'static str,
    },
    /// A parameter is not finite, or outside what the model accepts.
    #[error("parameter `{parameter}` of model `{model}` is {value:?}: expected {expected}")]
    OutOfRange {
        /// The model.
        model: &'static str,
        /// The parameter.
        parameter: &'static str,
        /// The value given.
        value: f64,
        /// What was expected.
        expected: String,
    },
    /// A parameter that was not given follows from the others as a value that makes no sense.
    #[error(
        "parameter `{parameter}` of model `{model}` is {value:?}, from its default {formula}: \
         expected {expected}; change what it depends on, or give `{parameter}` itself"
    )]
    DerivedOutOfRange {
        /// The model.
        model: &'static str,
        /// The parameter.
        parameter: &'static str,
        /// The value that follows.
        value: f64,
        /// The formula that it follows from.
        formula: &'static str,
        /// What was expected.
        expected: String,
    },
}
