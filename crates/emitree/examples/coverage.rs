//! How small a knot method `vol` detects: the fraction of renderings that end converged without it.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example coverage` renders, to 1 %, small Gaussians
//! ([`emitree_problems::knots`]) at 60 places before a smooth background and before turbulence, of several
//! sizes and contrasts; `… -- smooth 1 60 0.01,0.02 20,5` only those before one background, at 60 places of
//! set 1, of these standard deviations and contrasts. Set 1 is kept out of tuning. A contrast is the
//! image peak of the knot over the tolerance. A miss is a rendering that ends converged with a true error
//! beyond the tolerance.

use emitree::{Canonical, FromFn, Method, RenderOptions, VolOptions, render};
use emitree_problems::knots::{Background, Knot};
use emitree_problems::relative_error;
use std::error::Error;

const SHAPE: [usize; 2] = [64, 64];
const TOLERANCE: f64 = 0.01;
const WIDTHS: [f64; 11] = [0.004, 0.006, 0.009, 0.012, 0.016, 0.02, 0.025, 0.03, 0.035, 0.04, 0.05];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        [] => {
            table("smooth", 0, 60, &WIDTHS, &[20.0, 5.0, 2.0])?;
            // A rendering costs some hundred times as much.
            table("turbulence", 0, 20, &WIDTHS, &[20.0])
        }
        [background, set, places, widths, contrasts] => {
            let (widths, contrasts) = (numbers(widths)?, numbers(contrasts)?);
            table(background, set.parse()?, places.parse()?, &widths, &contrasts)
        }
        _ => Err("expected: nothing | smooth|turbulence SET PLACES WIDTH,… CONTRAST,…".into()),
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, Box<dyn Error>> {
    Ok(text.split(',').map(str::parse).collect::<Result<_, _>>()?)
}

fn table(
    background: &str,
    set: u64,
    places: u64,
    widths: &[f64],
    contrasts: &[f64],
) -> Result<(), Box<dyn Error>> {
    let background = match background {
        "smooth" => Background::Smooth,
        "turbulence" => Background::turbulence(),
        _ => return Err(format!("background {background}: expected smooth or turbulence").into()),
    };
    let behind = background.exact_image(SHAPE);
    println!("\n{} background, set {set}, tolerance {TOLERANCE}\n", background.name());
    println!(
        "| contrast | width | missed | not converged | evaluations, median | largest true error |"
    );
    println!("| --: | --: | --: | --: | --: | --: |");
    for &contrast in contrasts {
        for &width in widths {
            let (mut missed, mut unfinished, mut worst) = (0, 0, 0.0_f64);
            let mut evaluations = Vec::new();
            for number in 0..places {
                let peak = contrast * TOLERANCE;
                let knot = Knot::new((set, number), width, peak, &background, &behind);
                let emission = FromFn(|position, _| knot.rate(position));
                let method = Method::Vol(VolOptions::new(TOLERANCE));
                let rendering = render(&emission, &Canonical, SHAPE, &RenderOptions::new(method))?;
                let error = relative_error(&rendering.values, knot.exact_image());
                worst = worst.max(error);
                unfinished += u64::from(!rendering.converged());
                missed += u64::from(rendering.converged() && error > TOLERANCE);
                evaluations.push(rendering.stats.evaluations);
            }
            evaluations.sort_unstable();
            let median = evaluations.get(evaluations.len() / 2).copied().unwrap_or_default();
            println!(
                "| {contrast} | {width} | {missed} of {places} | {unfinished} | {median} | {worst:.1e} |"
            );
        }
    }
    Ok(())
}
