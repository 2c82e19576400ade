//! Header records: a keyword, its value, and what it means.

use super::FitsEncodeError;
use fits_well::FitsError;
use fits_well::header::{Header, Value};
use std::borrow::Cow;

/// A header record: keyword, value, comment.
///
/// ```
/// use emitree_io::Card;
///
/// let cards = [
///     Card::new("METHOD", "vol", "how the image was computed"),
///     Card::new("NEVAL", 4066, "evaluations of the emission rate"),
///     Card::new("TOL", 0.01, "tolerance, relative to the largest pixel"),
///     Card::new("CONVERGD", true, "the tolerance was met"),
/// ];
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Card {
    /// One to eight of A–Z, 0–9, `-` and `_`.
    pub keyword: String,
    /// The value.
    pub value: CardValue,
    /// What the keyword means, in a few words; cut where the record ends, except for texts.
    pub comment: String,
}

impl Card {
    /// A record from its three parts.
    pub fn new(
        keyword: impl Into<String>,
        value: impl Into<CardValue>,
        comment: impl Into<String>,
    ) -> Self {
        Self { keyword: keyword.into(), value: value.into(), comment: comment.into() }
    }
}

/// The value of a header record.
#[derive(Clone, Debug, PartialEq)]
pub enum CardValue {
    /// A text of any length: a long one goes on in `CONTINUE` records.
    Text(String),
    /// An integer.
    Integer(i128),
    /// A real number, written with as many digits as bring it back exactly. FITS has no infinity
    /// and no NaN: they become a record without a value.
    Real(f64),
    /// Yes or no.
    Logical(bool),
}

impl From<&str> for CardValue {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for CardValue {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<i32> for CardValue {
    fn from(integer: i32) -> Self {
        Self::Integer(integer.into())
    }
}

impl From<i64> for CardValue {
    fn from(integer: i64) -> Self {
        Self::Integer(integer.into())
    }
}

impl From<u64> for CardValue {
    fn from(integer: u64) -> Self {
        Self::Integer(integer.into())
    }
}

impl From<usize> for CardValue {
    fn from(integer: usize) -> Self {
        // No machine has an address space of more than 128 bits.
        Self::Integer(integer as i128)
    }
}

impl From<f64> for CardValue {
    fn from(real: f64) -> Self {
        Self::Real(real)
    }
}

impl From<bool> for CardValue {
    fn from(logical: bool) -> Self {
        Self::Logical(logical)
    }
}

/// Puts `card` into `header`, its comment cut to the room that the value leaves.
pub(crate) fn set(header: &mut Header, card: &Card) -> Result<(), FitsEncodeError> {
    let keyword = card.keyword.as_str();
    let value = match &card.value {
        CardValue::Text(text) => Value::Text(ascii(text).into_owned()),
        CardValue::Integer(integer) => Value::Integer((*integer).into()),
        CardValue::Real(real) if real.is_finite() => Value::Real(*real),
        CardValue::Real(_) => Value::Undefined,
        CardValue::Logical(logical) => Value::Logical(*logical),
    };
    let error = |source| FitsEncodeError::Card { keyword: keyword.to_owned(), source };
    header.set(keyword, value).map_err(error)?;
    let comment = ascii(&card.comment);
    match header.set_comment(keyword, &comment) {
        Err(FitsError::HeaderCardTooLong { length, .. }) => {
            let room = (comment.len() + CARD_LENGTH).saturating_sub(length);
            header.set_comment(keyword, comment[..room].trim_end()).map_err(error)?;
        }
        other => {
            other.map_err(error)?;
        }
    }
    Ok(())
}

/// Characters of a header record.
const CARD_LENGTH: usize = 80;

/// Characters of a `HISTORY` record after its name.
const HISTORY_LENGTH: usize = 72;

/// `text` in the characters of FITS: others become `\u00e9` or `\U0001f30d`, a tab two spaces.
pub(super) fn ascii(text: &str) -> Cow<'_, str> {
    if text.chars().all(|c| matches!(c, ' '..='~')) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        match (c, u32::from(c)) {
            (' '..='~', _) => escaped.push(c),
            ('\t', _) => escaped.push_str("  "),
            (_, code @ ..=0xffff) => escaped.push_str(&format!("\\u{code:04x}")),
            (_, code) => escaped.push_str(&format!("\\U{code:08x}")),
        }
    }
    Cow::Owned(escaped)
}

/// The `HISTORY` records of a text. Only a record that goes on in the next ends in a backslash in
/// its last column, so that the lines can be had back.
pub(crate) fn history_lines(text: &str) -> Vec<String> {
    let mut records = Vec::new();
    for line in text.lines() {
        let line = ascii(line.trim_end());
        let mut rest = &*line;
        while rest.len() > HISTORY_LENGTH || rest.len() == HISTORY_LENGTH && rest.ends_with('\\') {
            let (piece, after) = rest.split_at(HISTORY_LENGTH - 1);
            records.push(format!("{piece}\\"));
            rest = after;
        }
        records.push(rest.to_owned());
    }
    records
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_beyond_ascii_are_escaped_as_in_toml() {
        assert!(matches!(ascii("plain ~ text"), Cow::Borrowed("plain ~ text")));
        assert_eq!(ascii("é\t🌍\r\u{7f}"), "\\u00e9  \\U0001f30d\\u000d\\u007f");
    }

    #[test]
    fn history_can_be_joined_again() {
        let long = "x".repeat(200);
        let at_the_edge = format!("{}\\", "y".repeat(71));
        let exact = "z".repeat(72);
        let text = format!("a = 1\n\n  {long}\n{at_the_edge}\n{exact}");
        let records = history_lines(&text);
        assert!(records.iter().all(|record| record.len() <= 72));
        let mut joined = String::new();
        for record in &records {
            match record.strip_suffix('\\') {
                Some(piece) if record.len() == 72 => joined.push_str(piece),
                _ => joined.extend([record, "\n"]),
            }
        }
        assert_eq!(joined.trim_end(), text);
    }

    #[test]
    fn comments_are_cut_where_the_record_ends() {
        let mut header = Header::new();
        let comment = "c".repeat(90);
        for (keyword, value) in [("A", CardValue::Integer(1)), ("B", (-1.0 / 3.0 * 1e-200).into())]
        {
            set(&mut header, &Card::new(keyword, value, comment.clone())).unwrap();
            let kept = header.get_comment(keyword).unwrap().unwrap();
            assert!(comment.starts_with(kept) && kept.len() > 40, "{keyword}: {}", kept.len());
        }
        set(&mut header, &Card::new("C", "text", comment.clone())).unwrap();
        assert!(header.get_comment("C").unwrap().unwrap().len() >= 60);
    }

    #[test]
    fn reals_without_a_number_have_no_value() {
        let mut header = Header::new();
        set(&mut header, &Card::new("A", f64::INFINITY, "none")).unwrap();
        assert_eq!(header.get("A").unwrap(), Some(&Value::Undefined));
    }
}
