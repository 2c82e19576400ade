//! Lines of sight through all pixels, where time is minimized, against exact images: the table of docs/results/engine.md.
#![expect(clippy::print_stdout, reason = "this program prints a table")]
//!
//! `cargo run --release -p emitree --example pixel_lines -- 0 120 64 1e-2` renders the scenes of seeds 0 to 119 of three
//! random families with 64 × 64 pixels. Scenes that `vol` renders all the same are counted apart.

use emitree::vol::Minimize;
use emitree::{Canonical, FromFn, Image, RenderOptions, VolOptions, render};
use emitree_problems::family::{random_peak, random_scene};
use emitree_problems::relative_error;
use emitree_problems::wires::random_wires;
use std::error::Error;
use std::ops::Range;

type Rate = Box<dyn Fn([f64; 3]) -> f64 + Sync>;
type Scene = (Rate, Image);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [from, to, pixels, tolerance] = &arguments[..] else {
        return Err("expected: FROM TO PIXELS TOLERANCE".into());
    };
    let seeds = from.parse()?..to.parse()?;
    let (pixels, tolerance) = (pixels.parse()?, tolerance.parse()?);
    println!(
        "| family | seeds | by lines | of them within {tolerance} | largest error | estimate / error | pixels beyond \
         their error | evaluations a pixel |"
    );
    println!("| --- | --- | --: | --: | --: | --: | --: | --: |");
    let shape = [pixels; 2];
    let families: [(&str, &dyn Fn(u64) -> Scene); 3] = [
        ("family", &|seed| {
            let scene = random_scene(seed);
            let exact = scene.reference_image(shape).image;
            (Box::new(move |r| scene.rate(r)), exact)
        }),
        ("peaks", &|seed| {
            let scene = random_peak(seed);
            let exact = scene.reference_image(shape).image;
            (Box::new(move |r| scene.rate(r)), exact)
        }),
        ("wires", &|seed| {
            let scene = random_wires(seed);
            let exact = scene.exact_image(shape);
            (Box::new(move |r| scene.rate(r)), exact)
        }),
    ];
    for (name, scene) in families {
        println!("{}", row(name, seeds.clone(), scene, tolerance)?);
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
    for seed in seeds.clone() {
        let (rate, exact) = scene(seed);
        let options = VolOptions::new(tolerance).with_minimize(Minimize::Time);
        let emission = FromFn(|position, _| rate(position));
        let shape = [exact.height(), exact.width()];
        let found = render(&emission, &Canonical, shape, &RenderOptions::new(options))?;
        if found.stats.line_steps.is_none() {
            continue;
        }
        let error = relative_error(&found.values, &exact);
        by_lines += 1;
        within += u32::from(error <= tolerance);
        largest = largest.max(error);
        ratios += (found.estimated_error().unwrap_or(0.0) / error.max(1e-12)).ln();
        evaluations += found.stats.evaluations;
        let brightest = exact.pixels().iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        let errors = found.error.ok_or("errors")?;
        let pixels = found.values.pixels().iter().zip(exact.pixels()).zip(errors.pixels());
        all += exact.pixels().len();
        beyond += pixels
            .filter(|((a, b), error)| (*a - *b).abs() > *error + 0.01 * tolerance * brightest)
            .count();
    }
    let seeds = format!("{} to {}", seeds.start, seeds.end - 1);
    if by_lines == 0 {
        return Ok(format!("| {name} | {seeds} | 0 | - | - | - | - | - |"));
    }
    let ratio = (ratios / f64::from(by_lines)).exp();
    let share = beyond as f64 / all as f64;
    let each = evaluations as f64 / all as f64;
    Ok(format!(
        "| {name} | {seeds} | {by_lines} | {within} | {largest:.2e} | {ratio:.1} | {share:.1e} | {each:.0} |"
    ))
}
