//! The overhead of the trees of method `paper`: values of eq. (8) of the paper, recorded once and
//! replayed, so that evaluations are free.

use crate::heap::{Taken, measured};
use crate::table::{Table, number};
use core::convert::Infallible;
use core::hint::black_box;
use emitree::quadrature::Integrand;
use emitree::refinement::Threshold;
use emitree::tree::{BuildOptions, SparseTree, build};
use emitree_problems::recorded::{Record, Replay};

/// Thresholds that make about 10⁵, 10⁶ and 10⁷ cells of order 3, and how often they are built: the
/// fastest counts.
const TREES: [(f64, usize); 3] = [(0.0024, 20), (0.00035, 10), (0.000066, 4)];
/// Pixels that are no unions of cells: the most work.
const SHAPE: [usize; 2] = [75, 100];

/// What building a tree, projecting it and sampling an image took.
type Steps = [Taken; 3];

/// All on one core.
pub(crate) fn tables() -> Result<Vec<Table>, String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.map_err(|error| error.to_string())?;
    let mut rows = Vec::new();
    for (threshold, runs) in TREES {
        rows.push(pool.install(|| row(threshold, runs))?);
    }
    Ok(vec![Table {
        title: "The trees of method paper, without the emission",
        columns: vec![
            "cells",
            "build ns per cell",
            "project ns per cell",
            "sample ns per cell",
            "sum ns per cell",
            "peak bytes per cell",
            "allocations of build",
            "of project",
            "of sample",
        ],
        rows,
    }])
}

fn row(threshold: f64, runs: usize) -> Result<Vec<String>, String> {
    let record = Record::default();
    let cells = tree_of(&record, threshold)?.cells();
    let values = record.into_values();
    let mut best = steps(&values, threshold)?;
    for _ in 1..runs {
        for (best, taken) in best.iter_mut().zip(steps(&values, threshold)?) {
            best.time = best.time.min(taken.time);
        }
    }
    let ns_per_cell = best.map(|taken| taken.time.as_secs_f64() * 1e9 / cells as f64);
    let mut row = vec![cells.to_string()];
    row.extend(ns_per_cell.map(number));
    row.push(number(ns_per_cell.iter().sum()));
    row.push(number(best[0].peak_bytes as f64 / cells as f64));
    row.extend(best.map(|taken| taken.allocations.to_string()));
    Ok(row)
}

fn steps(values: &[f64], threshold: f64) -> Result<Steps, String> {
    let replay = Replay::new(values);
    let (tree, built) = measured(|| tree_of(&replay, threshold));
    let tree = tree?;
    let (image_tree, projected) = measured(|| tree.project::<2>(2));
    let [height, width] = SHAPE;
    let (image, sampled) = measured(|| image_tree.sample(height, width));
    black_box(image);
    Ok([built, projected, sampled])
}

fn tree_of(
    integrand: &impl Integrand<3, Error = Infallible>,
    threshold: f64,
) -> Result<SparseTree<3>, String> {
    let threshold = Threshold::Absolute(threshold);
    let options = BuildOptions::new(threshold);
    let built = build(integrand, [false; 3], &options).map_err(|error| error.to_string())?;
    Ok(built.tree)
}
