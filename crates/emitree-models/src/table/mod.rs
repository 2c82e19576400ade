//! Functions of one to three numbers from a table, such as an emissivity against temperature.
//!
//! A [`Table`] has values at the nodes of its axes, every combination of which it needs. In between it is
//! linear along each axis, in the coordinate or in its logarithm, and in the value or in its logarithm.
//! [`FieldExpression`](crate::FieldExpression) has tables as functions.

mod error;

pub use error::{OutsideTable, TableError};

use crate::elementary;
use crate::grid::axis::{Axis, Flaw, Location, flaw, is_descending};
use core::fmt;

/// What a table is beyond the outermost nodes of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BeyondTable {
    /// An argument there is an error, [`OutsideTable`], wherever a rate depends on it.
    #[default]
    Error,
    /// The value is 0 there.
    Zero,
    /// The value is that of the nearest node along the axis.
    Edge,
}

/// An axis of a table: an argument of the function.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TableAxis {
    /// Its name, for messages.
    pub name: String,
    /// At least two finite numbers that all increase or all decrease.
    pub nodes: Vec<f64>,
    /// Whether the table is interpolated in the logarithm of the argument.
    pub is_logarithmic: bool,
}

impl TableAxis {
    /// An axis that is interpolated in the argument itself.
    pub fn new(name: impl Into<String>, nodes: Vec<f64>) -> Self {
        Self { name: name.into(), nodes, is_logarithmic: false }
    }

    /// The same axis, interpolated in the logarithm of the argument.
    #[must_use]
    pub fn logarithmic(self) -> Self {
        Self { is_logarithmic: true, ..self }
    }
}

/// A function of one to three numbers, interpolated between the nodes of a table.
///
/// ```
/// use emitree_models::table::{BeyondTable, Table, TableAxis};
///
/// // A power law is exact in logarithms: 3 T^-2.
/// let axis = TableAxis::new("T", vec![1.0, 10.0, 100.0]).logarithmic();
/// let table = Table::new(vec![axis], vec![3.0, 0.03, 0.0003])?.with_logarithmic_values()?;
/// let table = table.with_beyond(BeyondTable::Edge);
/// assert!((table.value(&[5.0]).unwrap() / 0.12 - 1.0).abs() < 1e-14);
/// assert!((table.value(&[0.1]).unwrap() / 3.0 - 1.0).abs() < 1e-14);
///
/// let strict = table.with_beyond(BeyondTable::Error);
/// let error = strict.value(&[0.1]).unwrap_err();
/// assert_eq!(error.to_string(), "the argument `T` is 0.1: expected 1 to 100, the range of the table");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, PartialEq)]
pub struct Table {
    names: Vec<String>,
    axes: Vec<Axis>,
    /// The distance in `values` of neighbours along each axis.
    strides: [usize; Self::MAX_AXES],
    /// The last axis fastest; logarithms, if it is interpolated in them.
    values: Vec<f64>,
    has_logarithmic_values: bool,
    beyond: BeyondTable,
}

/// Arguments of a table; those beyond its axes have no effect.
pub(crate) type Arguments = [f64; Table::MAX_AXES];

impl Table {
    /// The most axes of a table.
    pub const MAX_AXES: usize = 3;

