//! The K corona with errors relative to each pixel: evaluations and true errors.
#![expect(clippy::print_stdout, reason = "this program prints a table")]
//!
//! `cargo run --release -p emitree --example corona -- 200 1e-2 1e-5 4 8 16` renders it on 200 × 200 pixels of
//! images of 4, 8 and 16 solar radii, each pixel within 1 % of itself or of 1e-5 of the brightest one.

use emitree::vol::PixelTolerance;
use emitree::{FromFn, RenderOptions, VolOptions, render};
use emitree_problems::corona::Corona;
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let [pixels, rtol, floor, extents @ ..] = words.as_slice() else {
        return Err("expected: PIXELS RTOL FLOOR EXTENT …".into());
    };
    let pixels: usize = pixels.parse()?;
    let by_pixel = PixelTolerance::relative(rtol.parse()?).with_floor(floor.parse()?);
    println!(
        "| extent | largest / smallest | error of the reference | error of | evaluations | true error / \
         allowed | estimate / allowed | seconds |"
    );
    println!("| --: | --: | --: | --- | --: | --: | --: | --: |");
    for extent in extents {
        let corona = Corona::new(extent.parse()?);
        let (exact, of_reference) = corona.reference(pixels);
        let [smallest, largest] = [exact.min_max().0, exact.min_max().1];
        let plain = VolOptions::new(by_pixel.rtol);
        let each = VolOptions::default().with_pixel_tolerance(by_pixel);
        for (name, vol) in [("the largest pixel", plain), ("each pixel", each)] {
            let emission = FromFn(|position, _| corona.rate(position));
            let options = RenderOptions::new(vol).with_max_evaluations(5_000_000);
            let start = Instant::now();
            let found = render(&emission, &corona.camera()?, [pixels; 2], &options)?;
            let seconds = start.elapsed().as_secs_f64();
            let worst = found.values.pixels().iter().zip(exact.pixels()).map(|(found, exact)| {
                let slack = of_reference * exact;
                ((found - exact).abs() - slack) / by_pixel.allowed(*exact, largest)
            });
            println!(
                "| {extent} | {:.1e} | {of_reference:.1e} | {name} | {} | {:.2} | {:.2}{} | {seconds:.1} |",
                largest / smallest,
                found.stats.evaluations,
                worst.fold(0.0, f64::max),
                found.stats.error_over_allowed.unwrap_or(f64::NAN),
                if found.converged() { "" } else { " (not converged)" },
            );
        }
    }
    Ok(())
}
