//! `[emission]`: an expression or a built-in model.

use super::document::Node;
use super::error::SceneError;
use super::source::Place;
use super::table::Table;
use emitree::{Emission, Samples};
use emitree_models::{Expression, Model, ModelError, build_model};
use std::collections::BTreeMap;
use std::convert::Infallible;

/// The emission of a scene.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum SceneEmission {
    /// An expression, in the units that its writer had in mind.
    Expression(Expression),
    /// A built-in model.
    Model(Model),
}

impl SceneEmission {
    /// The length unit that positions are in; `None` where the scene is free to choose.
    pub fn length_unit(&self) -> Option<&'static str> {
        match self {
            Self::Expression(_) => None,
            Self::Model(model) => Some(model.description().length_unit).filter(|&unit| unit != "1"),
        }
    }

    /// The unit of an image, FITS grammar; empty if the scene does not tell.
    pub fn image_unit(&self) -> &'static str {
        match self {
            Self::Expression(_) => "",
            Self::Model(model) => model.description().image_unit,
        }
    }
}

impl Emission for SceneEmission {
    type Error = Infallible;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Infallible> {
        match self {
            Self::Expression(expression) => expression.emission_rates(samples, rates),
            Self::Model(model) => model.emission_rates(samples, rates),
        }
    }
}

pub(super) fn read(mut table: Table) -> Result<SceneEmission, SceneError> {
    let place = table.place().clone();
    let expression = table.text("expression")?;
    let model = table.text("model")?;
    let emission = match (expression, model) {
        (Some(expression), None) => {
            let constants = table.table("constants")?;
            read_expression(expression, constants)?
        }
        (None, Some(model)) => {
            let parameters = table.take("parameters");
            read_model(&model, parameters)?
        }
        (Some((_, place)), Some(_)) => {
            return Err(SceneError::at(&place, "the scene has two emissions")
                .label("expected either `expression` or `model`"));
        }
        (None, None) => {
            return Err(SceneError::at(&place, "the scene has no emission")
                .label("expected `expression = \"…\"` or `model = \"…\"` here"));
        }
    };
    table.finish()?;
    Ok(emission)
}

fn read_expression(
    (text, place): (String, Place),
    constants: Option<Table>,
) -> Result<SceneEmission, SceneError> {
    let constants = constants.map(Table::numbers).transpose()?.unwrap_or_default();
    let values = constants.iter().map(|(name, (value, _))| (name.clone(), *value)).collect();
    let expression = Expression::parse(&text, &values).map_err(|error| {
        let place = Place { span: span_in_string(&place, error.span()), ..place.clone() };
        let scene_error = SceneError::at(&place, format!("`emission.expression`: {error}"));
        match error.help() {
            Some(help) => scene_error.help(help),
            None => scene_error,
        }
    })?;
    if let Some(name) = expression.unused_constants().first()
        && let Some((_, entry)) = constants.get(name)
    {
        return Err(SceneError::at(&entry.key, format!("the constant `{name}` is not used"))
            .label("expected a name that stands in `emission.expression`"));
    }
    Ok(SceneEmission::Expression(expression))
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
) -> Result<SceneEmission, SceneError> {
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
    Ok(SceneEmission::Model(model))
}
