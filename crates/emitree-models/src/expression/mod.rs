//! Emission rates written as an expression, as scenes do.
//!
//! # Language
//!
//! * Variables: `x`, `y`, `z`, the position in the scene's length unit; `r` = √(x² + y² + z²);
//!   `dx`, `dy`, `dz`, the unit vector of emission, from the point to the observer; `E`, the
//!   energy, in the unit of the scene's energy axis, or instead `t`, the time, where an axis of times is the third
//!   one ([`Expression::of_time`]). Constants have names of their own, and `pi` is
//!   3.14159….
//! * Numbers: `2`, `.5`, `1e-3`, `1_000`.
//! * Operators, the loosest first: `<` `<=` `>` `>=` `==` `!=` (1 where true, else 0; they do not
//!   chain), `+` `-`, `*` `/`, a leading `-`, and `^`, from the right: `-x^2` is −(x²) and `2^3^2`
//!   is 2⁹. Parentheses group.
//! * Functions: `if(condition, then, otherwise)`, `min` and `max` of two or more, `abs`, `sqrt`,
//!   `exp`, `ln`, `log10`, `sin`, `cos`, `tan`, `asin`, `acos`, `atan`, `atan2(y, x)`, `sinh`,
//!   `cosh`, `tanh`, `erf`, `floor`. Angles are in radians.
//!
//! Without an energy axis `E` is not a number. A scene refuses it then, at its
//! [place](Expression::energy_span). An expression without `E` is the same at all energies.
//!
//! `if` evaluates both branches and takes one: a value that is not a number in the other branch is
//! never seen, nor does it cost less. A condition holds where it is not 0. `min` and `max` ignore
//! an argument that is not a number, as IEEE 754-2008 has it.
//!
//! # Derivatives
//!
//! A [`DifferentiableExpression`] has the derivatives by its constants as well, which are parts of the same
//! graph.
//!
//! # Several expressions
//!
//! [`Expressions`] are several of the same constants, whose common parts are computed once.
//!
//! # Fields and tables
//!
//! With [`Inputs`] an expression has more variables, fields whose values are given for each sample, and
//! more functions, tables: those of a [`FieldExpression`].
//!
//! # Evaluation
//!
//! Text → graph in which equal parts are one node and constants are folded → tape of instructions
//! on a few registers → blocks of samples. Values are those of f64
//! arithmetic in the order written, but for xⁿ with an integer n up to 64, which is a product of
//! squares and differs by up to n/2 units in the last place. `exp`, `ln`, `log10`, `sin`, `cos` and
//! `^` are vectorised functions of our own, `sin` and `cos` within 2 units in the last place, the
//! others within 1: with the same bits on every machine. The other functions are the platform's, but
//! for `erf`.

mod derivative;
mod differentiable;
mod error;
mod evaluate;
mod field_expression;
mod graph;
mod inputs;
mod lanes;
mod lexer;
mod operation;
mod parser;
mod several;
mod tape;

pub use differentiable::DifferentiableExpression;
pub use error::{ExpressionError, FieldFailure};
pub use field_expression::FieldExpression;
pub use inputs::Inputs;
pub use several::Expressions;

use core::convert::Infallible;
use core::ops::Range;
use emitree::{Emission, Samples};
use std::collections::BTreeMap;
use tape::Tape;

/// An emission rate g given by an [expression](self), parsed once and evaluated in batches.
///
/// ```
/// use emitree::{Emission, Samples};
/// use emitree_models::Expression;
/// use std::collections::BTreeMap;
///
/// let constants = BTreeMap::from([("a".to_owned(), 100.0)]);
/// let glow = Expression::parse("exp(-a*((x-0.5)^2 + y^2 + z^2))", &constants)?;
/// let mut rates = [0.0; 2];
/// let samples = Samples::new(&[[0.5, 0.0, 0.0], [0.5, 0.1, 0.0]], &[[0.0, 0.0, 1.0]; 2]);
/// glow.emission_rates(&samples, &mut rates)?;
/// assert_eq!(rates[0], 1.0);
/// assert!((rates[1] - (-1.0_f64).exp()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Errors have their place and, where possible, what to write:
///
/// ```
/// # use emitree_models::Expression;
/// # use std::collections::BTreeMap;
/// let constants = BTreeMap::from([("alpha".to_owned(), 100.0)]);
/// let error = Expression::parse("exp(-aplha*x^2)", &constants).unwrap_err();
/// assert_eq!(error.message(), "unknown name `aplha`: did you mean `alpha`?");
/// assert_eq!(error.span(), 5..10);
/// assert_eq!(error.help(), Some("known: x, y, z, dx, dy, dz, E, r, pi, alpha"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    text: String,
    tape: Tape,
    unused_constants: Vec<String>,
    energy_span: Option<Range<usize>>,
}

