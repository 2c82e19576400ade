//! Sums over regions: how often their errors are within the estimates, and evaluations.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example sums -- family 0 60 1e-2 1e-3` renders random smooth scenes to 1
//! % of the brightest pixel with two sums, a disc and a box by the seed, each to 0.1 % of itself, and
//! compares them with those of reference images; `… -- views …` does the same for views with opaque
//! bodies, and `… -- solids …` for bodies with sharp edges.
//! Even and odd seeds are reported apart; constants were chosen on seeds below 60.

use emitree::sums::{Region, Sum, SumKind};
use emitree::{
    Canonical, FromFn, Image, Projection, RenderError, RenderOptions, Rendering, VolOptions, render,
};
use emitree_problems::family::{Reference, random_scene};
use emitree_problems::solids::random_solids;
use emitree_problems::views::random_view;
use std::convert::Infallible;
use std::error::Error;

/// A scene with its exact image.
struct Scene {
    name: String,
    render: Box<dyn Fn(VolOptions) -> Result<Rendering, RenderError<Infallible>>>,
    reference: Reference,
}

/// What was counted.
#[derive(Default)]
struct Counts {
    sums: u32,
    /// Sums whose error is within its estimate, and within what was allowed.
    within: u32,
    met: u32,
    converged: u32,
    /// Sums of logarithms of evaluations: with sums, and for the pixels alone.
    logs: [f64; 2],
    /// Of estimates over errors, and of the sums of errors of pixels over estimates.
    estimate_log: f64,
    bound_log: f64,
    scenes: u32,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let [family, from, to, tolerance, of_sums] = words.as_slice() else {
        return Err("expected: family|views|solids FROM TO TOLERANCE TOLERANCE_OF_SUMS".into());
    };
    let make = match *family {
        "family" => smooth_scene,
        "views" => view_scene,
        "solids" => solid_scene,
        _ => return Err("expected: family, views or solids".into()),
    };
    let (tolerance, of_sums) = (tolerance.parse()?, of_sums.parse()?);
    let mut halves = [Counts::default(), Counts::default()];
    for seed in from.parse()?..to.parse()? {
        let counts = &mut halves[usize::from(seed % 2 == 1)];
        measure(&make(seed), seed, [tolerance, of_sums], counts)?;
    }
    for (counts, half) in halves.iter().zip(["even", "odd "]) {
        print(half, counts);
    }
    Ok(())
}

fn smooth_scene(seed: u64) -> Scene {
    let scene = random_scene(seed);
    let (name, reference) = (scene.name(), scene.reference_image([64, 64]));
    let render = move |options| render_with(|r| scene.rate(r), &Canonical, [64, 64], options);
    Scene { name, render: Box::new(render), reference }
}

fn view_scene(seed: u64) -> Scene {
    let view = random_view(seed);
    let (name, reference) = (view.name(), view.reference());
    let render = move |options| render_with(|r| view.rate(r), view.camera(), view.shape(), options);
    Scene { name, render: Box::new(render), reference }
}

fn solid_scene(seed: u64) -> Scene {
    let solids = random_solids(seed);
    let (name, reference) = (format!("solids-{seed}"), solids.reference_image([64, 64]));
    let render = move |options| render_with(|r| solids.rate(r), &Canonical, [64, 64], options);
    Scene { name, render: Box::new(render), reference }
}

fn render_with(
    rate: impl Fn([f64; 3]) -> f64 + Sync,
    camera: &dyn Projection,
    shape: [usize; 2],
    options: VolOptions,
) -> Result<Rendering, RenderError<Infallible>> {
    let emission = FromFn(|position, _| rate(position));
    let options = RenderOptions::new(options).with_max_evaluations(5_000_000);
    render(&emission, camera, shape, &options)
}

/// The disc and the box of a seed.
fn regions(seed: u64, [height, width]: [usize; 2]) -> [Image; 2] {
    let mut bits = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5DEE_CE66;
    let mut next = || {
        bits ^= bits << 13;
        bits ^= bits >> 7;
        bits ^= bits << 17;
        (bits >> 11) as f64 / (1_u64 << 53) as f64
    };
    let [height_px, width_px] = [height as f64, width as f64];
    let center = [width_px * (0.2 + 0.6 * next()), height_px * (0.2 + 0.6 * next())];
    let radius = width_px.min(height_px) * (0.03 + 0.3 * next());
    let corner = [width_px * 0.6 * next(), height_px * 0.6 * next()];
    let other = [
        corner[0] + width_px * (0.05 + 0.35 * next()),
        corner[1] + height_px * (0.05 + 0.35 * next()),
    ];
    [Region::circle(center, radius), Region::rectangle(corner, other)]
        .map(|region| region.weights([height, width]))
}

