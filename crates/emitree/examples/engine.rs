//! Evaluations against error: the tables of docs/results/engine.md.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
//!
//! `cargo run --release -p emitree --example engine -- named 1e-2,1e-3` renders the named problems
//! with method `vol`, `… -- family 0 240 1e-2` the random scenes of seeds 0 to 239,
//! `… -- peaks 0 40 1e-2` anisotropic peaks, `… -- solids 0 120 1e-2` sums of random solids with sharp
//! surfaces, `… -- surfaces 1e-2,1e-3` two balls, a bent tube and a bar, `… -- shapes 0 80 1e-2` random boxes, ellipsoids, cylinders, unions and shells,
//! `… -- planets 0 80 1e-2` these around an opaque planet, in orthographic and perspective views,
//! `… -- divided 0 48 1e-2` Gaussians divided by declared planes,
//! `… -- wires 0 96 1e-2` narrow wires wound about random axes,
//! `… -- smile 0 40 1e-2` the magnetosheath from random viewpoints,
//! `… -- deep 0 40 10 1e-2` Gaussians in a depth range ten times as long as needed,
//! `… -- views 0 160 1e-2` random views with opaque bodies, `… -- rooms 0 60 1e-2` views of boxes with
//! emission up to their faces, `… -- monotone 0 60` and
//! `… -- monotone 0 40 peaks` search for tolerances that cost more than tighter ones, and
//! `… -- paper 0 72 1e-2` searches for the cheapest threshold of method `paper` for each random scene.
//! Images have 64 × 64 pixels, those of wires 160 × 160, those of views as many as the view has.

use emitree::progress::Frame;
use emitree::projection::GeometryError;
use emitree::refinement::Threshold;
use emitree::tree::BuildOptions;
use emitree::{Canonical, FromFn, Image, Projection, RenderOptions, Rendering, VolOptions, render};
use emitree_problems::catalogue::{Problem, problem, problems, surface_problems};
use emitree_problems::deep::random_deep;
use emitree_problems::divided::random_divided;
use emitree_problems::family::{RandomScene, Reference, random_peak, random_scene};
use emitree_problems::planets::random_planet;
use emitree_problems::relative_error;
use emitree_problems::shapes::random_shape;
use emitree_problems::smile::random_smile;
use emitree_problems::solids::random_solids;
use emitree_problems::views::{Outcome, RandomView, random_room, random_view};
use emitree_problems::wires::random_wires;
use std::error::Error;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

