//! Method `vol` on random views with opaque bodies and bounds: how often tolerances are met, and at what
//! cost. Seeds from 160 on took no part in the choice of any constant.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::{FromFn, RenderOptions, VolOptions, render};
use emitree_problems::views::{Outcome, random_view};
use rayon::prelude::*;
use std::ops::Range;

/// The view whose reference has an error of 4.6e-4, more quarterings or not: too much for 0.1 %.
const POORLY_KNOWN: u64 = 173;

/// Renders to a tolerance, and checks the evaluations of all; no more than `missed` views may be
/// beyond it.
fn check(seeds: Range<u64>, tolerance: f64, missed: usize, evaluations: u64) {
    let outcome = |seed| {
        let view = random_view(seed);
        let reference = view.reference();
        assert!(reference.error < 0.3 * tolerance, "{}: {:.1e}", view.name(), reference.error);
        let emission = FromFn(|position, _| view.rate(position));
        let options = VolOptions::new(tolerance);
        let options = RenderOptions::new(options);
        let rendering = render(&emission, view.camera(), view.shape(), &options).unwrap();
        assert!(rendering.converged(), "{}: {:?}", view.name(), rendering.stats.ending);
        let outcome = Outcome::of(&rendering, &reference);
        let allowed = 3.0 * tolerance + reference.error;
        assert!(outcome.error <= allowed, "{}: {:.1e}", view.name(), outcome.error);
        assert!(!outcome.is_negative, "{}", view.name());
        (outcome.error > tolerance + reference.error, rendering.stats.evaluations)
    };
    let known = seeds.into_par_iter().filter(|&seed| tolerance > 1e-3 || seed != POORLY_KNOWN);
    let outcomes: Vec<(bool, u64)> = known.map(outcome).collect();
    assert!(outcomes.iter().filter(|(is_missed, _)| *is_missed).count() <= missed);
    assert_eq!(outcomes.iter().map(|(_, evaluations)| evaluations).sum::<u64>(), evaluations);
}

macro_rules! tolerances_met {
    ($($name:ident: $seeds:expr, $tolerance:expr, $evaluations:expr;)*) => {$(
        #[test]
        fn $name() {
            check($seeds, $tolerance, 0, $evaluations);
        }
    )*};
}

tolerances_met! {
    a_hundredth_seeds_0: 0..12, 1e-2, 37_056;
    a_hundredth_seeds_12: 12..24, 1e-2, 108_947;
    a_hundredth_seeds_24: 24..36, 1e-2, 171_575;
    a_hundredth_seeds_160: 160..172, 1e-2, 59_156;
    a_hundredth_seeds_172: 172..184, 1e-2, 65_770;
    a_hundredth_seeds_184: 184..196, 1e-2, 129_656;
    a_thousandth_seeds_0: 0..12, 1e-3, 198_121;
    a_thousandth_seeds_12: 12..24, 1e-3, 345_239;
    a_thousandth_seeds_160: 160..172, 1e-3, 360_024;
    a_thousandth_seeds_172: 172..184, 1e-3, 213_636;
}
