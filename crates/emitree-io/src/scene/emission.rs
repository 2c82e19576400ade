//! `[emission]`: an expression, also of fields and tables, a built-in model, a grid of data, or a tree.

mod components;
mod fields;
mod grid;
mod lookup;

pub use components::{ComponentEmission, ComponentRates};
pub use grid::GridEmission;

use super::absorption::of_section;
use super::document::Node;
use super::error::SceneError;
use super::radiometry::EmissionUnits;
use super::source::Place;
use super::table::Table;
use super::tree;
use crate::tree_file::TreeFile;
use emitree::{Emission, Samples};
use emitree_models::catalogue::{SingularPoint, SphericalEdge};
use emitree_models::grid::GridAxes;
use emitree_models::{
    Expression, ExpressionError, FieldExpression, FieldFailure, Model, ModelError, Outside,
    OutsideGrid, build_model,
};
use fields::FieldTables;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The emission of a scene, in its own units.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum EmissionSource {
    /// An expression, in the units that its writer had in mind.
    Expression(Expression),
    /// An expression of data on grids and of tables.
    Fields(FieldExpression),
    /// Several rates at each point, none of which is that of the scene: [`Scene::components`](super::Scene::components)
    /// has a scene for each.
    Components(Arc<ComponentRates>),
    /// One of several rates.
    Component(ComponentEmission),
    /// A built-in model.
    Model(Model),
    /// Data on a grid, from a file.
    Grid(GridEmission),
    /// A tree that was built before.
    Tree(Arc<TreeFile>),
    /// A function of the program that reads the scene, by its name; only that program can call it.
    Function(String),
}

/// An emission that could not be evaluated at a point.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EmissionFailure {
    /// A grid with `outside = "error"` was evaluated outside.
    #[error("{0} (or `emission.grid.outside = \"zero\"`)")]
    OutsideGrid(#[from] OutsideGrid),
    /// A field or a table was evaluated outside, and has `outside = "error"`.
    #[error("{failure} ({})", remedy(failure))]
    OutsideField {
        /// The field or the table, and where.
        #[from]
        failure: FieldFailure,
    },
    /// The absorption coefficient could not be evaluated.
    #[error("of the absorption coefficient: {}", of_section(&.0.to_string()))]
    Absorption(Box<Self>),
    /// The scene has several emission rates, and what renders it takes one.
    #[error(
        "`emission.expressions` has {0} components: expected one emission rate, as \
         `emission.expression` is"
    )]
    Components(usize),
    /// The scene names a function, and is rendered without it.
    #[error(
        "`emission.function` is `{0}`, a function in Python: expected that this scene is rendered \
         from there, or another emission"
    )]
    Function(String),
}

/// The key that would change it.
fn remedy(failure: &FieldFailure) -> String {
    match failure {
        FieldFailure::Field { field, .. } => {
            format!("or `emission.fields.{field}.outside = \"zero\"`, or that of `emission.grid`")
        }
        FieldFailure::Table { cause, .. } => {
            let name = cause.table.as_deref().unwrap_or("NAME");
            format!("or `emission.table.{name}.outside`, \"zero\" or \"edge\"")
        }
        _ => String::new(),
    }
}

impl EmissionSource {
    /// The length unit that positions are in; `None` where the scene is free to choose.
    pub fn length_unit(&self) -> Option<&str> {
        match self {
            Self::Expression(_)
            | Self::Fields(_)
            | Self::Components(_)
            | Self::Component(_)
            | Self::Grid(_)
            | Self::Function(_) => None,
            Self::Model(model) => Some(model.description().length_unit).filter(|&unit| unit != "1"),
            Self::Tree(file) => file.length_unit.as_deref(),
        }
    }

    /// The points at which the rate is singular, as far as they are known, in its length unit.
    pub(super) fn singular_points(&self) -> Vec<SingularPoint> {
        match self {
            Self::Model(model) => model.singular_points(),
            _ => Vec::new(),
        }
    }

    /// The spheres at which the rate jumps or has a kink, as far as they are known, in its length unit.
    pub(super) fn edges(&self) -> Vec<SphericalEdge> {
        match self {
            Self::Model(model) => model.edges(),
            _ => Vec::new(),
        }
    }

