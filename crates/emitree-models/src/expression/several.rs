//! [`Expressions`]: several expressions of the same constants, evaluated together.

use super::error::ExpressionError;
use super::evaluate;
use super::graph::Graph;
use super::inputs::Inputs;
use super::parser;
use super::tape::Tape;
use emitree::Samples;
use std::collections::BTreeMap;

/// Several [expressions](super) of the same constants. A part that more than one of them has is computed once for
/// each sample.
///
/// ```
/// use emitree::Samples;
/// use emitree_models::expression::Expressions;
/// use std::collections::BTreeMap;
///
/// let constants = BTreeMap::from([("a".to_owned(), 2.0)]);
/// let both = Expressions::parse(&["exp(-a*x^2)", "y*exp(-a*x^2)"], &constants)?;
/// let samples = Samples::new(&[[0.0, 3.0, 0.0], [1.0, 4.0, 0.0]], &[[0.0, 0.0, 1.0]; 2]);
/// let mut rates = [0.0; 4];
/// both.rates(&samples, &mut rates);
/// let exponential = (-2.0_f64).exp();
/// assert_eq!(rates, [1.0, exponential, 3.0, 4.0 * exponential]);
/// # Ok::<(), emitree_models::ExpressionError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Expressions {
    texts: Vec<String>,
    tape: Tape,
}

impl Expressions {
    /// Parses `texts`, in each of which `constants` may be used by their names.
    ///
    /// # Errors
    ///
    /// [`ExpressionError`] of the first text that is refused, as of [`Expression::parse`](super::Expression::parse).
    pub fn parse<T: AsRef<str>>(
        texts: &[T],
        constants: &BTreeMap<String, f64>,
    ) -> Result<Self, ExpressionError> {
        Self::with_inputs(texts, constants, &Inputs::default())
    }

    /// Parses `texts`, in which `t` is the time and there is no energy `E`: the energies of samples are times.
    ///
    /// # Errors
    ///
    /// As [`parse`](Self::parse).
    pub fn of_time<T: AsRef<str>>(
        texts: &[T],
        constants: &BTreeMap<String, f64>,
    ) -> Result<Self, ExpressionError> {
        Self::with_inputs(texts, constants, &Inputs::default().of_time())
    }

    fn with_inputs<T: AsRef<str>>(
        texts: &[T],
        constants: &BTreeMap<String, f64>,
        inputs: &Inputs,
    ) -> Result<Self, ExpressionError> {
        let mut graph = Graph::default();
        let mut roots = Vec::with_capacity(texts.len());
        for text in texts {
            let parsed = parser::parse(text.as_ref(), constants, &[], inputs)?;
            roots.extend(graph.take_in(&parsed.graph, &[parsed.root], &[]));
        }
        let texts = texts.iter().map(|text| text.as_ref().to_owned()).collect();
        Ok(Self { texts, tape: Tape::new(&graph, &roots) })
    }

    /// The expressions as they were given.
    pub fn texts(&self) -> &[String] {
        &self.texts
    }

    /// Writes the rates of each expression at all n samples, one expression after the other. They are
    /// those of [`Expression`](super::Expression), to the last bit.
    ///
    /// # Panics
    ///
    /// If the length of `rates` is not n times the number of expressions.
    pub fn rates(&self, samples: &Samples<'_>, rates: &mut [f64]) {
        let n = samples.len();
        assert_eq!(rates.len(), n * self.texts.len(), "a rate for each sample and expression");
        if n == 0 {
            return;
        }
        let mut outputs: Vec<&mut [f64]> = rates.chunks_mut(n).collect();
        evaluate::evaluate(&self.tape, samples, evaluate::Given::default(), &mut outputs);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Expression;
    use super::*;
    use emitree::Emission;

    const TEXTS: [&str; 4] = [
        "a*exp(-(x - 0.3)^2 - y^2)*E",
        "if(x < y, exp(-y^2 - (x - 0.3)^2), max(r, z/y)) + dx*E^0.5",
        "0",
        "a",
    ];

    #[test]
    fn rates_have_the_bits_of_each_expression_alone() {
        let constants = BTreeMap::from([("a".to_owned(), 2.5)]);
        let all = Expressions::parse(&TEXTS, &constants).unwrap();
        assert_eq!(all.texts(), TEXTS);
        // Three blocks, the last of which is not full.
        let n: u32 = 600;
        let at = |i: u32| f64::from(i) / f64::from(n);
        let positions: Vec<[f64; 3]> =
            (0..n).map(|i| [at(i), 0.7 - at(i), at(i * i % n)]).collect();
        let directions: Vec<[f64; 3]> = (0..n).map(|i| [at(i), 0.0, 1.0]).collect();
        let energies: Vec<f64> = (0..n).map(|i| 0.1 + at(i)).collect();
        let samples = Samples::new(&positions, &directions).at_energies(&energies);
        let mut rates = vec![f64::NAN; 4 * positions.len()];
        all.rates(&samples, &mut rates);
        for (text, rates) in TEXTS.iter().zip(rates.chunks(positions.len())) {
            let mut alone = vec![f64::NAN; positions.len()];
            let of_text = BTreeMap::from([("a".to_owned(), 2.5)]);
            let expression = Expression::parse(text, &of_text).unwrap();
            expression.emission_rates(&samples, &mut alone).unwrap();
            let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(rates), bits(&alone), "{text}");
        }
    }

    #[test]
    fn common_parts_are_computed_once() {
        let constants = BTreeMap::new();
        let instructions =
            |texts: &[&str]| Expressions::parse(texts, &constants).unwrap().tape.instructions.len();
        let one = instructions(&["exp(-x^2 - y^2)"]);
        assert_eq!(instructions(&["exp(-x^2 - y^2)", "exp(-x^2 - y^2)"]), one);
        assert_eq!(instructions(&["exp(-x^2 - y^2)", "3*exp(-x^2 - y^2)"]), one + 1);
    }

    #[test]
    fn the_first_wrong_text_is_refused() {
        let error = Expressions::parse(&["x", "x +", "q"], &BTreeMap::new()).unwrap_err();
        assert!(error.message().contains("expected"), "{error}");
        let of_time = Expressions::of_time(&["t", "x*t"], &BTreeMap::new()).unwrap();
        let mut rates = [0.0; 2];
        let samples = Samples::new(&[[3.0, 0.0, 0.0]], &[[0.0, 0.0, 1.0]]);
        of_time.rates(&samples.at_energies(&[2.0]), &mut rates);
        assert_eq!(rates.map(f64::to_bits), [2.0_f64, 6.0].map(f64::to_bits));
    }
}
