//! How evaluations, time and memory grow with the tolerance, the pixels, the bins of energy and the width of a
//! structure; and how large the trees of method `paper` may become.

use crate::heap::{available_bytes, measured};
use crate::table::{Table, exponent, mebibytes, number};
use core::convert::Infallible;
use emitree::refinement::Threshold;
use emitree::tree::BuildOptions;
use emitree::vol::Seed;
use emitree::{
    Canonical, Cube, FromFn, FromSpectralFn, Image, Method, RenderError, RenderOptions, Rendering,
    VolOptions, render, render_cube,
};
use emitree_problems::catalogue::problem;
use emitree_problems::cubes;
use emitree_problems::gaussian::Gaussian;
use emitree_problems::{equation8, relative_error};

/// Pixels, where their number is not what changes.
const SHAPE: [usize; 2] = [128, 128];
/// The fastest of so many runs counts, unless one takes longer than [`LONG_S`].
const RUNS: usize = 3;
const LONG_S: f64 = 0.3;
/// A series ends with the first point that takes longer [s].
const MOST_S: f64 = 10.0;
/// Evaluations that `vol` and `paper` may make for one image, where growth is not what is measured.
const MOST_OF_VOL: u64 = 200_000;
const MOST_OF_PAPER: u64 = 5_000_000;

const SMOOTH: [&str; 3] = ["eq8", "shell", "gaussians"];
const TOLERANCES_OF_VOL: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5];
const THRESHOLDS_OF_PAPER: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];
const PIXELS_ALONG: [usize; 7] = [64, 128, 256, 512, 1024, 2048, 4096];
/// Two continua and a line, and spectra that jump, in images of so few pixels that 10⁷ voxels are exact in seconds.
const SPECTRAL: [&str; 2] = ["mixture", "edge"];
const BINS: [usize; 6] = [1, 8, 64, 512, 4096, 16_384];
const SHAPE_OF_CUBE: [usize; 2] = [32, 32];
const WIDTHS: [f64; 7] = [0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002];
/// Where the narrow Gaussian is: on no plane of any dyadic grid.
const PLACE: [f64; 3] = [0.4142, 0.5858, 0.3178];
const RADIUS_OF_SHELL: f64 = 0.3;

/// Evaluations that trees are grown to, and the thresholds for which they need as many or more.
const GROWTH: [(u64, f64); 4] =
    [(100_000, 2.3e-3), (1_000_000, 3.4e-4), (10_000_000, 6.5e-5), (100_000_000, 1e-5)];
/// What the largest of them may take, and what else has to be there.
const MOST_BYTES: u64 = 16 << 30;
const SPARE_BYTES: u64 = 1 << 30;

/// What one rendering took; errors are of the largest pixel.
struct Point {
    series: String,
    /// What it is against.
    along: f64,
    evaluations: u64,
    error: Option<f64>,
    estimate: Option<f64>,
    seconds: f64,
    peak_bytes: usize,
    /// Whether no limit has ended it.
    done: bool,
}

/// A series ends early where a point takes long, so that all of it ends in minutes on any machine.
pub(crate) fn tables() -> Result<Vec<Table>, String> {
    let (tolerance, pixels, bins) = (tolerance()?, pixels()?, bins()?);
    let (width, growth) = (width()?, growth()?);
    let evaluations = |point: &Point| point.evaluations as f64;
    let seconds = |point: &Point| point.seconds;
    let memory = |point: &Point| point.peak_bytes as f64;
    let exponents = [
        exponents("evaluations", "tolerance", &tolerance, evaluations),
        exponents("seconds", "pixels along", &pixels, seconds),
        exponents("memory", "pixels along", &pixels, memory),
        exponents("evaluations", "bins", &bins, evaluations),
        exponents("seconds", "bins", &bins, seconds),
        exponents("evaluations", "width", &width, evaluations),
        exponents("seconds", "evaluations", &growth, seconds),
        exponents("memory", "evaluations", &growth, memory),
    ];
    Ok(vec![
        table("Against the tolerance", "tolerance", &tolerance),
        table("Against the pixels", "pixels along", &pixels),
        table("Against the bins", "bins", &bins),
        table("Against the width of a structure", "width", &width),
        table("Trees of method paper grown to so many evaluations", "asked for", &growth),
        Table {
            title: "Fitted exponents",
            columns: vec!["of", "against", "series", "exponent"],
            rows: exponents.into_iter().flatten().collect(),
        },
    ])
}

