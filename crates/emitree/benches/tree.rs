//! The overhead of the trees: values of eq. (8) of the paper, recorded once and replayed, so
//! that evaluations are free. Times are per cell, that is, per evaluation; allocations are printed.
//!
//! For one core: `RAYON_NUM_THREADS=1 cargo bench -p emitree --bench tree`. Instructions: docs/performance.md.

#![expect(clippy::print_stdout, reason = "a bench that reports what criterion does not")]

use core::cell::{LazyCell, OnceCell};
use core::convert::Infallible;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use emitree::quadrature::Integrand;
use emitree::refinement::Threshold;
use emitree::tree::{BuildOptions, SparseTree, build};
use emitree_problems::equation8;
use emitree_problems::recorded::{Record, Replay};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

/// Counts allocations, at the cost of some nanoseconds for each.
#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Thresholds, the cells that they make of eq. (8) on a base grid of 8³, and a bound of the relative
/// error of the image.
const TREES: [(f64, usize, f64); 4] = [
    (0.02, 11_328, 0.014),
    (0.0024, 97_856, 0.0025),
    (0.00035, 982_144, 0.0007),
    (0.000_066, 10_364_928, 0.0002),
];

/// Pixels that are no unions of cells: the most work.
const SHAPE: [usize; 2] = [75, 100];

#[expect(clippy::panic, reason = "a bench that fails must be seen")]
fn tree_of(integrand: &impl Integrand<3, Error = Infallible>, threshold: f64) -> SparseTree<3> {
    let options = BuildOptions::new(Threshold::Absolute(threshold));
    match build(integrand, [false; 3], &options) {
        Ok(built) => built.tree,
        Err(error) => panic!("{error}"),
    }
}

/// A function by itself, so that a profiler finds it.
#[inline(never)]
fn build_replayed(values: &[f64], threshold: f64) -> SparseTree<3> {
    tree_of(&Replay::new(values), threshold)
}

/// Does `work` once and prints what it allocates.
fn counted<T>(step: &str, cells: usize, work: impl FnOnce() -> T) -> T {
    let region = Region::new(ALLOCATOR);
    let result = work();
    let change = region.change();
    let (count, bytes) = (change.allocations + change.reallocations, change.bytes_allocated);
    println!("tree/{step}/{cells}: {count} allocations, {bytes} bytes altogether");
    result
}

fn trees(criterion: &mut Criterion) {
    let exact = equation8::exact_image(equation8::ALPHA, SHAPE);
    let mean = exact.pixels().iter().sum::<f64>() / exact.pixels().len() as f64;
    for (threshold, cells, largest_error) in TREES {
        // Made only if one of the benches is run.
        let recorded = LazyCell::new(|| {
            let record = Record::default();
            let tree = tree_of(&record, threshold);
            (tree, record.into_values())
        });
        let projected = LazyCell::new(|| recorded.0.project::<2>(2));

        // What is checked and counted is done once, however often criterion comes by.
        let (built, was_projected, sampled) = (OnceCell::new(), OnceCell::new(), OnceCell::new());
        let check_tree = |tree: &SparseTree<3>| {
            assert_eq!(tree.cells(), cells);
            assert!((tree.integral() / mean - 1.0).abs() < 0.01, "{} of {mean}", tree.integral());
        };
        let check_image = |image: &emitree::Image| {
            let error = emitree_problems::relative_error(image, &exact);
            assert!(error < largest_error, "threshold {threshold}: {error}");
        };

        let samples = if cells < 1_000_000 { 20 } else { 10 };
        let mut group = criterion.benchmark_group("tree");
        group.throughput(Throughput::Elements(cells as u64)).sample_size(samples);
        group.bench_function(BenchmarkId::new("build", cells), |bencher| {
            // In a thread of the pool, where one thread does all of it.
            let values = &recorded.1;
            let build = || rayon::scope(|_| build_replayed(values, threshold));
            built.get_or_init(|| check_tree(&counted("build", cells, build)));
            bencher.iter(build);
        });
        group.bench_function(BenchmarkId::new("project", cells), |bencher| {
            let project = || recorded.0.project::<2>(2);
            let integral = recorded.0.integral();
            was_projected.get_or_init(|| {
                let image = counted("project", cells, project);
                assert!((image.integral() - integral).abs() < 1e-14);
            });
            bencher.iter(project);
        });
        group.bench_function(BenchmarkId::new("sample", cells), |bencher| {
            let [height, width] = SHAPE;
            let sample = || projected.sample(height, width);
            LazyCell::force(&projected);
            sampled.get_or_init(|| check_image(&counted("sample", cells, sample)));
            bencher.iter(sample);
        });
        group.finish();
    }
}

criterion_group!(benches, trees);
criterion_main!(benches);
