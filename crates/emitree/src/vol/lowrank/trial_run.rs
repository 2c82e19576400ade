//! The trial run: the cost of the image tree, measured on the interpolant instead of on G.

use crate::calls::Calls;
use crate::emission::{Emission, Samples};
use crate::erased::Erased;
use crate::error::RenderError;
use crate::exchange::drive;
use crate::meter::{Deadline, Limits, Meter};
use crate::projection::Canonical;
use crate::tile::Tile;
use crate::vol::engine::{BeforeTrees, Trees};
use crate::vol::lowrank::interpolant::Interpolant;
use crate::vol::view::part::parts;
use crate::vol::view::scattered::KnownParts;
use crate::vol::{PixelTolerance, VolOptions};
use core::convert::Infallible;
use core::pin::pin;

/// An interpolant as an emission, in canonical coordinates.
struct InterpolantEmission<'a>(&'a Interpolant);

impl Emission for InterpolantEmission<'_> {
    type Error = Infallible;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Infallible> {
        rates.copy_from_slice(&self.0.unscaled_values(samples.positions()));
        Ok(())
    }
}

/// The number of evaluations of an image tree for the interpolant's image of `shape` to
/// `tolerance`, or to one by pixel; `None` if they are more than `most` or the deadline passes.
pub(super) fn evaluations_of_tree(
    interpolant: &Interpolant,
    shape: [usize; 2],
    tolerance: f64,
    by_pixel: Option<PixelTolerance>,
    most: f64,
    deadline: Option<Deadline>,
) -> Option<f64> {
    let emission = Erased(&InterpolantEmission(interpolant));
    // A budget would change the refinement, so that the run is interrupted from outside.
    let [max_evaluations, max_kept, batch_size] = [u64::MAX; 3];
    let limits = Limits { max_evaluations, max_kept, batch_size, whole_batches: false, deadline };
    let meter = Meter::new([0, 0], limits, None, false);
    let vol = VolOptions { tolerance, by_pixel, ..VolOptions::default() };
    let tiles = [Tile { projection: &Canonical, shape, place: (0, 1) }];
    let parts = parts(&tiles, None, None);
    let tree = async {
        let known = KnownParts::none(1);
        Trees::begin(&meter, &tiles, &parts, None, &vol, known, BeforeTrees::default())
            .await?
            .finish()
            .await
    };
    let mut tree = pin!(tree);
    let calls = Calls::new(&emission, &meter, None);
    let is_too_expensive = || meter.evaluations() as f64 > most;
    let ended = drive(meter.exchange(), tree.as_mut(), |batch| match is_too_expensive() {
        true => Err(RenderError::Interrupted),
        false => calls.evaluate(batch).map_err(|error| error.with_emission_error(|_| None)),
    });
    ended.ok().filter(|_| !is_too_expensive()).map(|_| meter.evaluations() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_interpolant_costs_two_levels_and_a_limit_ends_the_trial_run() {
        let zero = Interpolant::new(4, None);
        let found = evaluations_of_tree(&zero, [16, 16], 0.01, None, 1e6, None).unwrap();
        assert!((729.0..5000.0).contains(&found), "{found}");
        assert_eq!(evaluations_of_tree(&zero, [16, 16], 0.01, None, 100.0, None), None);
    }
}
