//! Shapes with sharp surfaces seen by cameras of all kinds: the tables of docs/results/engine.md.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example jumps -- named 1e-2` renders a ball, two balls and a shell from
//! outside and from inside, `… -- named 1e-2 ball,polar` those whose names contain all of these words, and
//! `… -- family 0 100 1e-2` the random views of seeds 0 to 99.

use emitree::{FromFn, RenderOptions, Rendering, VolOptions, render};
use emitree_problems::jumps::{CAMERAS, Jump, SCENES, SURROUNDINGS, named_jump, random_jump};
use emitree_problems::views::Outcome;
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["named", tolerance] => named(tolerance.parse()?, ""),
        ["named", tolerance, names] => named(tolerance.parse()?, names),
        ["family", from, to, tolerance] => family(from.parse()?..to.parse()?, tolerance.parse()?),
        _ => Err("expected: named T [WORD,…] | family FROM TO T".into()),
    }
}

fn vol(view: &Jump, tolerance: f64) -> Result<Rendering, Box<dyn Error>> {
    let emission = FromFn(|position, _| view.rate(position));
    let options = RenderOptions::new(VolOptions::new(tolerance)).with_max_evaluations(3_000_000);
    Ok(render(&emission, view.camera(), view.pixels(), &options)?)
}

fn named(tolerance: f64, names: &str) -> Result<(), Box<dyn Error>> {
    println!("| view | evaluations | true error | estimate | by | seconds |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for scene in SCENES {
        for around in SURROUNDINGS {
            for is_inside in [false, true] {
                for camera in CAMERAS {
                    let Some(view) = named_jump(scene, camera, is_inside, around) else { continue };
                    if names.split(',').all(|word| view.name().contains(word)) {
                        row(&view, tolerance)?;
                    }
                }
            }
        }
    }
    Ok(())
}

fn row(view: &Jump, tolerance: f64) -> Result<(), Box<dyn Error>> {
    let exact = view.reference_image();
    let start = Instant::now();
    let rendering = vol(view, tolerance)?;
    println!(
        "| {} | {} | {:.1e} ± {:.0e} | {:.1e}{} | {} | {:.2} |",
        view.name(),
        rendering.stats.evaluations,
        Outcome::of(&rendering, &exact).error,
        exact.error,
        rendering.estimated_error().unwrap_or(f64::NAN),
        if rendering.converged() { "" } else { " (not converged)" },
        if rendering.surfaces.is_some() { "surfaces" } else { "trees" },
        start.elapsed().as_secs_f64(),
    );
    Ok(())
}

fn family(seeds: std::ops::Range<u64>, tolerance: f64) -> Result<(), Box<dyn Error>> {
    let count = seeds.end - seeds.start;
    // For each kind of camera: views, those within the tolerance, those of surfaces, logarithms of evaluations.
    let mut kinds = [(0_u32, 0_u32, 0_u32, 0.0_f64); CAMERAS.len()];
    for seed in seeds {
        let view = random_jump(seed);
        let exact = view.reference_image();
        let rendering = vol(&view, tolerance)?;
        let error = Outcome::of(&rendering, &exact).error;
        let is_kept = rendering.converged() && error <= tolerance + exact.error;
        let is_by_surfaces = rendering.surfaces.is_some();
        let kind = CAMERAS.iter().position(|kind| view.name().contains(kind)).unwrap_or(0);
        let of_kind = &mut kinds[kind];
        of_kind.0 += 1;
        of_kind.1 += u32::from(is_kept);
        of_kind.2 += u32::from(is_by_surfaces);
        of_kind.3 += (rendering.stats.evaluations as f64).ln();
        if !is_kept || !is_by_surfaces {
            println!(
                "{}: {} evaluations, true {error:.1e} ± {:.0e}, estimate {:.1e}, converged {}, {}, {:?}",
                view.name(),
                rendering.stats.evaluations,
                exact.error,
                rendering.estimated_error().unwrap_or(f64::NAN),
                rendering.converged(),
                if is_by_surfaces { "surfaces" } else { "no surfaces" },
                rendering.stats.smallest_feature,
            );
        }
    }
    println!(
        "| camera | views | within {tolerance} | by surfaces | evaluations (geometric mean) |"
    );
    println!("| --- | --- | --- | --- | --- |");
    let mut all = 0.0;
    for (camera, (views, kept, by_surfaces, logs)) in CAMERAS.iter().zip(kinds) {
        let mean = (logs / f64::from(views.max(1))).exp();
        println!("| {camera} | {views} | {kept} | {by_surfaces} | {mean:.0} |");
        all += logs;
    }
    println!("{:.0} evaluations (geometric mean of all)", (all / count as f64).exp());
    Ok(())
}
