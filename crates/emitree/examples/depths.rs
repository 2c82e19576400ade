//! Evaluations against the depth range: the last table of docs/results/engine.md.
//!
//! `cargo run --release -p emitree --example depths` renders four emissions near the origin, seen from a
//! distance of 10, to 1 %, with three depth ranges around them.
#![expect(clippy::print_stdout, reason = "this program prints a table")]

use emitree::{
    FromFn, Image, Perspective, Projection, RenderOptions, Session, Viewpoint, VolOptions,
};
use std::error::Error;

const SHAPE: [usize; 2] = [64, 64];
/// Near and far; the emission is in the first range.
const RANGES: [[f64; 2]; 3] = [[8.0, 12.0], [6.0, 14.0], [1.0, 41.0]];

/// An emission with its name.
type Named = (&'static str, fn([f64; 3]) -> f64);

const EMISSIONS: [Named; 4] = [
    ("exp(−r²/0.5)", |at| (-square(at, [0.0; 3]) / 0.5).exp()),
    ("two Gaussians of widths 0.22 and 0.32", |at| {
        (-square(at, [0.2, 0.3, 0.1]) / 0.1).exp()
            + 0.7 * (-square(at, [-0.3, -0.4, 0.2]) / 0.2).exp()
    }),
    ("(1 + 10 r²)⁻²", |at| (1.0 + 10.0 * square(at, [0.0; 3])).powi(-2)),
    ("exp(−((r − 1)/0.15)²)", |at| {
        (-((square(at, [0.0; 3]).sqrt() - 1.0) / 0.15).powi(2)).exp()
    }),
];

fn square(at: [f64; 3], centre: [f64; 3]) -> f64 {
    at.iter().zip(centre).map(|(a, b)| (a - b).powi(2)).sum()
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("| emission | depths | evaluations | at depths 8 to 12 | by |");
    println!("| --- | --- | --: | --: | --- |");
    for (name, rate) in EMISSIONS {
        for range in RANGES {
            let [evaluations, inside, products] = render(rate, range)?;
            let share = 100.0 * inside as f64 / evaluations as f64;
            let [near, far] = range;
            let way = if products == 1 { "products" } else { "image tree" };
            println!("| {name} | {near} to {far} | {evaluations} | {share:.0} % | {way} |");
        }
    }
    Ok(())
}

/// Evaluations, those at the depths of the emission, and 1 if the image is that of products.
fn render(rate: fn([f64; 3]) -> f64, range: [f64; 2]) -> Result<[usize; 3], Box<dyn Error>> {
    let viewpoint = Viewpoint { position: [10.0, 0.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let camera = Perspective::new(viewpoint, [20_f64.to_radians(); 2], range)?;
    let camera: &dyn Projection = &camera;
    let options = RenderOptions::new(VolOptions::new(0.01));
    let mut session = Session::<Image>::new(camera, SHAPE, &options)?;
    let [mut evaluations, mut inside] = [0; 2];
    while let Some(points) = session.ask() {
        let [low, high] = RANGES[0];
        let depth = |at: &[f64; 3]| square(*at, viewpoint.position).sqrt();
        let is_inside = |at: &&[f64; 3]| (low..=high).contains(&depth(at));
        evaluations += points.len();
        inside += points.positions().iter().filter(is_inside).count();
        session.step(&FromFn(|at, _| rate(at)))?;
    }
    let mesh = session.mesh()?;
    // Of products each node is one pivot; a line of sight that is integrated in full has 9 depths or more.
    let weights = mesh.weights();
    let products = (0..weights.rows()).all(|row| weights.row(row).count() <= 1);
    Ok([evaluations, inside, usize::from(products)])
}