const SHAPE: [usize; 2] = [64, 64];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["named", tolerances] => named(problems(), &numbers(tolerances)?, ""),
        ["named", tolerances, name] => named(problems(), &numbers(tolerances)?, name),
        ["surfaces", tolerances] => named(surface_problems(), &numbers(tolerances)?, ""),
        ["family", from, to, tolerances] => {
            let scenes = (from.parse()?..to.parse()?).map(|seed| smooth_scene(random_scene(seed)));
            many(scenes.collect(), &numbers(tolerances)?)
        }
        ["peaks", from, to, tolerances] => {
            let scenes = (from.parse()?..to.parse()?).map(|seed| smooth_scene(random_peak(seed)));
            many(scenes.collect(), &numbers(tolerances)?)
        }
        ["solids", from, to, tolerances] => {
            let scenes = (from.parse()?..to.parse()?).map(solid_scene).collect();
            many(scenes, &numbers(tolerances)?)
        }
        ["shapes", from, to, tolerances] => {
            let scenes = (from.parse()?..to.parse()?).map(shape_scene).collect();
            many(scenes, &numbers(tolerances)?)
        }
        ["planets", from, to, tolerances] => {
            let scenes = (from.parse()?..to.parse()?).map(planet_scene).collect();
            many(scenes, &numbers(tolerances)?)
        }
        ["divided", from, to, tolerances] => {
            let scenes: Result<Vec<Scene>, _> =
                (from.parse()?..to.parse()?).map(divided_scene).collect();
            many(scenes?, &numbers(tolerances)?)
        }
        ["wires", from, to, tolerances] => {
            let scenes = (from.parse()?..to.parse()?).map(wires_scene).collect();
            many(scenes, &numbers(tolerances)?)
        }
        ["smile", from, to, tolerances] => {
            let scenes = (from.parse()?..to.parse()?).map(smile_scene).collect();
            many(scenes, &numbers(tolerances)?)
        }
        ["deep", from, to, factor, tolerances] => {
            let factor: f64 = factor.parse()?;
            let scenes = (from.parse()?..to.parse()?).map(|seed| deep_scene(seed, factor));
            many(scenes.collect(), &numbers(tolerances)?)
        }
        ["views", from, to, tolerances] => {
            views((from.parse()?..to.parse()?).map(random_view).collect(), &numbers(tolerances)?)
        }
        ["rooms", from, to, tolerances] => {
            views((from.parse()?..to.parse()?).map(random_room).collect(), &numbers(tolerances)?)
        }
        ["monotone", from, to] => monotone((from.parse()?..to.parse()?).map(random_scene)),
        ["monotone", from, to, "peaks"] => monotone((from.parse()?..to.parse()?).map(random_peak)),
        ["paper", tolerances] => paper_named(&numbers(tolerances)?),
        ["paper", from, to, tolerances] => paper(from.parse()?, to.parse()?, &numbers(tolerances)?),
        ["trace", name, tolerance] => trace(name, tolerance.parse()?),
        _ => Err("expected: named T,… [NAME] | surfaces T,… | family FROM TO T,… | peaks FROM TO T,… | \
                  solids FROM TO T,… | shapes FROM TO T,… | planets FROM TO T,… | divided FROM TO T,… | \
                  wires FROM TO T,… | smile FROM TO T,… | deep FROM TO FACTOR T,… | views FROM TO T,… | rooms FROM TO T,… | \
                  monotone FROM TO [peaks] | paper [FROM TO] T,… | trace NAME T"
            .into()),
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, Box<dyn Error>> {
    Ok(text.split(',').map(str::parse).collect::<Result<_, _>>()?)
}

fn vol(
    rate: impl Fn([f64; 3]) -> f64 + Sync,
    camera: &dyn Projection,
    shape: [usize; 2],
    tolerance: f64,
) -> Result<Rendering, Box<dyn Error>> {
    let emission = FromFn(|position, _| rate(position));
    let options = VolOptions::new(tolerance);
    let options = RenderOptions::new(options).with_max_evaluations(3_000_000);
    Ok(render(&emission, camera, shape, &options)?)
}

/// The share of the pixels that are within their own estimate, and `slack` of the largest pixel.
fn inside(rendering: &Rendering, exact: &Image, slack: f64) -> f64 {
    let largest = exact.pixels().iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    let Some(error) = &rendering.error else { return 0.0 };
    let pairs = rendering.values.pixels().iter().zip(exact.pixels()).zip(error.pixels());
    let within =
        pairs.filter(|((found, exact), error)| (*found - *exact).abs() <= *error + slack * largest);
    within.count() as f64 / exact.pixels().len() as f64
}

fn named(problems: Vec<Problem>, tolerances: &[f64], only: &str) -> Result<(), Box<dyn Error>> {
    println!(
        "| scene | tolerance | evaluations | batches | true error | estimate | inside | seconds |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    for problem in problems.iter().filter(|p| p.name.starts_with(only)) {
        let exact = problem.exact_image(SHAPE);
        for &tolerance in tolerances {
            let start = Instant::now();
            let rendering = vol(|r| problem.rate(r), &Canonical, SHAPE, tolerance)?;
            println!(
                "| {} | {tolerance:.0e} | {} | {} | {:.1e} | {:.1e}{} | {:.4} | {:.2} |",
                problem.name,
                rendering.stats.evaluations,
                rendering.stats.batches,
                relative_error(&rendering.values, &exact),
                rendering.estimated_error().unwrap_or(f64::NAN),
                if rendering.converged() { "" } else { " (not converged)" },
                inside(&rendering, &exact, problem.image_error),
                start.elapsed().as_secs_f64(),
            );
        }
    }
    Ok(())
}

