use super::*;

fn plot(series: Series) -> Plot {
    Plot::new(Axis::linear("x"), Axis::linear("y")).series(series)
}

fn width(plot: &Plot) -> f64 {
    plot.draw().unwrap().width
}

#[test]
fn the_same_plot_gives_the_same_bytes() {
    let plot = plot(Series::line("a", [[0.0, 0.0], [1.0, 1.0]]).marked()).horizontal_line(0.5, "½");
    let (first, second) = (plot.draw().unwrap(), plot.draw().unwrap());
    assert_eq!(first, second);
    assert_eq!(first.png(1.5).unwrap(), second.png(1.5).unwrap());
}

#[test]
fn the_legend_moves_out_when_there_is_no_room() {
    let diagonal = plot(Series::line("a", [[0.0, 0.0], [1.0, 1.0]]));
    let zigzag: Vec<_> = (0..100).map(|i| [f64::from(i), f64::from(i % 2)]).collect();
    let full = plot(Series::line("a", zigzag));
    assert!(width(&full) > width(&diagonal) + 40.0);
}

#[test]
fn points_that_are_no_numbers_break_the_line() {
    let points = [[0.0, 0.0], [1.0, 1.0], [2.0, f64::NAN], [3.0, 1.0], [4.0, 0.0]];
    let lines = |points: &[[f64; 2]]| {
        let figure = plot(Series::line("", points)).draw().unwrap();
        // Of all lines, those of series alone are so wide.
        figure.svg().matches(r#"stroke-width="1.8""#).count()
    };
    assert_eq!(lines(&points), 2);
    assert_eq!(lines(&points[..2]), 1);
}

#[test]
fn a_narrower_range_than_the_data_is_drawn() {
    let figure = Plot::new(Axis::log("x").range([1.0, 10.0]), Axis::log("y").range([0.1, 1.0]))
        .series(Series::line("a", [[1e-300, 1e-300], [1e300, 1e300]]).marked())
        .draw()
        .unwrap();
    assert!(figure.png(1.0).is_ok());
}

#[test]
fn what_cannot_be_drawn_is_named() {
    let message = |plot: Plot| plot.draw().unwrap_err().to_string();
    let none = Plot::new(Axis::linear("x"), Axis::linear("y"));
    assert_eq!(message(none), "a figure without series: expected at least one");
    let empty = plot(Series::line("a", []));
    assert_eq!(message(empty), "a figure without finite data: expected at least one");
    let zero =
        Plot::new(Axis::linear("x"), Axis::log("error")).series(Series::markers("a", [[1.0, 0.0]]));
    assert_eq!(message(zero), "0 on the logarithmic axis `error`: expected positive values");
}

#[test]
fn pictures_without_pixels_are_refused() {
    let figure = plot(Series::markers("", [[1.0, 1.0]])).draw().unwrap();
    for scale in [0.0, -1.0, f64::NAN, 1e9] {
        assert!(matches!(figure.png(scale), Err(FigureError::Size { .. })), "{scale}");
    }
}
