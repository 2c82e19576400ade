//! The summary of a sweep, for people: a table of its images.

use crate::failure::Failure;
use emitree_io::{SweepReport, SweptImage, grouped};
use std::io::Write;
use std::path::Path;

pub(super) fn print(scene: &Path, report: &SweepReport) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let count = report.images().len();
    let images = format!("{count} image{}", if count == 1 { "" } else { "s" });
    let evaluations = grouped(report.evaluations());
    writeln!(out, "{}: {images}, {evaluations} evaluations", scene.display())?;
    let columns = ["evaluations", "estimated error", "converged"].map(str::to_owned);
    let mut rows = vec![report.keys().iter().cloned().chain(columns).collect::<Vec<_>>()];
    rows.extend(report.images().iter().map(row));
    for line in aligned(&rows) {
        writeln!(out, "  {line}")?;
    }
    Ok(())
}

fn row(image: &SweptImage) -> Vec<String> {
    let values = image.values.iter().map(f64::to_string);
    let of_rendering = match (&image.error, image.estimated_error) {
        (Some(_), _) => ["-".to_owned(), "-".to_owned(), "FAILED".to_owned()],
        (None, error) => [
            grouped(image.evaluations),
            error.map_or_else(|| "none".to_owned(), |error| format!("{error:.2e}")),
            if image.converged { "yes" } else { "NO" }.to_owned(),
        ],
    };
    values.chain(of_rendering).collect()
}

/// The rows with columns of one width, the numbers to the right.
fn aligned(rows: &[Vec<String>]) -> Vec<String> {
    let columns = rows.first().map_or(0, Vec::len);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max()
    };
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:>width$}"));
        cells.collect::<Vec<_>>().join("  ")
    };
    rows.iter().map(line).collect()
}
