//! Lines of sight through all pixels, where time is minimized, against exact images: the table of docs/results/engine.md.
#![expect(clippy::print_stdout, reason = "this program prints a table")]
//!
//! `cargo run --release -p emitree --example pixel_lines -- 0 120 64 1e-2` renders the scenes of seeds 0 to 119 of
//! random families with 64 × 64 pixels, `… -- 0 120 64 1e-2 shapes,planets` those of these families. Those of views have as many
//! pixels as the view has. Scenes that `vol` renders all the same are counted apart.

use emitree::vol::Minimize;
use emitree::{Canonical, FromFn, Projection, RenderOptions, VolOptions, render};
use emitree_problems::family::{Reference, random_peak, random_scene};
use emitree_problems::planets::random_planet;
use emitree_problems::shapes::random_shape;
use emitree_problems::views::{Outcome, random_view};
use emitree_problems::wires::random_wires;
use std::error::Error;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

type Rate = Box<dyn Fn([f64; 3]) -> f64 + Sync>;

struct Scene {
    name: String,
    rate: Rate,
    camera: Arc<dyn Projection + Send>,
    reference: Reference,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let ([from, to, pixels, tolerance], names) = match &arguments[..] {
        [from, to, pixels, tolerance] => ([from, to, pixels, tolerance], ""),
        [from, to, pixels, tolerance, names] => ([from, to, pixels, tolerance], names.as_str()),
        _ => return Err("expected: FROM TO PIXELS TOLERANCE [FAMILY,…]".into()),
    };
    let seeds = from.parse()?..to.parse()?;
    let (pixels, tolerance) = (pixels.parse()?, tolerance.parse()?);
    println!(
        "| family | seeds | by lines | of them within {tolerance} | largest error | estimate / error | pixels beyond \
         their error | evaluations a pixel | seconds of all |"
    );
    println!("| --- | --- | --: | --: | --: | --: | --: | --: | --: |");
    let shape = [pixels; 2];
    let canonical = |name, seed, rate, reference| Scene {
        name: format!("{name}-{seed}"),
        rate,
        camera: Arc::new(Canonical),
        reference,
    };
    let families: [(&str, &dyn Fn(u64) -> Scene); 6] = [
        ("family", &|seed| {
            let scene = random_scene(seed);
            let reference = scene.reference_image(shape);
            canonical("family", seed, Box::new(move |r| scene.rate(r)), reference)
        }),
        ("peaks", &|seed| {
            let scene = random_peak(seed);
            let reference = scene.reference_image(shape);
            canonical("peak", seed, Box::new(move |r| scene.rate(r)), reference)
        }),
        ("wires", &|seed| {
            let scene = random_wires(seed);
            let reference = Reference { image: scene.exact_image(shape), error: 0.0 };
            canonical("wires", seed, Box::new(move |r| scene.rate(r)), reference)
        }),
        ("shapes", &|seed| {
            let scene = random_shape(seed);
            let reference = scene.reference_image(shape);
            canonical(scene.kind(), seed, Box::new(move |r| scene.rate(r)), reference)
        }),
        ("planets", &|seed| {
            let scene = random_planet(seed);
            let (name, camera) = (scene.name(), scene.camera());
            let reference = scene.reference_image(shape);
            Scene { name, rate: Box::new(move |r| scene.rate(r)), camera, reference }
        }),
        ("views", &|seed| {
            let scene = Arc::new(random_view(seed));
            let (name, camera) = (scene.name(), scene.shared_camera());
            let reference = scene.reference();
            Scene { name, rate: Box::new(move |r| scene.rate(r)), camera, reference }
        }),
    ];
    for (name, scene) in families {
        if names.is_empty() || names.split(',').any(|wanted| wanted == name) {
            println!("{}", row(name, seeds.clone(), scene, tolerance)?);
        }
    }
    Ok(())
}

/// One family.
fn row(
    name: &str,
    seeds: Range<u64>,
    scene: &dyn Fn(u64) -> Scene,
    tolerance: f64,
) -> Result<String, Box<dyn Error>> {
    let (mut by_lines, mut within, mut largest) = (0_u32, 0_u32, 0.0_f64);
    let (mut ratios, mut beyond, mut all, mut evaluations) = (0.0, 0_usize, 0_usize, 0);
    let mut seconds = 0.0;
    for seed in seeds.clone() {
        let Scene { name, rate, camera, reference } = scene(seed);
        let exact = &reference.image;
        let options = VolOptions::new(tolerance).with_minimize(Minimize::Time);
        let emission = FromFn(|position, _| rate(position));
        let shape = [exact.height(), exact.width()];
        let start = Instant::now();
        let found = render(
            &emission,
            &*camera,
            shape,
            &RenderOptions::new(options).with_max_evaluations(1_000_000_000),
        )?;
        seconds += start.elapsed().as_secs_f64();
        if found.stats.line_steps.is_none() {
            continue;
        }
        let Outcome { error, worst, .. } = Outcome::of(&found, &reference);
        by_lines += 1;
        within += u32::from(error <= tolerance + reference.error);
        largest = largest.max(error);
        if error > tolerance {
            println!("{name}: {error:.1e} ± {:.0e} at {worst:?}", reference.error);
        }
        ratios += (found.estimated_error().unwrap_or(0.0) / error.max(1e-12)).ln();
        evaluations += found.stats.evaluations;
        let brightest = exact.pixels().iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        let slack = brightest * (0.01 * tolerance + reference.error);
        let errors = found.error.ok_or("errors")?;
        let pixels = found.values.pixels().iter().zip(exact.pixels()).zip(errors.pixels());
        all += exact.pixels().len();
        beyond += pixels.filter(|((a, b), error)| (*a - *b).abs() > *error + slack).count();
    }
    let seeds = format!("{} to {}", seeds.start, seeds.end - 1);
    if by_lines == 0 {
        return Ok(format!("| {name} | {seeds} | 0 | - | - | - | - | - | {seconds:.1} |"));
    }
    let ratio = (ratios / f64::from(by_lines)).exp();
    let share = beyond as f64 / all as f64;
    let each = evaluations as f64 / all as f64;
    Ok(format!(
        "| {name} | {seeds} | {by_lines} | {within} | {largest:.2e} | {ratio:.1} | {share:.1e} | {each:.0} | {seconds:.1} |"
    ))
}