/// The cost and the gain of each round.
fn trace(name: &str, tolerance: f64) -> Result<(), Box<dyn Error>> {
    let problem = problem(name).ok_or("expected the name of a problem, such as shell")?;
    let exact = problem.exact_image(SHAPE);
    println!("| evaluations | batches | true error | estimate |");
    println!("| --- | --- | --- | --- |");
    let largest = |image: &Image| image.pixels().iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    let frame = |frame: &Frame<'_>| {
        println!(
            "| {} | {} | {:.1e} | {:.1e} |",
            frame.evaluations,
            frame.batches,
            relative_error(frame.image, &exact),
            largest(frame.error) / largest(frame.image),
        );
        ControlFlow::Continue(())
    };
    let emission = FromFn(|position, _| problem.rate(position));
    let options = VolOptions::new(tolerance);
    let options = RenderOptions::new(options).with_frame(&frame);
    render(&emission, &Canonical, SHAPE, &options)?;
    Ok(())
}

/// A scene of a family by number, and its exact image.
struct Scene {
    name: String,
    rate: Box<dyn Fn([f64; 3]) -> f64 + Sync>,
    camera: Arc<dyn Projection + Send>,
    reference: Reference,
}

fn smooth_scene(scene: RandomScene) -> Scene {
    let (name, reference) = (scene.name(), scene.reference_image(SHAPE));
    Scene { name, rate: Box::new(move |r| scene.rate(r)), camera: Arc::new(Canonical), reference }
}

fn solid_scene(seed: u64) -> Scene {
    let solids = random_solids(seed);
    let reference = solids.reference_image(SHAPE);
    let rate = Box::new(move |r| solids.rate(r));
    Scene { name: format!("solids-{seed}"), rate, camera: Arc::new(Canonical), reference }
}

fn shape_scene(seed: u64) -> Scene {
    let shape = random_shape(seed);
    let (name, reference) = (format!("{}-{seed}", shape.kind()), shape.reference_image(SHAPE));
    let rate = Box::new(move |r| shape.rate(r));
    Scene { name, rate, camera: Arc::new(Canonical), reference }
}

fn planet_scene(seed: u64) -> Scene {
    let scene = random_planet(seed);
    let (name, reference) = (scene.name(), scene.reference_image(SHAPE));
    let camera = scene.camera();
    Scene { name, rate: Box::new(move |r| scene.rate(r)), camera, reference }
}

fn divided_scene(seed: u64) -> Result<Scene, GeometryError> {
    let scene = random_divided(seed);
    let (name, reference) = (scene.name(), scene.reference_image([64; 2]));
    let camera = scene.camera()?;
    Ok(Scene { name, rate: Box::new(move |r| scene.rate(r)), camera, reference })
}

fn wires_scene(seed: u64) -> Scene {
    let scene = random_wires(seed);
    let reference = Reference { image: scene.exact_image([160; 2]), error: 0.0 };
    Scene {
        name: format!("wires-{seed}"),
        rate: Box::new(move |r| scene.rate(r)),
        camera: Arc::new(Canonical),
        reference,
    }
}

fn smile_scene(seed: u64) -> Scene {
    let scene = random_smile(seed);
    let (name, reference) = (scene.name(), scene.reference_image([32; 2]));
    let camera = scene.camera();
    Scene { name, rate: Box::new(move |r| scene.rate(r)), camera, reference }
}

fn deep_scene(seed: u64, factor: f64) -> Scene {
    let scene = random_deep(seed, factor);
    let reference = Reference { image: scene.exact_image(SHAPE), error: 0.0 };
    let camera = Arc::new(Canonical);
    Scene {
        name: format!("deep-{seed}"),
        rate: Box::new(move |r| scene.rate(r)),
        camera,
        reference,
    }
}

