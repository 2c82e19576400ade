//! Method `vol` on depth ranges ten times as long as the emission needs.

use emitree::{Canonical, FromFn, RenderOptions, VolOptions, render};
use emitree_problems::deep::random_deep;
use emitree_problems::relative_error;

const TOLERANCE: f64 = 0.01;
const SHAPE: [usize; 2] = [64, 64];

/// The evaluations of a scene in a depth range `factor` times as long as the emission.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn evaluations(seed: u64, factor: f64) -> u64 {
    let scene = random_deep(seed, factor);
    let emission = FromFn(|position, _| scene.rate(position));
    let options = RenderOptions::new(VolOptions::new(TOLERANCE));
    let rendering = render(&emission, &Canonical, SHAPE, &options).unwrap();
    let error = relative_error(&rendering.values, &scene.exact_image(SHAPE));
    assert!(rendering.converged() && error <= TOLERANCE, "{seed}: {error}");
    rendering.stats.evaluations
}

#[test]
fn a_long_depth_range_costs_a_few_times_what_a_short_one_costs() {
    let total = |factor: f64| (0..12).map(|seed| evaluations(seed, factor)).sum::<u64>();
    assert_eq!([1.0, 10.0].map(total), [23_827, 91_095]);
}
