//! A built-in model with its derivatives by some of its parameters.

use super::error::ModelError;
use super::model::{Formula, Model, ModelDescription};
use crate::scalar::Dual;
use crate::spelling::closest;
use emitree::{Emission, Samples};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A built-in [model](Model) with its derivatives by some of its parameters: exact but for rounding, by forward
/// differentiation of its formula.
///
/// A parameter that is not given and follows from others changes with them: the derivatives of `cmem` by
/// `density` contain those by the defaults of `A1` and `A2`.
///
/// # Jumps
///
/// Many models end at a surface, or jump at one. The derivatives are those of the smooth pieces, at every point
/// that is not on such a surface itself. Where the surface moves with a parameter, the derivative of an *image*
/// has another part, the jump times the speed of the surface, which no derivative of a rate contains:
/// [`moves_jumps`](Self::moves_jumps) has these parameters. Integrals of the derivatives are the derivatives of
/// integrals for all others.
///
/// ```
/// use emitree::Samples;
/// use emitree_models::DifferentiableModel;
/// use std::collections::BTreeMap;
///
/// let given = BTreeMap::from([("amplitude".to_owned(), 3.0), ("exponent".to_owned(), 2.5)]);
/// let by = ["amplitude", "exponent", "inner_radius"];
/// let wind = DifferentiableModel::new("power_law", &given, &by)?;
/// let samples = Samples::new(&[[4.0, 0.0, 0.0]], &[[0.0, 0.0, 1.0]]);
/// let (mut rates, mut derivatives) = ([0.0], [0.0; 3]);
/// wind.rates_and_derivatives(&samples, &mut rates, &mut derivatives);
/// assert!((rates[0] - 3.0 / 32.0).abs() < 1e-16); // 3 · 4^-2.5
/// assert!((derivatives[0] - 1.0 / 32.0).abs() < 1e-16);
/// assert!((derivatives[1] + 3.0 / 32.0 * 4.0_f64.ln()).abs() < 1e-15);
/// assert_eq!(derivatives[2], 0.0); // the surface moves, the rate beside it does not change
/// assert_eq!(wind.moves_jumps(), ["inner_radius"]);
/// # Ok::<(), emitree_models::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct DifferentiableModel {
    model: Model,
    by: Vec<&'static str>,
    /// The model over dual numbers, one for each parameter.
    formulas: Vec<Arc<dyn Formula<Dual>>>,
    moves_jumps: Vec<&'static str>,
}

/// Samples whose dual numbers are in memory at once.
const BATCH: usize = 4096;

impl DifferentiableModel {
    /// The model of this name with these parameters, and defaults for the others, to be differentiated by those
    /// named in `by`.
    ///
    /// # Errors
    ///
    /// [`ModelError`] as of [`build_model`](super::build_model), or if `by` has a name that is not one of the
    /// parameters, or twice the same.
    pub fn new<N: AsRef<str>>(
        name: &str,
        parameters: &BTreeMap<String, f64>,
        by: &[N],
    ) -> Result<Self, ModelError> {
        let description = super::description(name)?;
        let model = Model::new(description, parameters)?;
        let by = checked(description, by)?;
        let (mut formulas, mut moves_jumps) = (Vec::with_capacity(by.len()), Vec::new());
        for &name in &by {
            let given = seeded(&model, parameters, name);
            let values = description.dual_values(&given)?;
            let moves = |name: &&str| values.of(name).derivative != 0.0;
            if description.jumps_move_with.iter().any(moves) {
                moves_jumps.push(name);
            }
            formulas.push((description.build.dual)(&values)?);
        }
        Ok(Self { model, by, formulas, moves_jumps })
    }

    /// The model itself.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The names of the parameters, in the order of the derivatives.
    pub fn parameters(&self) -> &[&'static str] {
        &self.by
    }

    /// Those of the parameters with which a surface moves at which the rate may jump: the derivative of an image
    /// by them is not the image of the derivatives.
    pub fn moves_jumps(&self) -> &[&'static str] {
        &self.moves_jumps
    }

    /// Writes the rate of each of n samples to `rates`, and the derivative by parameter k at sample i to
    /// `derivatives[k n + i]`, in the unit of the rates over that of the parameter. The rates are those of the
    /// [model](Self::model), to the last bit.
    ///
    /// The derivatives at a point at which the rate is infinite may be no numbers.
    ///
    /// # Panics
    ///
    /// If the lengths are not n, the number of samples, and n times that of the parameters.
    pub fn rates_and_derivatives(
        &self,
        samples: &Samples<'_>,
        rates: &mut [f64],
        derivatives: &mut [f64],
    ) {
        let n = samples.len();
        assert_eq!(rates.len(), n, "a rate for each sample");
        let expected = n * self.by.len();
        assert_eq!(derivatives.len(), expected, "a derivative for each parameter and sample");
        let Ok(()) = self.model.emission_rates(samples, rates);
        let mut duals = vec![Dual { value: 0.0, derivative: 0.0 }; n.min(BATCH)];
        for (k, formula) in self.formulas.iter().enumerate() {
            for from in (0..n).step_by(BATCH) {
                let to = n.min(from + BATCH);
                let duals = &mut duals[..to - from];
                formula.fill(&part(samples, from, to), duals);
                let derivatives = &mut derivatives[k * n + from..k * n + to];
                for (derivative, dual) in derivatives.iter_mut().zip(&*duals) {
                    *derivative = dual.derivative;
                }
            }
        }
    }
}

/// The parameters of these names, each once.
fn checked<N: AsRef<str>>(
    description: &'static ModelDescription,
    names: &[N],
) -> Result<Vec<&'static str>, ModelError> {
    let known = || description.parameters.iter().map(|parameter| parameter.name);
    let mut found = Vec::with_capacity(names.len());
    for name in names {
        let name = name.as_ref();
        let Some(parameter) = known().find(|known| *known == name) else {
            return Err(ModelError::UnknownParameter {
                model: description.name,
                name: name.to_owned(),
                suggestion: closest(name, known()),
                known: known().collect(),
            });
        };
        if found.contains(&parameter) {
            return Err(ModelError::Repeated { model: description.name, parameter });
        }
        found.push(parameter);
    }
    Ok(found)
}

/// The given parameters and one to be differentiated by, as dual numbers.
fn seeded(model: &Model, given: &BTreeMap<String, f64>, by: &str) -> BTreeMap<String, Dual> {
    let constant =
        |(name, &value): (&String, &f64)| (name.clone(), Dual { value, derivative: 0.0 });
    let mut duals: BTreeMap<String, Dual> = given.iter().map(constant).collect();
    if let Some(value) = model.parameter(by) {
        duals.insert(by.to_owned(), Dual { value, derivative: 1.0 });
    }
    duals
}

/// Some of the samples.
fn part<'a>(samples: &Samples<'a>, from: usize, to: usize) -> Samples<'a> {
    let part = Samples::new(&samples.positions()[from..to], &samples.directions()[from..to]);
    match samples.energies() {
        [] => part,
        energies => part.at_energies(&energies[from..to]),
    }
}