    /// The axes of data outside of which there is no emission.
    pub(super) fn data_axes(&self) -> Vec<&GridAxes> {
        match self {
            Self::Grid(emission) if emission.grid.outside() == Outside::Zero => {
                vec![emission.grid.axes()]
            }
            Self::Fields(expression) => expression.data_axes().collect(),
            _ => Vec::new(),
        }
    }

    /// The unit that energies are in; `None` where the scene is free to choose.
    pub fn energy_unit(&self) -> Option<&str> {
        match self {
            Self::Model(model) => model.description().energy_unit,
            _ => None,
        }
    }

    /// The unit of an image, FITS grammar; empty if the source has none.
    pub fn image_unit(&self) -> &str {
        match self {
            Self::Expression(_)
            | Self::Fields(_)
            | Self::Components(_)
            | Self::Component(_)
            | Self::Grid(_)
            | Self::Function(_) => "",
            Self::Model(model) => model.description().image_unit,
            Self::Tree(file) => &file.image_unit,
        }
    }
}

impl Emission for EmissionSource {
    type Error = EmissionFailure;

    fn emission_rates(
        &self,
        samples: &Samples<'_>,
        rates: &mut [f64],
    ) -> Result<(), EmissionFailure> {
        match self {
            Self::Expression(expression) => {
                expression.emission_rates(samples, rates).map_err(|never| match never {})
            }
            Self::Components(of_all) => Err(EmissionFailure::Components(of_all.names().len())),
            Self::Component(component) => {
                component.rates.of(component.number, samples, rates);
                Ok(())
            }
            Self::Model(model) => {
                model.emission_rates(samples, rates).map_err(|never| match never {})
            }
            Self::Fields(expression) => Ok(expression.emission_rates(samples, rates)?),
            Self::Grid(emission) => Ok(emission.grid.emission_rates(samples, rates)?),
            Self::Tree(file) => {
                file.tree.emission_rates(samples, rates).map_err(|never| match never {})
            }
            Self::Function(name) => Err(EmissionFailure::Function(name.clone())),
        }
    }
}

/// The kinds of emission, each by the key that a scene has it under.
const KINDS: &str = "`expression = \"…\"`, `model = \"…\"`, `grid = { file = \"…\" }` or \
                     `tree = \"…\"`";

/// The name of an emission that another program evaluates.
const OF_ANOTHER_PROGRAM: &str = "of another program";

/// Whether a function depends on the energy, or on the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spectrum {
    /// It depends on neither: the scene has no such axis.
    Without,
    /// It does, as a rate per unit of energy.
    Of,
    /// It may.
    OrGrey,
    /// It may depend on the time: the scene has `[time]`.
    InTime,
}

/// The emission, and its units in the scene. An emission that is not needed may be missing.
pub(super) fn read(
    mut table: Table,
    spectrum: Spectrum,
    is_needed: bool,
) -> Result<(EmissionSource, EmissionUnits), SceneError> {
    let emission = read_source(&mut table, spectrum, is_needed)?;
    let units = EmissionUnits::read(&mut table)?;
    table.finish()?;
    Ok((emission, units))
}

/// A coefficient with the same keys, and its unit.
pub(super) fn read_coefficient(
    mut table: Table,
    spectrum: Spectrum,
) -> Result<(EmissionSource, Option<(String, Place)>), SceneError> {
    if let Some(node) = table.peek("expressions") {
        let message = "`emission.expressions`: a medium has one absorption coefficient";
        return Err(SceneError::at(&node.place, message).label("expected `expression = \"…\"`"));
    }
    let source = read_source(&mut table, spectrum, true)?;
    let unit = table.text("unit")?;
    table.finish()?;
    Ok((source, unit))
}