/// How often a tolerance is met, and at what cost.
fn many(scenes: Vec<Scene>, tolerances: &[f64]) -> Result<(), Box<dyn Error>> {
    for &tolerance in tolerances {
        let (mut kept, mut logs, mut ratios, mut insides) = (0, 0.0, Vec::new(), 0.0);
        for Scene { name, rate, camera, reference } in &scenes {
            let (exact, slack) = (&reference.image, reference.error);
            let shape = [exact.height(), exact.width()];
            let rendering = vol(rate, &**camera, shape, tolerance)?;
            let error = relative_error(&rendering.values, exact);
            let estimate = rendering.estimated_error().unwrap_or(f64::NAN);
            let is_kept = error <= tolerance + slack && rendering.converged();
            kept += usize::from(is_kept);
            logs += (rendering.stats.evaluations as f64).ln();
            ratios.push(estimate / error.max(1e-15));
            insides += inside(&rendering, exact, slack);
            if !is_kept {
                println!(
                    "{name}: {} evaluations, true {error:.1e}, estimate {estimate:.1e}, converged {}",
                    rendering.stats.evaluations,
                    rendering.converged()
                );
            }
        }
        let count = scenes.len();
        ratios.sort_by(f64::total_cmp);
        println!(
            "{tolerance:.0e}: {kept} of {count} kept, {:.0} evaluations (geometric mean), estimate \
             over true {:.1} (median; {:.1} to {:.1}), inside {:.4}",
            (logs / count as f64).exp(),
            ratios[count / 2],
            ratios[count / 10],
            ratios[count * 9 / 10],
            insides / count as f64,
        );
    }
    Ok(())
}

/// How often a tolerance is met in views with bodies, and at what cost.
fn views(views: Vec<RandomView>, tolerances: &[f64]) -> Result<(), Box<dyn Error>> {
    let references: Vec<Reference> = views.iter().map(RandomView::reference).collect();
    let worst = references.iter().map(|reference| reference.error).fold(0.0, f64::max);
    println!("references: largest error {worst:.1e}");
    for (view, reference) in views.iter().zip(&references).filter(|(_, of)| of.error > 1e-4) {
        println!("{}: reference error {:.1e}", view.name(), reference.error);
    }
    for &tolerance in tolerances {
        let (mut kept, mut ended, mut broken, mut negative, mut logs) = (0, 0, 0, 0, 0.0);
        for (view, reference) in views.iter().zip(&references) {
            let emission = FromFn(|position, _| view.rate(position));
            let vol = VolOptions::new(tolerance);
            let options = RenderOptions::new(vol).with_max_evaluations(3_000_000);
            let rendering = render(&emission, view.camera(), view.shape(), &options)?;
            let outcome = Outcome::of(&rendering, reference);
            let converged = rendering.converged();
            let is_within = outcome.error <= tolerance + reference.error;
            let is_broken = converged && outcome.error > 3.0 * tolerance + reference.error;
            kept += usize::from(converged && is_within);
            ended += usize::from(converged);
            broken += usize::from(is_broken);
            negative += usize::from(outcome.is_negative);
            logs += (rendering.stats.evaluations as f64).ln();
            if !(converged && is_within) || outcome.is_negative {
                println!(
                    "{}: {} evaluations, true {:.1e} at {:?}, estimate {:.1e}, converged {converged}{}{}",
                    view.name(),
                    rendering.stats.evaluations,
                    outcome.error,
                    outcome.worst,
                    rendering.estimated_error().unwrap_or(f64::NAN),
                    if is_broken { ", BROKEN" } else { "" },
                    if outcome.is_negative { ", NEGATIVE" } else { "" },
                );
            }
        }
        let count = views.len();
        println!(
            "{tolerance:.0e}: {kept} of {count} kept, {ended} converged, {broken} of them beyond three \
             times the tolerance, {negative} with a pixel below minus its estimate, {:.0} evaluations \
             (geometric mean)",
            (logs / count as f64).exp(),
        );
    }
    Ok(())
}

/// The tolerances of [`monotone`].
const LADDER: [f64; 12] = [0.1, 0.05, 0.03, 0.02, 0.01, 5e-3, 3e-3, 2e-3, 1e-3, 5e-4, 3e-4, 1e-4];
/// What a looser tolerance may cost, in terms of a tighter one.
const MONOTONE: f64 = 1.15;

