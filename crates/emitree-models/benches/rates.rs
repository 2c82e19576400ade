//! Evaluating g on batches: nanoseconds a point, on one core, of eq. (8) of the paper as a scene writes it, as a
//! closure and as a model, of other models with their defaults, and of data on grids.
//!
//! `cargo bench -p emitree-models --bench rates`.

use core::hint::black_box;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use emitree::los::{LosOptions, Steps};
use emitree::{Canonical, Emission, FromFn, RenderOptions, Samples, render};
use emitree_models::grid::{Coordinates, GridAxes, logarithmic_nodes, uniform_nodes};
use emitree_models::{Expression, Grid, Interpolation, Model, build_model};
use std::collections::BTreeMap;

/// Points of one call, as `emitree` makes them.
const POINTS: usize = 2048;

/// Pixels along each side of an image, and steps along the line of each.
const PIXELS: usize = 1024;
const LINE_STEPS: usize = 13;

const EQUATION_8: &str = "(sin(5*x)*sin(7*y)*sin(11*z)/10)^2 + exp(-a*(x-sqrt(2)/3)^2/sqrt(2) \
                          - a*(y-sqrt(7)/5)^2*sqrt(2) - a*(z-sqrt(6)/5)^2*sqrt(3))";

/// Models, and half the width of the cube about their centre in which they are evaluated.
const MODELS: [(&str, f64); 14] = [
    ("holmstrom", 0.5),
    ("power_law", 1.0),
    ("beta_model", 500.0),
    ("k_corona", 5.0),
    ("geocorona", 4.0),
    ("mars_hydrogen", 8e6),
    ("mars_oxygen", 8e6),
    ("airglow", 6.6e3),
    ("shell_nebula", 1.0),
    ("cmem", 15.0),
    ("jorgensen", 15.0),
    ("ena", 8e6),
    ("bremsstrahlung", 500.0),
    ("ena_ring", 8.0),
];

/// Eq. (8) with the functions of the standard library.
fn equation_8([x, y, z]: [f64; 3], _direction: [f64; 3]) -> f64 {
    let waves = (5.0 * x).sin() * (7.0 * y).sin() * (11.0 * z).sin() / 10.0;
    let (x, y, z) = (x - 2.0_f64.sqrt() / 3.0, y - 7.0_f64.sqrt() / 5.0, z - 6.0_f64.sqrt() / 5.0);
    let sum = x * x / 2.0_f64.sqrt() + y * y * 2.0_f64.sqrt() + z * z * 3.0_f64.sqrt();
    waves * waves + (-100.0 * sum).exp()
}

/// Points of (−1, 1)³ that fill it evenly.
fn points() -> Vec<[f64; 3]> {
    let steps = [2.0_f64.sqrt(), 3.0_f64.sqrt(), 5.0_f64.sqrt()];
    (0..POINTS).map(|i| steps.map(|step| 2.0 * (i as f64 * step).fract() - 1.0)).collect()
}

#[expect(clippy::panic, reason = "a bench that fails must be seen")]
fn model(name: &str) -> Model {
    match build_model(name, &BTreeMap::new()) {
        Ok(model) => model,
        Err(error) => panic!("{error}"),
    }
}

#[expect(clippy::panic, reason = "a bench that fails must be seen")]
fn expression() -> Expression {
    match Expression::parse(EQUATION_8, &BTreeMap::from([("a".to_owned(), 100.0)])) {
        Ok(expression) => expression,
        Err(error) => panic!("{error}"),
    }
}

fn rates(criterion: &mut Criterion) {
    let unit = points();
    let directions = vec![[-0.6, 0.0, -0.8]; POINTS];
    let energies = vec![1.0; POINTS];
    let mut group = criterion.benchmark_group("rates");
    group.throughput(Throughput::Elements(POINTS as u64)).sample_size(20);
    let mut bench = |name: &str,
                     emission: &dyn Emission<Error = core::convert::Infallible>,
                     half_width: f64| {
        let positions: Vec<_> = unit.iter().map(|u| u.map(|u| u * half_width)).collect();
        let samples = Samples::new(&positions, &directions).at_energies(&energies);
        let mut rates = vec![0.0; POINTS];
        group.bench_function(name, |bencher| {
            bencher.iter(|| emission.emission_rates(black_box(&samples), &mut rates));
            assert!(rates.iter().any(|rate| *rate > 0.0), "{name} is dark");
        });
    };
    bench("equation_8 closure", &FromFn(equation_8), 1.0);
    bench("equation_8 expression", &expression(), 1.0);
    for (name, half_width) in MODELS {
        bench(name, &model(name), half_width);
    }
    group.finish();
}

