//! From text to a unit.

use super::UnitError;
use super::magnitude::Magnitude;
use super::table;
use super::unit::{Factor, Unit};

/// The deepest nesting of parentheses; two are usual.
const MAX_DEPTH: usize = 16;

/// The largest power; the 99 keeps all arithmetic on powers far from overflow.
const MAX_POWER: i32 = 99;

pub(super) fn parse(text: &str) -> Result<Unit, UnitError> {
    let mut parser = Parser { text, chars: text.chars().collect(), at: 0 };
    parser.skip_spaces();
    if parser.peek().is_none() {
        return Ok(Unit::one());
    }
    let unit = parser.product(0)?;
    match parser.peek() {
        None => Ok(unit),
        Some(_) => Err(parser.unexpected("a `(` before it")),
    }
}

struct Parser<'a> {
    text: &'a str,
    chars: Vec<char>,
    at: usize,
}

impl Parser<'_> {
    /// Factors with signs of multiplication, spaces or slashes between them, up to a `)` or the
    /// end.
    fn product(&mut self, depth: usize) -> Result<Unit, UnitError> {
        let mut unit = match self.peek() {
            Some(c) if c.is_ascii_digit() => self.number()?,
            _ => self.factor(depth)?,
        };
        let mut divided = false;
        loop {
            let apart = self.skip_spaces() || self.at > 0 && self.chars[self.at - 1] == ')';
            let sign = match self.peek() {
                None | Some(')') => return Ok(unit),
                Some(sign @ ('/' | '*' | '.' | '·')) => Some(sign),
                Some('(') => None,
                Some(c) if is_of_name(c) && apart => None,
                Some(_) => return Err(self.unexpected("a space, `*`, `/` or the end")),
            };
            if divided && sign != Some('/') {
                return Err(self.syntax(
                    "a product after a quotient".to_owned(),
                    "parentheses: a/(b c), or powers: a b-1 c",
                ));
            }
            if sign.is_some() {
                self.at += 1;
                self.skip_spaces();
            }
            divided = sign == Some('/');
            let factor = self.factor(depth)?;
            unit = unit.times(&if divided { factor.power(-1) } else { factor });
        }
    }

    /// A name or a product in parentheses, either to a power.
    fn factor(&mut self, depth: usize) -> Result<Unit, UnitError> {
        match self.peek() {
            Some('(') if depth == MAX_DEPTH => Err(self.unexpected("at most 16 open parentheses")),
            Some('(') => {
                self.at += 1;
                self.skip_spaces();
                let inner = self.product(depth + 1)?;
                if self.peek() != Some(')') {
                    return Err(self.unexpected("`)`"));
                }
                self.at += 1;
                let exponent = self.exponent()?.unwrap_or(1);
                Ok(inner.power(exponent))
            }
            Some(c) if is_of_name(c) => self.name(),
            _ => Err(self.unexpected("a unit")),
        }
    }

    fn name(&mut self) -> Result<Unit, UnitError> {
        let start = self.at;
        while self.peek().is_some_and(is_of_name) {
            self.at += 1;
        }
        let name: String = self.chars[start..self.at].iter().collect();
        let Some((prefix, known)) = table::find(&name) else {
            let suggestion = table::similar(&name);
            let (text, position) = (self.text.to_owned(), start + 1);
            return Err(UnitError::UnknownName { text, position, name, suggestion });
        };
        match self.exponent()?.unwrap_or(1) {
            0 => Ok(Unit::one()),
            exponent => Ok(Unit::named(Factor { prefix, known, exponent })),
        }
    }

    /// A positive number at the start of a product: `2.5`, `1e-6`, `10**6`, `10+6`.
    fn number(&mut self) -> Result<Unit, UnitError> {
        let start = self.at;
        self.skip_digits();
        let digit_at = |at: usize| self.chars.get(at).is_some_and(char::is_ascii_digit);
        if self.peek() == Some('.') && digit_at(self.at + 1) {
            self.at += 1;
            self.skip_digits();
        }
        if matches!(self.peek(), Some('e' | 'E')) {
            let signed = matches!(self.chars.get(self.at + 1), Some('+' | '-'));
            let digits = self.at + 1 + usize::from(signed);
            if self.chars.get(digits).is_some_and(char::is_ascii_digit) {
                self.at = digits;
                self.skip_digits();
            }
        }
        let text: String = self.chars[start..self.at].iter().collect();
        let value = text.parse().unwrap_or(f64::NAN);
        if !(value > 0.0 && value.is_finite()) {
            self.at = start;
            return Err(self.syntax(format!("the number {text}"), "a positive, finite number"));
        }
        let exponent = self.exponent()?.unwrap_or(1);
        Ok(Unit::number(decimal(value).power(exponent)))
    }

    /// The power that follows at once: `-3`, `**-3`, `^-3`, `(-3)`.
    fn exponent(&mut self) -> Result<Option<i32>, UnitError> {
        let next = |parser: &Self, ahead: usize| parser.chars.get(parser.at + ahead).copied();
        let starts = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit() || "+-".contains(c));
        let marked = match (next(self, 0), next(self, 1)) {
            (Some('*'), Some('*')) => 2,
            (Some('^'), _) => 1,
            _ => 0,
        };
        if marked == 0 && !starts(next(self, 0)) {
            // A product in parentheses may follow, too.
            if !(next(self, 0) == Some('(') && starts(next(self, 1))) {
                return Ok(None);
            }
        }
        self.at += marked;
        let bracketed = self.peek() == Some('(');
        self.at += usize::from(bracketed);
        let exponent = self.whole_power()?;
        if bracketed {
            if self.peek() != Some(')') {
                return Err(self.unexpected("`)` after a whole power"));
            }
            self.at += 1;
        }
        Ok(Some(exponent))
    }

    fn whole_power(&mut self) -> Result<i32, UnitError> {
        const EXPECTED: &str = "a whole power from -99 to 99";
        let start = self.at;
        if matches!(self.peek(), Some('+' | '-')) {
            self.at += 1;
        }
        self.skip_digits();
        let text: String = self.chars[start..self.at].iter().collect();
        let fraction = self.peek() == Some('.')
            && self.chars.get(self.at + 1).is_some_and(char::is_ascii_digit);
        match text.parse::<i32>() {
            Ok(power) if power.abs() <= MAX_POWER && !fraction => Ok(power),
            Ok(_) => {
                self.at = start;
                Err(self.syntax("a power that is out of range or not whole".to_owned(), EXPECTED))
            }
            // No digit, or more than a power can have.
            Err(_) if text.len() < 2 => Err(self.unexpected(EXPECTED)),
            Err(_) => {
                self.at = start;
                Err(self.syntax(format!("the power {text}"), EXPECTED))
            }
        }
    }

    fn peek(&self) -> Option<char> {
        self.chars.get(self.at).copied()
    }

    /// Whether there were any.
    fn skip_spaces(&mut self) -> bool {
        let start = self.at;
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
        self.at > start
    }

    fn skip_digits(&mut self) {
        while self.peek().is_some_and(|c| c.is_ascii_digit()) {
            self.at += 1;
        }
    }

    /// An error about the next character.
    fn unexpected(&self, expected: &'static str) -> UnitError {
        let found = self.peek().map_or_else(|| "the end".to_owned(), |c| format!("`{c}`"));
        self.syntax(found, expected)
    }

    /// An error at the next character.
    fn syntax(&self, found: String, expected: &'static str) -> UnitError {
        UnitError::Syntax { text: self.text.to_owned(), position: self.at + 1, found, expected }
    }
}

/// Whether a name may have the character; digits are powers.
fn is_of_name(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

/// A number with its power of ten apart if it is one.
#[expect(clippy::cast_possible_truncation, reason = "floats have decades from -324 to 308")]
#[expect(clippy::float_cmp, reason = "only the exact power of ten is one")]
fn decimal(value: f64) -> Magnitude {
    let power = Magnitude::new(1.0, value.log10().round() as i32);
    if power.value() == value { power } else { Magnitude::new(value, 0) }
}
