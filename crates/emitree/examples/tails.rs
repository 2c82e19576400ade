//! Lines of sight to infinity: how often method `vol` meets a tolerance, and at what cost.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example tails -- 0 40 1e-2,1e-3` renders the scenes of seeds 0 to 39
//! of [`emitree_problems::tails`] on 48 × 48 pixels.

use emitree::{FromFn, Method, RenderOptions, VolOptions, render};
use emitree_problems::relative_error;
use emitree_problems::tails::random_tail;
use std::error::Error;

const SHAPE: [usize; 2] = [48, 48];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let [from, to, tolerances] = words.as_slice() else {
        return Err("expected: FROM TO T,…".into());
    };
    let tolerances: Vec<f64> = tolerances.split(',').map(str::parse).collect::<Result<_, _>>()?;
    println!("| scene | reference | asked | evaluations | true error | estimate | converged | |");
    println!("| --- | --: | --: | --: | --: | --: | --- | --- |");
    let mut kept = vec![0; tolerances.len()];
    let (from, to): (u64, u64) = (from.parse()?, to.parse()?);
    for seed in from..to {
        let tail = random_tail(seed);
        let camera = tail.camera()?;
        let reference = tail.reference_image(SHAPE);
        let emission = FromFn(|position, _| tail.rate(position));
        for (&tolerance, kept) in tolerances.iter().zip(&mut kept) {
            let method = Method::Vol(VolOptions::new(tolerance));
            let options = RenderOptions::new(method).with_max_evaluations(3_000_000);
            let rendering = render(&emission, &*camera, SHAPE, &options)?;
            let error = relative_error(&rendering.values, &reference.image);
            let converged = rendering.converged();
            let is_broken = converged && error > tolerance + reference.error;
            *kept += u64::from(!is_broken);
            println!(
                "| {} | {:.0e} | {tolerance} | {} | {error:.1e} | {:.1e} | {} | {} |",
                tail.name(),
                reference.error,
                rendering.stats.evaluations,
                rendering.estimated_error().unwrap_or(f64::NAN),
                if converged { "yes" } else { "no" },
                if is_broken { "**broken**" } else { "" },
            );
        }
    }
    for (tolerance, kept) in tolerances.iter().zip(kept) {
        println!("\ntolerance {tolerance}: {kept} of {} met, or not converged", to - from);
    }
    Ok(())
}
