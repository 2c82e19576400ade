//! `emission.table.NAME`: a function of an expression, from a file of a table.

use super::super::beside_scene;
use super::super::document::{Node, Value};
use super::super::error::SceneError;
use super::super::source::Place;
use super::super::table::Table;
use super::grid::choice;
use crate::table::{TableFormat, TableRequest, read_table};
use emitree_models::table::{BeyondTable, Table as Lookup};

pub(super) fn read(mut table: Table) -> Result<Lookup, SceneError> {
    const FILE: &str = "the name of a file of a table, as in \"cooling.csv\"";
    let path = table.path().to_owned();
    let (file, file_place) = table.require("file", FILE)?.text()?;
    let mut places: Vec<(&str, Place)> = Vec::new();
    let format = choice(table.text("format")?, "format", &TableFormat::NAMES)?;
    let mut request = TableRequest { format, ..TableRequest::default() };
    if let Some((name, place)) = table.text("extension")? {
        request.extension = Some(name);
        places.push(("extension", place));
    }
    if let Some(node) = table.take("axes") {
        places.push(("axes", node.place.clone()));
        request.axes = names(&node, "a list of columns or arrays, one for each argument")?;
        if request.axes.is_empty() || request.axes.len() > Lookup::MAX_AXES {
            let count = request.axes.len();
            return Err(node.refuse(&format!("a list of {count}"), "1 to 3 names"));
        }
    }
    if let Some((name, place)) = table.text("values")? {
        request.values = Some(name);
        places.push(("values", place));
    }
    if let Some(node) = table.take("logarithmic") {
        places.push(("logarithmic", node.place.clone()));
        request.logarithmic = names(&node, "a list of names, of axes or of the values")?;
    }
    let beyond = choice(
        table.text("outside")?,
        "answer outside the table",
        &[("error", BeyondTable::Error), ("zero", BeyondTable::Zero), ("edge", BeyondTable::Edge)],
    )?;
    request.beyond = beyond.unwrap_or_default();
    if let Some(scale) = table.take("scale") {
        request.scale = scale.number()?;
    }
    table.finish()?;
    let file = beside_scene(&file, &file_place);
    read_table(&file, &request).map_err(|error| {
        let concerns = error.cause.concerns();
        let place = places.iter().find(|(key, _)| *key == concerns);
        let place = place.map_or(&file_place, |(_, place)| place);
        SceneError::at(place, format!("`{path}`: {error}"))
    })
}

/// A list of texts.
fn names(node: &Node, expected: &str) -> Result<Vec<String>, SceneError> {
    let Value::Array(items) = &node.value else {
        return Err(node.refuse(node.value.kind(), expected));
    };
    items.iter().map(|item| Ok(item.text()?.0)).collect()
}