    /// A table of `values` at all combinations of the nodes of `axes`, the last axis varying fastest, linear
    /// in the values. Beyond its axes is an [error](BeyondTable::Error).
    ///
    /// # Errors
    ///
    /// [`TableError`] names the axis and the node, or the value, and what was expected.
    pub fn new(axes: Vec<TableAxis>, values: Vec<f64>) -> Result<Self, TableError> {
        if axes.is_empty() || axes.len() > Self::MAX_AXES {
            return Err(TableError::Axes { count: axes.len() });
        }
        axes.iter().try_for_each(check_axis)?;
        let shape: Vec<usize> = axes.iter().map(|axis| axis.nodes.len()).collect();
        let expected = shape.iter().fold(1, |count: usize, &nodes| count.saturating_mul(nodes));
        if values.len() != expected {
            return Err(TableError::Length { shape, found: values.len() });
        }
        if let Some(place) = values.iter().position(|value| !value.is_finite()) {
            return Err(TableError::Value { index: index_of(place, &shape), value: values[place] });
        }
        let mut strides = [0; Self::MAX_AXES];
        let mut stride = 1;
        for (of_axis, length) in strides.iter_mut().zip(&shape).take(shape.len()).rev() {
            *of_axis = stride;
            stride *= length;
        }
        let turned: Vec<bool> = axes.iter().map(|axis| is_descending(&axis.nodes)).collect();
        let values = (0..values.len())
            .map(|place| {
                let ways = strides.iter().zip(shape.iter().zip(&turned));
                ways.fold(0, |at, (stride, (length, turned))| {
                    let index = place / stride % length;
                    at + stride * if *turned { length - 1 - index } else { index }
                })
            })
            .map(|place| values[place])
            .collect();
        let (mut names, mut found) = (Vec::new(), Vec::new());
        for (axis, turned) in axes.into_iter().zip(turned) {
            let mut nodes = axis.nodes;
            if turned {
                nodes.reverse();
            }
            let (name, is_logarithmic, count) = (axis.name, axis.is_logarithmic, nodes.len());
            let plain = Axis::new(nodes);
            found.push(if is_logarithmic {
                plain.logarithmic().map_err(|(index, value)| {
                    let index = if turned { count - 1 - index } else { index };
                    TableError::NodeWithoutLogarithm { axis: name.clone(), index, value }
                })?
            } else {
                plain
            });
            names.push(name);
        }
        let beyond = BeyondTable::default();
        Ok(Self { names, axes: found, strides, values, has_logarithmic_values: false, beyond })
    }

    /// The same table, interpolated in the logarithm of its values.
    ///
    /// # Errors
    ///
    /// [`TableError::ValueWithoutLogarithm`], with the indices along the axes in increasing order.
    pub fn with_logarithmic_values(mut self) -> Result<Self, TableError> {
        if self.has_logarithmic_values {
            return Ok(self);
        }
        if let Some(place) = self.values.iter().position(|&value| value <= 0.0) {
            let shape: Vec<usize> = self.axes.iter().map(|axis| axis.nodes().len()).collect();
            let (index, value) = (index_of(place, &shape), self.values[place]);
            return Err(TableError::ValueWithoutLogarithm { index, value });
        }
        self.values.iter_mut().for_each(|value| *value = elementary::ln(*value));
        self.has_logarithmic_values = true;
        Ok(self)
    }

    /// The same table with another answer beyond its axes.
    #[must_use]
    pub fn with_beyond(self, beyond: BeyondTable) -> Self {
        Self { beyond, ..self }
    }

    /// What it is beyond its axes.
    pub fn beyond(&self) -> BeyondTable {
        self.beyond
    }

    /// The names of its axes, in the order of its arguments.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The nodes along an axis, from 0, in increasing order; none if there is no such axis.
    pub fn nodes(&self, axis: usize) -> &[f64] {
        self.axes.get(axis).map_or(&[], Axis::nodes)
    }

    /// The value at one number for each axis; NaN if one of them is.
    ///
    /// # Errors
    ///
    /// [`OutsideTable`] if the table has [`BeyondTable::Error`] and an argument is beyond its axis.
    ///
    /// # Panics
    ///
    /// If the arguments are not as many as the axes.
    pub fn value(&self, arguments: &[f64]) -> Result<f64, OutsideTable> {
        assert_eq!(arguments.len(), self.axes.len(), "an argument for each axis");
        let mut given = [0.0; Self::MAX_AXES];
        given[..arguments.len()].copy_from_slice(arguments);
        self.outside(given).map_or_else(|| Ok(self.interpolated(given)), Err)
    }

    /// The value; NaN beyond an axis with [`BeyondTable::Error`].
    pub(crate) fn interpolated(&self, arguments: Arguments) -> f64 {
        match self.locate(arguments) {
            Ok(at) => {
                let value = self.between(0, 0, &at);
                if self.has_logarithmic_values { elementary::exp(value) } else { value }
            }
            Err(beyond) => beyond,
        }
    }

