//! Writes sample figures: `write_figures FOLDER`.

use emitree::Image;
use emitree_io::figure::{Axis, Figure, Heatmap, Panel, Plot, Series};
use emitree_io::{ColourMap, OutputFile, ValueRange};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).ok_or("expected a folder for the figures")?;
    let folder = PathBuf::from(folder);
    let write = |name: &str, figure: Figure| -> Result<(), Box<dyn Error>> {
        OutputFile::create(folder.join(name).with_extension("svg"))?
            .commit(figure.svg().as_bytes())?;
        Ok(OutputFile::create(folder.join(name).with_extension("png"))?
            .commit(&figure.png(2.0)?)?)
    };
    write("convergence", convergence()?)?;
    write("crowded", crowded()?)?;
    write("linear", linear()?)?;
    write("panels", panels()?)?;
    write("narrow", narrow()?)?;
    Ok(())
}

fn power(constant: f64, exponent: f64, from: f64, to: f64) -> Vec<[f64; 2]> {
    let step = (to / from).powf(0.125);
    (0..=8).map(|i| from * step.powi(i)).map(|n| [n, constant * n.powf(exponent)]).collect()
}

fn convergence() -> Result<Figure, Box<dyn Error>> {
    Ok(Plot::new(
        Axis::log("evaluations of the emission rate"),
        Axis::log("largest error / largest pixel"),
    )
    .title("Error against evaluations, 64 × 64 pixels")
    .series(Series::line("vol", power(3e4, -1.9, 800.0, 6e4)).marked())
    .series(Series::line("paper", power(900.0, -1.2, 600.0, 1.2e5)).marked())
    .series(Series::line("los, fixed step", power(4e3, -1.1, 3e4, 1e6)).marked())
    .series(Series::line("paper, asked for", power(2000.0, -1.2, 600.0, 1.2e5)).dashed().colour(1))
    .horizontal_line(0.01, "1 %")
    .vertical_line(4032.0, "the paper's 4,032")
    .annotation([6e4, 3e4 * 6e4_f64.powf(-1.9)], "base grid 8³")
    .draw()?)
}

fn crowded() -> Result<Figure, Box<dyn Error>> {
    let mut plot = Plot::new(Axis::log("evaluations"), Axis::log("error"))
        .title("A plot without a free corner has its legend outside");
    for number in 0..8 {
        let height = 10_f64.powf(0.5 * f64::from(number));
        let points = power(height, 0.05, 1.0, 1e9);
        plot = plot.series(Series::line(format!("series {number}"), points).marked());
    }
    Ok(plot.draw()?)
}

fn linear() -> Result<Figure, Box<dyn Error>> {
    let wave = |phase: f64| -> Vec<[f64; 2]> {
        (0..=200).map(|i| 0.005 * f64::from(i)).map(|x| [x, (9.0 * x + phase).sin()]).collect()
    };
    let points: Vec<_> = wave(0.0).into_iter().step_by(20).collect();
    Ok(Plot::new(Axis::linear("x"), Axis::linear("radiance [m⁻² sr⁻¹ s⁻¹]"))
        .series(Series::line("exact", wave(0.0)))
        .series(Series::line("estimate", wave(0.3)).dotted())
        .series(Series::markers("samples", points))
        .horizontal_line(0.0, "")
        .annotation([0.5, 0.0], "crossing < zero & more")
        .draw()?)
}

fn blob(height: usize, width: usize, sharp: f64) -> Image {
    let mut image = Image::zeros(height, width);
    let place = |index: usize, count: usize| (index as f64 + 0.5) / count as f64;
    for row in 0..height {
        for column in 0..width {
            let (x, y) = (place(column, width) - 0.3, place(row, height) - 0.65);
            image[(row, column)] = 3.2e7 * (-sharp * (x * x + 2.0 * y * y)).exp();
        }
    }
    image
}

fn panels() -> Result<Figure, Box<dyn Error>> {
    let (image, coarse) = (blob(64, 64, 12.0), blob(8, 8, 12.0));
    let mut error = blob(64, 64, 20.0);
    error.pixels_mut().iter_mut().for_each(|pixel| *pixel *= 1e-3);
    error[(3, 60)] = f64::NAN;
    let range = ValueRange::of(&[&image, &coarse]);
    let panel = |image| Panel::new(image).x("x", [0.0, 1.0]).y("y", [0.0, 1.0]);
    Ok(Heatmap::new()
        .title("One scene, two images and the error")
        .panel(panel(&image).title("64 × 64 pixels").range(range))
        .panel(
            panel(&coarse).title("8 × 8 pixels").range(range).colour_bar("radiance [m⁻² sr⁻¹ s⁻¹]"),
        )
        .panel(
            panel(&error)
                .title("error")
                .colour_map(ColourMap::Inferno)
                .logarithmic()
                .colour_bar("|error| [m⁻² sr⁻¹ s⁻¹]"),
        )
        .draw()?)
}

fn narrow() -> Result<Figure, Box<dyn Error>> {
    let image = blob(100, 50, 12.0);
    Ok(Heatmap::new()
        .panel(
            Panel::new(&image)
                .title("SMILE view, 50 × 100 pixels")
                .x("longitude [deg]", [-8.0, 8.0])
                .y("latitude [deg]", [-13.5, 13.5])
                .colour_map(ColourMap::Inferno)
                .colour_bar("radiance [m⁻² sr⁻¹ s⁻¹]"),
        )
        .draw()?)
}
