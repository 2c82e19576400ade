//! Options of the command line as scenes of one line that are merged into the file.

use super::document::Node;
use super::error::SceneError;
use super::source::Source;
use std::sync::Arc;

/// What the names of sources that are options of the command line start with.
const OPTION_PREFIX: &str = "option --";

/// A value that replaces one of the scene file: an option of the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    /// The key with its path, such as `render.method`.
    pub key: String,
    /// The value as TOML writes it; anything that is not TOML is taken as a string.
    pub value: String,
    /// The option that it comes from, such as `--method`, for messages.
    pub option: String,
}

impl Override {
    /// The scene of one line that this is, and the line as TOML.
    pub(super) fn parse(&self) -> Result<(Node, String), SceneError> {
        let parsed = |line: String| {
            let name = format!("{OPTION_PREFIX}{}", self.option.trim_start_matches('-'));
            let source = Arc::new(Source { name, text: line.clone() });
            Ok((Node::parse(&source)?, line))
        };
        let as_text = || format!("{} = {}", self.key, toml::Value::from(self.value.as_str()));
        if self.value.contains('\n') {
            return parsed(as_text());
        }
        // Words need no quotes on a command line; a number, a list or a table that is wrong is wrong.
        let is_number = |value: &str| value.chars().all(|c| "0123456789+-_.eE".contains(c));
        let is_word = |value: &str| !value.starts_with(['"', '\'', '[', '{']) && !is_number(value);
        parsed(format!("{} = {}", self.key, self.value)).or_else(|error| {
            if !is_word(&self.value) {
                return Err(error);
            }
            // If even a string can't be put there, it is the key that is wrong.
            parsed(as_text()).map_err(|_: SceneError| error)
        })
    }
}

pub(super) fn is_option(source: &Source) -> bool {
    source.name.starts_with(OPTION_PREFIX)
}
