//! The time of method `vol` beside that of lines of sight with the fewest steps: the table of docs/performance.md,
//! Scenes.
//!
//! `cargo run --release -p emitree-io --example lines_of_sight -- table TOLERANCE FOLDER SCENE.toml …` renders each
//! scene with 256 × 256 pixels by `vol`, with fewest evaluations and in the shortest time, and by `los` with 1 to 16
//! lines of each pixel and 4 to 128 steps of each line: the fastest combination whose error is within the tolerance, in
//! hindsight. The reference has 64 lines of each pixel, integrated adaptively, and its own error is about its difference
//! from 16 lines. References take minutes, but no time of theirs is measured: `… -- references TOLERANCE FOLDER
//! SCENE.toml …` makes them alone, and FOLDER keeps them.
#![expect(clippy::print_stdout, reason = "this program prints a table")]

use emitree::los::{LosOptions, Steps};
use emitree::{Cube, Image, Method, Rendering};
use emitree_io::{Override, Scene};
use std::error::Error;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
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
    let [what, tolerance, folder, paths @ ..] = &arguments[..] else {
        return Err("expected: table|references TOLERANCE FOLDER SCENE.toml …".into());
    };
    let (tolerance, folder): (f64, _) = (tolerance.parse()?, Path::new(folder));
    match what.as_str() {
        "references" => references(tolerance, folder, paths),
        "table" => table(tolerance, folder, paths),
        other => Err(format!("expected table or references, not {other}").into()),
    }
}

/// Makes the references that the folder does not have.
fn references(tolerance: f64, folder: &Path, paths: &[String]) -> Result<(), Box<dyn Error>> {
    for path in paths {
        let start = Instant::now();
        let scene = open(path, tolerance, "evaluations")?;
        let made = reference(&scene, path, tolerance, folder)?;
        println!("{path}: error {:.0e}, {:.0} s", made.error, start.elapsed().as_secs_f64());
    }
    Ok(())
}

fn table(tolerance: f64, folder: &Path, paths: &[String]) -> Result<(), Box<dyn Error>> {
    println!("# section: scenes");
    println!("# table: vol beside lines of sight, scenes");
    println!(
        "scene,evaluations of vol,error of vol,vol s,evaluations in least time,its error,its s,its steps,\
         lines x steps,error of los,los s,los / vol,los / least time,error of reference"
    );
    for path in paths {
        println!("{}", row(path, tolerance, folder)?);
    }
    Ok(())
}

/// A scene of so many pixels, rendered by `vol` to a tolerance with as little as possible of something.
fn open(path: &str, tolerance: f64, minimize: &str) -> Result<Scene, Box<dyn Error>> {
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
    Ok(Scene::open(Path::new(path), &overrides)?)
}

/// Pixels that are compared with those of an image, and how far those of fewer lines are from them.
struct Reference {
    pixels: Vec<f64>,
    error: f64,
}

/// The reference of a scene, from the folder if it is there. The folder is to be emptied after a change of a model or of
/// lines of sight, which the names of its files do not show.
fn reference(
    scene: &Scene,
    path: &str,
    tolerance: f64,
    folder: &Path,
) -> Result<Reference, Box<dyn Error>> {
    let mut hasher = DefaultHasher::new();
    (fs::read_to_string(path)?, REFERENCE, PIXELS, (ERROR_OF_LINE * tolerance).to_bits())
        .hash(&mut hasher);
    let kept = folder.join(format!("{}-{:016x}.f64", stem(path), hasher.finish()));
    let mut numbers: Vec<f64> = match fs::read(&kept) {
        Ok(bytes) => bytes.as_chunks().0.iter().map(|of| f64::from_le_bytes(*of)).collect(),
        Err(_) => {
            let adaptive = Steps::Adaptive(ERROR_OF_LINE * tolerance);
            let [fine, coarse] = REFERENCE.map(|lines| marched(scene, lines, adaptive));
            let pixels = pixels(&fine?);
            let error = difference(&coarse?, &pixels);
            let numbers = [pixels, vec![error]].concat();
            // A run that is interrupted leaves no incomplete file of this name.
            let part = kept.with_extension("part");
            fs::create_dir_all(folder)?;
            fs::write(&part, numbers.iter().flat_map(|of| of.to_le_bytes()).collect::<Vec<u8>>())?;
            fs::rename(&part, &kept)?;
            numbers
        }
    };
    let error = numbers.pop().ok_or("an empty reference")?;
    Ok(Reference { pixels: numbers, error })
}

fn stem(path: &str) -> String {
    Path::new(path).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn pixels(image: &Rendering<Cube>) -> Vec<f64> {
    image.values.bands().iter().flat_map(Image::pixels).copied().collect()
}

fn row(path: &str, tolerance: f64, folder: &Path) -> Result<String, Box<dyn Error>> {
    let scene = open(path, tolerance, "evaluations")?;
    let reference = reference(&scene, path, tolerance, folder)?;
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
            let error = difference(&found, &reference.pixels);
            if error <= tolerance {
                let (seconds, _) = fastest(|| marched(&scene, lines, Steps::Fixed(steps)))?;
                if best.is_none_or(|(fastest, ..)| seconds < fastest) {
                    best = Some((seconds, lines, steps, error));
                }
                break;
            }
        }
    }
    let of_los = match best {
        Some((seconds, lines, steps, error)) => {
            let [of_vol, of_time] = [vol_s, in_time_s].map(|of| seconds / of);
            format!("{} x {steps},{error:.1e},{seconds:.3},{of_vol:.2},{of_time:.2}", lines * lines)
        }
        None => "none,-,-,-,-".to_owned(),
    };
    Ok(format!(
        "{},{},{:.1e},{vol_s:.3},{},{:.1e},{in_time_s:.3},{steps},{of_los},{:.0e}",
        stem(path),
        vol.stats.evaluations,
        difference(&vol, &reference.pixels),
        in_time.stats.evaluations,
        difference(&in_time, &reference.pixels),
        reference.error
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

/// The largest difference of an image from the exact pixels, as a share of the largest of them. Pixels without a line
/// of sight are NaN in both.
fn difference(image: &Rendering<Cube>, exact: &[f64]) -> f64 {
    let pairs = pixels(image).into_iter().zip(exact);
    let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    worst / exact.iter().map(|pixel| pixel.abs()).fold(0.0, f64::max)
}
