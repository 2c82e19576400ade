//! An expression with its derivatives by some of its constants.

use super::derivative::derivatives;
use super::error::{ExpressionError, FieldFailure};
use super::evaluate;
use super::inputs::Inputs;
use super::parser;
use super::tape::Tape;
use emitree::Samples;
use std::collections::BTreeMap;

/// An [expression](super) with its derivatives by some of its constants: exact but for rounding, by forward
/// differentiation of the whole expression.
///
/// At a kink the derivative is that of one side: `abs` has that of its argument where this is 0, `min` and
/// `max` that of their first argument where both are equal, `if` that of the branch that it takes. `floor` and
/// comparisons have the derivative 0, also where they jump: an image whose edge moves with a constant has a
/// derivative at the edge that these do not contain. A root of 0 has the derivative 0 where its argument has,
/// and is infinite elsewhere.
///
/// ```
/// use emitree::Samples;
/// use emitree_models::DifferentiableExpression;
/// use std::collections::BTreeMap;
///
/// let constants = BTreeMap::from([("a".to_owned(), 2.0), ("b".to_owned(), 3.0)]);
/// let glow = DifferentiableExpression::parse("b*exp(-a*x^2)", &constants, &["a", "b"])?;
/// let samples = Samples::new(&[[0.5, 0.0, 0.0]], &[[0.0, 0.0, 1.0]]);
/// let (mut rates, mut derivatives) = ([0.0], [0.0; 2]);
/// glow.rates_and_derivatives(&samples, &mut rates, &mut derivatives);
/// let peak = (-0.5_f64).exp();
/// assert!((rates[0] - 3.0 * peak).abs() < 1e-15);
/// assert!((derivatives[0] + 3.0 * 0.25 * peak).abs() < 1e-15);
/// assert!((derivatives[1] - peak).abs() < 1e-15);
/// # Ok::<(), emitree_models::ExpressionError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DifferentiableExpression {
    tape: Tape,
    constants: Vec<String>,
    inputs: Inputs,
    has_energy: bool,
}

impl DifferentiableExpression {
    /// Parses `text` with `constants`, to be differentiated by those named in `by`.
    ///
    /// # Errors
    ///
    /// [`ExpressionError`] as of [`Expression::parse`](super::Expression::parse), or if `by` has a name that is
    /// not one of the constants, or twice the same.
    pub fn parse<N: AsRef<str>>(
        text: &str,
        constants: &BTreeMap<String, f64>,
        by: &[N],
    ) -> Result<Self, ExpressionError> {
        Self::with_inputs(text, constants, by, &Inputs::default())
    }

    /// As [`parse`](Self::parse), with fields and tables: see [`Inputs`].
    ///
    /// # Errors
    ///
    /// As of [`parse`](Self::parse), or if a field or a table has the name of something else.
    pub fn with_inputs<N: AsRef<str>>(
        text: &str,
        constants: &BTreeMap<String, f64>,
        by: &[N],
        inputs: &Inputs,
    ) -> Result<Self, ExpressionError> {
        let by: Vec<String> = by.iter().map(|name| name.as_ref().to_owned()).collect();
        let mut values = Vec::with_capacity(by.len());
        for (number, name) in by.iter().enumerate() {
            let refuse = |why: &str| ExpressionError::new(format!("`{name}` {why}"), 0..0);
            let Some(value) = constants.get(name) else {
                let known: Vec<&str> = constants.keys().map(String::as_str).collect();
                let error = refuse("is not a constant of the expression");
                return Err(error.with_help(format!("constants: {}", known.join(", "))));
            };
            if by[..number].contains(name) {
                return Err(refuse("is differentiated by twice: expected each constant once"));
            }
            values.push(*value);
        }
        let mut parsed = parser::parse(text, constants, &by, inputs)?;
        let has_energy = parsed.energy_span.is_some();
        let of_root = derivatives(&mut parsed.graph, parsed.root, by.len());
        let roots: Vec<_> = core::iter::once(parsed.root).chain(of_root).collect();
        let (graph, roots) = parsed.graph.with_values(&roots, &values);
        let (tape, inputs) = (Tape::new(&graph, &roots), inputs.clone());
        Ok(Self { tape, constants: by, inputs, has_energy })
    }

    /// Whether it has the energy `E`: without energies its rates are not numbers then.
    pub fn has_energy(&self) -> bool {
        self.has_energy
    }

    /// The names of its fields, in the order of their values.
    pub fn fields(&self) -> &[String] {
        self.inputs.fields()
    }

    /// The names of the constants, in the order of the derivatives.
    pub fn constants(&self) -> &[String] {
        &self.constants
    }

    /// Writes the rates (n), and the derivatives by each constant, one after the other (constants, n). The rates
    /// are those of [`Expression`](super::Expression), to the last bit.
    ///
    /// # Panics
    ///
    /// If the lengths are not n, the number of samples, and n times that of the constants, or if the expression
    /// has fields.
    pub fn rates_and_derivatives(
        &self,
        samples: &Samples<'_>,
        rates: &mut [f64],
        derivatives: &mut [f64],
    ) {
        self.evaluate(samples, &[], rates, derivatives);
    }

    /// As [`rates_and_derivatives`](Self::rates_and_derivatives), with the values of each field at all samples.
    /// The derivatives of a table are those of its interpolant.
    ///
    /// # Errors
    ///
    /// [`FieldFailure::Table`] if a rate is not a number and an argument of a table is outside of it.
    ///
    /// # Panics
    ///
    /// If there is not one list of n values for each field, or as `rates_and_derivatives`.
    pub fn rates_and_derivatives_of(
        &self,
        samples: &Samples<'_>,
        fields: &[&[f64]],
        rates: &mut [f64],
        derivatives: &mut [f64],
    ) -> Result<(), FieldFailure> {
        self.evaluate(samples, fields, rates, derivatives);
        let given = evaluate::Given::new(&self.inputs, fields);
        evaluate::check(&self.tape, samples, given, rates)
    }

    fn evaluate(
        &self,
        samples: &Samples<'_>,
        fields: &[&[f64]],
        rates: &mut [f64],
        derivatives: &mut [f64],
    ) {
        let n = samples.len();
        assert_eq!(rates.len(), n, "a rate for each sample");
        assert_eq!(fields.len(), self.inputs.fields().len(), "the values of each field");
        assert!(fields.iter().all(|values| values.len() == n), "a value for each field and sample");
        let expected = n * self.constants.len();
        assert_eq!(derivatives.len(), expected, "a derivative for each constant and sample");
        let mut outputs = vec![rates];
        if n > 0 {
            outputs.extend(derivatives.chunks_mut(n));
        }
        let given = evaluate::Given::new(&self.inputs, fields);
        evaluate::evaluate(&self.tape, samples, given, &mut outputs);
    }
}

#[cfg(test)]
mod tests;