fn read_source(
    table: &mut Table,
    spectrum: Spectrum,
    is_needed: bool,
) -> Result<EmissionSource, SceneError> {
    let must_be = spectrum == Spectrum::Of;
    let whole = table.place().clone();
    let expressions = table.take("expressions");
    let names = table.take("components");
    if let Some(expressions) = expressions {
        refuse_beside(table, &expressions)?;
        if !is_needed {
            let message = "`emission.expressions` in a scene whose rates another program makes";
            return Err(SceneError::at(&expressions.place, message)
                .label("expected one emission rate, or no `[emission]`"));
        }
        let constants = table.table("constants")?;
        let found = components::read(expressions, names, constants, spectrum)?;
        return Ok(EmissionSource::Components(Arc::new(found)));
    }
    if let Some(names) = names {
        return Err(SceneError::at(
            &names.place,
            "`emission.components` is for `emission.expressions`",
        )
        .label("expected `expressions = [\"…\", \"…\"]` too, which they name"));
    }
    let expression = table.text("expression")?;
    let model = table.text("model")?;
    let grid = table.take("grid");
    let tree = table.text("tree")?;
    let function = table.text("function")?;
    let (fields, tables) = (table.take("fields"), table.take("table"));
    let mut of_fields = FieldTables { grid: None, fields, tables };
    let grid = match &expression {
        Some(_) if of_fields.are_some() => {
            of_fields.grid = grid;
            None
        }
        Some(_) => grid,
        None => {
            of_fields.refuse()?;
            grid
        }
    };
    let emission = match (expression, model, grid, tree, function) {
        (Some((text, place)), None, None, None, None) if of_fields.are_some() => {
            let constants = table.table("constants")?;
            let found = fields::read(&text, &place, constants, of_fields, spectrum)?;
            EmissionSource::Fields(found)
        }
        (Some(expression), None, None, None, None) => {
            let constants = table.table("constants")?;
            read_expression(expression, constants, spectrum)?
        }
        (None, Some(model), None, None, None) => {
            let parameters = table.take("parameters");
            read_model(&model, parameters, spectrum)?
        }
        (None, None, Some(grid), None, None) => {
            refuse_energies(must_be, "grid", &grid.place)?;
            EmissionSource::Grid(grid::read(Table::new(grid)?)?)
        }
        (None, None, None, Some(tree), None) => {
            refuse_energies(must_be, "tree", &tree.1)?;
            tree::read_emission(&tree)?
        }
        (None, None, None, None, Some((name, _))) => EmissionSource::Function(name),
        (None, None, None, None, None) if !is_needed => {
            EmissionSource::Function(OF_ANOTHER_PROGRAM.to_owned())
        }
        (None, None, None, None, None) => {
            return Err(SceneError::at(&whole, "the scene has no emission")
                .label(format!("expected {KINDS} here")));
        }
        (_, model, grid, tree, function) => {
            let second = function.or(tree).map(|(_, place)| place);
            let second = second.or(grid.map(|node| node.place));
            let second = second.or(model.map(|(_, place)| place)).unwrap_or(whole);
            return Err(SceneError::at(&second, "the scene has two emissions")
                .label(format!("expected only one of {KINDS}"))
                .help("an expression of data has a grid and `fields = { n = \"…\" }` too"));
        }
    };
    Ok(emission)
}

/// Refuses an emission that is the same at all energies by its nature where there is an energy axis.
fn refuse_energies(spectral: bool, key: &str, place: &Place) -> Result<(), SceneError> {
    if !spectral {
        return Ok(());
    }
    let message = format!("`emission.{key}` has no spectrum, and the scene has `[energy]`");
    Err(SceneError::at(place, message).label(
        "expected an emission that depends on it, `expression = \"…\"` with `E`, or no `[energy]`",
    ))
}

/// Refuses an emission that depends on the energy where there is none.
fn needs_energies(what: &str, place: &Place) -> SceneError {
    let message = format!("{what} depends on the energy `E`, and the scene has no `[energy]`");
    SceneError::at(place, message)
        .label("expected a table `[energy]` too, with `min`, `max` and `bins`")
}

/// Refuses an emission, or data for an expression, beside a list of expressions.
fn refuse_beside(table: &Table, expressions: &Node) -> Result<(), SceneError> {
    for key in ["expression", "model", "grid", "tree", "function"] {
        if table.peek(key).is_some() {
            let message = format!("the scene has `emission.{key}` and `emission.expressions`");
            return Err(SceneError::at(&expressions.place, message).label("expected one of them"));
        }
    }
    for key in ["fields", "table"] {
        if let Some(node) = table.peek(key) {
            let message = format!("`emission.{key}` is given with `emission.expressions`");
            return Err(SceneError::at(&node.place, message)
                .label("expected none: data are for a single `emission.expression`"));
        }
    }
    Ok(())
}

