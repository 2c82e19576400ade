//! `emission.grid`: a cube of data in a file.

use super::super::beside_scene;
use super::super::document::{Node, Value};
use super::super::error::SceneError;
use super::super::source::Place;
use super::super::table::Table;
use crate::grid::{ArrayOrder, AxisNodes, GridFormat, GridRequest, read_grid};
use emitree_models::{Grid, Interpolation, Outside};
use std::path::PathBuf;

/// A grid, and where it is from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GridEmission {
    /// The grid.
    pub grid: Grid,
    /// The unit of its values, as the file has it.
    pub unit: Option<String>,
    /// The file that was read.
    pub file: PathBuf,
}

/// The places of the keys that a file may contradict.
struct Places {
    file: Place,
    others: Vec<(&'static str, Place)>,
}

impl Places {
    /// The place of a key, or of the name of the file where the scene leaves the key out.
    fn of(&self, key: &str) -> &Place {
        self.others.iter().find(|(other, _)| *other == key).map_or(&self.file, |(_, place)| place)
    }
}

pub(super) fn read(mut table: Table) -> Result<GridEmission, SceneError> {
    const FILE: &str = "the name of a file of data, as in \"cube.fits\"";
    let (file, file_place) = table.require("file", FILE)?.text()?;
    let mut places = Places { file: file_place, others: Vec::new() };
    let request = request(&mut table, &mut places)?;
    let interpolation = choice(
        table.text("interpolation")?,
        "interpolation",
        &[("linear", Interpolation::Linear), ("monotone", Interpolation::MonotoneCubic)],
    )?;
    let outside = choice(
        table.text("outside")?,
        "answer outside the grid",
        &[("zero", Outside::Zero), ("error", Outside::Error)],
    )?;
    table.finish()?;

    let file = beside_scene(&file, &places.file);
    let read = read_grid(&file, &request).map_err(|error| {
        let place = places.of(error.cause.concerns());
        SceneError::at(place, format!("`emission.grid`: {error}"))
    })?;
    let grid = read.grid.with_interpolation(interpolation.unwrap_or_default());
    let grid = grid.with_outside(outside.unwrap_or_default());
    Ok(GridEmission { grid, unit: read.unit, file })
}

fn request(table: &mut Table, places: &mut Places) -> Result<GridRequest, SceneError> {
    let format = choice(table.text("format")?, "format", &GridFormat::NAMES)?;
    let mut request = GridRequest { format, ..GridRequest::default() };
    if let Some((name, place)) = table.text("values")? {
        places.others.push(("values", place));
        request.values = Some(name);
    }
    for (key, nodes) in ["x", "y", "z"].into_iter().zip(&mut request.nodes) {
        if let Some(node) = table.take(key) {
            places.others.push((key, node.place.clone()));
            *nodes = axis_nodes(node)?;
        }
    }
    if let Some((text, place)) = table.text("order")? {
        let order: ArrayOrder = text.parse().map_err(|expected| {
            SceneError::at(&place, format!("`emission.grid.order` is \"{text}\""))
                .label(format!("{expected}"))
        })?;
        places.others.push(("order", place));
        request.order = Some(order);
    }
    if let Some(scale) = table.take("scale") {
        request.scale = scale.number()?;
    }
    Ok(request)
}

/// The nodes of an axis: the name of an array, the numbers themselves, or a range.
fn axis_nodes(node: Node) -> Result<AxisNodes, SceneError> {
    const NODE: &str = "the coordinate of a node, in the length unit of the scene";
    match node.value {
        Value::Text(name) => Ok(AxisNodes::Named(name)),
        Value::Array(items) => {
            let nodes: Result<Vec<f64>, _> = items.iter().map(Node::number).collect();
            Ok(AxisNodes::List(nodes?))
        }
        Value::Table(_) => {
            let mut table = Table::new(node)?;
            let (min, max) = (table.require("min", NODE)?, table.require("max", NODE)?);
            table.finish()?;
            let range = [min.number()?, max.number()?];
            if range[0] < range[1] {
                Ok(AxisNodes::Range { min: range[0], max: range[1] })
            } else {
                Err(max
                    .refuse(&range[1].to_string(), &format!("more than {}, the `min`", range[0])))
            }
        }
        _ => Err(node.refuse(
            node.value.kind(),
            "the name of an array, a list of nodes, or { min = …, max = … }",
        )),
    }
}

/// The value that a word stands for.
fn choice<T: Copy>(
    given: Option<(String, Place)>,
    what: &str,
    choices: &[(&str, T)],
) -> Result<Option<T>, SceneError> {
    let Some((word, place)) = given else { return Ok(None) };
    if let Some((_, value)) = choices.iter().find(|(name, _)| *name == word) {
        return Ok(Some(*value));
    }
    let names: Vec<String> = choices.iter().map(|(name, _)| format!("`{name}`")).collect();
    Err(SceneError::at(&place, format!("unknown {what} `{word}`"))
        .label(format!("expected one of {}", names.join(", "))))
}
