//! Names of files by the values of a sweep: `images/bz_{bz}.fits`.

use super::error::SweepError;
use super::{SceneSweep, SweptKey, as_text};
use std::collections::HashMap;
use std::path::PathBuf;

/// The name of the number of an image.
const NUMBER: &str = "number";

/// A name of files with parts in braces: a key of the sweep, its last part, or `number`, the number of the image
/// from 0 with leading zeros. Two braces are one in the name.
///
/// ```
/// use emitree_io::{NameTemplate, SceneSweep, SweptKey};
///
/// let sweep = SceneSweep::new(vec![SweptKey::parse("emission.parameters.bz=-5:5:11")?])?;
/// let names = NameTemplate::parse("images/{number}_bz{bz}.fits", &sweep)?.names(&sweep)?;
/// assert_eq!(names[10], std::path::Path::new("images/10_bz5.fits"));
/// # Ok::<(), emitree_io::SweepError>(())
/// ```
#[derive(Clone, Debug)]
pub struct NameTemplate {
    text: String,
    parts: Vec<Part>,
}

#[derive(Clone, Debug)]
enum Part {
    Text(String),
    /// The value of the key of this number.
    Value(usize),
    Number,
}

impl NameTemplate {
    /// Reads a template for a sweep.
    ///
    /// # Errors
    ///
    /// [`SweepError`]: a part in braces that is not a key of the sweep, a single brace.
    pub fn parse(text: &str, sweep: &SceneSweep) -> Result<Self, SweepError> {
        let brace = || SweepError::Brace { template: text.to_owned() };
        let (mut parts, mut plain, mut rest) = (Vec::new(), String::new(), text);
        while let Some(at) = rest.find(['{', '}']) {
            let (before, from) = rest.split_at(at);
            plain.push_str(before);
            if let Some(after) = from.strip_prefix("{{").or_else(|| from.strip_prefix("}}")) {
                plain.extend(from.chars().next());
                rest = after;
                continue;
            }
            let inside = from.strip_prefix('{').ok_or_else(brace)?;
            let (name, after) = inside.split_once('}').ok_or_else(brace)?;
            parts.push(Part::Text(core::mem::take(&mut plain)));
            parts.push(part(name, sweep.keys()).ok_or_else(|| SweepError::Placeholder {
                template: text.to_owned(),
                name: name.to_owned(),
                expected: names_of(sweep.keys()),
            })?);
            rest = after;
        }
        plain.push_str(rest);
        parts.push(Part::Text(plain));
        Ok(Self { text: text.to_owned(), parts })
    }

    /// The name of each image, all different.
    ///
    /// # Errors
    ///
    /// [`SweepError::SameName`].
    pub fn names(&self, sweep: &SceneSweep) -> Result<Vec<PathBuf>, SweepError> {
        let mut first_with: HashMap<String, usize> = HashMap::new();
        let name = |image| {
            let name = self.name(image, sweep);
            match first_with.insert(name.clone(), image) {
                None => Ok(PathBuf::from(name)),
                Some(first) => Err(SweepError::SameName {
                    name,
                    first: sweep.label(first),
                    second: sweep.label(image),
                    expected: names_of(sweep.keys()),
                }),
            }
        };
        (0..sweep.len()).map(name).collect()
    }

    /// The template as it was given.
    pub fn text(&self) -> &str {
        &self.text
    }

    fn name(&self, image: usize, sweep: &SceneSweep) -> String {
        let values = sweep.values(image);
        let digits = sweep.len().saturating_sub(1).to_string().len();
        let of_part = |part: &Part| match part {
            Part::Text(text) => text.clone(),
            Part::Value(key) => values.get(*key).copied().map(as_text).unwrap_or_default(),
            Part::Number => format!("{image:0digits$}"),
        };
        self.parts.iter().map(of_part).collect()
    }
}

/// A key by its name, or by the last part of its name if no other key has the same.
fn part(name: &str, keys: &[SweptKey]) -> Option<Part> {
    if let Some(key) = keys.iter().position(|key| key.name() == name) {
        return Some(Part::Value(key));
    }
    let mut with_part = keys.iter().enumerate().filter(|(_, key)| key.last_part() == name);
    match (with_part.next(), with_part.next()) {
        (Some((key, _)), None) => Some(Part::Value(key)),
        (None, _) if name == NUMBER => Some(Part::Number),
        _ => None,
    }
}

/// What may stand in braces.
fn names_of(keys: &[SweptKey]) -> Vec<String> {
    let shortest = |key: &SweptKey| {
        let is_only = keys.iter().filter(|other| other.last_part() == key.last_part()).count() == 1;
        if is_only { key.last_part() } else { key.name() }.to_owned()
    };
    keys.iter().map(shortest).chain([NUMBER.to_owned()]).collect()
}