fn table(title: &'static str, along: &'static str, points: &[Point]) -> Table {
    let known = |error: Option<f64>| error.map_or_else(|| "-".to_owned(), number);
    let row = |point: &Point| {
        vec![
            point.series.clone(),
            point.along.to_string(),
            point.evaluations.to_string(),
            known(point.error),
            known(point.estimate),
            number(point.seconds),
            mebibytes(point.peak_bytes),
            if point.done { "yes" } else { "no" }.to_owned(),
        ]
    };
    Table {
        title,
        columns: vec![
            "series",
            along,
            "evaluations",
            "error",
            "estimated error",
            "seconds",
            "peak MiB",
            "done",
        ],
        rows: points.iter().map(row).collect(),
    }
}

/// The exponent of each series: through the points that met the stopping criterion, or, where a budget is
/// the limit, through all.
fn exponents(
    of: &str,
    against: &str,
    points: &[Point],
    value: impl Fn(&Point) -> f64,
) -> Vec<Vec<String>> {
    let same_series = |a: &Point, b: &Point| a.series == b.series;
    let row = |points: &[Point]| {
        let pairs: Vec<[f64; 2]> = points.iter().map(|point| [point.along, value(point)]).collect();
        let slope = exponent(&pairs).map_or_else(|| "-".to_owned(), |slope| format!("{slope:.2}"));
        vec![of.to_owned(), against.to_owned(), points[0].series.clone(), slope]
    };
    points.chunk_by(same_series).map(row).collect()
}

fn vol(tolerance: f64) -> RenderOptions<'static> {
    let method = Method::Vol(VolOptions::new(tolerance));
    RenderOptions::new(method).with_max_evaluations(MOST_OF_VOL)
}

fn paper(threshold: Threshold) -> RenderOptions<'static> {
    let method = Method::Paper(BuildOptions::new(threshold));
    RenderOptions::new(method).with_max_evaluations(MOST_OF_PAPER)
}

/// One image of `rate`, the fastest of some renderings.
fn point(
    series: &str,
    along: f64,
    rate: impl Fn([f64; 3]) -> f64 + Sync,
    (shape, options): ([usize; 2], &RenderOptions<'_>),
    exact: Option<&Image>,
) -> Result<Point, String> {
    let emission = FromFn(|position, _| rate(position));
    let image = || render(&emission, &Canonical, shape, options).map(Into::into);
    fastest(series, along, image, |made| exact.map(|exact| relative_error(&made.bands()[0], exact)))
}

/// The fastest of some renderings.
fn fastest(
    series: &str,
    along: f64,
    make: impl Fn() -> Result<Rendering<Cube>, RenderError<Infallible>>,
    error: impl Fn(&Cube) -> Option<f64>,
) -> Result<Point, String> {
    let mut seconds = f64::INFINITY;
    let mut last = None;
    for _ in 0..RUNS {
        let (rendering, taken) = measured(&make);
        let rendering = rendering.map_err(|error| format!("{series} at {along}: {error}"))?;
        seconds = seconds.min(taken.time.as_secs_f64());
        last = Some((rendering, taken.peak_bytes));
        if taken.time.as_secs_f64() > LONG_S {
            break;
        }
    }
    let (rendering, peak_bytes) = last.ok_or("nothing was run")?;
    Ok(Point {
        series: series.to_owned(),
        along,
        evaluations: rendering.stats.evaluations,
        error: error(&rendering.values),
        estimate: rendering.estimated_error(),
        seconds,
        peak_bytes,
        done: rendering.converged(),
    })
}

/// Adds the points of one series, until one takes too long.
fn add_series(
    points: &mut Vec<Point>,
    along: &[f64],
    mut point: impl FnMut(f64) -> Result<Point, String>,
) -> Result<(), String> {
    for &along in along {
        points.push(point(along)?);
        if points.last().is_some_and(|point| point.seconds > MOST_S) {
            break;
        }
    }
    Ok(())
}

fn tolerance() -> Result<Vec<Point>, String> {
    let mut points = Vec::new();
    for problem in SMOOTH.into_iter().filter_map(problem) {
        let exact = problem.exact_image(SHAPE);
        let of = |method: &str, along: f64, options: &RenderOptions<'_>| {
            let series = format!("{method} {}", problem.name);
            point(&series, along, |u| problem.rate(u), (SHAPE, options), Some(&exact))
        };
        add_series(&mut points, &TOLERANCES_OF_VOL, |along| of("vol", along, &vol(along)))?;
        add_series(&mut points, &THRESHOLDS_OF_PAPER, |along| {
            of("paper", along, &paper(Threshold::Relative(along)))
        })?;
    }
    Ok(points)
}

