//! `emission.fields` and `emission.table`: an expression of data on grids and of tables.

use super::super::document::{Entry, Node, Value};
use super::super::error::SceneError;
use super::super::source::Place;
use super::super::table::Table;
use super::{Spectrum, grid, lookup, needs_energies, place_in, refuse_unused};
use emitree_models::FieldExpression;
use std::collections::BTreeMap;

/// What a scene has for an expression besides constants.
pub(super) struct FieldTables {
    /// What all fields have in common.
    pub(super) grid: Option<Node>,
    pub(super) fields: Option<Node>,
    pub(super) tables: Option<Node>,
}

impl FieldTables {
    /// Whether the expression has fields or tables.
    pub(super) fn are_some(&self) -> bool {
        self.fields.is_some() || self.tables.is_some()
    }

    /// Refuses them without an expression.
    pub(super) fn refuse(&self) -> Result<(), SceneError> {
        for (key, node) in [("fields", &self.fields), ("table", &self.tables)] {
            if let Some(node) = node {
                let message = format!("`emission.{key}` is for `emission.expression`");
                return Err(SceneError::at(&node.place, message)
                    .label("expected `expression = \"…\"` too, which names them"));
            }
        }
        Ok(())
    }
}

pub(super) fn read(
    text: &str,
    place: &Place,
    constants: Option<Table>,
    given: FieldTables,
    spectrum: Spectrum,
) -> Result<FieldExpression, SceneError> {
    let constants = constants.map(Table::numbers).transpose()?.unwrap_or_default();
    let values: BTreeMap<String, f64> =
        constants.iter().map(|(name, (value, _))| (name.clone(), *value)).collect();
    let mut keys: BTreeMap<String, (&str, Place)> =
        constants.into_iter().map(|(name, (_, entry))| (name, ("constant", entry.key))).collect();
    let mut note = |what, entries: &BTreeMap<String, Entry>| {
        for (name, entry) in entries {
            keys.entry(name.clone()).or_insert((what, entry.key.clone()));
        }
    };
    let FieldTables { grid, fields, tables } = given;
    let fields = fields.map(Table::new).transpose()?.map(Table::into_entries).unwrap_or_default();
    let tables = tables.map(Table::new).transpose()?.map(Table::into_entries).unwrap_or_default();
    note("field", &fields);
    note("table", &tables);
    if let (Some(grid), true) = (&grid, fields.is_empty()) {
        return Err(SceneError::at(&grid.place, "`emission.grid` is not used")
            .label("expected `fields = { n = \"…\" }` too, which name its arrays"));
    }
    refuse_values(grid.as_ref())?;
    let of_fields = fields
        .into_iter()
        .map(|(name, entry)| {
            let found = grid::read(Table::new(field_node(&name, grid.as_ref(), entry.node)?)?)?;
            Ok((name, found.grid))
        })
        .collect::<Result<_, SceneError>>()?;
    let of_tables = tables
        .into_iter()
        .map(|(name, entry)| Ok((name, lookup::read(Table::new(entry.node)?)?)))
        .collect::<Result<_, SceneError>>()?;
    let expression = match spectrum {
        Spectrum::InTime => FieldExpression::of_time(text, &values, of_fields, of_tables),
        _ => FieldExpression::parse(text, &values, of_fields, of_tables),
    };
    let expression = expression.map_err(|error| place_in("emission.expression", &error, place))?;
    if let Some(name) = expression.unused_names().first()
        && let Some((what, place)) = keys.get(name)
    {
        return Err(refuse_unused(what, name, place, "emission.expression"));
    }
    if let (Spectrum::Without, Some(span)) = (spectrum, expression.energy_span()) {
        let place = Place { span: super::span_in_string(place, span), ..place.clone() };
        return Err(needs_energies("`emission.expression`", &place));
    }
    Ok(expression)
}

/// Which array a file of fields has is said by `fields`.
fn refuse_values(grid: Option<&Node>) -> Result<(), SceneError> {
    let Some(Node { value: Value::Table(entries), .. }) = grid else { return Ok(()) };
    match entries.get("values") {
        None => Ok(()),
        Some(entry) => {
            let message = "`emission.grid.values` is given with `emission.fields`";
            Err(SceneError::at(&entry.key, message)
                .label("expected none: the fields name the arrays"))
        }
    }
}

/// The keys of a field as those of a grid: its own, and those of `emission.grid` that it has not.
fn field_node(name: &str, grid: Option<&Node>, own: Node) -> Result<Node, SceneError> {
    let path = format!("emission.fields.{name}");
    let own = match (&own.value, grid) {
        (Value::Text(_), Some(_)) => {
            let place = own.place.clone();
            let entry = Entry { key: place.clone(), node: own };
            let entries = BTreeMap::from([("values".to_owned(), entry)]);
            Node { path: path.clone(), place, value: Value::Table(entries) }
        }
        (Value::Text(array), None) => {
            let message = format!("`{path}` is \"{array}\", and the scene has no `emission.grid`");
            return Err(SceneError::at(&own.place, message).label(
                "expected `grid = { file = \"…\" }` in `[emission]` too, the file that has this \
                 array, or a table `{ file = \"…\" }` here",
            ));
        }
        (Value::Table(_), _) => own,
        (other, _) => {
            return Err(own.refuse(
                other.kind(),
                "the name of an array of `emission.grid`, or a table with the keys of a grid",
            ));
        }
    };
    let mut node = match grid {
        // What is no table is refused where it stands.
        Some(grid) if matches!(grid.value, Value::Table(_)) => grid.clone(),
        Some(grid) => return Err(grid.refuse(grid.value.kind(), "a table")),
        None => Node { value: Value::Table(BTreeMap::new()), ..own.clone() },
    };
    let place = own.place.clone();
    node.merge(own);
    Ok(Node { path, place, ..node })
}

#[cfg(test)]
mod tests;
