//! What a session that is continued to a tighter tolerance has evaluated for the looser one alone.
//!
//! `cargo run --release -p emitree --example resumed` prints the table of docs/log.md, Sessions: random
//! scenes at 1 % and at 0.1 %, and the points of the first that the second does not use.
#![expect(clippy::print_stdout, reason = "this program prints a table")]

use emitree::{Canonical, FromFn, Image, Projection, RenderOptions, Session, VolOptions};
use emitree_problems::family::random_scene;
use std::collections::HashSet;
use std::error::Error;

const SHAPE: [usize; 2] = [32, 32];
const SEEDS: [u64; 12] = [0, 1, 2, 3, 4, 5, 240, 241, 242, 243, 244, 245];

/// The bits of a position.
type Point = [u64; 3];

fn main() -> Result<(), Box<dyn Error>> {
    println!("| scene | 1 % | 0.1 % | both | depths of common lines | lines | scattered |");
    println!("| --- | --: | --: | --: | --: | --: | --: |");
    let mut sums = [0; 6];
    for seed in SEEDS {
        let [coarse, fine] = [points(seed, 0.01)?, points(seed, 1e-3)?];
        let lines: HashSet<[u64; 2]> = fine.iter().map(line).collect();
        let [mut of_common, mut of_others, mut scattered] = [0; 3];
        for point in coarse.difference(&fine) {
            let number = match () {
                () if lines.contains(&line(point)) => &mut of_common,
                () if is_dyadic(point) => &mut of_others,
                () => &mut scattered,
            };
            *number += 1;
        }
        let both = coarse.union(&fine).count();
        let row = [coarse.len(), fine.len(), both, of_common, of_others, scattered];
        print_row(&random_scene(seed).name(), row);
        sums.iter_mut().zip(row).for_each(|(sum, number)| *sum += number);
    }
    print_row("all", sums);
    Ok(())
}

fn print_row(name: &str, row: [usize; 6]) {
    let cells = row.map(|number| number.to_string()).join(" | ");
    println!("| {name} | {cells} |");
}

/// All points of a rendering.
fn points(seed: u64, tolerance: f64) -> Result<HashSet<Point>, Box<dyn Error>> {
    let scene = random_scene(seed);
    let camera: &dyn Projection = &Canonical;
    let options = RenderOptions::new(VolOptions::new(tolerance));
    let mut session = Session::<Image>::new(camera, SHAPE, &options)?;
    let mut points = HashSet::new();
    while let Some(asked) = session.ask() {
        points.extend(asked.positions().iter().map(|at| at.map(f64::to_bits)));
        session.step(&FromFn(|at, _| scene.rate(at)))?;
    }
    Ok(points)
}

/// The line of sight of a point.
fn line([x, y, _]: &Point) -> [u64; 2] {
    [*x, *y]
}

/// Whether it is on a line of sight of an image tree: those of fibers and of probes have other places.
fn is_dyadic(point: &Point) -> bool {
    let steps = |bits: u64| f64::from_bits(bits) * f64::from(1_u32 << 24);
    line(point).iter().all(|bits| steps(*bits).fract() == 0.0)
}
