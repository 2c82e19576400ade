//! Tests of the choice between the low-rank approximation and the image tree.

use crate::calls::Calls;
use crate::emission::FromFn;
use crate::erased::Erased;
use crate::meter::{Limits, Meter};
use crate::options::DEFAULT_MAX_EVALUATIONS;
use crate::parallel::prelude::*;
use crate::projection::Canonical;
use crate::tile::Tile;
use crate::vol::VolOptions;
use crate::vol::choose::render;
use crate::vol::engine::{BeforeTrees, Trees};
use crate::vol::view::part::parts;
use crate::vol::view::scattered::KnownParts;
use core::f64::consts::TAU;
use core::pin::pin;
use emitree_problems::family::random_scene;

const SHAPE: [usize; 2] = [64, 64];

/// Evaluations with the choice, and of the image tree alone.
fn costs(rate: impl Fn([f64; 3]) -> f64 + Sync, tolerance: f64) -> [u64; 2] {
    let emission = FromFn(|position, _| rate(position));
    let limits = Limits {
        max_evaluations: DEFAULT_MAX_EVALUATIONS,
        max_kept: u64::MAX,
        batch_size: u64::MAX,
        whole_batches: false,
        deadline: None,
    };
    let vol = VolOptions { tolerance, ..Default::default() };
    let tiles = [Tile { projection: &Canonical, shape: SHAPE, place: (0, 1) }];
    let meters = [(); 2].map(|()| Meter::new(SHAPE, limits, None, false));
    let engine = render(&meters[0], &tiles, None, &vol);
    Calls::new(&Erased(&emission), &meters[0], None).drive(pin!(engine)).unwrap();
    let parts = parts(&tiles, None, None);
    let tree = async {
        let known = KnownParts::none(1);
        Trees::begin(&meters[1], &tiles, &parts, None, &vol, known, BeforeTrees::default())
            .await?
            .finish()
            .await
    };
    Calls::new(&Erased(&emission), &meters[1], None).drive(pin!(tree)).unwrap();
    meters.map(|meter| meter.evaluations())
}

/// The ratio of these costs on random scenes: the largest, and the geometric mean.
fn ratios(seeds: core::ops::Range<u64>, tolerance: f64) -> (f64, f64) {
    let ratio = |seed: u64| {
        let scene = random_scene(seed);
        let [engine, tree] = costs(|r| scene.rate(r), tolerance);
        engine as f64 / tree as f64
    };
    let count = seeds.end - seeds.start;
    let ratios: Vec<f64> = seeds.into_par_iter().map(ratio).collect();
    let largest = ratios.iter().copied().fold(0.0, f64::max);
    (largest, (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / count as f64).exp())
}

/// The choice needs no option and costs at most a fixed factor.
#[test]
fn the_choice_costs_little_at_one_percent() {
    let (largest, mean) = ratios(0..48, 0.01);
    assert!(largest < 1.5 && mean < 1.0, "{largest} {mean}");
}

#[test]
fn the_choice_pays_at_a_tenth_of_a_percent() {
    let (largest, mean) = ratios(0..48, 1e-3);
    assert!(largest < 1.5 && mean < 0.8, "{largest} {mean}");
}

/// Emissions that are not separable cost little more than without the search for an interpolant.
#[test]
fn what_is_not_separable_costs_little_more() {
    // The lines of the verification are scattered, so that single costs vary: sums over several
    // cases are compared.
    let normals = [[0.48, 0.6, 0.64], [0.36, 0.48, 0.8], [0.6, 0.64, 0.48], [0.64, 0.48, 0.6]];
    let sheet = |normal: [f64; 3]| {
        move |r: [f64; 3]| {
            let across: f64 = (0..3).map(|k| normal[k] * (r[k] - 0.5)).sum();
            (-(across / 0.02).powi(2)).exp()
        }
    };
    let blobs = |first: u32| -> Vec<([f64; 3], f64, f64)> {
        let blob = |k: u32| {
            let along = |step: f64| 0.1 + 0.8 * (f64::from(k) * step).fract();
            ([along(0.618), along(0.414), along(0.732)], 0.03 + 0.07 * along(0.3), along(0.9))
        };
        (first..first + 20).map(blob).collect()
    };
    let gaussians = |first: u32| {
        let blobs = blobs(first);
        move |r: [f64; 3]| -> f64 {
            let of_blob = |(at, width, height): &([f64; 3], f64, f64)| {
                let square: f64 = (0..3).map(|axis| (r[axis] - at[axis]).powi(2)).sum();
                height * (-square / (width * width)).exp()
            };
            blobs.iter().map(of_blob).sum()
        }
    };
    for tolerance in [0.1, 0.01] {
        let of_sheets: Vec<[u64; 2]> =
            normals.into_par_iter().map(|normal| costs(sheet(normal), tolerance)).collect();
        let of_blobs: Vec<[u64; 2]> = [0, 20, 40, 60, 80, 100]
            .into_par_iter()
            .map(|first| costs(gaussians(first), tolerance))
            .collect();
        let sum = |costs: Vec<[u64; 2]>| [0, 1].map(|k| costs.iter().map(|of| of[k]).sum::<u64>());
        for [engine, tree] in [sum(of_sheets), sum(of_blobs)] {
            assert!(engine as f64 <= 1.2 * tree as f64, "{tolerance}: {engine} {tree}");
        }
    }
}

#[test]
fn a_helix_costs_little_more() {
    let helix = |[x, y, z]: [f64; 3]| {
        let (sine, cosine) = (4.0 * TAU * z).sin_cos();
        let square = (x - 0.5 - 0.25 * sine).powi(2) + (y - 0.5 - 0.25 * cosine).powi(2);
        (-square / 0.0016).exp()
    };
    let [engine, tree] = costs(helix, 0.05);
    assert!(engine as f64 <= 1.2 * tree as f64, "{engine} {tree}");
}