/// Eq. (8) at 0.1 %: its exact image has a closed form at any number of pixels.
fn pixels() -> Result<Vec<Point>, String> {
    let mut points = Vec::new();
    let rate = |position| equation8::rate(position, equation8::ALPHA);
    for (series, options) in
        [("vol eq8", vol(1e-3)), ("paper eq8", paper(Threshold::Relative(1e-3)))]
    {
        for pixels in PIXELS_ALONG {
            let shape = [pixels; 2];
            let exact = equation8::exact_image(equation8::ALPHA, shape);
            points.push(point(series, pixels as f64, rate, (shape, &options), Some(&exact))?);
        }
    }
    Ok(points)
}

/// Cubes at 1 %: an energy is a fourth variable, not an image more.
fn bins() -> Result<Vec<Point>, String> {
    let options = vol(0.01);
    let mut points = Vec::new();
    for problem in SPECTRAL.into_iter().filter_map(cubes::problem) {
        let emission = FromSpectralFn(|position, _, energy| problem.rate(position, energy));
        let series = format!("vol {}", problem.name);
        for bins in BINS {
            let axis = problem.default_axis(bins).map_err(|error| error.to_string())?;
            let exact = problem.exact(SHAPE_OF_CUBE, &axis);
            let make = || render_cube(&emission, &Canonical, SHAPE_OF_CUBE, &axis, &options);
            let error = |made: &Cube| Some(made.max_difference(&exact) / exact.largest());
            points.push(fastest(&series, bins as f64, make, error)?);
        }
    }
    Ok(points)
}

/// A Gaussian ball and a shell of width w at 1 %; the ball without and with a seed that names it.
fn width() -> Result<Vec<Point>, String> {
    let mut points = Vec::new();
    let methods = [
        ("vol", vol(0.01)),
        ("paper", paper(Threshold::Relative(0.01))),
        ("vol with seed", vol(0.01)),
    ];
    for (name, options) in &methods {
        let series = format!("{name} ball");
        add_series(&mut points, &WIDTHS, |width| {
            let ball = Gaussian { centre: PLACE, width };
            let seeds = [Seed { position: PLACE, radius: width }];
            let mut options = options.clone();
            if let Method::Vol(vol) = &mut options.method
                && name.ends_with("seed")
            {
                vol.seeds = seeds.to_vec();
            }
            let exact = ball.exact_image(SHAPE);
            point(&series, width, |u| ball.rate(u), (SHAPE, &options), Some(&exact))
        })?;
    }
    for (name, options) in &methods[..2] {
        add_series(&mut points, &WIDTHS, |width| {
            let rate = |position: [f64; 3]| {
                let square: f64 = position.iter().map(|x| (x - 0.5).powi(2)).sum();
                let distance = (square.sqrt() - RADIUS_OF_SHELL) / width;
                (-distance * distance).exp()
            };
            point(&format!("{name} shell"), width, rate, (SHAPE, options), None)
        })?;
    }
    Ok(points)
}

/// Trees of eq. (8); the largest ones only where there is memory for what they may take.
fn growth() -> Result<Vec<Point>, String> {
    let exact = equation8::exact_image(equation8::ALPHA, SHAPE);
    let rate = |position| equation8::rate(position, equation8::ALPHA);
    let mut points = Vec::new();
    for (max_evaluations, threshold) in GROWTH {
        let enough = available_bytes().is_some_and(|bytes| bytes > MOST_BYTES / 2 + SPARE_BYTES);
        if max_evaluations > 10_000_000 && !enough {
            eprintln!("performance: no memory for {max_evaluations} evaluations, left out");
            continue;
        }
        let options = paper(Threshold::Absolute(threshold))
            .with_max_evaluations(max_evaluations)
            .with_max_memory_bytes(MOST_BYTES);
        let grown =
            point("paper eq8", max_evaluations as f64, rate, (SHAPE, &options), Some(&exact))?;
        if grown.peak_bytes as u64 > MOST_BYTES {
            return Err(format!("{max_evaluations} evaluations took {} bytes", grown.peak_bytes));
        }
        points.push(grown);
    }
    Ok(points)
}