    /// The derivative by the argument `along`; that of the cell above at a node, NaN as the value is.
    pub(crate) fn slope(&self, arguments: Arguments, along: usize) -> f64 {
        let at = match self.locate(arguments) {
            Ok(at) => at,
            Err(beyond) => return beyond,
        };
        let axis = &self.axes[along];
        if !(axis.min() <= arguments[along] && arguments[along] <= axis.max()) {
            return 0.0; // Beyond the edge it is constant.
        }
        let places = axis.places();
        let cell = at[along].cell;
        let ends = [0.0, 1.0].map(|fraction| {
            let mut end = at;
            end[along].fraction = fraction;
            self.between(0, 0, &end)
        });
        let slope = (ends[1] - ends[0]) / (places[cell + 1] - places[cell]);
        let of_axis = if axis.is_logarithmic() { 1.0 / arguments[along] } else { 1.0 };
        let of_value = if self.has_logarithmic_values { self.interpolated(arguments) } else { 1.0 };
        slope * of_axis * of_value
    }

    /// The first argument that is beyond its axis, if that is an error.
    pub(crate) fn outside(&self, arguments: Arguments) -> Option<OutsideTable> {
        if self.beyond != BeyondTable::Error {
            return None;
        }
        let beyond = |(axis, value): (&Axis, f64)| value < axis.min() || value > axis.max();
        let number = self.axes.iter().zip(arguments).position(beyond)?;
        let axis = &self.axes[number];
        Some(OutsideTable {
            table: None,
            argument: self.names[number].clone(),
            value: arguments[number],
            min: axis.min(),
            max: axis.max(),
        })
    }

    /// The cells of all arguments, or what the table is where there are none.
    fn locate(&self, arguments: Arguments) -> Result<[Location; Self::MAX_AXES], f64> {
        let mut found = [Location { cell: 0, fraction: 0.0 }; Self::MAX_AXES];
        for ((location, axis), argument) in found.iter_mut().zip(&self.axes).zip(arguments) {
            let place = match self.beyond {
                BeyondTable::Edge if !argument.is_nan() => argument.max(axis.min()).min(axis.max()),
                _ => argument,
            };
            *location = match (axis.locate(place), self.beyond) {
                (Some(location), _) => location,
                (None, BeyondTable::Zero) if !argument.is_nan() => {
                    // An argument that is no number is not hidden by another one that is beyond.
                    let is_nan = arguments[..self.axes.len()].iter().any(|value| value.is_nan());
                    return Err(if is_nan { f64::NAN } else { 0.0 });
                }
                (None, _) => return Err(f64::NAN),
            };
        }
        Ok(found)
    }

    /// Linear along the axes from number `axis`, in the values from `start`.
    fn between(&self, axis: usize, start: usize, at: &[Location; Self::MAX_AXES]) -> f64 {
        let Location { cell, fraction } = at[axis];
        let stride = self.strides[axis];
        let start = start + cell * stride;
        let ends = if axis + 1 == self.axes.len() {
            [self.values[start], self.values[start + 1]]
        } else {
            [start, start + stride].map(|start| self.between(axis + 1, start, at))
        };
        (1.0 - fraction) * ends[0] + fraction * ends[1]
    }
}

impl fmt::Debug for Table {
    /// The names and ranges of the axes; the values are too many.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ranges: Vec<_> = self.axes.iter().map(|axis| [axis.min(), axis.max()]).collect();
        f.debug_struct("Table")
            .field("names", &self.names)
            .field("ranges", &ranges)
            .field("has_logarithmic_values", &self.has_logarithmic_values)
            .field("beyond", &self.beyond)
            .finish_non_exhaustive()
    }
}

fn check_axis(axis: &TableAxis) -> Result<(), TableError> {
    let (name, nodes) = (|| axis.name.clone(), &axis.nodes);
    if nodes.len() < 2 {
        return Err(TableError::TooFewNodes { axis: name(), count: nodes.len() });
    }
    match flaw(nodes) {
        None => Ok(()),
        Some(Flaw::NotFinite { index, value }) => {
            Err(TableError::NodeNotFinite { axis: name(), index, value })
        }
        Some(Flaw::NotMonotone { index, previous, value }) => {
            Err(TableError::NotMonotone { axis: name(), index, previous, value })
        }
    }
}

/// The indices along all axes of the value at a place, the last axis fastest.
fn index_of(mut place: usize, shape: &[usize]) -> Vec<usize> {
    let mut index: Vec<usize> = Vec::with_capacity(shape.len());
    for &length in shape.iter().rev() {
        index.push(place % length);
        place /= length;
    }
    index.reverse();
    index
}

#[cfg(test)]
mod tests;