impl Expression {
    /// Parses `text`, in which `constants` may be used by their names.
    ///
    /// # Errors
    ///
    /// [`ExpressionError`] if the text is not an expression of the [language](self), names
    /// something unknown, or is nested more than 128 deep; or if a constant is not finite or has
    /// the name of something else.
    pub fn parse(text: &str, constants: &BTreeMap<String, f64>) -> Result<Self, ExpressionError> {
        Self::with_inputs(text, constants, &Inputs::default())
    }

    /// Parses `text`, in which `t` is the time and there is no energy `E`: the energies of samples are times.
    ///
    /// ```
    /// use emitree::{Emission, Samples};
    /// use emitree_models::Expression;
    /// use std::collections::BTreeMap;
    ///
    /// let decay = Expression::of_time("exp(-t/30)", &BTreeMap::new())?;
    /// let mut rates = [0.0];
    /// let samples = Samples::new(&[[0.0; 3]], &[[0.0, 0.0, 1.0]]);
    /// decay.emission_rates(&samples.at_energies(&[60.0]), &mut rates)?;
    /// assert_eq!(rates[0], (-2.0_f64).exp());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`parse`](Self::parse).
    pub fn of_time(text: &str, constants: &BTreeMap<String, f64>) -> Result<Self, ExpressionError> {
        Self::with_inputs(text, constants, &Inputs::default().of_time())
    }

    fn with_inputs(
        text: &str,
        constants: &BTreeMap<String, f64>,
        inputs: &Inputs,
    ) -> Result<Self, ExpressionError> {
        let parsed = parser::parse(text, constants, &[], inputs)?;
        let unused = constants.keys().filter(|name| !parsed.used.contains(*name));
        Ok(Self {
            text: text.to_owned(),
            tape: Tape::new(&parsed.graph, &[parsed.root]),
            unused_constants: unused.cloned().collect(),
            energy_span: parsed.energy_span,
        })
    }

    /// The expression as it was given.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The constants that the expression does not name: likely a slip, but harmless.
    ///
    /// ```
    /// # use emitree_models::Expression;
    /// # use std::collections::BTreeMap;
    /// let constants = BTreeMap::from([("a".to_owned(), 1.0), ("b".to_owned(), 2.0)]);
    /// assert_eq!(Expression::parse("a*x", &constants)?.unused_constants(), ["b"]);
    /// # Ok::<(), emitree_models::ExpressionError>(())
    /// ```
    pub fn unused_constants(&self) -> &[String] {
        &self.unused_constants
    }

    /// The place of the first `E`, or of the first `t` where the time is the third axis, in bytes of the text; `None` if the expression does not name the
    /// energy, and so has no need of an energy axis.
    ///
    /// ```
    /// use emitree::{Emission, Samples};
    /// use emitree_models::Expression;
    /// use std::collections::BTreeMap;
    ///
    /// let line = Expression::parse("exp(-r^2)*exp(-((E - 0.57)/0.01)^2)", &BTreeMap::new())?;
    /// assert_eq!(line.energy_span(), Some(17..18));
    /// let mut rates = [0.0; 2];
    /// let samples = Samples::new(&[[0.0; 3]; 2], &[[0.0, 0.0, 1.0]; 2]);
    /// line.emission_rates(&samples.at_energies(&[0.57, 0.9]), &mut rates)?;
    /// assert_eq!(rates[0], 1.0);
    /// assert!(rates[1] < 1e-100);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn energy_span(&self) -> Option<Range<usize>> {
        self.energy_span.clone()
    }
}

impl Emission for Expression {
    type Error = Infallible;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Infallible> {
        evaluate::evaluate(&self.tape, samples, evaluate::Given::default(), &mut [rates]);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
