//! The runs as tables and pictures.

use super::measure::{Measurements, Run};
use crate::failure::Failure;
use emitree_io::ValueRange;
use emitree_io::figure::{Axis, Heatmap, Panel, Plot, Series};
use std::fmt::Write;

/// Pixels of the pictures for each unit of the drawing.
const SCALE: f64 = 2.0;

/// Figure 9: the exact image and the hierarchical one, in the same colours.
pub(crate) fn images(measured: &Measurements) -> Result<Vec<u8>, Failure> {
    let range = ValueRange::of(&[&measured.exact]);
    let panel = |image, title: &str| {
        Panel::new(image).title(title).x("x", [0.0, 1.0]).y("y", [0.0, 1.0]).range(range)
    };
    let title = format!(
        "{} evaluations, largest error {:.1} %",
        emitree_io::grouped(measured.figure_9.evaluations),
        100.0 * measured.figure_9.error
    );
    let exact = panel(&measured.exact, "exact").colour_bar("radiance");
    let hierarchical = panel(&measured.figure_9_image, &title).colour_bar("radiance");
    let figure = Heatmap::new()
        .title("Fig. 9: eq. (8), 64 × 64 pixels")
        .panel(exact)
        .panel(hierarchical)
        .draw()?;
    Ok(figure.png(SCALE)?)
}

/// Figure 10: error against evaluations for both methods.
pub(crate) fn error_against_evaluations(measured: &Measurements) -> Result<Vec<u8>, Failure> {
    let points = |runs: &[Run]| -> Vec<[f64; 2]> {
        runs.iter().map(|run| [run.evaluations as f64, run.error]).collect()
    };
    let mut plot = Plot::new(
        Axis::log("evaluations of the emission rate"),
        Axis::log("largest error / largest pixel"),
    )
    .title("Fig. 10: eq. (8), 64 × 64 pixels")
    .series(Series::line("hierarchical, base grid 4³", points(&measured.paper_4)).marked())
    .series(Series::line("hierarchical, base grid 8³", points(&measured.paper_8)).marked());
    for (lines, runs) in &measured.los {
        let label = format!("{} for each pixel", super::counted_lines(*lines));
        plot = plot.series(Series::line(label, points(runs)).marked().dashed());
    }
    let figure = plot
        .horizontal_line(0.01, "1 %")
        .series(Series::markers("stated in the paper", [[4032.0, 0.06], [20_000.0, 0.01]]))
        .draw()?;
    Ok(figure.png(SCALE)?)
}

/// Figure 11: error against threshold.
pub(crate) fn error_against_threshold(measured: &Measurements) -> Result<Vec<u8>, Failure> {
    let points = |runs: &[Run]| -> Vec<[f64; 2]> {
        runs.iter().map(|run| [run.parameter, run.error]).collect()
    };
    let figure = Plot::new(Axis::log("threshold ε"), Axis::log("largest error / largest pixel"))
        .title("Fig. 11: eq. (8), 64 × 64 pixels")
        .series(Series::line("hierarchical, base grid 4³", points(&measured.paper_4)).marked())
        .series(Series::line("hierarchical, base grid 8³", points(&measured.paper_8)).marked())
        .draw()?;
    Ok(figure.png(SCALE)?)
}

/// Runs as CSV.
pub(crate) fn csv_of_runs<'a>(runs: impl Iterator<Item = &'a Run>) -> Vec<u8> {
    let mut csv = String::from("method,threshold_or_steps,evaluations,max_relative_error\n");
    for run in runs {
        // Writing to a string can't fail.
        let _ = writeln!(
            csv,
            "\"{}\",{:.6},{},{:.6e}",
            run.method, run.parameter, run.evaluations, run.error
        );
    }
    csv.into_bytes()
}

/// Both images of Figure 9 as CSV, pixel by pixel.
pub(crate) fn csv_of_images(measured: &Measurements) -> Vec<u8> {
    let mut csv = String::from("row,column,exact,hierarchical\n");
    let images = measured.exact.rows().zip(measured.figure_9_image.rows());
    for (row, (exact, image)) in images.enumerate() {
        for (column, (exact, pixel)) in exact.iter().zip(image).enumerate() {
            let _ = writeln!(csv, "{row},{column},{exact:.9e},{pixel:.9e}");
        }
    }
    csv.into_bytes()
}