/// Evaluations of each scene at each tolerance of a ladder, where a looser one costs more than a tighter
/// one, and by how much at the most.
fn monotone(scenes: impl Iterator<Item = RandomScene>) -> Result<(), Box<dyn Error>> {
    println!("| scene | {} | worst |", LADDER.map(|t| format!("{t:.0e}")).join(" | "));
    println!("| --- |{}", " --- |".repeat(LADDER.len() + 1));
    let (mut count, mut violations, mut logs) = (0, 0, [0.0; LADDER.len()]);
    for scene in scenes {
        let mut costs = [0.0; LADDER.len()];
        for (cost, tolerance) in costs.iter_mut().zip(LADDER) {
            *cost = vol(|r| scene.rate(r), &Canonical, SHAPE, tolerance)?.stats.evaluations as f64;
        }
        let cheapest_from = |k: usize| costs[k..].iter().copied().fold(f64::INFINITY, f64::min);
        let worst = (0..costs.len()).map(|k| costs[k] / cheapest_from(k)).fold(0.0, f64::max);
        count += 1;
        logs.iter_mut().zip(&costs).for_each(|(log, cost)| *log += cost.ln());
        if worst > MONOTONE {
            violations += 1;
            let costs = costs.map(|cost| cost.to_string()).join(" | ");
            println!("| {} | {costs} | {worst:.2} |", scene.name());
        }
    }
    let means = logs.map(|log| format!("{:.0}", (log / f64::from(count)).exp())).join(" | ");
    println!("| geometric mean | {means} | |");
    println!("{violations} of {count} scenes cost more than {MONOTONE} times a tighter tolerance");
    Ok(())
}

/// The evaluations of the coarsest threshold that reaches each tolerance, and of the finest tried.
type Cheapest = (Vec<Option<u64>>, u64);

/// Method `paper` on one scene, base 8³, with thresholds from a ladder.
fn cheapest(
    rate: impl Fn([f64; 3]) -> f64 + Sync,
    exact: &Image,
    tolerances: &[f64],
) -> Result<Cheapest, Box<dyn Error>> {
    let emission = FromFn(|position, _| rate(position));
    let mut cheapest: Vec<Option<u64>> = vec![None; tolerances.len()];
    let (mut threshold, mut most) = (0.3, 0);
    while cheapest.contains(&None) && most < 1_000_000 && threshold > 1e-7 {
        let build = BuildOptions::new(Threshold::Relative(threshold)).with_finest_level(7);
        let options = RenderOptions::new(build);
        let rendering = render(&emission, &Canonical, SHAPE, &options)?;
        let error = relative_error(&rendering.values, exact);
        most = rendering.stats.evaluations;
        for (cheapest, &tolerance) in cheapest.iter_mut().zip(tolerances) {
            if error <= tolerance && cheapest.is_none() {
                *cheapest = Some(most);
            }
        }
        threshold *= 0.6;
    }
    Ok((cheapest, most))
}

/// Method `paper` on the named problems.
fn paper_named(tolerances: &[f64]) -> Result<(), Box<dyn Error>> {
    for problem in problems() {
        let (found, most) = cheapest(|r| problem.rate(r), &problem.exact_image(SHAPE), tolerances)?;
        println!("{}: {found:?} for {tolerances:?}, {most} at the most", problem.name);
    }
    Ok(())
}

/// Method `paper` on the random scenes: geometric means.
fn paper(from: u64, to: u64, tolerances: &[f64]) -> Result<(), Box<dyn Error>> {
    let mut sums = vec![(0.0, 0); tolerances.len()];
    for seed in from..to {
        let Scene { rate, reference, .. } = smooth_scene(random_scene(seed));
        let (found, most) = cheapest(rate, &reference.image, tolerances)?;
        for ((logs, never), found) in sums.iter_mut().zip(found) {
            *logs += (found.unwrap_or(most) as f64).ln();
            *never += usize::from(found.is_none());
        }
    }
    for (tolerance, (logs, never)) in tolerances.iter().zip(sums) {
        println!(
            "{tolerance:.0e}: {:.0} evaluations (geometric mean of {}; {never} never reached it and \
             count with their largest tree)",
            (logs / (to - from) as f64).exp(),
            to - from,
        );
    }
    Ok(())
}
