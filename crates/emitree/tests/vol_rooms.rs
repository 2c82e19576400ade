//! Method `vol` on random boxes with emission up to their faces, seen by cameras of all kinds: tolerances are
//! met, at what cost. Seeds from 60 on took no part in the choice of any constant.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::{FromFn, RenderOptions, VolOptions, render};
use emitree_problems::views::{Outcome, random_room};
use rayon::prelude::*;
use std::ops::Range;

/// Renders to a tolerance, and checks the errors and the evaluations of all.
fn check(seeds: Range<u64>, tolerance: f64, evaluations: u64) {
    let of_seed = |seed| {
        let view = random_room(seed);
        let reference = view.reference();
        assert!(reference.error < 0.1 * tolerance, "{}: {:.1e}", view.name(), reference.error);
        let emission = FromFn(|position, _| view.rate(position));
        let options = RenderOptions::new(VolOptions::new(tolerance));
        let rendering = render(&emission, view.camera(), view.shape(), &options).unwrap();
        assert!(rendering.converged(), "{}: {:?}", view.name(), rendering.stats.ending);
        let outcome = Outcome::of(&rendering, &reference);
        let allowed = tolerance + reference.error;
        assert!(outcome.error <= allowed, "{}: {:.1e}", view.name(), outcome.error);
        assert!(!outcome.is_negative, "{}", view.name());
        rendering.stats.evaluations
    };
    let spent: u64 = seeds.into_par_iter().map(of_seed).sum();
    assert_eq!(spent, evaluations);
}

macro_rules! tolerances_met {
    ($($name:ident: $seeds:expr, $tolerance:expr, $evaluations:expr;)*) => {$(
        #[test]
        fn $name() {
            check($seeds, $tolerance, $evaluations);
        }
    )*};
}

tolerances_met! {
    a_hundredth_seeds_0: 0..12, 1e-2, 43_776;
    a_hundredth_seeds_60: 60..72, 1e-2, 36_684;
    a_thousandth_seeds_0: 0..12, 1e-3, 65_730;
    a_thousandth_seeds_60: 60..72, 1e-3, 49_632;
}
