//! From columns, a row for each combination of the arguments, to a table.

use super::error::{Place, TableReadError};
use super::request::TableRequest;
use emitree_models::table::{Table, TableAxis};

/// A column of numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    pub(super) name: String,
    /// NaN where there is no number.
    pub(super) values: Vec<f64>,
    /// The first field that is no number, if there is one: its row, and what is there.
    fault: Option<(Place, String)>,
}

impl Column {
    pub(super) fn new(name: String) -> Self {
        Self { name, values: Vec::new(), fault: None }
    }

    /// Adds a row.
    pub(super) fn push(&mut self, value: Option<f64>, field: &str, place: Place) {
        let value = value.filter(|value| value.is_finite());
        if value.is_none() {
            self.fault.get_or_insert_with(|| (place, field.to_owned()));
        }
        self.values.push(value.unwrap_or(f64::NAN));
    }
}

/// The columns of a file, and where each row stands.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Columns {
    pub(super) columns: Vec<Column>,
    pub(super) places: Vec<Place>,
}

impl Columns {
    /// The names of all columns.
    pub(crate) fn names(&self) -> Vec<&str> {
        self.columns.iter().map(|column| column.name.as_str()).collect()
    }

    /// The numbers of the column of this name, which the request has under `key`.
    pub(crate) fn numbers(&self, name: &str, key: &'static str) -> Result<&[f64], TableReadError> {
        Ok(&self.take(name, key, false)?.values)
    }

    /// The column of this name, all of whose fields are numbers, above 0 if it needs logarithms.
    fn take(&self, name: &str, key: &'static str, log: bool) -> Result<&Column, TableReadError> {
        let mut found = self.columns.iter().filter(|column| column.name == name);
        let (Some(column), second) = (found.next(), found.next()) else {
            let available = self.columns.iter().map(|column| column.name.clone()).collect();
            return Err(TableReadError::NoColumn { name: name.to_owned(), available, key });
        };
        if second.is_some() {
            return Err(TableReadError::TwoColumns(name.to_owned()));
        }
        let refuse = |place, value, expected| {
            Err(TableReadError::Cell { place, column: name.to_owned(), value, expected })
        };
        if let Some((place, value)) = &column.fault {
            return refuse(*place, value.clone(), "a finite number");
        }
        match column.values.iter().position(|&value| log && value <= 0.0) {
            None => Ok(column),
            Some(row) => {
                let expected = "a number above 0, which has a logarithm";
                refuse(self.places[row], column.values[row].to_string(), expected)
            }
        }
    }
}

/// The table in these columns.
pub(super) fn table(columns: Columns, request: &TableRequest) -> Result<Table, TableReadError> {
    let names = || columns.columns.iter().map(|column| column.name.clone());
    let values = match (&request.values, columns.columns.last()) {
        (Some(name), _) => name.clone(),
        (None, Some(last)) => last.name.clone(),
        (None, None) => return Err(TableReadError::Columns { names: Vec::new() }),
    };
    let axes: Vec<String> = match request.axes.as_slice() {
        [] => names().filter(|name| *name != values).collect(),
        axes => axes.to_vec(),
    };
    if axes.is_empty() || axes.len() > Table::MAX_AXES {
        return Err(TableReadError::Columns { names: names().collect() });
    }
    request.check_logarithmic(&axes, &values)?;
    let of_axis = |name: &String| columns.take(name, "axes", request.is_logarithmic(name));
    let arguments: Vec<&Column> = axes.iter().map(of_axis).collect::<Result<_, _>>()?;
    let column = columns.take(&values, "values", request.is_logarithmic(&values))?;

    let nodes: Vec<Vec<f64>> =
        arguments.iter().map(|argument| nodes_of(&argument.values)).collect();
    let arranged = arranged(&columns.places, &arguments, &nodes, column)?;
    let found = axes.into_iter().zip(nodes).map(|(name, nodes)| {
        let is_logarithmic = request.is_logarithmic(&name);
        let axis = TableAxis::new(name, nodes);
        if is_logarithmic { axis.logarithmic() } else { axis }
    });
    finished(found.collect(), arranged, request, &values)
}

/// The table of these axes and values.
pub(super) fn finished(
    axes: Vec<TableAxis>,
    mut values: Vec<f64>,
    request: &TableRequest,
    name: &str,
) -> Result<Table, TableReadError> {
    values.iter_mut().for_each(|value| *value *= request.scale);
    let table = Table::new(axes, values);
    let table = match request.is_logarithmic(name) {
        true => table.and_then(Table::with_logarithmic_values),
        false => table,
    };
    table.map_err(TableReadError::Table)
}

/// The different numbers of a column, in increasing order.
fn nodes_of(values: &[f64]) -> Vec<f64> {
    let mut nodes = values.to_vec();
    nodes.sort_by(f64::total_cmp);
    // 0 and -0 are one node.
    nodes.dedup_by(|a, b| (*a - *b).abs() <= 0.0);
    nodes
}

/// The values in the order of a table, one for each combination of nodes.
fn arranged(
    places: &[Place],
    arguments: &[&Column],
    nodes: &[Vec<f64>],
    values: &Column,
) -> Result<Vec<f64>, TableReadError> {
    let combination = |index: &dyn Fn(usize) -> f64| {
        let parts = arguments.iter().enumerate();
        let parts: Vec<String> = parts
            .map(|(axis, argument)| format!("`{}` = {}", argument.name, index(axis)))
            .collect();
        parts.join(" and ")
    };
    let counts = || {
        let parts: Vec<String> = arguments
            .iter()
            .zip(nodes)
            .map(|(argument, nodes)| format!("{} numbers of `{}`", nodes.len(), argument.name))
            .collect();
        parts.join(" and ")
    };
    let size = nodes.iter().fold(1, |size: usize, nodes| size.saturating_mul(nodes.len()));
    let rows = places.len();
    // Of more combinations than rows at least one is missing: one of the first `rows` + 1.
    let mut row_of = vec![None; size.min(rows + 1)];
    for row in 0..rows {
        let at = arguments.iter().zip(nodes).fold(0, |at: usize, (argument, nodes)| {
            let value = argument.values[row];
            let index = nodes.partition_point(|&node| node < value);
            at.saturating_mul(nodes.len()).saturating_add(index)
        });
        let Some(known) = row_of.get_mut(at) else { continue };
        if let Some(first) = *known {
            let (place, first): (Place, Place) = (places[row], places[first]);
            let combination = combination(&|axis| arguments[axis].values[row]);
            return Err(TableReadError::Repeated { place, combination, first });
        }
        *known = Some(row);
    }
    let found: Option<Vec<f64>> =
        row_of.iter().map(|row| row.map(|row| values.values[row])).collect();
    match found {
        Some(found) if found.len() == size => Ok(found),
        _ => {
            let at = row_of.iter().position(Option::is_none).unwrap_or_default();
            let index = |axis: usize| {
                let after: usize = nodes[axis + 1..].iter().map(Vec::len).product();
                nodes[axis][at / after % nodes[axis].len()]
            };
            let combination = combination(&index);
            Err(TableReadError::MissingCombination { combination, counts: counts() })
        }
    }
}
