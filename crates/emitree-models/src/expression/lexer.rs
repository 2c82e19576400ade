//! From text to tokens: numbers, names, operators and parentheses.

use super::error::ExpressionError;
use core::ops::Range;

/// The smallest meaningful piece of an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Token<'a> {
    Number(f64),
    Name(&'a str),
    Plus,
    Minus,
    Star,
    Slash,
    Caret,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
    Open,
    Close,
    Comma,
    End,
}

/// Whether a constant of this name could be written in an expression.
pub(super) fn is_name(text: &str) -> bool {
    text.starts_with(starts_name) && text.chars().all(continues_name)
}

fn starts_name(letter: char) -> bool {
    letter.is_alphabetic() || letter == '_'
}

fn continues_name(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// Hands out the tokens of a text one after the other, then [`Token::End`] for ever.
#[derive(Debug)]
pub(super) struct Lexer<'a> {
    text: &'a str,
    position: usize,
}

impl<'a> Lexer<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, position: 0 }
    }

    /// The text at a token's place.
    pub(super) fn text(&self, span: Range<usize>) -> &'a str {
        &self.text[span]
    }

    /// The next token and its place in the text.
    pub(super) fn token(&mut self) -> Result<(Token<'a>, Range<usize>), ExpressionError> {
        let rest = self.text[self.position..].trim_start();
        let start = self.text.len() - rest.len();
        let (token, length) = match rest.chars().next() {
            None => (Token::End, 0),
            Some(first) if first.is_ascii_digit() || first == '.' => number(rest, start)?,
            Some(first) if starts_name(first) => {
                let length = rest.find(|c| !continues_name(c)).unwrap_or(rest.len());
                (Token::Name(&rest[..length]), length)
            }
            Some(first) => symbol(rest, first, start)?,
        };
        self.position = start + length;
        Ok((token, start..self.position))
    }
}

/// An operator, a parenthesis or a comma at the start of `rest`.
fn symbol<'a>(
    rest: &str,
    first: char,
    start: usize,
) -> Result<(Token<'a>, usize), ExpressionError> {
    let two = [
        ("<=", Token::LessEqual),
        (">=", Token::GreaterEqual),
        ("==", Token::Equal),
        ("!=", Token::NotEqual),
    ];
    if let Some(&(_, token)) = two.iter().find(|(text, _)| rest.starts_with(text)) {
        return Ok((token, 2));
    }
    let token = match first {
        '+' => Token::Plus,
        '-' => Token::Minus,
        '*' => Token::Star,
        '/' => Token::Slash,
        '^' => Token::Caret,
        '<' => Token::Less,
        '>' => Token::Greater,
        '(' => Token::Open,
        ')' => Token::Close,
        ',' => Token::Comma,
        _ => {
            let span = start..start + first.len_utf8();
            let error = ExpressionError::new(format!("unexpected character `{first}`"), span);
            return Err(match first {
                '=' => error.with_help("to compare, write =="),
                '&' => error.with_help("multiply conditions: (x > 0) * (y > 0)"),
                '|' => error.with_help("take the larger of two conditions: max(x > 0, y > 0)"),
                '!' => error.with_help("compare with 0 instead: (x > 0) == 0"),
                '²' | '³' => error.with_help("powers are written x^2"),
                '−' | '–' => error.with_help("the minus sign is -"),
                '·' | '×' => error.with_help("products are written with *"),
                '[' | '{' => error.with_help("only parentheses group: ( )"),
                _ => error,
            });
        }
    };
    Ok((token, first.len_utf8()))
}

/// A number at the start of `rest`: digits with single underscores between them (as in TOML), a
/// fraction, an exponent.
fn number<'a>(rest: &str, start: usize) -> Result<(Token<'a>, usize), ExpressionError> {
    let bytes = rest.as_bytes();
    let digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
    let digits = |from: usize| {
        let mut end = from;
        while digit(end) || (end > from && bytes.get(end) == Some(&b'_') && digit(end + 1)) {
            end += 1;
        }
        end
    };
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        // Without a digit the letter is no exponent, and the parser will expect an operator.
        if digit(end + 1 + sign) {
            end = digits(end + 1 + sign);
        }
    }
    let (text, span) = (&rest[..end], start..start + end);
    match text.replace('_', "").parse::<f64>() {
        Ok(value) if value.is_finite() => Ok((Token::Number(value), end)),
        Ok(_) => Err(ExpressionError::new(format!("the number {text} is too large"), span)
            .with_help(format!("the largest number is {:e}", f64::MAX))),
        Err(_) => Err(ExpressionError::new(format!("`{text}` is not a number"), span)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Vec<Token<'_>> {
        let mut lexer = Lexer::new(text);
        let mut tokens = Vec::new();
        loop {
            match lexer.token().unwrap().0 {
                Token::End => return tokens,
                token => tokens.push(token),
            }
        }
    }

    #[test]
    fn numbers() {
        let values = [
            ("0", 0.0),
            ("1e-3", 1e-3),
            ("2E+5", 2e5),
            (".5", 0.5),
            ("5.", 5.0),
            ("1_000", 1000.0),
            ("1_0.2_5e1_0", 10.25e10),
            ("1e-999", 0.0),
        ];
        for (text, value) in values {
            assert_eq!(tokens(text), [Token::Number(value)], "{text}");
        }
    }

    #[test]
    fn a_number_ends_where_it_makes_no_sense_any_more() {
        assert_eq!(tokens("2e"), [Token::Number(2.0), Token::Name("e")]);
        assert_eq!(tokens("1__0"), [Token::Number(1.0), Token::Name("__0")]);
        assert_eq!(tokens("1_"), [Token::Number(1.0), Token::Name("_")]);
    }

    #[test]
    fn operators_and_names() {
        let expected = [
            Token::Name("α_1"),
            Token::LessEqual,
            Token::Minus,
            Token::Name("b"),
            Token::Less,
            Token::Name("c"),
        ];
        assert_eq!(tokens(" α_1<=-b\n< c"), expected);
    }

    #[test]
    fn failures() {
        let error = |text| Lexer::new(text).token().unwrap_err();
        assert_eq!(error("  $").to_string(), "unexpected character `$`");
        assert_eq!(error("  $").span(), 2..3);
        assert_eq!(error("=").help(), Some("to compare, write =="));
        assert_eq!(error("1e999").to_string(), "the number 1e999 is too large");
        assert_eq!(error(" .").to_string(), "`.` is not a number");
        assert_eq!(error("²").span(), 0..2);
    }
}