fn measure(
    scene: &Scene,
    seed: u64,
    [tolerance, of_sums]: [f64; 2],
    counts: &mut Counts,
) -> Result<(), Box<dyn Error>> {
    let exact = &scene.reference.image;
    let largest = exact
        .pixels()
        .iter()
        .filter(|pixel| pixel.is_finite())
        .fold(0.0, |most: f64, pixel| most.max(pixel.abs()));
    let value = |weights: &Image, image: &Image| -> f64 {
        let pixels = weights.pixels().iter().zip(image.pixels());
        pixels.filter(|(w, p)| **w > 0.0 && p.is_finite()).map(|(w, p)| w * p).sum()
    };
    // Dark regions of a random scene are no test of relative errors.
    let is_lit = |weights: &&Image| {
        let area: f64 = weights.pixels().iter().sum();
        value(weights, exact) > 0.01 * largest * area
    };
    let regions = regions(seed, [exact.height(), exact.width()]);
    let lit: Vec<&Image> = regions.iter().filter(is_lit).collect();
    if lit.is_empty() {
        return Ok(());
    }
    let sum = |(number, weights): (usize, &&Image)| {
        let kind = if number == 0 { SumKind::Sum } else { SumKind::Mean };
        Sum::new(format!("region {number}"), (*weights).clone())
            .with_kind(kind)
            .with_tolerance(of_sums)
    };
    let sums: Vec<Sum> = lit.iter().enumerate().map(sum).collect();
    let of_pixels = if tolerance < 1.0 { tolerance } else { 0.05 };
    let plain = (scene.render)(VolOptions::new(of_pixels))?;
    let found = (scene.render)(VolOptions::new(tolerance).with_sums(sums.clone()))?;
    counts.scenes += 1;
    counts.converged += u32::from(found.converged());
    counts.logs[0] += (found.stats.evaluations as f64).ln();
    counts.logs[1] += (plain.stats.evaluations as f64).ln();
    for ((sum, weights), of_region) in sums.iter().zip(&lit).zip(&found.sums) {
        let pixels = weights.pixels().iter().zip(exact.pixels());
        let area: f64 = pixels.filter(|(_, pixel)| pixel.is_finite()).map(|(w, _)| w).sum();
        let norm = if sum.kind == SumKind::Mean { area } else { 1.0 };
        let of_reference = scene.reference.error * largest * area / norm;
        let error = (of_region.value - value(weights, exact) / norm).abs();
        let error = (error - of_reference).max(0.0);
        let bound = found.error.as_ref().map_or(f64::NAN, |error| value(weights, error) / norm);
        let is_within = error <= of_region.error;
        counts.sums += 1;
        counts.within += u32::from(is_within);
        counts.met += u32::from(error <= of_region.allowed);
        counts.estimate_log += (of_region.error / error.max(1e-12 * largest * area / norm)).ln();
        counts.bound_log += (bound / of_region.error).ln();
        if !is_within || !found.converged() {
            println!(
                "{} {}: error {:.2} of the estimate, estimate {:.2} of the error allowed ({} samples, sum of \
                 errors {:.1}), {} evaluations ({} without sums), {:?}",
                scene.name,
                of_region.name,
                error / of_region.error,
                of_region.error / of_region.allowed,
                of_region.samples,
                bound / of_region.allowed,
                found.stats.evaluations,
                plain.stats.evaluations,
                found.stats.ending,
            );
        }
    }
    Ok(())
}

fn print(half: &str, counts: &Counts) {
    let sums = f64::from(counts.sums);
    let [with, without] = counts.logs.map(|log| (log / f64::from(counts.scenes)).exp());
    println!(
        "{half} seeds: {} of {} sums within their estimates ({:.2} %), {} within the error allowed, {} of {} \
         scenes converged; estimate {:.1} times the error, sum of errors {:.1} times the estimate \
         (geometric means); {with:.0} evaluations, {without:.0} without sums",
        counts.within,
        counts.sums,
        100.0 * f64::from(counts.within) / sums,
        counts.met,
        counts.converged,
        counts.scenes,
        (counts.estimate_log / sums).exp(),
        (counts.bound_log / sums).exp(),
    );
}
