//! The influence of each constant of method `vol`: evaluations and tolerances met at the ends of its range.
#![expect(clippy::print_stdout, reason = "this program prints a table")]
//!
//! `cargo xtask ablate` runs it and writes docs/results/tuning.md. All scenes belong to the parts of the
//! families on which nothing was chosen.

use emitree::vol::tuning::{Constant, End, constants, select};
use emitree::{
    Canonical, Cube, FromFn, FromSpectralFn, RenderOptions, Rendering, VolOptions, render,
    render_cube,
};
use emitree_problems::catalogue::problem;
use emitree_problems::cubes;
use emitree_problems::family::{Reference, random_peak, random_scene};
use emitree_problems::relative_error;
use emitree_problems::views::random_view;
use rayon::prelude::*;
use std::error::Error;

const SHAPE: [usize; 2] = [64, 64];
/// Seeds of each family, from those set aside.
const SCENES: core::ops::Range<u64> = 240..252;
const PEAKS: core::ops::Range<u64> = 120..125;
const VIEWS: core::ops::Range<u64> = 160..168;
const TOLERANCE: f64 = 0.01;
/// A scene with a jump, which is expensive at a smaller tolerance.
const DISCONTINUOUS: [&str; 1] = ["ball"];
const TOLERANCE_OF_DISCONTINUOUS: f64 = 0.1;
/// Scenes with an energy axis of so many bins.
const CUBES: [&str; 4] = ["separable", "mixture", "narrow-line", "ena-ring"];
const BINS: usize = 16;
const SHAPE_OF_CUBE: [usize; 2] = [32, 32];

/// A scene, and how it is rendered and compared with its exact image.
struct Scene {
    render: Box<dyn Fn() -> Option<Outcome> + Sync>,
}

/// Evaluations of one rendering, and whether it has met its tolerance.
#[derive(Clone, Copy, PartialEq)]
struct Outcome {
    evaluations: u64,
    is_met: bool,
}

/// The outcomes of all scenes.
#[derive(PartialEq)]
struct Summary {
    outcomes: Vec<Option<Outcome>>,
}

impl Summary {
    fn met(&self) -> usize {
        self.outcomes.iter().flatten().filter(|outcome| outcome.is_met).count()
    }

    /// The geometric mean, over the scenes, of the evaluations over those of a standard.
    fn ratio(&self, standard: &Self) -> f64 {
        let pairs = self.outcomes.iter().zip(&standard.outcomes);
        let logs: Vec<f64> = pairs
            .filter_map(|(one, other)| Some((one.as_ref()?, other.as_ref()?)))
            .map(|(one, other)| (one.evaluations as f64 / other.evaluations as f64).ln())
            .collect();
        (logs.iter().sum::<f64>() / logs.len() as f64).exp()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let groups: Vec<String> = std::env::args().skip(1).collect();
    let scenes = scenes()?;
    let standard = summary(&scenes);
    println!(
        "{} scenes; with the standard values {} meet their tolerance.\n",
        scenes.len(),
        standard.met()
    );
    println!("| constant | value | low | high | evaluations | tolerance met | what it is |");
    println!("| --- | --: | --: | --: | --- | --- | --- |");
    let mut without = Vec::new();
    for (number, constant) in constants().iter().enumerate() {
        let Constant { name, value, low, high, reason } = constant;
        if !groups.is_empty() && !groups.iter().any(|group| name.starts_with(group.as_str())) {
            continue;
        }
        let ends = [End::Low, End::High].map(|end| {
            select(Some((number, end)));
            let found = summary(&scenes);
            select(None);
            found
        });
        let [ratios, met] = [
            ends.each_ref().map(|end| format!("{:.3}", end.ratio(&standard))),
            ends.each_ref().map(|end| end.met().to_string()),
        ];
        println!(
            "| `{name}` | {value} | {low} | {high} | {} | {} | {reason} |",
            ratios.join(" / "),
            met.join(" / "),
        );
        if ends.iter().all(|end| *end == standard) {
            without.push(name.clone());
        }
    }
    println!("\nNo influence on these scenes: {}.", without.join(", "));
    Ok(())
}

fn summary(scenes: &[Scene]) -> Summary {
    Summary { outcomes: scenes.par_iter().map(|scene| (scene.render)()).collect() }
}

fn scenes() -> Result<Vec<Scene>, Box<dyn Error>> {
    let smooth = SCENES.map(random_scene).chain(PEAKS.map(random_peak));
    let mut scenes: Vec<Scene> = smooth
        .map(|scene| {
            let reference = scene.reference_image(SHAPE);
            in_cube(move |r| scene.rate(r), reference, TOLERANCE)
        })
        .collect();
    for name in DISCONTINUOUS {
        let problem = problem(name).ok_or("expected the name of a problem")?;
        let reference = Reference { image: problem.exact_image(SHAPE), error: problem.image_error };
        scenes.push(in_cube(move |r| problem.rate(r), reference, TOLERANCE_OF_DISCONTINUOUS));
    }
    for name in CUBES {
        scenes.push(cube(name)?);
    }
    scenes.extend(VIEWS.map(|seed| {
        let view = random_view(seed);
        let reference = view.reference();
        Scene {
            render: Box::new(move || {
                let emission = FromFn(|position, _| view.rate(position));
                let found = render(&emission, view.camera(), view.shape(), &options(TOLERANCE));
                Some(outcome(&found.ok()?, &reference, TOLERANCE))
            }),
        }
    }));
    Ok(scenes)
}

fn in_cube(
    rate: impl Fn([f64; 3]) -> f64 + Sync + 'static,
    reference: Reference,
    tolerance: f64,
) -> Scene {
    let rendered = move || {
        let emission = FromFn(|position, _| rate(position));
        let found = render(&emission, &Canonical, SHAPE, &options(tolerance));
        Some(outcome(&found.ok()?, &reference, tolerance))
    };
    Scene { render: Box::new(rendered) }
}

fn cube(name: &str) -> Result<Scene, Box<dyn Error>> {
    let problem = cubes::problem(name).ok_or("expected the name of a problem with energies")?;
    let axis = problem.default_axis(BINS)?;
    let exact = problem.exact(SHAPE_OF_CUBE, &axis);
    let rendered = move || {
        let emission =
            FromSpectralFn(|position, _: [f64; 3], energy| problem.rate(position, energy));
        let found =
            render_cube(&emission, &Canonical, SHAPE_OF_CUBE, &axis, &options(TOLERANCE)).ok()?;
        let voxels = |cube: &Cube| -> Vec<f64> {
            cube.bands().iter().flat_map(|band| band.pixels().to_vec()).collect()
        };
        let (found_voxels, exact_voxels) = (voxels(&found.values), voxels(&exact));
        let largest = exact_voxels.iter().fold(0.0, |most: f64, voxel| most.max(voxel.abs()));
        let pairs = found_voxels.iter().zip(&exact_voxels);
        let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
        let is_met = found.converged() && error <= TOLERANCE + problem.cube_error;
        Some(Outcome { evaluations: found.stats.evaluations, is_met })
    };
    Ok(Scene { render: Box::new(rendered) })
}

fn options(tolerance: f64) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(tolerance)).with_max_evaluations(1_000_000)
}

fn outcome(rendering: &Rendering, reference: &Reference, tolerance: f64) -> Outcome {
    let error = relative_error(&rendering.values, &reference.image);
    let is_met = rendering.converged() && error <= tolerance + reference.error;
    Outcome { evaluations: rendering.stats.evaluations, is_met }
}
