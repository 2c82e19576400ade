//! Meshes for other parameters: errors as estimated and true, and evaluations.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example plans -- family 0 60 1e-2` renders the random scenes of seeds 0
//! to 59, and with the mesh of each the same scene with parameters that differ by up to 1, 3, 10 and 30 %;
//! `… -- views 0 60 1e-2` does so with random views. Scenes whose mesh has lines, those of image trees, are left
//! out; `… -- family 0 60 1e-2 trees 4` has these alone, with meshes for a tolerance 4 times smaller.

use emitree::{Emission, FromFn, Projection, RenderOptions, VolOptions, render};
use emitree_problems::family::{Reference, random_scene};
use emitree_problems::views::{Outcome, random_view};
use std::error::Error;

const CHANGES: [f64; 4] = [0.01, 0.03, 0.1, 0.3];

/// What was found with one change.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    scenes: u32,
    /// Renderings that did not need other functions, and those of them that are not within the tolerance.
    suffice: u32,
    wrong: u32,
    /// Logarithms of evaluations: with a mesh where it suffices, and from nothing.
    with_mesh: f64,
    from_nothing: f64,
    /// The largest true error over the error allowed, where the mesh suffices.
    worst: f64,
    /// The logarithm of the estimated over the true error.
    excess: f64,
    /// Renderings whose true error is beyond the estimated one, whether the mesh suffices or not.
    underestimated: u32,
}

/// Which meshes, and for which tolerances.
#[derive(Clone, Copy, Debug)]
struct Wanted {
    tolerance: f64,
    trees: bool,
    /// The tolerance over that of the meshes.
    finer: f64,
}

/// A camera with emissions: of the seed, and with other parameters.
struct Scene<'a> {
    name: String,
    camera: &'a dyn Projection,
    shape: [usize; 2],
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let mut sums = [Sums::default(); CHANGES.len()];
    let [kind, from, to, tolerance, rest @ ..] = words.as_slice() else {
        return Err("expected: family FROM TO TOLERANCE [trees FINER], or views …".into());
    };
    let wanted = Wanted {
        tolerance: tolerance.parse()?,
        trees: rest.first() == Some(&"trees"),
        finer: rest.get(1).map_or(Ok(1.0), |finer| finer.parse())?,
    };
    for seed in from.parse()?..to.parse()? {
        match *kind {
            "family" => {
                let scene = |change| random_scene(seed).changed(change);
                let camera = &emitree::Canonical;
                let view = Scene { name: scene(0.0).name(), camera, shape: [64; 2] };
                let glow = |change| {
                    let scene = scene(change);
                    FromFn(move |position: [f64; 3], _| scene.rate(position))
                };
                let reference = |change: f64| scene(change).reference_image([64; 2]);
                of_scene(&view, glow, reference, wanted, &mut sums)?;
            }
            _ => {
                let scene = |change| random_view(seed).changed(change);
                let of_seed = scene(0.0);
                let (camera, shape) = (of_seed.camera(), of_seed.shape());
                let view = Scene { name: of_seed.name(), camera, shape };
                let glow = |change| {
                    let scene = scene(change);
                    FromFn(move |position: [f64; 3], _| scene.rate(position))
                };
                let reference = |change: f64| scene(change).reference();
                of_scene(&view, glow, reference, wanted, &mut sums)?;
            }
        }
    }
    println!(
        "| change | scenes | mesh suffices | beyond T | worst / T | evaluations | from nothing | estimate / error | underestimated |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for (change, of) in CHANGES.iter().zip(sums) {
        let mean = |sum: f64, count: u32| (sum / f64::from(count.max(1))).exp();
        println!(
            "| {:.0} % | {} | {} | {} | {:.2} | {:.0} | {:.0} | {:.1} | {} |",
            100.0 * change,
            of.scenes,
            of.suffice,
            of.wrong,
            of.worst,
            mean(of.with_mesh, of.suffice),
            mean(of.from_nothing, of.suffice),
            mean(of.excess, of.scenes),
            of.underestimated,
        );
    }
    Ok(())
}

fn of_scene<E: Emission>(
    scene: &Scene<'_>,
    glow: impl Fn(f64) -> E,
    reference: impl Fn(f64) -> Reference,
    wanted: Wanted,
    sums: &mut [Sums],
) -> Result<(), Box<dyn Error>>
where
    E::Error: 'static,
{
    let with_tolerance =
        |tolerance| RenderOptions::new(VolOptions::new(tolerance)).with_mesh_up_to(1_000_000);
    let (tolerance, options) = (wanted.tolerance, with_tolerance(wanted.tolerance));
    let finer = with_tolerance(tolerance / wanted.finer);
    let first = render(&glow(0.0), scene.camera, scene.shape, &finer)?;
    let Some(mesh) = first.mesh else { return Ok(()) };
    let has_lines = (0..mesh.weights().rows()).any(|row| mesh.weights().row(row).count() > 1);
    if has_lines != wanted.trees {
        return Ok(());
    }
    for (&change, sums) in CHANGES.iter().zip(sums) {
        let fixed = options.clone().with_fixed_mesh(&mesh);
        let Ok(found) = render(&glow(change), scene.camera, scene.shape, &fixed) else {
            return Ok(());
        };
        let outcome = Outcome::of(&found, &reference(change));
        let (share, estimate) = (outcome.error / tolerance, found.estimated_error().unwrap_or(0.0));
        sums.scenes += 1;
        sums.excess += (estimate.max(1e-9) / outcome.error.max(1e-9)).ln();
        sums.underestimated += u32::from(outcome.error > estimate);
        if !found.converged() {
            continue;
        }
        let rendered = render(&glow(change), scene.camera, scene.shape, &options)?;
        sums.suffice += 1;
        sums.with_mesh += (found.stats.evaluations as f64).ln();
        sums.from_nothing += (rendered.stats.evaluations as f64).ln();
        sums.worst = sums.worst.max(share);
        if share > 1.0 {
            sums.wrong += 1;
            println!("{} changed by {change}: {share:.2} of the tolerance", scene.name);
        }
    }
    Ok(())
}
