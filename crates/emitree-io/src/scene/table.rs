//! Reading a table key by key: typed values out, and nothing left over.

use super::document::{Entry, Node, Value};
use super::error::SceneError;
use super::source::Place;
use std::collections::BTreeMap;

/// A table that is being read. Keys that were not read are refused at the end, with the keys
/// that were read as what was expected.
pub(super) struct Table {
    path: String,
    place: Place,
    entries: BTreeMap<String, Entry>,
    asked: Vec<&'static str>,
}

impl Table {
    /// A table that the scene has not; `place` is where it could be.
    pub(super) fn absent(path: &str, place: &Place) -> Self {
        let (path, place) = (path.to_owned(), place.clone());
        Self { path, place, entries: BTreeMap::new(), asked: Vec::new() }
    }

    pub(super) fn new(node: Node) -> Result<Self, SceneError> {
        match node.value {
            Value::Table(entries) => {
                Ok(Self { path: node.path, place: node.place, entries, asked: Vec::new() })
            }
            _ => Err(wrong_kind(&node, "a table")),
        }
    }

    /// The value of an optional key.
    pub(super) fn take(&mut self, key: &'static str) -> Option<Node> {
        self.asked.push(key);
        self.entries.remove(key).map(|entry| entry.node)
    }

    /// The value of a key that is read elsewhere.
    pub(super) fn peek(&self, key: &str) -> Option<&Node> {
        self.entries.get(key).map(|entry| &entry.node)
    }

    /// The value of a key that must be there; a similar key is taken for a slip.
    pub(super) fn require(
        &mut self,
        key: &'static str,
        expected: &str,
    ) -> Result<Node, SceneError> {
        if let Some(node) = self.take(key) {
            return Ok(node);
        }
        if let Some(slip) = self.slip_of(key) {
            return Err(slip);
        }
        let path = self.path_of(key);
        Err(SceneError::at(&self.place, format!("`{path}` is missing"))
            .label(format!("expected `{key}` here: {expected}")))
    }

    /// The error of a key that may be a slip for one that is missing.
    pub(super) fn slip_of(&self, key: &str) -> Option<SceneError> {
        let (slip, entry) = self.entries.iter().find(|(other, _)| similar(key, other))?;
        Some(self.unknown(slip, entry))
    }

    pub(super) fn table(&mut self, key: &'static str) -> Result<Option<Self>, SceneError> {
        self.take(key).map(Self::new).transpose()
    }

    /// The tables `[[key]]`, in their order; none if the key is absent.
    pub(super) fn tables(
        &mut self,
        key: &'static str,
        expected: &str,
    ) -> Result<Vec<Self>, SceneError> {
        let Some(node) = self.take(key) else { return Ok(Vec::new()) };
        match node.value {
            Value::Array(items) => items.into_iter().map(Self::new).collect(),
            _ => Err(wrong_kind(&node, expected)),
        }
    }

    pub(super) fn text(
        &mut self,
        key: &'static str,
    ) -> Result<Option<(String, Place)>, SceneError> {
        self.take(key).map(|node| node.text()).transpose()
    }

    /// All entries as numbers, whatever their names.
    pub(super) fn numbers(self) -> Result<BTreeMap<String, (f64, Entry)>, SceneError> {
        let number = |(key, entry): (String, Entry)| {
            let value = entry.node.number()?;
            Ok((key, (value, entry)))
        };
        self.entries.into_iter().map(number).collect()
    }

    /// All entries, whatever their names.
    pub(super) fn into_entries(self) -> BTreeMap<String, Entry> {
        self.entries
    }

    /// The keys that lead to it, as in `emission.grid`.
    pub(super) fn path(&self) -> &str {
        &self.path
    }

    pub(super) fn place(&self) -> &Place {
        &self.place
    }

    /// Refuses keys that were not read.
    pub(super) fn finish(self) -> Result<(), SceneError> {
        self.entries.iter().next().map_or(Ok(()), |(key, entry)| Err(self.unknown(key, entry)))
    }

    fn unknown(&self, key: &str, entry: &Entry) -> SceneError {
        let known: Vec<String> = self.asked.iter().map(|key| format!("`{key}`")).collect();
        let label = match self.asked.iter().find(|known| similar(known, key)) {
            Some(known) => format!("did you mean `{known}`?"),
            None => format!("expected one of {}", known.join(", ")),
        };
        let path = self.path_of(key);
        SceneError::at(&entry.key, format!("unknown key `{path}`")).label(label)
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }
}

/// Whether one key may be a slip for the other: a letter or two changed, missing or swapped.
fn similar(a: &str, b: &str) -> bool {
    strsim::osa_distance(a, b) <= 1 + a.len().max(b.len()) / 5
}

impl Node {
    pub(super) fn text(&self) -> Result<(String, Place), SceneError> {
        match &self.value {
            Value::Text(text) => Ok((text.clone(), self.place.clone())),
            _ => Err(wrong_kind(self, "a string")),
        }
    }

    /// A finite number, written as an integer or not.
    pub(super) fn number(&self) -> Result<f64, SceneError> {
        match self.value {
            #[expect(clippy::cast_precision_loss, reason = "TOML's 1 and 1.0 mean the same here")]
            Value::Integer(integer) => Ok(integer as f64),
            Value::Real(real) if real.is_finite() => Ok(real),
            Value::Real(real) => Err(self.refuse(&real.to_string(), "a finite number")),
            _ => Err(wrong_kind(self, "a number")),
        }
    }

    /// A number that may be `inf` or `-inf`.
    pub(super) fn number_or_infinite(&self) -> Result<f64, SceneError> {
        match self.value {
            Value::Real(real) if real.is_infinite() => Ok(real),
            _ => self.number(),
        }
    }

    /// An integer that fits `T`.
    pub(super) fn count<T: TryFrom<i64>>(&self, expected: &str) -> Result<T, SceneError> {
        match self.value {
            Value::Integer(integer) => {
                T::try_from(integer).map_err(|_| self.refuse(&integer.to_string(), expected))
            }
            _ => Err(wrong_kind(self, expected)),
        }
    }

    pub(super) fn vector<const N: usize>(&self, expected: &str) -> Result<[f64; N], SceneError> {
        let Value::Array(items) = &self.value else { return Err(wrong_kind(self, expected)) };
        let numbers: Vec<f64> = items.iter().map(Self::number).collect::<Result<_, _>>()?;
        let count = numbers.len();
        <[f64; N]>::try_from(numbers)
            .map_err(|_| self.refuse(&format!("an array of {count}"), expected))
    }

    /// Any number of numbers, each with the node that it stands in.
    pub(super) fn list(&self, expected: &str) -> Result<Vec<(f64, &Self)>, SceneError> {
        let Value::Array(items) = &self.value else { return Err(wrong_kind(self, expected)) };
        items.iter().map(|item| Ok((item.number()?, item))).collect()
    }

    /// An error with the value and what was expected.
    pub(super) fn refuse(&self, value: &str, expected: &str) -> SceneError {
        SceneError::at(&self.place, format!("`{}` is {value}", self.path))
            .label(format!("expected {expected}"))
    }
}

fn wrong_kind(node: &Node, expected: &str) -> SceneError {
    node.refuse(node.value.kind(), expected)
}
