//! The time of method `vol` beside that of lines of sight with the fewest steps: the table of docs/performance.md,
//! Scenes.
//!
//! `cargo run --release -p emitree-io --example lines_of_sight -- table TOLERANCE FOLDER SCENE.toml …` renders each
//! scene with 256 × 256 pixels by `vol`, with fewest evaluations and in the shortest time, and by `los` with 1 to 64
//! lines of each pixel and 4 to 128 steps of each line: the fastest combination whose error is within the tolerance, in
//! hindsight. References (`reference.rs`) take minutes, but no time of theirs is measured: `… -- references TOLERANCE
//! FOLDER SCENE.toml …` makes them alone, and FOLDER keeps them.
#![expect(clippy::print_stdout, reason = "this program prints a table")]

mod reference;

use emitree::los::{LosOptions, Steps};
use emitree::{Cube, Image, Method, Rendering};
use emitree_io::{Override, Scene};
use reference::Exact;
use std::error::Error;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::time::Instant;

/// The pixels along each side.
const PIXELS: usize = 256;
/// The lines along each side of a pixel, and the steps of a line.
const LINES: [usize; 4] = [1, 2, 4, 8];
const STEPS: [usize; 11] = [4, 6, 8, 11, 16, 23, 32, 45, 64, 91, 128];
/// The fastest of so many runs counts; a run that takes longer \[s\] is made once.
const RUNS: usize = 3;
const LONG: f64 = 2.0;
/// Lines of sight that take so many times as long as `vol` are not continued with more steps.
const MOST_TIMES: f64 = 2.0;

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
        let error = reference(&scene, path, tolerance, folder)?.error();
        println!("{path}: error {error:.0e}, {:.0} s", start.elapsed().as_secs_f64());
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

/// Pixels that those of an image are compared with, and their errors.
struct Reference {
    pixels: Vec<f64>,
    errors: Vec<f64>,
}

impl Reference {
    /// The largest |pixel|.
    fn largest(&self) -> f64 {
        self.pixels.iter().map(|pixel| pixel.abs()).fold(0.0, f64::max)
    }

    /// The largest error, as a share of the largest pixel.
    fn error(&self) -> f64 {
        self.errors.iter().copied().fold(0.0, f64::max) / self.largest()
    }

    /// The largest difference of an image from these pixels, as a share of the largest of them. Pixels in which no
    /// line of sight was met are NaN.
    fn difference(&self, image: &Rendering<Cube>) -> f64 {
        let image = image.values.bands().iter().flat_map(Image::pixels);
        let pairs = image.zip(&self.pixels).filter(|(_, exact)| !exact.is_nan());
        let difference =
            |(a, b): (&f64, &f64)| if a.is_nan() { f64::INFINITY } else { (a - b).abs() };
        pairs.map(difference).fold(0.0, f64::max) / self.largest()
    }
}

/// The reference of a scene, from the folder if it is there. The folder is to be emptied after a change of a model or of
/// the reference, which the names of its files do not show.
fn reference(
    scene: &Scene,
    path: &str,
    tolerance: f64,
    folder: &Path,
) -> Result<Reference, Box<dyn Error>> {
    let mut hasher = DefaultHasher::new();
    (fs::read_to_string(path)?, PIXELS, tolerance.to_bits()).hash(&mut hasher);
    let kept = folder.join(format!("{}-{:016x}.f64", stem(path), hasher.finish()));
    if let Ok(bytes) = fs::read(&kept) {
        let (numbers, _) = bytes.as_chunks();
        let numbers: Vec<f64> = numbers.iter().map(|of| f64::from_le_bytes(*of)).collect();
        let (pixels, errors) = numbers.split_at(PIXELS * PIXELS);
        return Ok(Reference { pixels: pixels.to_vec(), errors: errors.to_vec() });
    }
    let emission = &scene.emission;
    let camera = scene.camera.projection();
    let [pixels, errors] = Exact { emission, camera, shape: [PIXELS; 2], tolerance }.pixels()?;
    // A run that is interrupted leaves no incomplete file of this name.
    let part = kept.with_extension("part");
    fs::create_dir_all(folder)?;
    let numbers = pixels.iter().chain(&errors).flat_map(|of| of.to_le_bytes());
    fs::write(&part, numbers.collect::<Vec<u8>>())?;
    fs::rename(&part, &kept)?;
    Ok(Reference { pixels, errors })
}

fn stem(path: &str) -> String {
    Path::new(path).file_stem().unwrap_or_default().to_string_lossy().into_owned()
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
            if best.map_or(MOST_TIMES * in_time_s, |(fastest, ..)| 2.0 * fastest) < seconds {
                break;
            }
            let error = reference.difference(&found);
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
        reference.difference(&vol),
        in_time.stats.evaluations,
        reference.difference(&in_time),
        reference.error()
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
