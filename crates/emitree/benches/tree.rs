//! What the trees themselves cost: values of eq. (8) of the paper, recorded once and replayed, so
//! that evaluations are free. Times are per cell, that is, per evaluation.
//!
//! For one core: `RAYON_NUM_THREADS=1 cargo bench -p emitree --bench tree`.

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::hint::black_box;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use emitree::quadrature::{Integrand, Points};
use emitree::tree::{BuildOptions, build};
use emitree::{SparseTree, Threshold};
use emitree_problems::equation8;

/// Thresholds, the cells that they make of eq. (8) on a base grid of 8³, and a bound of the relative
/// error of the image.
const TREES: [(f64, usize, f64); 3] =
    [(0.02, 11_328, 0.014), (0.0024, 97_856, 0.0025), (0.00035, 982_144, 0.0007)];

/// Pixels that are no unions of cells: the most work.
const SHAPE: [usize; 2] = [75, 100];

/// Eq. (8), remembering its values in the order of their evaluation.
#[derive(Default)]
struct Record(RefCell<Vec<f64>>);

impl Integrand<3> for Record {
    type Error = Infallible;

    fn evaluate(&self, points: Points<'_, 3>, values: &mut [f64]) -> Result<(), Infallible> {
        for (i, value) in values.iter_mut().enumerate() {
            *value = equation8::rate(points.at(i), equation8::ALPHA);
        }
        self.0.borrow_mut().extend_from_slice(values);
        Ok(())
    }
}

/// The values of a record, in place of the function.
struct Replay<'a> {
    values: &'a [f64],
    used: Cell<usize>,
}

impl Integrand<3> for Replay<'_> {
    type Error = Infallible;

    fn evaluate(&self, points: Points<'_, 3>, values: &mut [f64]) -> Result<(), Infallible> {
        let used = self.used.replace(self.used.get() + values.len());
        values.copy_from_slice(&self.values[used..][..values.len()]);
        // To make the points is our work, too.
        for i in 0..points.len() {
            black_box(points.at(i));
        }
        Ok(())
    }
}

#[expect(clippy::panic, reason = "a bench that fails must be seen")]
fn tree_of(integrand: &impl Integrand<3, Error = Infallible>, threshold: f64) -> SparseTree<3> {
    let options =
        BuildOptions { threshold: Threshold::Absolute(threshold), ..BuildOptions::default() };
    match build(integrand, [false; 3], &options) {
        Ok(built) => built.tree,
        Err(error) => panic!("{error}"),
    }
}

fn trees(criterion: &mut Criterion) {
    let exact = equation8::exact_image(equation8::ALPHA, SHAPE);
    let mean = exact.pixels().iter().sum::<f64>() / exact.pixels().len() as f64;
    for (threshold, cells, largest_error) in TREES {
        let record = Record::default();
        let tree = tree_of(&record, threshold);
        let values = record.0.into_inner();
        let projected = tree.project::<2>(2);

        let check_tree = |tree: &SparseTree<3>| {
            assert_eq!(tree.cells(), cells);
            assert!((tree.integral() / mean - 1.0).abs() < 0.01, "{} of {mean}", tree.integral());
        };
        let check_image = |image: &emitree::Image| {
            let error = emitree_problems::relative_error(image, &exact);
            assert!(error < largest_error, "threshold {threshold}: {error}");
        };

        let mut group = criterion.benchmark_group("tree");
        group.throughput(Throughput::Elements(cells as u64)).sample_size(20);
        group.bench_function(BenchmarkId::new("build", cells), |bencher| {
            let replay = || Replay { values: &values, used: Cell::new(0) };
            check_tree(&tree_of(&replay(), threshold));
            bencher.iter(|| tree_of(&replay(), threshold));
        });
        group.bench_function(BenchmarkId::new("project", cells), |bencher| {
            assert!((projected.integral() - tree.integral()).abs() < 1e-14);
            bencher.iter(|| tree.project::<2>(2));
        });
        group.bench_function(BenchmarkId::new("sample", cells), |bencher| {
            let [height, width] = SHAPE;
            check_image(&projected.sample(height, width));
            bencher.iter(|| projected.sample(height, width));
        });
        group.finish();
    }
}

criterion_group!(benches, trees);
criterion_main!(benches);
