//! Evaluations of spectral cubes against bins × one image: the tables of docs/results/engine.md.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example cubes -- 32 1e-1,1e-2,1e-3` renders the cubes of
//! `emitree_problems::cubes` with 64 × 64 pixels and 32 bins; a third argument names one of them.
//! Beside them are the evaluations of one image for each bin, at the middle of its energies: to the
//! same tolerance of its own largest pixel, and to the same error as the cube.
//!
//! `cubes -- jumps 0 50 20 1e-2` renders random cubes with sharp surfaces, beside an image at the energy of the largest
//! band; with `trees` at the end by trees alone. `cubes -- skies 0 50 20 1e-2` renders such cubes from cameras of all
//! kinds, and `smooth` and `views` render two smooth emissions with spectra of their own, in the canonical projection and in
//! random views.

use emitree::{
    Canonical, Cube, EnergyAxis, FromFn, FromSpectralFn, Image, Projection, RenderOptions,
    Rendering, VolOptions, render, render_cube,
};
use emitree_problems::cubes::jumps::{CubeReference, JumpCube, random_jump_cube};
use emitree_problems::cubes::mixtures::{MixtureCube, random_mixture};
use emitree_problems::cubes::skies::{SkyCube, random_sky_cube};
use emitree_problems::cubes::{CubeProblem, problems};
use std::error::Error;
use std::ops::Range;
use std::time::Instant;

const SHAPE: [usize; 2] = [64, 64];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        [
            family @ ("jumps" | "skies" | "smooth" | "views"),
            from,
            to,
            bins,
            tolerances,
            with @ ..,
        ] if matches!(with, [] | ["trees"]) => {
            let scene = match *family {
                "jumps" => Scene::canonical,
                "skies" => Scene::of_camera,
                "smooth" => Scene::smooth,
                _ => Scene::of_view,
            };
            let by_trees = with == ["trees"];
            random_cubes(scene, from.parse()?..to.parse()?, bins.parse()?, tolerances, by_trees)
        }
        [bins, tolerances] => table(bins.parse()?, tolerances, ""),
        [bins, tolerances, name] => table(bins.parse()?, tolerances, name),
        _ => {
            Err("expected: BINS T,… [NAME] | jumps|skies|smooth|views FROM TO BINS T,… [trees]"
                .into())
        }
    }
}

fn options(tolerance: f64) -> RenderOptions<'static> {
    let vol = VolOptions::new(tolerance);
    RenderOptions::new(vol).with_max_evaluations(10_000_000)
}

/// The same by trees alone, since errors are weighted, if only with 1.
fn options_of_trees(tolerance: f64, [height, width]: [usize; 2]) -> RenderOptions<'static> {
    let weights = Image::from_pixels(height, width, vec![1.0; height * width]);
    let vol = VolOptions::new(tolerance).with_weights(weights);
    RenderOptions::new(vol).with_max_evaluations(10_000_000)
}

/// A random cube.
enum Scene {
    Canonical(JumpCube),
    OfCamera(Box<SkyCube>),
    Mixture(MixtureCube),
}

impl Scene {
    fn canonical(seed: u64) -> Self {
        Self::Canonical(random_jump_cube(seed))
    }

    fn of_camera(seed: u64) -> Self {
        Self::OfCamera(Box::new(random_sky_cube(seed)))
    }

    fn smooth(seed: u64) -> Self {
        Self::Mixture(random_mixture(seed, false))
    }

    fn of_view(seed: u64) -> Self {
        Self::Mixture(random_mixture(seed, true))
    }

    fn name(&self) -> String {
        match self {
            Self::Canonical(scene) => scene.name().into(),
            Self::OfCamera(scene) => scene.name(),
            Self::Mixture(scene) => scene.name().into(),
        }
    }

    fn camera(&self) -> &dyn Projection {
        match self {
            Self::Canonical(_) => &Canonical,
            Self::OfCamera(scene) => scene.camera(),
            Self::Mixture(scene) => scene.camera(),
        }
    }

    fn pixels(&self) -> [usize; 2] {
        match self {
            Self::Canonical(_) => SHAPE,
            Self::OfCamera(scene) => scene.pixels(),
            Self::Mixture(scene) => scene.pixels(),
        }
    }

    fn rate(&self, position: [f64; 3], energy: f64) -> f64 {
        match self {
            Self::Canonical(scene) => scene.rate(position, energy),
            Self::OfCamera(scene) => scene.rate(position, energy),
            Self::Mixture(scene) => scene.rate(position, energy),
        }
    }

    fn axis(&self, bins: usize) -> Result<EnergyAxis, Box<dyn Error>> {
        Ok(match self {
            Self::Canonical(scene) => scene.axis(bins)?,
            Self::OfCamera(scene) => scene.axis(bins)?,
            Self::Mixture(scene) => scene.axis(bins)?,
        })
    }

    fn reference(&self, axis: &EnergyAxis) -> CubeReference {
        match self {
            Self::Canonical(scene) => scene.reference(SHAPE, axis),
            Self::OfCamera(scene) => scene.reference(axis),
            Self::Mixture(scene) => scene.reference(axis),
        }
    }
}

fn cube(
    problem: &CubeProblem,
    axis: &EnergyAxis,
    tolerance: f64,
) -> Result<Rendering<Cube>, Box<dyn Error>> {
    let emission = FromSpectralFn(|position, _, energy| problem.rate(position, energy));
    Ok(render_cube(&emission, &Canonical, SHAPE, axis, &options(tolerance))?)
}

