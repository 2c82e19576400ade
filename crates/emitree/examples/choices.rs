//! The choices of method `vol` compared with each other: evaluations of every one, forced, over those of the chosen one.
#![expect(clippy::print_stdout, reason = "this program prints a table")]
//!
//! `cargo run --release -p emitree --features ablate --example choices -- views 80 120 1e-2` makes each choice on the
//! random views with bodies of seeds 80 to 119, `… -- family 0 40 1e-2` on the random scenes. A choice with which
//! the tolerance is not met counts as none.

use emitree::vol::tuning::{Forced, force};
use emitree::{Canonical, FromFn, RenderOptions, VolOptions, render};
use emitree_problems::family::{RandomScene, Reference, random_scene};
use emitree_problems::views::{Outcome, RandomView, random_view};
use std::error::Error;

const SHAPE: [usize; 2] = [64, 64];
/// What the chosen one may cost, in terms of the cheapest one.
const ALLOWED: f64 = 1.3;
/// The most evaluations of a forced choice, in terms of the chosen one: it is not the cheapest one then.
const MOST: u64 = 4;

/// A scene of a family with its reference image.
struct Scene {
    of: Of,
    reference: Reference,
}

enum Of {
    View(Box<RandomView>),
    Smooth(u64, RandomScene),
}

impl Scene {
    fn new(family: &str, seed: u64) -> Self {
        if family == "views" {
            let view = random_view(seed);
            Self { reference: view.reference(), of: Of::View(Box::new(view)) }
        } else {
            let scene = random_scene(seed);
            Self { reference: scene.reference_image(SHAPE), of: Of::Smooth(seed, scene) }
        }
    }

    fn name(&self) -> String {
        match &self.of {
            Of::View(view) => view.name(),
            Of::Smooth(seed, _) => format!("family-{seed}"),
        }
    }

    /// The evaluations, if the rendering has converged within the tolerance and at most so many; `None`, too, if g is
    /// not finite, as inside bodies on the image plane.
    fn evaluations(&self, tolerance: f64, most: u64) -> Option<u64> {
        let options = RenderOptions::new(VolOptions::new(tolerance)).with_max_evaluations(most);
        let rendering = match &self.of {
            Of::View(view) => {
                let emission = FromFn(|position, _| view.rate(position));
                render(&emission, view.camera(), view.shape(), &options)
            }
            Of::Smooth(_, scene) => {
                let emission = FromFn(|position, _| scene.rate(position));
                render(&emission, &Canonical, SHAPE, &options)
            }
        };
        let rendering = rendering.ok()?;
        let error = Outcome::of(&rendering, &self.reference).error;
        let is_met = rendering.converged() && error <= tolerance + self.reference.error;
        is_met.then_some(rendering.stats.evaluations)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let [family @ ("views" | "family"), from, to, tolerance] = words.as_slice() else {
        return Err("expected: views FROM TO T | family FROM TO T".into());
    };
    let scenes = (from.parse()?..to.parse()?).map(|seed| Scene::new(family, seed));
    compare(&scenes.collect::<Vec<_>>(), tolerance.parse()?);
    Ok(())
}

fn compare(scenes: &[Scene], tolerance: f64) {
    let choices = Forced::ALL.map(|choice| format!("{choice:?}")).join(" | ");
    println!("| scene | chosen | {choices} | chosen / cheapest |");
    println!("| --- | --: |{} --: |", " --: |".repeat(Forced::ALL.len()));
    let mut ratios = Vec::new();
    for scene in scenes {
        force(None);
        let Some(chosen) = scene.evaluations(tolerance, 3_000_000) else {
            println!("| {} | not converged |", scene.name());
            continue;
        };
        let mut cheapest = chosen;
        let mut row = format!("| {} | {chosen} |", scene.name());
        for choice in Forced::ALL {
            force(Some(choice));
            let found = scene.evaluations(tolerance, MOST * chosen);
            cheapest = cheapest.min(found.unwrap_or(u64::MAX));
            row += &found.map_or(" – |".to_owned(), |found| format!(" {found} |"));
        }
        let ratio = chosen as f64 / cheapest as f64;
        println!("{row} {ratio:.2} |");
        ratios.push(ratio);
    }
    force(None);
    let above = ratios.iter().filter(|ratio| **ratio > ALLOWED).count();
    let mean = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64;
    let largest = ratios.iter().fold(1.0, |a: f64, b| a.max(*b));
    println!(
        "\n{above} of {} above {ALLOWED}, geometric mean {:.3}, largest {largest:.2}",
        ratios.len(),
        mean.exp()
    );
}
