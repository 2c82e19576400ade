//! Batches and evaluations with the option `rounds`: the table of docs/guide.md, Fewer rounds.
//!
//! `cargo run --release -p emitree --example rounds -- named 0 5 1e-2 6,3` renders the first five named problems to
//! 1 % as usual, with 6 rounds and with 3; `… -- family 0 12 1e-2 6` random smooth scenes, `… -- views 0 12 1e-2 6` views
//! with bodies, and `… -- solids 0 4 1e-2 6` solids with sharp surfaces, of these seeds.
#![expect(clippy::print_stdout, reason = "this program prints a table")]

use emitree::{Canonical, FromFn, Projection, RenderOptions, Rendering, VolOptions, render};
use emitree_problems::catalogue::problems;
use emitree_problems::family::random_scene;
use emitree_problems::solids::random_solids;
use emitree_problems::views::random_view;
use std::error::Error;

const SHAPE: [usize; 2] = [64, 64];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let [kind, from, to, tolerance, rounds] = words.as_slice() else {
        return Err("expected: named|family|views|solids FROM TO TOLERANCE ROUNDS,…".into());
    };
    let seeds = from.parse::<u64>()?..to.parse()?;
    let tolerance: f64 = tolerance.parse()?;
    let rounds: Vec<u32> = rounds.split(',').map(str::parse).collect::<Result<_, _>>()?;
    println!("| scene | evaluations, batches | with `rounds` |");
    println!("| --- | --- | --- |");
    let row = |name: String,
               g: &(dyn Fn([f64; 3]) -> f64 + Sync),
               camera: &dyn Projection,
               shape| { row(&name, g, camera, shape, tolerance, &rounds) };
    for seed in seeds {
        match *kind {
            "named" => {
                let all = problems();
                let number = usize::try_from(seed)?;
                let problem = all.get(number).ok_or("expected a number of a problem")?;
                row(problem.name.to_owned(), &|r| problem.rate(r), &Canonical, SHAPE)?;
            }
            "family" => {
                let scene = random_scene(seed);
                row(scene.name(), &|r| scene.rate(r), &Canonical, SHAPE)?;
            }
            "solids" => {
                let solids = random_solids(seed);
                row(format!("solids-{seed}"), &|r| solids.rate(r), &Canonical, SHAPE)?;
            }
            "views" => {
                let view = random_view(seed);
                row(view.name(), &|r| view.rate(r), view.camera(), view.shape())?;
            }
            _ => return Err("expected named, family, views or solids".into()),
        }
    }
    Ok(())
}

/// Prints a row, and compares the images.
fn row(
    name: &str,
    g: &(dyn Fn([f64; 3]) -> f64 + Sync),
    camera: &dyn Projection,
    shape: [usize; 2],
    tolerance: f64,
    rounds: &[u32],
) -> Result<(), Box<dyn Error>> {
    let emission = FromFn(|position, _| g(position));
    let options = RenderOptions::new(VolOptions::new(tolerance));
    let plain = render(&emission, camera, shape, &options)?;
    let mut cells = vec![cell(&plain)];
    for &rounds in rounds {
        let fewer = render(&emission, camera, shape, &options.clone().with_rounds(rounds))?;
        let factor = fewer.stats.evaluations as f64 / plain.stats.evaluations as f64;
        let is_same = fewer.values == plain.values;
        let note = if is_same { "" } else { " (another image)" };
        cells.push(format!("{rounds}: {} (× {factor:.2}){note}", cell(&fewer)));
    }
    println!("| {name} | {} |", cells.join(" | "));
    Ok(())
}

fn cell(rendering: &Rendering) -> String {
    format!("{}, {}", rendering.stats.evaluations, rendering.stats.batches)
}
