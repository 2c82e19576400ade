//! A scene that can't be read: what, where, and what was expected.

use super::document::Place;
use miette::{Diagnostic, NamedSource, SourceSpan};
use std::fmt;
use std::path::PathBuf;

/// A scene that can't be read.
///
/// As a [`Diagnostic`] it carries the source text and the span of the offending part, so that a
/// report shows the file, the line, the text and what was expected there.
#[derive(Clone, Debug, Diagnostic)]
pub struct SceneError {
    message: String,
    label: String,
    #[help]
    help: Option<String>,
    #[source_code]
    source: Option<NamedSource<String>>,
    #[label("{label}")]
    span: Option<SourceSpan>,
}

impl SceneError {
    /// An error about the text at `place`.
    pub(super) fn at(place: &Place, message: impl Into<String>) -> Self {
        let source = NamedSource::new(&place.source.name, place.source.text.clone());
        Self {
            message: message.into(),
            label: "here".into(),
            help: None,
            source: Some(source),
            span: Some(place.span.clone().into()),
        }
    }

    /// A scene file that can't be opened.
    pub(super) fn unreadable(path: &PathBuf, cause: &std::io::Error) -> Self {
        Self {
            message: format!("the scene {} can't be read: {cause}", path.display()),
            label: String::new(),
            help: None,
            source: None,
            span: None,
        }
    }

    /// What stands at the marked text: usually what was expected there.
    #[must_use]
    pub(super) fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// A line of advice below the text.
    #[must_use]
    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// What is wrong, in one sentence.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What was expected at the marked text.
    pub fn expected(&self) -> &str {
        &self.label
    }

    /// The name of the source and the line of the offending text, from 1, if there is one.
    pub fn line(&self) -> Option<(&str, usize)> {
        let (source, span) = (self.source.as_ref()?, self.span?);
        let before = source.inner().get(..span.offset())?;
        Some((source.name(), before.matches('\n').count() + 1))
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for SceneError {}
