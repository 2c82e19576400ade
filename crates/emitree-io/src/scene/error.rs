//! A scene that can't be read: what, where, and what was expected.

use super::excerpt::{excerpt, shortened};
use super::source::Place;
use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};
use std::fmt;
use std::ops::Range;
use std::path::Path;

/// A scene that can't be read.
///
/// As a [`Diagnostic`] it carries the source text and the span of the offending part, so that a
/// report shows the file, the line, the text and what was expected there. Of very long lines and
/// quotations a part is left out.
#[derive(Clone, Debug)]
pub struct SceneError(Box<Details>);

#[derive(Clone, Debug)]
struct Details {
    message: String,
    label: Option<String>,
    help: Option<String>,
    place: Option<(NamedSource<String>, Range<usize>)>,
}

impl SceneError {
    /// An error about the text at `place`.
    pub(super) fn at(place: &Place, message: impl Into<String>) -> Self {
        let (text, span) = excerpt(&place.source.text, place.span.clone());
        let source = NamedSource::new(&place.source.name, text);
        Self(Box::new(Details {
            message: shortened(message.into()),
            label: None,
            help: None,
            place: Some((source, span)),
        }))
    }

    /// A scene file that can't be opened.
    pub(super) fn unreadable(path: &Path, cause: &std::io::Error) -> Self {
        Self(Box::new(Details {
            message: format!("the scene {} can't be read: {cause}", path.display()),
            label: None,
            help: None,
            place: None,
        }))
    }

    /// What stands at the marked text: usually what was expected there.
    #[must_use]
    pub(super) fn label(mut self, label: impl Into<String>) -> Self {
        self.0.label = Some(shortened(label.into()));
        self
    }

    /// A line of advice below the text.
    #[must_use]
    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.0.help = Some(shortened(help.into()));
        self
    }

    /// The same with other texts, each made of the former one.
    #[must_use]
    pub(super) fn with_text(mut self, of_text: impl Fn(&str) -> String) -> Self {
        self.0.message = of_text(&self.0.message);
        for text in [&mut self.0.label, &mut self.0.help] {
            *text = text.as_deref().map(&of_text);
        }
        self
    }

    /// What is wrong, in one sentence.
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// What was expected at the marked text; empty where the message says it all.
    pub fn expected(&self) -> &str {
        self.0.label.as_deref().unwrap_or_default()
    }

    /// The name of the source and the line of the offending text, from 1, if there is one.
    pub fn line(&self) -> Option<(&str, usize)> {
        let (source, span) = self.0.place.as_ref()?;
        let before = source.inner().get(..span.start)?;
        Some((source.name(), before.matches('\n').count() + 1))
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.message)
    }
}

impl std::error::Error for SceneError {}

impl Diagnostic for SceneError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let help = self.0.help.as_ref()?;
        Some(Box::new(help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        let (source, _) = self.0.place.as_ref()?;
        Some(source)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (_, span) = self.0.place.as_ref()?;
        let label = LabeledSpan::new_with_span(self.0.label.clone(), span.clone());
        Some(Box::new(std::iter::once(label)))
    }
}
