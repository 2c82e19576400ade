//! A model's parameters as data: names, units, defaults, ranges; and their values.

use crate::scalar::{Dual, Scalar};
use core::fmt;

/// One parameter of a model.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ParameterDescription {
    /// The name in scenes.
    pub name: &'static str,
    /// The unit of its value, in the grammar of FITS; "1" if it has none.
    pub unit: &'static str,
    /// The value where none is given.
    pub default: ParameterDefault,
    /// What it is, in a few words.
    pub meaning: &'static str,
    /// Which values are accepted.
    pub range: AcceptedRange,
}

/// The value of a parameter that is not given. Its `Display` is the number or the formula.
#[derive(Clone, Copy, Debug)]
pub enum ParameterDefault {
    /// Always the same value.
    Value(f64),
    /// A value that follows from the parameters listed before it.
    Derived(Derivation),
}

impl fmt::Display for ParameterDefault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(value) => write!(f, "{value:?}"),
            Self::Derived(derivation) => f.write_str(derivation.formula()),
        }
    }
}

/// How a parameter follows from those listed before it, given or derived themselves.
#[derive(Clone, Copy, Debug)]
pub struct Derivation {
    pub(crate) formula: &'static str,
    pub(crate) value: DerivedValue,
}

/// The formula itself, of plain numbers and of dual ones; made by `derived!`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DerivedValue {
    pub(crate) plain: fn(&Values<f64>) -> f64,
    pub(crate) dual: fn(&Values<Dual>) -> Dual,
}

/// A [`DerivedValue`] of one formula of [`Values`] of any [`Scalar`].
macro_rules! derived {
    ($formula:expr) => {
        $crate::catalogue::parameter::DerivedValue { plain: $formula, dual: $formula }
    };
}
pub(crate) use derived;

impl Derivation {
    /// The formula for people to read, in terms of the other parameters' names.
    pub fn formula(&self) -> &'static str {
        self.formula
    }
}

/// The values that a parameter may have, all finite. Its `Display` completes "expected …".
///
/// ```
/// use emitree_models::catalogue::AcceptedRange;
///
/// assert!(AcceptedRange::Between(0.0, 1.0).contains(1.0));
/// assert!(!AcceptedRange::Positive.contains(0.0));
/// assert!(!AcceptedRange::Finite.contains(f64::INFINITY));
/// assert_eq!(AcceptedRange::NonNegative.to_string(), "a finite number, 0 or more");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AcceptedRange {
    /// Any finite number.
    Finite,
    /// More than 0.
    Positive,
    /// 0 or more.
    NonNegative,
    /// From the first to the second, both included.
    Between(f64, f64),
}

impl AcceptedRange {
    /// Whether the value is accepted.
    pub fn contains(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::Positive => value > 0.0,
                Self::NonNegative => value >= 0.0,
                Self::Between(low, high) => (low..=high).contains(&value),
            }
    }
}

impl fmt::Display for AcceptedRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finite => f.write_str("a finite number"),
            Self::Positive => f.write_str("a finite number more than 0"),
            Self::NonNegative => f.write_str("a finite number, 0 or more"),
            Self::Between(low, high) => write!(f, "a number from {low} to {high}"),
        }
    }
}

/// The values of all parameters of a model, in the order of its description.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Values<T = f64>(Vec<(&'static str, T)>);

impl<T: Scalar> Values<T> {
    pub(crate) fn with_capacity(parameters: usize) -> Self {
        Self(Vec::with_capacity(parameters))
    }

    pub(crate) fn push(&mut self, name: &'static str, value: T) {
        self.0.push((name, value));
    }

    /// The value of a parameter listed before; NaN, which no range accepts, for any other.
    pub(crate) fn of(&self, name: &str) -> T {
        let found = self.0.iter().find(|(known, _)| *known == name);
        found.map_or(T::of(f64::NAN), |&(_, value)| value)
    }

    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = (&'static str, T)> {
        self.0.iter().copied()
    }

    /// The same without derivatives.
    pub(crate) fn plain(&self) -> Values<f64> {
        Values(self.iter().map(|(name, value)| (name, value.value())).collect())
    }
}
