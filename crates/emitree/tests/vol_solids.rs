//! Method `vol` on bodies with sharp edges, whose images have kinks along their limbs.

use emitree::{Canonical, FromFn, RenderOptions, VolOptions, render};
use emitree_problems::relative_error;
use emitree_problems::solids::random_solids;
use rayon::prelude::*;
use std::ops::Range;

/// A tolerance of 5 % on some scenes, and the evaluations of all.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn check(seeds: Range<u64>, evaluations: u64) {
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
    let outcomes: Vec<(bool, u64)> = seeds.into_par_iter().map(outcome).collect();
    let found: u64 = outcomes.iter().map(|outcome| outcome.1).sum();
    assert!(outcomes.iter().all(|outcome| outcome.0), "{outcomes:?}");
    assert_eq!(found, evaluations);
}

macro_rules! tolerances_met {
    ($($name:ident: $seeds:expr, $evaluations:literal;)*) => {$(
        #[test]
        fn $name() {
            check($seeds, $evaluations);
        }
    )*};
}

tolerances_met! {
    five_percent_seeds_0: 0..5, 144_643;
    five_percent_seeds_5: 5..10, 110_369;
    five_percent_seeds_10: 10..15, 81_099;
    five_percent_seeds_15: 15..20, 324_260;
}
