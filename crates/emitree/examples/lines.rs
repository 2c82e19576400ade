//! Radiances of lines of sight beside an image, against closed forms: how many are within their errors, and how many
//! of these errors are beyond the tolerance, so that such lines have to be integrated by themselves.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example lines -- shapes 0 40 1e-2 100` names the lines through the centres of
//! 100 × 100 pixels of random shapes with the seeds 0 to 39; `… -- solids …` those of sums of solids, `… -- planets …` of
//! shapes around an opaque planet.

use emitree::{Canonical, FromFn, Projection, RenderOptions, VolOptions, render};
use emitree_problems::planets::random_planet;
use emitree_problems::shapes::random_shape;
use emitree_problems::solids::random_solids;
use std::error::Error;
use std::sync::Arc;

/// A scene with the radiances of its lines.
struct Scene {
    name: String,
    camera: Arc<dyn Projection + Send>,
    rate: Box<dyn Fn([f64; 3]) -> f64 + Sync>,
    line: Box<dyn Fn([f64; 2]) -> f64 + Sync>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [family, from, to, tolerance, side] = &arguments[..] else {
        return Err("expected: family from to tolerance side".into());
    };
    let (tolerance, side): (f64, usize) = (tolerance.parse()?, side.parse()?);
    println!(
        "| scene | evaluations | surfaces | beyond the tolerance | wrong | worst / tolerance |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    let mut totals = [0.0; 4];
    for seed in from.parse::<u64>()?..to.parse()? {
        let scene = scene(family, seed)?;
        let of_scene = compare(&scene, tolerance, side)?;
        for (total, of_scene) in totals.iter_mut().zip(of_scene) {
            *total += of_scene;
        }
    }
    let [evaluations, beyond, wrong, within] = totals;
    println!(
        "evaluations {evaluations}, lines beyond the tolerance {beyond}, wrong {wrong} of {within}"
    );
    Ok(())
}

fn scene(family: &str, seed: u64) -> Result<Scene, Box<dyn Error>> {
    Ok(match family {
        "shapes" => {
            let (shape, other) = (random_shape(seed), random_shape(seed));
            Scene {
                name: format!("{}-{seed}", shape.kind()),
                camera: Arc::new(Canonical),
                rate: Box::new(move |r| shape.rate(r)),
                line: Box::new(move |xy| other.line_integral(xy)),
            }
        }
        "solids" => {
            let (solids, other) = (random_solids(seed), random_solids(seed));
            Scene {
                name: format!("solids-{seed}"),
                camera: Arc::new(Canonical),
                rate: Box::new(move |r| solids.rate(r)),
                line: Box::new(move |xy| other.line_integral(xy)),
            }
        }
        "planets" => {
            let (planet, other) = (random_planet(seed), random_planet(seed));
            Scene {
                name: planet.name(),
                camera: planet.camera(),
                rate: Box::new(move |r| planet.rate(r)),
                line: Box::new(move |xy| other.line_integral(xy)),
            }
        }
        other => {
            return Err(format!("the family is {other}: expected shapes, solids or planets").into());
        }
    })
}

/// Prints a row, and returns evaluations, lines beyond the tolerance, wrong ones of those within it, and those within.
fn compare(scene: &Scene, tolerance: f64, side: usize) -> Result<[f64; 4], Box<dyn Error>> {
    let at = |k: usize| (k as f64 + 0.5) / side as f64;
    let places: Vec<[f64; 2]> = (0..side * side).map(|k| [at(k % side), at(k / side)]).collect();
    let options = VolOptions::new(tolerance).with_lines(places.clone());
    let rate = FromFn(|r: [f64; 3], _| (scene.rate)(r));
    let made = render(&rate, &*scene.camera, [side; 2], &RenderOptions::new(options))?;
    let lines = made.lines.as_ref().ok_or("no lines")?;
    let exact: Vec<f64> = places.iter().map(|xy| (scene.line)(*xy)).collect();
    let allowed = tolerance * exact.iter().fold(0.0, |most: f64, of| most.max(of.abs()));
    let (mut beyond, mut wrong, mut worst) = (0, 0, 0.0_f64);
    for ((value, error), exact) in lines.values.iter().zip(&lines.errors).zip(&exact) {
        if *error > allowed {
            beyond += 1;
            continue;
        }
        let of_line = (value - exact).abs();
        wrong += usize::from(of_line > allowed);
        worst = worst.max(of_line / allowed);
    }
    let evaluations = made.stats.evaluations;
    let surfaces = if made.surfaces.is_some() { "yes" } else { "no" };
    println!("| {} | {evaluations} | {surfaces} | {beyond} | {wrong} | {worst:.2} |", scene.name);
    Ok([evaluations as f64, beyond as f64, wrong as f64, (places.len() - beyond) as f64])
}
