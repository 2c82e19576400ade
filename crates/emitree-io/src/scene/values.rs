//! All values of a scene by their keys: what two versions of a scene differ in.

use super::Scene;
use super::document::{Node, Value};
use super::error::SceneError;
use super::source::Source;
use std::collections::BTreeMap;
use std::sync::Arc;

impl Scene {
    /// The values of the scene with those of its overrides, each as text by the path of its key.
    pub(crate) fn values(&self) -> Result<BTreeMap<String, String>, SceneError> {
        let parse = |text: &String| {
            Node::parse(&Arc::new(Source { name: self.name.clone(), text: text.clone() }))
        };
        let mut root = parse(&self.text)?;
        for line in &self.overrides {
            root.merge(parse(line)?);
        }
        let mut values = BTreeMap::new();
        add(&mut values, String::new(), &root);
        Ok(values)
    }
}

/// Adds all values in a node, whose path may be another one than it had when it was parsed.
fn add(values: &mut BTreeMap<String, String>, path: String, node: &Node) {
    let text = match &node.value {
        Value::Table(entries) => {
            for (key, entry) in entries {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                add(values, path, &entry.node);
            }
            return;
        }
        Value::Array(items) if items.iter().any(|item| matches!(item.value, Value::Table(_))) => {
            for (number, item) in items.iter().enumerate() {
                add(values, format!("{path}[{number}]"), item);
            }
            return;
        }
        value => text_of(value),
    };
    values.insert(path, text);
}

/// A value that is no table, as text: 1 and 1.0 are the same.
fn text_of(value: &Value) -> String {
    match value {
        Value::Text(text) => format!("{text:?}"),
        Value::Integer(integer) => integer.to_string(),
        Value::Real(real) => real.to_string(),
        Value::Boolean(value) => value.to_string(),
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(|item| text_of(&item.value)).collect();
            format!("[{}]", items.join(", "))
        }
        value @ (Value::Datetime | Value::Table(_)) => value.kind().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Override;

    #[test]
    fn values_have_the_paths_of_their_keys_whatever_the_order() {
        let text = "image = { width = 8, height = 4 }\nemission.expression = \"a * x\"\n\
                    emission.constants = { a = 2.0 }\nprojection.type = \"canonical\"\n\
                    [[seed]]\nposition = [0.5, 0.25, 1]\nradius = 1e-2\n";
        let change = Override {
            key: "emission.constants.a".into(),
            value: "3".into(),
            option: "set".into(),
        };
        let values = Scene::parse("a scene", text, &[change]).unwrap().values().unwrap();
        let lines: Vec<String> =
            values.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        let expected = [
            "emission.constants.a = 3",
            "emission.expression = \"a * x\"",
            "image.height = 4",
            "image.width = 8",
            "projection.type = \"canonical\"",
            "seed[0].position = [0.5, 0.25, 1]",
            "seed[0].radius = 0.01",
        ];
        assert_eq!(lines, expected);
    }
}
