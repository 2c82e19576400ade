//! `emission.grid`: data on a grid in a file.

use super::super::beside_scene;
use super::super::document::{Node, Value};
use super::super::error::SceneError;
use super::super::source::Place;
use super::super::table::Table;
use crate::grid::{AngleUnit, ArrayOrder, AxisNodes, GridFormat, GridRequest, Step, read_grid};
use crate::words::alternatives;
use emitree_models::grid::Coordinates;
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
    let path = table.path().to_owned();
    let (file, file_place) = table.require("file", FILE)?.text()?;
    let mut places = Places { file: file_place, others: Vec::new() };
    let request = request(&mut table, &mut places)?;
    let interpolation = choice(
        table.text("interpolation")?,
        "interpolation",
        &[
            ("linear", Interpolation::Linear),
            ("cubic", Interpolation::Cubic),
            ("monotone", Interpolation::MonotoneCubic),
            ("nearest", Interpolation::Nearest),
        ],
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
        SceneError::at(place, format!("`{path}`: {error}"))
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
    let coordinates =
        choice(table.text("coordinates")?, "coordinates", &COORDINATES)?.unwrap_or_default();
    request.coordinates = coordinates;
    for (key, nodes) in coordinates.names().into_iter().zip(&mut request.nodes) {
        let latitudes = if key == "theta" { table.take("latitude") } else { None };
        let given = table.take(key);
        if let (Some(latitudes), Some(_)) = (&latitudes, &given) {
            let message = format!("`{}` has `theta` and `latitude`", table.path());
            return Err(SceneError::at(&latitudes.place, message).label("expected one of them"));
        }
        request.has_latitudes |= latitudes.is_some();
        if let Some(node) = given.or(latitudes) {
            places.others.push((key, node.place.clone()));
            *nodes = axis_nodes(node)?;
        }
    }
    request.angle_unit = choice(table.text("angle_unit")?, "unit of angles", &AngleUnit::NAMES)?;
    if let Some(node) = table.take("logarithmic") {
        places.others.push(("logarithmic", node.place.clone()));
        request.are_logarithmic = logarithmic(&node, coordinates)?;
    }
    if let Some((text, place)) = table.text("order")? {
        let order: ArrayOrder = text.parse().map_err(|expected| {
            SceneError::at(&place, format!("`{}.order` is \"{text}\"", table.path()))
                .label(format!("{expected}"))
        })?;
        places.others.push(("order", place));
        request.order = Some(order);
    }
    if let Some(node) = table.take("step") {
        places.others.push(("step", node.place.clone()));
        request.step = Some(step(node)?);
    }
    if let Some(scale) = table.take("scale") {
        request.scale = scale.number()?;
    }
    Ok(request)
}

/// The coordinates by the names that scenes have for them.
const COORDINATES: [(&str, Coordinates); 3] = [
    ("cartesian", Coordinates::Cartesian),
    ("cylindrical", Coordinates::Cylindrical),
    ("spherical", Coordinates::Spherical),
];

/// The axes that are interpolated in their logarithm, from a list of names.
fn logarithmic(node: &Node, coordinates: Coordinates) -> Result<[bool; 3], SceneError> {
    let names = coordinates.names();
    let expected = || format!("a list of axes, each {}", alternatives(quoted(names)));
    let Value::Array(items) = &node.value else {
        return Err(node.refuse(node.value.kind(), &expected()));
    };
    let mut chosen = [false; 3];
    for item in items {
        let axis = match &item.value {
            Value::Text(name) => names.iter().position(|other| other == name),
            _ => None,
        };
        match (axis, &item.value) {
            (Some(axis), _) => chosen[axis] = true,
            (None, Value::Text(name)) => {
                return Err(item.refuse(&format!("\"{name}\""), &alternatives(quoted(names))));
            }
            (None, other) => return Err(item.refuse(other.kind(), &alternatives(quoted(names)))),
        }
    }
    Ok(chosen)
}

fn quoted(names: [&str; 3]) -> impl Iterator<Item = String> {
    names.map(|name| format!("\"{name}\"")).into_iter()
}

/// A step: its number, or a table with its number or its coordinate.
fn step(node: Node) -> Result<Step, SceneError> {
    const EXPECTED: &str = "the number of a step, or { index = … } or { value = … } of one";
    if let Value::Integer(index) = node.value {
        return Ok(Step::index(index));
    }
    if !matches!(node.value, Value::Table(_)) {
        return Err(node.refuse(node.value.kind(), EXPECTED));
    }
    let (path, place) = (node.path.clone(), node.place.clone());
    let mut table = Table::new(node)?;
    let axis = table.text("axis")?.map(|(axis, _)| axis);
    let (index, value) = (table.take("index"), table.take("value"));
    table.finish()?;
    let mut found = match (index, value) {
        (Some(index), None) => Step::index(index.count::<i64>("the number of a step")?),
        (None, Some(value)) => Step::value(value.number()?),
        _ => {
            let message = format!("`{path}` has not one of `index` and `value`");
            return Err(SceneError::at(&place, message).label(format!("expected {EXPECTED}")));
        }
    };
    found.axis = axis;
    Ok(found)
}

/// The nodes of an axis: the name of an array, the numbers themselves, or a range.
fn axis_nodes(node: Node) -> Result<AxisNodes, SceneError> {
    const NODE: &str = "the coordinate of a node, in the length unit of the scene or `angle_unit`";
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
pub(super) fn choice<T: Copy>(
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
