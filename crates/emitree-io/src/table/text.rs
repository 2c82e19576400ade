//! Columns of a text: CSV, ECSV and others.

use super::columns::{Column, Columns};
use super::error::{Place, TableReadError};

/// What separates the fields of a text.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Separator {
    Character(char),
    Blanks,
}

impl Separator {
    /// That of a row.
    fn of(row: &str) -> Self {
        let used = [',', ';'].into_iter().find(|&character| outside_quotes(row, character));
        used.map_or(Self::Blanks, Self::Character)
    }

    /// The fields of a row, without blanks and quotes around them.
    fn fields(self, row: &str) -> Vec<&str> {
        let mut fields = Vec::new();
        let (mut start, mut quote) = (0, None);
        for (at, character) in row.char_indices() {
            match quote {
                Some(open) if character == open => quote = None,
                Some(_) => {}
                None if character == '"' => quote = Some(character),
                None if self.separates(character) => {
                    fields.push(&row[start..at]);
                    start = at + character.len_utf8();
                }
                None => {}
            }
        }
        fields.push(&row[start..]);
        if self == Self::Blanks {
            fields.retain(|field| !field.trim().is_empty());
        }
        fields.into_iter().map(|field| field.trim().trim_matches('"').trim()).collect()
    }

    fn separates(self, character: char) -> bool {
        match self {
            Self::Character(other) => character == other,
            Self::Blanks => character.is_whitespace(),
        }
    }
}

/// Whether a character is in a row, not between quotes.
fn outside_quotes(row: &str, character: char) -> bool {
    row.split('"').step_by(2).any(|part| part.contains(character))
}

/// The columns of a text.
pub(super) fn columns(bytes: &[u8]) -> Result<Columns, TableReadError> {
    const EXPECTED: &str = "lines of numbers, the arguments and then the value";
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let rows = text.lines().enumerate().map(|(number, line)| {
        let content = if outside_quotes(line, '#') { before_comment(line) } else { line };
        (Place::Line(number + 1), content.trim())
    });
    let mut rows = rows.filter(|(_, row)| !row.is_empty()).peekable();
    let Some(&(first, row)) = rows.peek() else { return Err(TableReadError::NoRows(EXPECTED)) };
    let separator = Separator::of(row);
    let fields = separator.fields(row);
    let expected = fields.len();
    let is_header = fields.iter().all(|field| number(field).is_none());
    let names = (0..expected).map(|at| match fields.get(at) {
        Some(name) if is_header => (*name).to_owned(),
        _ => (at + 1).to_string(),
    });
    let mut columns: Vec<Column> = names.map(Column::new).collect();
    if is_header {
        rows.next();
    }
    let mut places = Vec::new();
    for (place, row) in rows {
        let fields = separator.fields(row);
        if fields.len() != expected {
            return Err(TableReadError::Fields { place, found: fields.len(), expected, first });
        }
        places.push(place);
        for (column, field) in columns.iter_mut().zip(fields) {
            column.push(number(field), field, place);
        }
    }
    if places.is_empty() {
        return Err(TableReadError::NoRows(EXPECTED));
    }
    Ok(Columns { columns, places })
}

fn before_comment(line: &str) -> &str {
    let mut is_quoted = false;
    for (at, character) in line.char_indices() {
        match character {
            '"' => is_quoted = !is_quoted,
            '#' if !is_quoted => return &line[..at],
            _ => {}
        }
    }
    line
}

/// A number, also as Fortran writes it, 1.5D-3.
fn number(field: &str) -> Option<f64> {
    let parsed = field.parse().ok();
    parsed.or_else(|| {
        let has_digits = field.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        let with_e = || field.replace(['d', 'D'], "e").parse().ok();
        has_digits.then(with_e).flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<(String, Vec<f64>)> {
        let columns = columns(text.as_bytes()).unwrap().columns;
        columns.into_iter().map(|column| (column.name, column.values)).collect()
    }

    fn failure(text: &str) -> String {
        columns(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn every_way_to_write_rows_is_read() {
        let expected = vec![("T".to_owned(), vec![1.0, 20.0]), ("L".to_owned(), vec![3.0, 0.04])];
        let ecsv = "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: T, unit: K, datatype: float64}\n\
                    # - {name: L, datatype: float64}\n# schema: astropy-2.0\nT L\n1.0 3\n20 0.04\n";
        for text in [
            "T,L\n1,3\n2e1,4e-2\n",
            "\u{feff}T;L\r\n1.0 ; 3\r\n20;0.04\r\n",
            "# of a model\n\n  T \t L # names\n1 3\n  2D+1\t4d-2  # the last\n",
            "\"T\",\"L\"\n1,3\n20,.04",
            ecsv,
        ] {
            assert_eq!(read(text), expected, "{text}");
        }
        assert_eq!(read("1 3\n20 0.04")[1], ("2".to_owned(), vec![3.0, 0.04]));
        assert_eq!(read("\"T, in K\",L\n1,3\n")[0].0, "T, in K");
    }

    #[test]
    fn rows_of_other_lengths_are_named() {
        assert_eq!(failure("T,L\n1,3\n\n1,3,4\n"), "line 4 has 3 fields: expected 2, as in line 1");
        let none = "it has no rows: expected lines of numbers, the arguments and then the value";
        for text in ["", "# T L\n\n", "T L\n"] {
            assert_eq!(failure(text), none);
        }
    }
}
