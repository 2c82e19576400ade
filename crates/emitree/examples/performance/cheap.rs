//! Cheap emissions: the image tree and the low-rank approximation against lines of sight.

use crate::heap::measured;
use crate::table::{Table, number};
use emitree::los::{LosOptions, Steps};
use emitree::{
    Canonical, Emission, FromFn, Image, Method, RenderOptions, Rendering, VolOptions, render,
};
use emitree_models::Expression;
use emitree_problems::{equation8, relative_error};
use std::collections::BTreeMap;
use std::hint;
use std::time::{Duration, Instant};

const EQUATION_8: &str = "(sin(5*x)*sin(7*y)*sin(11*z)/10)^2 + exp(-a*(x-sqrt(2)/3)^2/sqrt(2) \
                          - a*(y-sqrt(7)/5)^2*sqrt(2) - a*(z-sqrt(6)/5)^2*sqrt(3))";
const PIXELS_ALONG: [usize; 4] = [64, 256, 1024, 4096];
const ERRORS: [f64; 2] = [0.01, 0.001];
/// Lines of a pixel, along each side, and steps of a line that are tried, the cheapest first.
const LINES: [usize; 3] = [1, 2, 3];
const MOST_STEPS: usize = 20;
/// Pixels along a side beyond which the steps that are needed do not change.
const ENOUGH_PIXELS: usize = 512;
/// The fastest of so many runs counts, or of more if they take less than this together.
const LEAST_RUNS: usize = 3;
const RUNS_S: f64 = 0.5;
/// A run that takes longer is the only one.
const LONG_S: f64 = 5.0;
/// The cost of an expensive g, and where it is measured.
const EXPENSIVE: Duration = Duration::from_micros(1);
const PIXELS_OF_EXPENSIVE: usize = 1024;

/// Eq. (8) as a scene writes it and as a closure, and a closure that takes a microsecond.
pub(crate) fn tables() -> Result<Vec<Table>, String> {
    let constants = BTreeMap::from([("a".to_owned(), equation8::ALPHA)]);
    let expression =
        Expression::parse(EQUATION_8, &constants).map_err(|error| error.to_string())?;
    let closure = FromFn(|position, _| equation8::rate(position, equation8::ALPHA));
    let expensive = FromFn(|position, _| {
        let start = Instant::now();
        let rate = equation8::rate(position, equation8::ALPHA);
        while start.elapsed() < EXPENSIVE {
            hint::spin_loop();
        }
        rate
    });
    let mut rows = Vec::new();
    for pixels in PIXELS_ALONG {
        for error in ERRORS {
            let settings = Settings::new(&expression, pixels, error)?;
            rows.push(row("expression", &expression, &settings)?);
            rows.push(row("closure", &closure, &settings)?);
            if (pixels, error) == (PIXELS_OF_EXPENSIVE, ERRORS[1]) {
                rows.push(row("closure of 1 µs", &expensive, &settings)?);
            }
        }
    }
    let columns = vec![
        "g",
        "pixels along",
        "asked for",
        "lines x steps",
        "error of los",
        "error of vol",
        "los ms",
        "vol ms",
        "los / vol",
        "vol / writing an image",
        "peak of vol / image",
    ];
    Ok(vec![Table { title: "vol against lines of sight", columns, rows }])
}

/// The cheapest lines of sight of an error, and what they are compared with.
struct Settings {
    shape: [usize; 2],
    error: f64,
    los: LosOptions,
    exact: Image,
}

impl Settings {
    fn new(emission: &impl Emission, pixels: usize, error: f64) -> Result<Self, String> {
        let image = |pixels: usize| equation8::exact_image(equation8::ALPHA, [pixels; 2]);
        // More pixels only make the middle of each a better place for its line.
        let coarse = pixels.min(ENOUGH_PIXELS);
        let exact = image(coarse);
        for lines in LINES {
            for steps in 2..=MOST_STEPS {
                let los = LosOptions::new(lines, Steps::Fixed(steps));
                let found = rendered(emission, [coarse; 2], Method::Los(los))?;
                if relative_error(&found.values, &exact) <= error {
                    return Ok(Self { shape: [pixels; 2], error, los, exact: image(pixels) });
                }
            }
        }
        Err(format!("no lines of sight have an error of {error} with {pixels} pixels"))
    }
}

fn row(name: &str, emission: &impl Emission, settings: &Settings) -> Result<Vec<String>, String> {
    let &Settings { shape, error: tolerance, los, ref exact } = settings;
    let method = Method::Vol(VolOptions::new(tolerance));
    let (seconds_of_vol, of_vol, peak) = fastest(|| rendered(emission, shape, method.clone()))?;
    let (seconds_of_los, of_los, _) = fastest(|| rendered(emission, shape, Method::Los(los)))?;
    let [height, width] = shape;
    let pixels = height * width;
    let (writing, _, _) =
        fastest(|| Ok(Image::from_pixels(height, width, hint::black_box(vec![1.0; pixels]))))?;
    let Steps::Fixed(steps) = los.steps else { return Err("steps that are not fixed".to_owned()) };
    Ok(vec![
        name.to_owned(),
        width.to_string(),
        tolerance.to_string(),
        format!("{} x {steps}", los.lines * los.lines),
        number(relative_error(&of_los.values, exact)),
        number(relative_error(&of_vol.values, exact)),
        number(seconds_of_los * 1e3),
        number(seconds_of_vol * 1e3),
        number(seconds_of_los / seconds_of_vol),
        number(seconds_of_vol / writing),
        number(peak as f64 / (pixels * size_of::<f64>()) as f64),
    ])
}

fn rendered(
    emission: &impl Emission,
    shape: [usize; 2],
    method: Method,
) -> Result<Rendering, String> {
    render(emission, &Canonical, shape, &RenderOptions::new(method))
        .map_err(|error| error.to_string())
}

/// The seconds of the fastest of some runs, what the last one made, and the most bytes that one took.
fn fastest<T>(mut work: impl FnMut() -> Result<T, String>) -> Result<(f64, T, usize), String> {
    let (mut seconds, mut together, mut peak) = (f64::INFINITY, 0.0, 0);
    let mut runs = 0;
    loop {
        let (made, taken) = measured(&mut work);
        let made = made?;
        runs += 1;
        seconds = seconds.min(taken.time.as_secs_f64());
        together += taken.time.as_secs_f64();
        peak = peak.max(taken.peak_bytes);
        if (runs >= LEAST_RUNS && together > RUNS_S) || taken.time.as_secs_f64() > LONG_S {
            return Ok((seconds, made, peak));
        }
    }
}
