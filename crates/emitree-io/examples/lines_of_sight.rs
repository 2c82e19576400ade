//! The time of method `vol` beside that of lines of sight with the fewest steps: the table of docs/performance.md,
//! Scenes.
//!
//! `cargo run --release -p emitree-io --example lines_of_sight -- TOLERANCE SCENE.toml …` renders each scene with
//! 256 × 256 pixels by `vol`, with fewest evaluations and in the shortest time, and by `los` with 1 or 4 lines of each pixel and 4 to 128 steps of each line: the
//! fastest combination whose error is within the tolerance, in hindsight. The reference has 9 lines of each pixel with 256
//! steps, and its own error is about its difference from 4 lines with 128 steps.
#![expect(clippy::print_stdout, reason = "this program prints a table")]

use emitree::los::{LosOptions, Steps};
use emitree::{Cube, Image, Method, Rendering};
use emitree_io::{Override, Scene};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

/// The pixels along each side.
const PIXELS: usize = 256;
/// The lines along each side of a pixel, and the steps of a line.
const LINES: [usize; 3] = [1, 2, 4];
const STEPS: [usize; 11] = [4, 6, 8, 11, 16, 23, 32, 45, 64, 91, 128];
/// The lines along each side of a pixel of the reference, and of the image from which its error follows; the error of a
/// line as a share of the tolerance.
const REFERENCE: [usize; 2] = [8, 4];
const ERROR_OF_LINE: f64 = 0.1;
/// The fastest of so many runs counts; a run that takes longer \[s\] is made once.
const RUNS: usize = 3;
const LONG: f64 = 2.0;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [tolerance, paths @ ..] = &arguments[..] else {
        return Err("expected: TOLERANCE SCENE.toml …".into());
    };
    let tolerance: f64 = tolerance.parse()?;
    println!("# section: scenes");
    println!("# table: vol beside lines of sight, scenes");
    println!(
        "scene,evaluations of vol,error of vol,vol s,evaluations in least time,its error,its s,its steps,\
         lines x steps,error of los,los s,los / vol,los / least time,error of reference"
    );
    for path in paths {
        println!("{}", row(Path::new(path), tolerance)?);
    }
    Ok(())
}

/// A scene of so many pixels, rendered by `vol` to a tolerance with as little as possible of something.
fn open(path: &Path, tolerance: f64, minimize: &str) -> Result<Scene, Box<dyn Error>> {
    let values = [
        ("image.width", PIXELS.to_string()),
        ("image.height", PIXELS.to_string()),
        ("render.method", "vol".to_owned()),
        ("render.tolerance", tolerance.to_string()),
        ("render.minimize", minimize.to_owned()),
    ];
    let overrides = values.map(|(key, value)| Override {
        key: key.to_owned(),
        value,
        option: format!("--{}", key.rsplit('.').next().unwrap_or(key)),
    });
    Ok(Scene::open(path, &overrides)?)
}

fn row(path: &Path, tolerance: f64) -> Result<String, Box<dyn Error>> {
    let scene = open(path, tolerance, "evaluations")?;
    let adaptive = Steps::Adaptive(ERROR_OF_LINE * tolerance);
    let [reference, coarser] = REFERENCE.map(|lines| marched(&scene, lines, adaptive));
    let (reference, coarser) = (reference?, coarser?);
    let (vol_s, vol) = fastest(|| rendered(&scene, scene.render.method.clone()))?;
    let in_time = open(path, tolerance, "time")?;
    let (in_time_s, in_time) = fastest(|| rendered(&in_time, in_time.render.method.clone()))?;
    let steps = in_time.stats.line_steps.map_or("-".to_owned(), |steps| steps.to_string());
    let mut best: Option<(f64, usize, usize, f64)> = None;
    for lines in LINES {
        for steps in STEPS {
            let start = Instant::now();
            let found = marched(&scene, lines, Steps::Fixed(steps))?;
            let seconds = start.elapsed().as_secs_f64();
            if best.is_some_and(|(fastest, ..)| seconds > 2.0 * fastest) {
                break;
            }
            let error = difference(&found, &reference);
            if error <= tolerance {
                let (seconds, _) = fastest(|| marched(&scene, lines, Steps::Fixed(steps)))?;
                if best.is_none_or(|(fastest, ..)| seconds < fastest) {
                    best = Some((seconds, lines, steps, error));
                }
                break;
            }
        }
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let of_los = match best {
        Some((seconds, lines, steps, error)) => {
            let [of_vol, of_time] = [vol_s, in_time_s].map(|of| seconds / of);
            format!("{} x {steps},{error:.1e},{seconds:.3},{of_vol:.2},{of_time:.2}", lines * lines)
        }
        None => "none,-,-,-,-".to_owned(),
    };
    Ok(format!(
        "{name},{},{:.1e},{vol_s:.3},{},{:.1e},{in_time_s:.3},{steps},{of_los},{:.0e}",
        vol.stats.evaluations,
        difference(&vol, &reference),
        in_time.stats.evaluations,
        difference(&in_time, &reference),
        difference(&coarser, &reference)
    ))
}

/// The image of lines of sight.
fn marched(scene: &Scene, lines: usize, steps: Steps) -> Result<Rendering<Cube>, Box<dyn Error>> {
    rendered(scene, Method::Los(LosOptions::new(lines, steps)))
}

fn rendered(scene: &Scene, method: Method) -> Result<Rendering<Cube>, Box<dyn Error>> {
    let mut options = scene.render_options();
    options.method = method;
    options.max_evaluations = u64::MAX;
    Ok(scene.render(&scene.emission, &options)?)
}

/// The seconds of the fastest of some runs, and what the last one made.
fn fastest<T>(work: impl Fn() -> Result<T, Box<dyn Error>>) -> Result<(f64, T), Box<dyn Error>> {
    let timed = || {
        let start = Instant::now();
        work().map(|made| (start.elapsed().as_secs_f64(), made))
    };
    let (mut seconds, mut made) = timed()?;
    for _ in 1..RUNS {
        if seconds > LONG {
            break;
        }
        let of_run = timed()?;
        (seconds, made) = (seconds.min(of_run.0), of_run.1);
    }
    Ok((seconds, made))
}

/// The largest difference of two images, as a share of the largest pixel of the second. Pixels without a line of
/// sight are NaN in both.
fn difference(image: &Rendering<Cube>, reference: &Rendering<Cube>) -> f64 {
    let bands = image.values.bands().iter().zip(reference.values.bands());
    let pixels = bands.flat_map(|(of, exact)| of.pixels().iter().zip(exact.pixels()));
    let worst = pixels.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let exact = reference.values.bands().iter().flat_map(Image::pixels);
    worst / exact.map(|pixel| pixel.abs()).fold(0.0, f64::max)
}
