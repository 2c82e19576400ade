//! One number of a table that can't be.

/// A number in a table of a response, and what was expected in its place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{column} of row {row} is {value}: expected {expected}")]
pub struct WrongCell {
    /// The column, as OGIP names it; of a table of points `energy` or `area`.
    pub column: &'static str,
    /// The row, from 1.
    pub row: usize,
    /// The number.
    pub value: f64,
    /// What was expected.
    pub expected: String,
}

impl WrongCell {
    /// The number in the row at `index`, from 0.
    pub(crate) fn new(
        column: &'static str,
        index: usize,
        value: f64,
        expected: impl Into<String>,
    ) -> Self {
        Self { column, row: index + 1, value, expected: expected.into() }
    }

    /// Refuses the first number that is negative, infinite or none.
    pub(crate) fn unless_all_count(column: &'static str, values: &[f64]) -> Result<(), Self> {
        let counts = |value: &f64| *value >= 0.0 && value.is_finite();
        match values.iter().position(|value| !counts(value)) {
            Some(index) => {
                Err(Self::new(column, index, values[index], "a finite number, 0 or more"))
            }
            None => Ok(()),
        }
    }
}