/// Evaluations of one image for each bin: to a tolerance of its own largest pixel, or of `largest`.
fn images(
    problem: &CubeProblem,
    axis: &EnergyAxis,
    tolerance: f64,
    largest: Option<&[f64]>,
) -> Result<u64, Box<dyn Error>> {
    let mut evaluations = 0;
    let brightest = largest.map(|bands| bands.iter().copied().fold(0.0, f64::max));
    for bin in 0..axis.bins() {
        let energy = axis.energy((bin as f64 + 0.5) / axis.bins() as f64);
        let emission = FromFn(|position, _| problem.rate(position, energy));
        let tolerance = match (brightest, largest) {
            (Some(brightest), Some(bands)) => (tolerance * brightest / bands[bin]).min(0.5),
            _ => tolerance,
        };
        evaluations += render(&emission, &Canonical, SHAPE, &options(tolerance))?.stats.evaluations;
    }
    Ok(evaluations)
}

fn table(bins: usize, tolerances: &str, only: &str) -> Result<(), Box<dyn Error>> {
    println!(
        "| cube | tolerance | evaluations | energies | true error | estimate | inside | seconds | \
         one image a bin | to the same error |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for problem in problems().iter().filter(|p| p.name.starts_with(only)) {
        let axis = problem.default_axis(bins)?;
        let exact = problem.exact(SHAPE, &axis);
        let largest: Vec<f64> = exact.bands().iter().map(|band| band.min_max().1).collect();
        for tolerance in tolerances.split(',') {
            let tolerance: f64 = tolerance.parse()?;
            let start = Instant::now();
            let found = cube(problem, &axis, tolerance)?;
            let seconds = start.elapsed().as_secs_f64();
            let errors = found.error.as_ref().map(|error| error.voxels().collect::<Vec<_>>());
            let errors = errors.unwrap_or_default();
            let slack = problem.cube_error * exact.largest();
            let within = found.values.voxels().zip(exact.voxels()).zip(&errors);
            let within = within.filter(|((a, b), error)| (a - b).abs() <= **error + slack).count();
            println!(
                "| {} | {tolerance:.0e} | {} | {} | {:.1e} | {:.1e}{} | {:.4} | {seconds:.2} | {} | {} |",
                problem.name,
                found.stats.evaluations,
                found.stats.energies.len(),
                found.values.max_difference(&exact) / exact.largest(),
                found.estimated_error().unwrap_or(f64::NAN),
                if found.converged() { "" } else { " (not converged)" },
                within as f64 / errors.len() as f64,
                images(problem, &axis, tolerance, None)?,
                images(problem, &axis, tolerance, Some(&largest))?,
            );
        }
    }
    Ok(())
}

/// How often a tolerance is met by random cubes, and at what cost.
fn random_cubes(
    scene: fn(u64) -> Scene,
    seeds: Range<u64>,
    bins: usize,
    tolerances: &str,
    by_trees: bool,
) -> Result<(), Box<dyn Error>> {
    for tolerance in tolerances.split(',') {
        let tolerance: f64 = tolerance.parse()?;
        println!(
            "| scene | evaluations | energies | surfaces | one image | true error | estimate | inside | seconds |"
        );
        println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
        let (mut kept, mut found_surfaces, mut logs, mut ratios) = (0, 0, 0.0, Vec::new());
        let count = seeds.end - seeds.start;
        for seed in seeds.clone() {
            let scene = scene(seed);
            let (axis, shape) = (scene.axis(bins)?, scene.pixels());
            let options = || match by_trees {
                false => options(tolerance),
                true => options_of_trees(tolerance, shape),
            };
            let reference = scene.reference(&axis);
            let largest = reference.cube.largest();
            let start = Instant::now();
            let emission = FromSpectralFn(|position, _, energy| scene.rate(position, energy));
            let found = render_cube(&emission, scene.camera(), shape, &axis, &options())?;
            let seconds = start.elapsed().as_secs_f64();
            let bands = reference.cube.bands().iter().map(|band| band.min_max().1).enumerate();
            let brightest = bands.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(bin, _)| bin);
            let energy = axis.energy((brightest as f64 + 0.5) / bins as f64);
            let image = FromFn(|position, _| scene.rate(position, energy));
            let image = render(&image, scene.camera(), shape, &options())?;
            let error = found.values.max_difference(&reference.cube) / largest;
            let is_kept = found.converged() && error <= tolerance + reference.error;
            let errors: Vec<f64> =
                found.error.as_ref().map(|error| error.voxels().collect()).unwrap_or_default();
            let slack = reference.error * largest;
            let within = found.values.voxels().zip(reference.cube.voxels()).zip(&errors);
            let within = within.filter(|((a, b), error)| (a - b).abs() <= **error + slack).count();
            kept += u64::from(is_kept);
            found_surfaces += u64::from(found.surfaces.is_some());
            logs += (found.stats.evaluations as f64).ln();
            ratios.push(found.stats.evaluations as f64 / image.stats.evaluations as f64);
            println!(
                "| {} | {} | {} | {} | {} | {error:.1e}{} | {:.1e} | {:.4} | {seconds:.2} |",
                scene.name(),
                found.stats.evaluations,
                found.stats.energies.len(),
                if found.surfaces.is_some() { "yes" } else { "no" },
                image.stats.evaluations,
                if is_kept { "" } else { " (not kept)" },
                found.estimated_error().unwrap_or(f64::NAN),
                within as f64 / errors.len() as f64,
            );
        }
        ratios.sort_by(f64::total_cmp);
        println!(
            "{tolerance:.0e}: {kept} of {count} kept, {found_surfaces} with surfaces, {:.0} evaluations (geometric \
             mean), over those of an image {:.1} (median; {:.1} to {:.1})",
            (logs / count as f64).exp(),
            ratios[ratios.len() / 2],
            ratios[ratios.len() / 10],
            ratios[ratios.len() * 9 / 10],
        );
    }
    Ok(())
}
