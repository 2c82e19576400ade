//! The values of one key, `KEY=START:STOP:COUNT` or `KEY=A,B,C`.

use super::error::SweepError;
use super::{MOST_IMAGES, as_text};

/// A key of a scene and its values, all different and finite.
///
/// ```
/// use emitree_io::SweptKey;
///
/// let key = SweptKey::parse("emission.parameters.bz=-5:5:11")?;
/// assert_eq!((key.name(), key.values()[3]), ("emission.parameters.bz", -2.0));
/// assert_eq!(SweptKey::parse("image.width=32,64")?.values(), [32.0, 64.0]);
/// # Ok::<(), emitree_io::SweepError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SweptKey {
    name: String,
    values: Vec<f64>,
}

impl SweptKey {
    /// Reads `KEY=START:STOP:COUNT`, COUNT values in uniform steps with both ends, rounded to 12 digits, or
    /// `KEY=A,B,C`.
    ///
    /// # Errors
    ///
    /// [`SweepError`] names the key, the text and what was expected.
    pub fn parse(text: &str) -> Result<Self, SweepError> {
        let form = || SweepError::Form { text: text.to_owned() };
        let (name, values) = text.split_once('=').ok_or_else(form)?;
        let (name, values) = (name.trim(), values.trim());
        if name.is_empty() || values.is_empty() {
            return Err(form());
        }
        let values = match values.contains(':') {
            true => steps(name, values)?,
            false => list(name, values)?,
        };
        for (number, &value) in values.iter().enumerate() {
            if values.iter().take(number).any(|&before| is_same(before, value)) {
                return Err(SweepError::ValueTwice { key: name.into(), value: as_text(value) });
            }
        }
        Ok(Self { name: name.to_owned(), values })
    }

    /// The key with its path, such as `emission.parameters.bz`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The last part of the key, such as `bz`.
    pub fn last_part(&self) -> &str {
        self.name.rsplit('.').next().unwrap_or_default().trim_matches(['"', '\'', ' '])
    }

    /// The values, in the order given.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

fn list(key: &str, values: &str) -> Result<Vec<f64>, SweepError> {
    values.split(',').map(|text| number(key, text)).collect()
}

fn steps(key: &str, values: &str) -> Result<Vec<f64>, SweepError> {
    let parts: Vec<&str> = values.split(':').collect();
    let [start, stop, count] = parts.as_slice() else {
        return Err(SweepError::Steps { key: key.into(), text: values.into() });
    };
    let [start, stop] = [number(key, start)?, number(key, stop)?];
    let of_count = || SweepError::Count { key: key.into(), text: count.trim().into() };
    let count: usize = count.trim().parse().map_err(|_| of_count())?;
    if count == 0 || (count == 1 && !is_same(start, stop)) {
        return Err(of_count());
    }
    if count > MOST_IMAGES {
        return Err(SweepError::TooMany { count, most: MOST_IMAGES });
    }
    let steps = (count - 1).max(1) as f64;
    // Without the last digits, which are of the binary number: 0.3 is not 0.30000000000000004.
    let at = |i: usize| rounded(start + (stop - start) * (i as f64 / steps));
    let mut values: Vec<f64> = (0..count).map(at).collect();
    if let Some(last) = values.last_mut() {
        *last = stop;
    }
    if let Some(first) = values.first_mut() {
        *first = start;
    }
    Ok(values)
}

/// Whether two values are the same number; 0 and −0 are.
#[expect(clippy::float_cmp, reason = "values as they are written")]
fn is_same(a: f64, b: f64) -> bool {
    a == b
}

/// A number to 12 digits; 0 without a sign.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value) + 0.0
}

fn number(key: &str, text: &str) -> Result<f64, SweepError> {
    let text = text.trim();
    let not_a_number = || SweepError::Number { key: key.into(), text: text.into() };
    let value: f64 = text.parse().map_err(|_| not_a_number())?;
    if value.is_finite() { Ok(value) } else { Err(not_a_number()) }
}
