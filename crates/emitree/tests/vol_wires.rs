//! Method `vol` on narrow wires: how often tolerances are met, and at what cost.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::{Canonical, FromFn, RenderOptions, Rendering, VolOptions, render};
use emitree_problems::relative_error;
use emitree_problems::wires::random_wires;
use rayon::prelude::*;

const SHAPE: [usize; 2] = [160, 160];

/// Scenes of one part at one tolerance: all are within it, with `evaluations` as their geometric mean, rounded.
fn check(tolerance: f64, seeds: core::ops::Range<u64>, evaluations: &str) {
    let count = (seeds.end - seeds.start) as f64;
    let log_of = |seed| {
        let scene = random_wires(seed);
        let emission = FromFn(|position, _| scene.rate(position));
        let options = RenderOptions::new(VolOptions::new(tolerance));
        let rendering: Rendering = render(&emission, &Canonical, SHAPE, &options).unwrap();
        let error = relative_error(&rendering.values, &scene.exact_image(SHAPE));
        assert!(rendering.converged() && error <= tolerance, "wires-{seed}: {error:.1e}");
        (rendering.stats.evaluations as f64).ln()
    };
    let logs: f64 = seeds.into_par_iter().map(log_of).collect::<Vec<f64>>().iter().sum();
    assert_eq!(format!("{:.0}", (logs / count).exp()), evaluations, "evaluations");
}

#[test]
fn wires_at_one_percent() {
    check(0.01, 0..12, "36757");
}

#[test]
fn wires_at_a_tenth_of_a_percent() {
    check(1e-3, 12..15, "97952");
}
