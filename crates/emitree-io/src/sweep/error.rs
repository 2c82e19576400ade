//! What can be wrong with a sweep.

use crate::words::alternatives;

/// A sweep that can't be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// No key has values.
    #[error("no key has values: expected KEY=START:STOP:COUNT or KEY=A,B,C")]
    NoKey,
    /// The text is not that of a key and its values.
    #[error(
        "`{text}`: expected KEY=START:STOP:COUNT, as in emission.parameters.bz=-5:5:11, or KEY=A,B,C, as \
         in image.width=32,64"
    )]
    Form {
        /// The text.
        text: String,
    },
    /// The steps are not two numbers and a count.
    #[error("the values of `{key}` are `{text}`: expected START:STOP:COUNT, as in -5:5:11")]
    Steps {
        /// The key.
        key: String,
        /// The text.
        text: String,
    },
    /// A value is not a number.
    #[error("a value of `{key}` is `{text}`: expected a finite number")]
    Number {
        /// The key.
        key: String,
        /// The text.
        text: String,
    },
    /// The number of values is not one.
    #[error(
        "the count of values of `{key}` is `{text}`: expected a whole number of 2 or more, or 1 where START \
         is STOP"
    )]
    Count {
        /// The key.
        key: String,
        /// The text.
        text: String,
    },
    /// A key is there twice.
    #[error("the key `{key}` has values twice: expected each key once")]
    KeyTwice {
        /// The key.
        key: String,
    },
    /// A value is there twice.
    #[error("`{key}` has the value {value} twice: expected different values")]
    ValueTwice {
        /// The key.
        key: String,
        /// The value.
        value: String,
    },
    /// There are too many images.
    #[error("the sweep has {count} images: expected {most} or less")]
    TooMany {
        /// The number of images.
        count: usize,
        /// The largest number allowed.
        most: usize,
    },
    /// A name of files has a part in braces that is no key.
    #[error(
        "the output `{template}` has `{{{name}}}`: expected {}",
        alternatives(expected.iter().map(|name| format!("{{{name}}}")))
    )]
    Placeholder {
        /// The template.
        template: String,
        /// The part in braces.
        name: String,
        /// What may stand in braces.
        expected: Vec<String>,
    },
    /// A brace is not closed, or not opened.
    #[error(
        "the output `{template}` has a single brace: expected {{KEY}}, or two braces for one in the name"
    )]
    Brace {
        /// The template.
        template: String,
    },
    /// Two images have the same name.
    #[error(
        "the output `{name}` is that of {first} and of {second}: expected a name with {}",
        alternatives(expected.iter().map(|name| format!("{{{name}}}")))
    )]
    SameName {
        /// The name.
        name: String,
        /// The values of one image.
        first: String,
        /// The values of the other one.
        second: String,
        /// What would make the names different.
        expected: Vec<String>,
    },
}
