//! Method `vol` on bodies with sharp edges, whose images have kinks along their limbs.

use emitree::{Canonical, FromFn, RenderOptions, VolOptions, render};
use emitree_problems::relative_error;
use emitree_problems::solids::random_solids;
use rayon::prelude::*;

/// A tolerance of 5 % on twenty scenes, and the evaluations of all.
#[test]
fn tolerances_are_met_where_g_jumps() {
    let outcome = |seed| {
        let solids = random_solids(seed);
        let exact = solids.reference_image([64, 64]);
        let options = VolOptions::new(0.05);
        let options = RenderOptions::new(options);
        let emission = FromFn(|position, _| solids.rate(position));
        let rendering = render(&emission, &Canonical, [64, 64], &options).unwrap();
        let error = relative_error(&rendering.values, &exact.image);
        (rendering.converged() && error <= 0.05 + exact.error, rendering.stats.evaluations)
    };
    let outcomes: Vec<(bool, u64)> = (0..20_u64).into_par_iter().map(outcome).collect();
    let evaluations: u64 = outcomes.iter().map(|outcome| outcome.1).sum();
    assert_eq!(outcomes.iter().filter(|outcome| outcome.0).count(), 20);
    assert_eq!(evaluations, 1_762_661);
}
