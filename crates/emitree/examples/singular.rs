//! Singular points: tolerances met and evaluations.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example singular -- named 1e-2,1e-3` renders halos with cusps and cores,
//! power laws and a comet; `… -- family 0 60 1e-2` renders random scenes with one or two cusps, and prints
//! those that are not within the tolerance.

use emitree::{FromFn, RenderOptions, VolOptions, render};
use emitree_problems::cusps::{CuspView, Place, comet, nfw_halo, power_law, random_cusps};
use std::error::Error;
use std::time::Instant;

const CORES_KPC: [f64; 5] = [0.0, 1e-2, 1e-3, 1e-4, 1e-5];
const POWERS: [f64; 5] = [0.5, 1.0, 1.5, 2.0, 2.3];

/// What was found of one scene.
struct Found {
    evaluations: u64,
    is_converged: bool,
    /// The true and the estimated error, over the largest pixel.
    errors: [f64; 2],
    /// Of the largest pixel itself.
    of_largest: f64,
    /// The relative error of the reference.
    of_reference: f64,
    seconds: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["named", tolerances] => named(tolerances),
        ["family", from, to, tolerances] => {
            tolerances.split(',').try_for_each(|t| family(from.parse()?, to.parse()?, t.parse()?))
        }
        _ => Err("expected: named TOLERANCES, or family FROM TO TOLERANCES".into()),
    }
}

fn named(tolerances: &str) -> Result<(), Box<dyn Error>> {
    let places = [Place::Centre, Place::Corner];
    let halos = CORES_KPC.iter().flat_map(|core| places.map(|place| nfw_halo(*core, place)));
    let powers = POWERS.iter().flat_map(|power| places.map(|place| power_law(*power, place)));
    let views = halos.chain(powers).chain(places.map(comet));
    println!("| scene | tolerance | evaluations | true error | estimate | brightest pixel | s |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for view in views {
        for tolerance in tolerances.split(',') {
            let found = of_view(&view, tolerance.parse()?)?;
            let [error, estimate] = found.errors;
            println!(
                "| {} | {tolerance} | {}{} | {error:.1e} | {estimate:.1e} | {:.1e} | {:.2} |",
                view.name(),
                found.evaluations,
                if found.is_converged { "" } else { " (not met)" },
                found.of_largest,
                found.seconds,
            );
        }
    }
    Ok(())
}

fn family(from: u64, to: u64, tolerance: f64) -> Result<(), Box<dyn Error>> {
    let (mut kept, mut untrue, mut logs) = (0, 0, 0.0);
    for seed in from..to {
        let view = random_cusps(seed);
        let found = match of_view(&view, tolerance) {
            Ok(found) => found,
            Err(error) => {
                println!("{}: {error}", view.name());
                continue;
            }
        };
        let [error, estimate] = found.errors;
        let is_within = error <= tolerance + found.of_reference;
        kept += u32::from(is_within && found.is_converged);
        untrue += u32::from(!is_within && found.is_converged);
        logs += (found.evaluations as f64).ln();
        if !is_within || !found.is_converged {
            let points: Vec<_> = view.points().collect();
            println!(
                "{}: {} evaluations, true error {error:.1e}, estimate {estimate:.1e}, reference {:.0e}, \
                 converged: {}, {:.1} s, {points:?}",
                view.name(),
                found.evaluations,
                found.of_reference,
                found.is_converged,
                found.seconds,
            );
        }
    }
    println!(
        "{kept} of {} kept at {tolerance}, {untrue} converged and wrong, {:.0} evaluations (geometric mean)",
        to - from,
        (logs / (to - from) as f64).exp()
    );
    Ok(())
}

fn of_view(view: &CuspView, tolerance: f64) -> Result<Found, Box<dyn Error>> {
    let emission = FromFn(|position, _| view.rate(position));
    let options = RenderOptions::new(VolOptions::new(tolerance)).with_max_evaluations(1_000_000);
    let start = Instant::now();
    let found = render(&emission, view.camera(), view.shape(), &options)?;
    let seconds = start.elapsed().as_secs_f64();
    let reference = view.reference();
    let pairs = || found.values.pixels().iter().zip(reference.image.pixels());
    let largest = pairs().fold(0.0, |most: f64, (_, exact)| most.max(exact.abs()));
    let wrong = pairs().map(|(found, exact)| (found - exact).abs()).fold(0.0, f64::max);
    let brightest = pairs().max_by(|a, b| a.1.total_cmp(b.1));
    Ok(Found {
        evaluations: found.stats.evaluations,
        is_converged: found.converged(),
        errors: [wrong / largest, found.estimated_error().unwrap_or(f64::NAN)],
        of_largest: brightest.map_or(f64::NAN, |(found, exact)| (found / exact - 1.0).abs()),
        of_reference: reference.error,
        seconds,
    })
}
