//! [`FieldExpression`]: an emission of several gridded fields and of tables, by one expression.

use super::error::{ExpressionError, FieldFailure};
use super::evaluate;
use super::inputs::Inputs;
use super::parser;
use super::tape::Tape;
use crate::grid::{Grid, GridAxes, Locations, Outside};
use crate::table::Table;
use core::ops::Range;
use emitree::{Emission, Samples};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Samples whose fields are interpolated at once: their cells and values stay in a fast cache.
const CHUNK: usize = 1024;

/// An emission rate g that is an [expression](super) of fields, such as a density and a temperature, and of
/// tables, such as an emissivity against temperature.
///
/// A field is a [`Grid`], interpolated at the point as the grid is by itself; a [`Table`] is a function. Outside of
/// a field with [`Outside::Zero`] the rate is 0, whatever the expression: the data end there. Outside of one with
/// [`Outside::Error`] it is an error. Fields on the same axes search the cell of a point once.
///
/// ```
/// use emitree::{Emission, Samples};
/// use emitree_models::table::{Table, TableAxis};
/// use emitree_models::{FieldExpression, Grid};
/// use std::collections::BTreeMap;
///
/// let nodes = || [vec![0.0, 1.0], vec![0.0, 1.0], vec![0.0, 1.0]];
/// let n = Grid::new(nodes(), vec![2.0; 8])?;
/// let t = Grid::new(nodes(), [1.0, 3.0].repeat(4))?; // 1 + 2 x
/// let cooling = Table::new(vec![TableAxis::new("T", vec![0.0, 4.0])], vec![0.0, 8.0])?; // 2 T
///
/// let fields = vec![("n".to_owned(), n), ("T".to_owned(), t)];
/// let tables = vec![("Lambda".to_owned(), cooling)];
/// let glow = FieldExpression::parse("n^2*Lambda(T)", &BTreeMap::new(), fields, tables)?;
/// let mut rates = [0.0; 2];
/// let samples = Samples::new(&[[0.5, 0.5, 0.5], [2.0, 0.5, 0.5]], &[[0.0, 0.0, 1.0]; 2]);
/// glow.emission_rates(&samples, &mut rates)?;
/// assert_eq!(rates, [4.0 * 2.0 * 2.0, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FieldExpression {
    text: String,
    tape: Tape,
    inputs: Inputs,
    /// In the order of the inputs' names.
    fields: Vec<Grid>,
    /// For each field the first one with the same axes.
    same_axes: Vec<usize>,
    unused: Vec<String>,
    energy_span: Option<Range<usize>>,
}

impl FieldExpression {
    /// Parses `text`, in which constants, fields and tables may be used by their names.
    ///
    /// # Errors
    ///
    /// [`ExpressionError`] as of [`Expression::parse`](super::Expression::parse), or if a field or a table has the
    /// name of something else, or a table another number of arguments.
    pub fn parse(
        text: &str,
        constants: &BTreeMap<String, f64>,
        fields: Vec<(String, Grid)>,
        tables: Vec<(String, Table)>,
    ) -> Result<Self, ExpressionError> {
        Self::with_third_axis(text, constants, fields, tables, false)
    }

    /// Parses `text`, in which `t` is the time and there is no energy `E`: the energies of samples are times.
    ///
    /// # Errors
    ///
    /// As [`parse`](Self::parse).
    pub fn of_time(
        text: &str,
        constants: &BTreeMap<String, f64>,
        fields: Vec<(String, Grid)>,
        tables: Vec<(String, Table)>,
    ) -> Result<Self, ExpressionError> {
        Self::with_third_axis(text, constants, fields, tables, true)
    }

    fn with_third_axis(
        text: &str,
        constants: &BTreeMap<String, f64>,
        fields: Vec<(String, Grid)>,
        tables: Vec<(String, Table)>,
        is_of_time: bool,
    ) -> Result<Self, ExpressionError> {
        let (names, fields): (Vec<String>, Vec<Grid>) = fields.into_iter().unzip();
        let tables = tables.into_iter().map(|(name, table)| (name, Arc::new(table))).collect();
        let inputs = Inputs::new(names, tables);
        let inputs = if is_of_time { inputs.of_time() } else { inputs };
        let parsed = parser::parse(text, constants, &[], &inputs)?;
        let names = constants.keys().map(String::as_str).chain(inputs.names());
        let unused = names.filter(|&name| !parsed.used.contains(name)).map(str::to_owned).collect();
        let first_like = |field: &Grid| {
            let is_same = |other: &Grid| other.axes() == field.axes();
            fields.iter().position(is_same).unwrap_or_default()
        };
        Ok(Self {
            text: text.to_owned(),
            tape: Tape::new(&parsed.graph, &[parsed.root]),
            same_axes: fields.iter().map(first_like).collect(),
            inputs,
            fields,
            unused,
            energy_span: parsed.energy_span,
        })
    }

