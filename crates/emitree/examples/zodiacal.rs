//! Zodiacal light at 25 µm to several tolerances: evaluations against true errors.
#![expect(clippy::print_stdout, reason = "this program prints a table")]
//!
//! `cargo run --release -p emitree --example zodiacal` renders [`emitree_problems::zodiacal`] on
//! 120 × 120 pixels with method `vol`; `… -- 1e-2,1e-3` to these tolerances, `… -- 1e-2 0,60,120` with the
//! Earth at these longitudes \[degrees\] and towards its apex and its antapex. The last columns are the
//! pixels with an error above their own estimate, and above the tolerance.

use emitree::{FromFn, RenderOptions, VolOptions, render};
use emitree_problems::relative_error;
use emitree_problems::zodiacal::{Towards, Zodiacal};
use std::error::Error;
use std::time::Instant;

const SHAPE: [usize; 2] = [120, 120];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        [] => table(&Zodiacal::default(), &[0.1, 0.05, 0.02, 0.01, 0.005, 0.001]),
        [tolerances] => table(&Zodiacal::default(), &numbers(tolerances)?),
        [tolerances, longitudes] => {
            let tolerances = numbers(tolerances)?;
            for longitude_deg in numbers(longitudes)? {
                for towards in [Towards::Apex, Towards::Antapex] {
                    println!("\nlongitude {longitude_deg}, {towards:?}");
                    table(&Zodiacal::in_season(longitude_deg.to_radians(), towards), &tolerances)?;
                }
            }
            Ok(())
        }
        _ => Err("expected: [T,… [LONGITUDE,…]]".into()),
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, Box<dyn Error>> {
    Ok(text.split(',').map(str::parse).collect::<Result<_, _>>()?)
}

fn table(zodiacal: &Zodiacal, tolerances: &[f64]) -> Result<(), Box<dyn Error>> {
    let camera = zodiacal.camera()?;
    let reference = zodiacal.reference_image(SHAPE);
    let exact = &reference.image;
    let (_, largest) = exact.min_max();
    println!("exact image: largest pixel {largest:.3} MJy/sr, error {:.1e} of it", reference.error);
    println!(
        "| asked | evaluations | true error | estimate | outside their estimate | beyond the tolerance | seconds |"
    );
    println!("| --: | --: | --: | --: | --: | --: | --: |");
    let emission = FromFn(|position, _| zodiacal.rate(position));
    for &tolerance in tolerances {
        let options = VolOptions::new(tolerance);
        let start = Instant::now();
        let rendering = render(&emission, &camera, SHAPE, &RenderOptions::new(options))?;
        let error = rendering.error.as_ref().ok_or("method vol estimates errors")?;
        let far = rendering.values.pixels().iter().zip(exact.pixels()).map(|(a, b)| (a - b).abs());
        let slack = reference.error * largest;
        let outside = far.clone().zip(error.pixels()).filter(|(far, own)| *far > *own + slack);
        println!(
            "| {tolerance} | {} | {:.2e} | {:.2e}{} | {} | {} | {:.2} |",
            rendering.stats.evaluations,
            relative_error(&rendering.values, exact),
            rendering.estimated_error().unwrap_or(f64::NAN),
            if rendering.converged() { "" } else { " (not converged)" },
            outside.count(),
            far.filter(|far| *far > tolerance * largest + slack).count(),
            start.elapsed().as_secs_f64(),
        );
    }
    Ok(())
}
