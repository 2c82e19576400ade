//! The text of a scene as a tree of values, each with its place in the text.
//!
//! The scene's kinds are tagged by a key (`type = "…"`), and a TOML reader that deserialises tagged
//! kinds loses the place of what is wrong. So values keep their spans here, and are read by hand.

use super::error::SceneError;
use super::source::{Place, Source};
use std::collections::BTreeMap;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value, its path of keys from the top, and its place.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) path: String,
    pub(super) place: Place,
    pub(super) value: Value,
}

#[derive(Clone, Debug)]
pub(super) enum Value {
    Text(String),
    Integer(i64),
    Real(f64),
    Boolean(bool),
    Datetime,
    Array(Vec<Node>),
    Table(BTreeMap<String, Entry>),
}

/// An entry of a table: its value, and where its key stands.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) key: Place,
    pub(super) node: Node,
}

impl Value {
    /// The kind of value, with its article, for messages.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Text(_) => "a string",
            Self::Integer(_) => "an integer",
            Self::Real(_) => "a number",
            Self::Boolean(_) => "a boolean",
            Self::Datetime => "a date",
            Self::Array(_) => "an array",
            Self::Table(_) => "a table",
        }
    }
}

impl Node {
    /// The root of a scene's text.
    pub(super) fn parse(source: &Arc<Source>) -> Result<Self, SceneError> {
        let whole = Place { source: Arc::clone(source), span: 0..source.text.len() };
        let table = DeTable::parse(&source.text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            SceneError::at(&Place { span, ..whole.clone() }, "the scene is not valid TOML")
                .label(error.message())
        })?;
        let value = table_value(source, "", table.get_ref())?;
        Ok(Self { path: String::new(), place: whole, value })
    }

    /// Puts `other` into this table: tables are merged, everything else is replaced.
    pub(super) fn merge(&mut self, other: Self) {
        match (&mut self.value, other.value) {
            (Value::Table(mine), Value::Table(theirs)) => {
                for (key, entry) in theirs {
                    match mine.get_mut(&key) {
                        Some(old) => old.node.merge(entry.node),
                        None => {
                            mine.insert(key, entry);
                        }
                    }
                }
            }
            (mine, theirs) => {
                *mine = theirs;
                self.place = other.place;
            }
        }
    }
}

fn table_value(source: &Arc<Source>, path: &str, table: &DeTable<'_>) -> Result<Value, SceneError> {
    let mut entries = BTreeMap::new();
    for (key, value) in table {
        let name = key.get_ref().to_string();
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        let key = Place { source: Arc::clone(source), span: key.span() };
        entries.insert(name, Entry { key, node: node(source, path, value)? });
    }
    Ok(Value::Table(entries))
}

fn node(
    source: &Arc<Source>,
    path: String,
    value: &Spanned<DeValue<'_>>,
) -> Result<Node, SceneError> {
    let place = Place { source: Arc::clone(source), span: value.span() };
    let not_held = |what| {
        SceneError::at(&place, format!("`{path}` is {what}")).label("expected a smaller number")
    };
    let value = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
            .map(Value::Integer)
            .map_err(|_| not_held("an integer beyond 64 bits"))?,
        DeValue::Float(real) => {
            real.as_str().parse().map(Value::Real).map_err(|_| not_held("no number"))?
        }
        DeValue::Boolean(value) => Value::Boolean(*value),
        DeValue::Datetime(_) => Value::Datetime,
        DeValue::Array(items) => {
            let item = |(i, item)| node(source, format!("{path}[{i}]"), item);
            Value::Array(items.iter().enumerate().map(item).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => table_value(source, &path, table)?,
    };
    Ok(Node { path, place, value })
}
