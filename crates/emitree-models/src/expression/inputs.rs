//! [`Inputs`]: what an expression may name besides its constants.

use super::error::ExpressionError;
use super::lexer::is_name;
use super::operation::{ThirdAxis, function};
use crate::table::Table;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What an expression may name besides its constants: fields, whose values are given for each sample, and
/// tables, which are functions.
///
/// ```
/// use emitree::Samples;
/// use emitree_models::expression::{DifferentiableExpression, Inputs};
/// use std::collections::BTreeMap;
///
/// let inputs = Inputs::new(vec!["n".to_owned()], Vec::new());
/// let constants = BTreeMap::from([("a".to_owned(), 3.0)]);
/// let squares = DifferentiableExpression::with_inputs("a*n^2", &constants, &["a"], &inputs)?;
/// let samples = Samples::new(&[[0.0; 3]; 2], &[[0.0, 0.0, 1.0]; 2]);
/// let (mut rates, mut derivatives) = ([0.0; 2], [0.0; 2]);
/// squares.rates_and_derivatives_of(&samples, &[&[1.0, 2.0]], &mut rates, &mut derivatives)?;
/// assert_eq!((rates, derivatives), ([3.0, 12.0], [1.0, 4.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    fields: Vec<String>,
    tables: Vec<(String, Arc<Table>)>,
    third_axis: ThirdAxis,
}

impl Inputs {
    /// Fields by their names, in the order in which their values are given, and tables by theirs.
    pub fn new(fields: Vec<String>, tables: Vec<(String, Arc<Table>)>) -> Self {
        Self { fields, tables, third_axis: ThirdAxis::Energy }
    }

    /// The same of an expression that depends on the time `t` instead of the energy `E`: samples have times as
    /// their energies.
    #[must_use]
    pub fn of_time(self) -> Self {
        Self { third_axis: ThirdAxis::Time, ..self }
    }

    /// What the third axis is called.
    pub(super) fn third_axis(&self) -> ThirdAxis {
        self.third_axis
    }

    /// The names of the fields.
    pub fn fields(&self) -> &[String] {
        &self.fields
    }

    /// The tables by their names.
    pub fn tables(&self) -> &[(String, Arc<Table>)] {
        &self.tables
    }

    /// The place of a field.
    pub(super) fn field(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|field| field == name)
    }

    /// The place of a table, and the table.
    pub(super) fn table(&self, name: &str) -> Option<(usize, &Table)> {
        let place = self.tables.iter().position(|(table, _)| table == name)?;
        Some((place, &self.tables[place].1))
    }

    /// The names of fields, then of tables.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        let tables = self.tables.iter().map(|(name, _)| name.as_str());
        self.fields.iter().map(String::as_str).chain(tables)
    }
}

/// Refuses names that could not be written or would hide something else, and constants that are not finite.
pub(super) fn check_names(
    constants: &BTreeMap<String, f64>,
    inputs: &Inputs,
) -> Result<(), ExpressionError> {
    let refuse = |what: &str, name: &str, fault: &str| {
        Err(ExpressionError::new(format!("the {what} `{name}` {fault}"), 0..0))
    };
    for (name, value) in constants {
        if let Some(fault) = fault_of(name, inputs.third_axis) {
            return refuse("constant", name, fault);
        }
        if !value.is_finite() {
            return refuse("constant", name, "is not a finite number");
        }
    }
    for (place, name) in inputs.names().enumerate() {
        let what = if place < inputs.fields.len() { "field" } else { "table" };
        if let Some(fault) = fault_of(name, inputs.third_axis) {
            return refuse(what, name, fault);
        }
        if constants.contains_key(name) {
            return refuse(what, name, "has the name of a constant");
        }
        if inputs.names().take(place).any(|before| before == name) {
            return refuse(what, name, "has the name of another field or table");
        }
    }
    Ok(())
}

/// What is wrong with a name.
fn fault_of(name: &str, third_axis: ThirdAxis) -> Option<&'static str> {
    Some(if !is_name(name) {
        "is not a name: expected letters, digits and underscores, a digit not first"
    } else if name == "E" {
        "has a reserved name: `E` is the energy"
    } else if name == "t" && third_axis == ThirdAxis::Time {
        "has a reserved name: `t` is the time"
    } else if function(name).is_some() {
        "has the name of a function"
    } else if name == "pi" {
        "has the name of the number pi"
    } else if name == "r" || third_axis.variables().any(|(variable, _)| variable == name) {
        "has the name of a variable"
    } else {
        return None;
    })
}
