//! Errors by pixel: tolerances met and evaluations of random scenes.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example by_pixel -- family 0 60 1e-2 1e-3` renders random smooth
//! scenes so that each pixel has an error of 1 % of its own value, or of 1e-3 of the brightest one, and
//! compares the evaluations with those for 1 % of the brightest; `… -- views 0 60 1e-2 1e-3` does the same
//! for views with opaque bodies. `… -- cubes 32 1e-2 1e-3` renders the cubes of `emitree_problems::cubes` with 32
//! bins: to 1 % of the largest voxel, each band to 1 % of its own largest voxel, and each voxel to 1 % of itself or of
//! 1e-3 of the largest; a fifth argument names one of them.

use emitree::vol::PixelTolerance;
use emitree::{
    Canonical, FromFn, FromSpectralFn, Projection, RenderError, RenderOptions, Rendering,
    VolOptions, render, render_cube,
};
use emitree_problems::cubes::problems;
use emitree_problems::family::{Reference, random_scene};
use emitree_problems::views::random_view;
use std::convert::Infallible;
use std::error::Error;

/// A scene with its exact image.
struct Scene {
    name: String,
    render: Box<dyn Fn(VolOptions) -> Result<Rendering, RenderError<Infallible>>>,
    reference: Reference,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    if let ["cubes", bins, rtol, floor, name @ ..] = words.as_slice() {
        let by_pixel = PixelTolerance::relative(rtol.parse()?).with_floor(floor.parse()?);
        return cubes(bins.parse()?, by_pixel, name.first().unwrap_or(&""));
    }
    let [family, from, to, rtol, floor] = words.as_slice() else {
        return Err(
            "expected: family|views FROM TO RTOL FLOOR or cubes BINS RTOL FLOOR [NAME]".into()
        );
    };
    let by_pixel = PixelTolerance::relative(rtol.parse()?).with_floor(floor.parse()?);
    let make = match *family {
        "family" => smooth_scene,
        "views" => view_scene,
        _ => return Err("expected: family or views".into()),
    };
    compare((from.parse()?..to.parse()?).map(make), by_pixel)
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

fn compare(
    scenes: impl Iterator<Item = Scene>,
    by_pixel: PixelTolerance,
) -> Result<(), Box<dyn Error>> {
    let (mut count, mut kept, mut logs, mut uniform_logs) = (0, 0, 0.0, 0.0);
    for scene in scenes {
        let options = VolOptions::default().with_pixel_tolerance(by_pixel);
        let found = (scene.render)(options)?;
        let uniform = (scene.render)(VolOptions::new(by_pixel.rtol))?;
        let exact = &scene.reference.image;
        let largest = exact.pixels().iter().fold(0.0, |most: f64, pixel| most.max(pixel.abs()));
        let of_reference = scene.reference.error * largest;
        let ratio = |(found, exact): (&f64, &f64)| {
            ((found - exact).abs() - of_reference) / by_pixel.allowed(*exact, largest)
        };
        let pixels = found.values.pixels().iter().zip(exact.pixels());
        let mut ratios: Vec<f64> = pixels.map(ratio).filter(|ratio| !ratio.is_nan()).collect();
        ratios.sort_by(f64::total_cmp);
        let within = ratios.iter().filter(|ratio| **ratio <= 1.0).count() as f64;
        let is_kept = found.converged() && within >= 0.999 * ratios.len() as f64;
        let [evaluations, of_uniform] = [&found, &uniform].map(|of| of.stats.evaluations as f64);
        count += 1;
        kept += usize::from(is_kept);
        logs += evaluations.ln();
        uniform_logs += of_uniform.ln();
        if !is_kept {
            println!(
                "{}: {evaluations} evaluations ({of_uniform} for the brightest), {:.4} of the pixels \
                 within, worst {:.2}, estimate {:.2} of the error allowed, {:?}",
                scene.name,
                within / ratios.len() as f64,
                ratios.last().copied().unwrap_or(f64::NAN),
                found.stats.error_over_allowed.unwrap_or(f64::NAN),
                found.stats.ending,
            );
        }
    }
    let [mean, of_uniform] = [logs, uniform_logs].map(|logs| (logs / f64::from(count)).exp());
    println!(
        "{kept} of {count} kept, {mean:.0} evaluations (geometric mean), {of_uniform:.0} for the same \
         tolerance of the brightest pixel: {:.2} times",
        mean / of_uniform
    );
    Ok(())
}

fn cubes(bins: usize, by_pixel: PixelTolerance, only: &str) -> Result<(), Box<dyn Error>> {
    println!(
        "| cube | error of | evaluations | energies | true error / allowed | estimate / allowed |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    for problem in problems().iter().filter(|problem| problem.name.starts_with(only)) {
        let axis = problem.default_axis(bins)?;
        let exact = problem.exact([64, 64], &axis);
        let largest = exact.largest();
        let of_bands: Vec<f64> = exact.bands().iter().map(|band| band.min_max().1).collect();
        let plain = VolOptions::new(by_pixel.rtol);
        let kinds = [
            ("the largest voxel", plain.clone()),
            ("that of each band", plain.with_per_band(true)),
            ("each voxel", VolOptions::default().with_pixel_tolerance(by_pixel)),
        ];
        for (kind, (name, vol)) in kinds.into_iter().enumerate() {
            let emission = FromSpectralFn(|position, _, energy| problem.rate(position, energy));
            let options = RenderOptions::new(vol).with_max_evaluations(10_000_000);
            let found = render_cube(&emission, &Canonical, [64, 64], &axis, &options)?;
            let allowed = |band: usize, voxel: f64| match kind {
                0 => by_pixel.rtol * largest,
                1 => by_pixel.rtol * of_bands[band].max(1e-5 * largest),
                _ => by_pixel.allowed(voxel, largest),
            };
            let mut worst: f64 = 0.0;
            for (band, (found, exact)) in found.values.bands().iter().zip(exact.bands()).enumerate()
            {
                for (found, exact) in found.pixels().iter().zip(exact.pixels()) {
                    let error = (found - exact).abs() - problem.cube_error * largest;
                    worst = worst.max(error / allowed(band, *exact));
                }
            }
            let estimate = found.stats.error_over_allowed;
            let estimate = estimate.or(found.estimated_error().map(|error| error / by_pixel.rtol));
            println!(
                "| {} | {name} | {} | {} | {worst:.2} | {:.2}{} |",
                problem.name,
                found.stats.evaluations,
                found.stats.energies.len(),
                estimate.unwrap_or(f64::NAN),
                if found.converged() { "" } else { " (not converged)" },
            );
        }
    }
    Ok(())
}