    /// The expression as it was given.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The constants, fields and tables that the expression does not name.
    pub fn unused_names(&self) -> &[String] {
        &self.unused
    }

    /// The place of the first `E`: see [`Expression::energy_span`](super::Expression::energy_span).
    pub fn energy_span(&self) -> Option<Range<usize>> {
        self.energy_span.clone()
    }

    /// The fields by their names.
    pub fn fields(&self) -> impl Iterator<Item = (&str, &Grid)> {
        self.inputs.fields().iter().map(String::as_str).zip(&self.fields)
    }

    /// The axes of each field outside of which the rate is 0.
    pub fn data_axes(&self) -> impl Iterator<Item = &GridAxes> {
        let own = self.fields.iter().enumerate().filter(|(number, _)| {
            let is_first = self.same_axes[*number] == *number;
            let is_zero = |other: usize| self.fields[other].outside() == Outside::Zero;
            let same = |other: &usize| self.same_axes[*other] == *number;
            is_first && (0..self.fields.len()).filter(same).any(is_zero)
        });
        own.map(|(_, field)| field.axes())
    }

    /// Rates at few samples, and the buffers that they need.
    fn rates_of_chunk(
        &self,
        samples: &Samples<'_>,
        buffers: &mut Buffers,
        rates: &mut [f64],
    ) -> Result<(), FieldFailure> {
        let n = samples.len();
        let Buffers { locations, values, is_outside } = buffers;
        is_outside.clear();
        is_outside.resize(n, false);
        for (number, field) in self.fields.iter().enumerate() {
            let first = self.same_axes[number];
            if first == number {
                locations[number].find(field.axes(), samples.positions());
            }
            let at = &locations[first];
            let are_inside = at.are_inside();
            if let Some(place) = are_inside.iter().position(|is_inside| !is_inside) {
                if field.outside() == Outside::Error {
                    let cause = field.axes().outside(samples.positions()[place]);
                    let field = self.inputs.fields()[number].clone();
                    return Err(FieldFailure::Field { field, cause });
                }
                for (is_outside, is_inside) in is_outside.iter_mut().zip(are_inside) {
                    *is_outside |= !is_inside;
                }
            }
            field.values_in(at, 0.0, &mut values[number][..n]);
        }
        let fields: Vec<&[f64]> = values.iter().map(|values| &values[..n]).collect();
        let given = evaluate::Given::new(&self.inputs, &fields);
        evaluate::evaluate(&self.tape, samples, given, &mut [&mut rates[..]]);
        for (rate, _) in rates.iter_mut().zip(is_outside).filter(|(_, is_outside)| **is_outside) {
            *rate = 0.0;
        }
        evaluate::check(&self.tape, samples, given, rates)
    }
}

/// What is calculated of each field.
struct Buffers {
    /// The cells of all samples, for the first of the fields with the same axes.
    locations: Vec<Locations>,
    values: Vec<Vec<f64>>,
    /// Whether a sample is outside of one of the fields.
    is_outside: Vec<bool>,
}

impl Emission for FieldExpression {
    type Error = FieldFailure;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), FieldFailure> {
        let (count, n) = (self.fields.len(), samples.len().min(CHUNK));
        let mut buffers = Buffers {
            locations: (0..count).map(|_| Locations::default()).collect(),
            values: vec![vec![0.0; n]; count],
            is_outside: Vec::with_capacity(n),
        };
        let chunks = samples.positions().chunks(CHUNK).zip(samples.directions().chunks(CHUNK));
        // A batch without energies has none in any chunk.
        let energies = samples.energies().chunks(CHUNK).chain(core::iter::repeat(&[][..]));
        let rates = rates.chunks_mut(CHUNK);
        for (((positions, directions), energies), rates) in chunks.zip(energies).zip(rates) {
            let chunk = Samples::new(positions, directions).at_energies(energies);
            self.rates_of_chunk(&chunk, &mut buffers, rates)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