/// What the line-of-sight method adds to its evaluations: nanoseconds an evaluation, g's included.
fn lines(criterion: &mut Criterion) {
    let los = LosOptions::new(1, Steps::Fixed(LINE_STEPS));
    let options = RenderOptions::new(los);
    let evaluations = PIXELS * PIXELS * LINE_STEPS;
    let mut group = criterion.benchmark_group("lines");
    group.throughput(Throughput::Elements(evaluations as u64)).sample_size(10);
    let glow = expression();
    group.bench_function("equation_8 expression", |bencher| {
        bencher.iter(|| {
            let rendering = render(&glow, &Canonical, [PIXELS, PIXELS], &options);
            assert!(
                rendering.is_ok_and(|rendering| rendering.stats.evaluations == evaluations as u64)
            );
        });
    });
    group.finish();
}

/// A grid of smooth positive values.
#[expect(clippy::panic, reason = "a bench that fails must be seen")]
fn grid(coordinates: Coordinates, nodes: [Vec<f64>; 3], logarithmic: bool) -> Grid {
    let count: usize = nodes.iter().map(Vec::len).product();
    let values = (0..count).map(|i| 2.0 + (i as f64).sin()).collect();
    let made = GridAxes::new(coordinates, nodes)
        .and_then(|axes| if logarithmic { axes.with_logarithmic(0) } else { Ok(axes) })
        .and_then(|axes| Grid::on(axes, values));
    made.unwrap_or_else(|error| panic!("{error}"))
}

/// Data on grids, at the points of (−1, 1)³ that are within them.
fn grids(criterion: &mut Criterion) {
    let turn = core::f64::consts::TAU;
    let sphere = |r: Vec<f64>| {
        [r, uniform_nodes(0.0, 0.5 * turn, 40), uniform_nodes(0.0, turn * 79.0 / 80.0, 80)]
    };
    let cube = || [0, 1, 2].map(|_| uniform_nodes(-1.0, 1.0, 60));
    let uneven = || cube().map(|nodes| nodes.iter().map(|u| u * u * u + 0.2 * u).collect());
    let drum = [uniform_nodes(0.0, 1.5, 60), sphere(Vec::new())[2].clone(), cube()[2].clone()];
    let ratios = || logarithmic_nodes(0.01, 2.0, 60);
    let cases = [
        ("grid cartesian", grid(Coordinates::Cartesian, cube(), false)),
        ("grid cartesian uneven", grid(Coordinates::Cartesian, uneven(), false)),
        ("grid cylindrical", grid(Coordinates::Cylindrical, drum, false)),
        ("grid spherical", grid(Coordinates::Spherical, sphere(ratios()), false)),
        ("grid spherical ln r", grid(Coordinates::Spherical, sphere(ratios()), true)),
    ];
    let (positions, directions) = (points(), vec![[0.0, 0.0, 1.0]; POINTS]);
    let samples = Samples::new(&positions, &directions);
    let mut group = criterion.benchmark_group("grids");
    group.throughput(Throughput::Elements(POINTS as u64)).sample_size(20);
    for (name, grid) in cases {
        for interpolation in [
            Interpolation::Nearest,
            Interpolation::Linear,
            Interpolation::MonotoneCubic,
            Interpolation::Cubic,
        ] {
            let grid = grid.clone().with_interpolation(interpolation);
            let mut rates = vec![0.0; POINTS];
            group.bench_function(format!("{name} {interpolation:?}"), |bencher| {
                bencher.iter(|| grid.emission_rates(black_box(&samples), &mut rates));
                assert!(rates.iter().all(|rate| *rate > 0.0), "{name} is dark");
            });
        }
    }
    group.finish();
}

criterion_group!(benches, rates, grids, lines);
criterion_main!(benches);
