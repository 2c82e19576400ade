//! Tables of numbers.

use core::fmt;

/// A table; what is not known is `-`.
#[derive(Debug)]
pub(crate) struct Table {
    pub(crate) title: &'static str,
    pub(crate) columns: Vec<&'static str>,
    /// Plain numbers, or names, as text: as many in each row as there are columns.
    pub(crate) rows: Vec<Vec<String>>,
}

/// Comma-separated values, after a comment with the title.
impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "# table: {}", self.title)?;
        writeln!(f, "{}", self.columns.join(","))?;
        self.rows.iter().try_for_each(|row| writeln!(f, "{}", row.join(",")))
    }
}

/// A number with three significant digits.
#[expect(clippy::cast_possible_truncation, reason = "exponents of numbers are below 400")]
pub(crate) fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    // After rounding: 9.996 is 10.0.
    let scientific = format!("{x:.2e}");
    let rounded: f64 = scientific.parse().unwrap_or(x);
    let exponent = rounded.abs().log10().floor() as i32;
    match usize::try_from(2 - exponent) {
        _ if exponent < -3 => scientific,
        Ok(decimals) => format!("{rounded:.decimals$}"),
        Err(_) => format!("{rounded:.0}"),
    }
}

/// Mebibytes.
pub(crate) fn mebibytes(bytes: usize) -> String {
    number(bytes as f64 / f64::from(1 << 20))
}

/// The slope of the straight line that fits log y against log x best; `None` for fewer than two
/// points.
pub(crate) fn exponent(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> = points.iter().map(|point| point.map(f64::ln)).collect();
    let count = logs.len() as f64;
    let mean = |at: usize| logs.iter().map(|log| log[at]).sum::<f64>() / count;
    let [x, y] = [mean(0), mean(1)];
    let square: f64 = logs.iter().map(|log| (log[0] - x) * (log[0] - x)).sum();
    let product: f64 = logs.iter().map(|log| (log[0] - x) * (log[1] - y)).sum();
    (square > 0.0).then(|| product / square)
}