fn read_expression(
    expression: (String, Place),
    constants: Option<Table>,
    spectrum: Spectrum,
) -> Result<EmissionSource, SceneError> {
    let constants = constants.map(Table::numbers).transpose()?.unwrap_or_default();
    let values = constants.iter().map(|(name, (value, _))| (name.clone(), *value)).collect();
    let expression = parse_expression("emission.expression", &expression, &values, spectrum)?;
    if let Some(name) = expression.unused_constants().first()
        && let Some((_, entry)) = constants.get(name)
    {
        return Err(refuse_unused("constant", name, &entry.key, "emission.expression"));
    }
    Ok(EmissionSource::Expression(expression))
}

/// The expression in the text of a key.
fn parse_expression(
    key: &str,
    (text, place): &(String, Place),
    constants: &BTreeMap<String, f64>,
    spectrum: Spectrum,
) -> Result<Expression, SceneError> {
    let expression = match spectrum {
        Spectrum::InTime => Expression::of_time(text, constants),
        _ => Expression::parse(text, constants),
    };
    let expression = expression.map_err(|error| place_in(key, &error, place))?;
    if let (Spectrum::Without, Some(span)) = (spectrum, expression.energy_span()) {
        let place = Place { span: span_in_string(place, span), ..place.clone() };
        return Err(needs_energies(&format!("`{key}`"), &place));
    }
    Ok(expression)
}

/// An error of an expression at its place in the scene.
fn place_in(key: &str, error: &ExpressionError, place: &Place) -> SceneError {
    let place = Place { span: span_in_string(place, error.span()), ..place.clone() };
    let scene_error = SceneError::at(&place, format!("`{key}`: {error}"));
    match error.help() {
        Some(help) => scene_error.help(help),
        None => scene_error,
    }
}

/// Refuses a constant, a field or a table that the expression does not name.
fn refuse_unused(what: &str, name: &str, place: &Place, key: &str) -> SceneError {
    SceneError::at(place, format!("the {what} `{name}` is not used"))
        .label(format!("expected a name that stands in `{key}`"))
}

/// The place in the scene of a span of a string's content. Where escapes make the text differ from
/// the content, the whole string is marked.
fn span_in_string(place: &Place, span: std::ops::Range<usize>) -> std::ops::Range<usize> {
    let literal = place.source.text.get(place.span.clone()).unwrap_or_default();
    let multi_line = literal.starts_with("\"\"\"") || literal.starts_with("'''");
    if literal.contains('\\') || literal.contains('\r') {
        return place.span.clone();
    }
    // TOML drops a line break right after the opening quotes.
    let opening = match (multi_line, literal.as_bytes().get(3)) {
        (true, Some(b'\n')) => 4,
        (true, _) => 3,
        (false, _) => 1,
    };
    let start = place.span.start + opening + span.start;
    let end = place.span.start + opening + span.end;
    start..end.max(start + 1).min(place.span.end)
}

fn read_model(
    (name, place): &(String, Place),
    parameters: Option<Node>,
    spectrum: Spectrum,
) -> Result<EmissionSource, SceneError> {
    let parameters = parameters.map(Table::new).transpose()?;
    let parameters = parameters.map(Table::numbers).transpose()?.unwrap_or_default();
    let values: BTreeMap<String, f64> =
        parameters.iter().map(|(name, (value, _))| (name.clone(), *value)).collect();
    let model = build_model(name, &values).map_err(|error| {
        // The model's own error names everything; here it gets its place.
        let place = match &error {
            ModelError::UnknownParameter { name, .. } => {
                parameters.get(name).map(|(_, entry)| &entry.key)
            }
            ModelError::OutOfRange { parameter, .. } => {
                parameters.get(*parameter).map(|(_, entry)| &entry.node.place)
            }
            _ => None,
        }
        .unwrap_or(place);
        SceneError::at(place, error.to_string())
    })?;
    match model.description().needs_energy() {
        false => refuse_energies(spectrum == Spectrum::Of, "model", place)?,
        true if matches!(spectrum, Spectrum::Without | Spectrum::InTime) => {
            return Err(needs_energies("`emission.model`", place));
        }
        true => {}
    }
    Ok(EmissionSource::Model(model))
}

#[cfg(test)]
mod tests;
