//! Samples of the radiance per depth along lines of sight, evaluated in batches.

use crate::error::RenderError;
use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::projection::Layer;
use crate::site::{Site, Sites};
use crate::vol::dyadic::{Place, unit};

/// Reasons for which a batch is not evaluated.
#[derive(Debug)]
pub(crate) enum Stop {
    /// The budget does not suffice for the batch, or the time limit was reached: there are no new
    /// rates.
    Budget,
    Failed(MethodError),
}

/// The view in which G is sampled.
pub(crate) struct View<'a> {
    pub(crate) meter: &'a Meter,
    pub(crate) layer: &'a dyn Layer,
    /// The number of the tile of the image, and the number of tiles.
    pub(crate) tile: (usize, usize),
    /// The energy of all samples, if there is an energy axis.
    pub(crate) energy: Option<EnergySample>,
}

/// An energy at which G is sampled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnergySample {
    /// The energy in the unit of the energy axis.
    pub(crate) energy: f64,
    /// dE/du over its mean, the weight of G.
    pub(crate) density: f64,
}

impl View<'_> {
    /// One sample of the radiance per depth, G = g · ds/dz · dE/du.
    pub(crate) fn site(&self, [x, y, depth]: [u32; 3], energy: Option<EnergySample>) -> Site {
        let u = [unit(x), unit(y), unit(depth)];
        let mut point = self.layer.world_from_canonical(u);
        if let Some(energy) = energy {
            point.path_per_depth *= energy.density;
        }
        let energy = energy.map(|sample| sample.energy);
        Site { xy: [u[0], u[1]], point, energy, tile: self.tile }
    }

    /// G at the energy of the view, in one batch.
    pub(crate) async fn rates(&self, points: &[(Place, u32)]) -> Result<Vec<f64>, Stop> {
        let site = |i: usize| {
            let ([x, y], depth) = points[i];
            self.site([x, y, depth], self.energy)
        };
        evaluate(self.meter, points.len(), &site).await
    }
}

/// Evaluates one batch if the budget suffices for all of it.
pub(crate) async fn evaluate(
    meter: &Meter,
    count: usize,
    site: &Sites<'_>,
) -> Result<Vec<f64>, Stop> {
    let left = meter.evaluations_left();
    // Points outside the view cost nothing; they are counted only if the budget may not suffice
    // otherwise.
    let needed = || (0..count).filter(|&i| site(i).point.path_per_depth != 0.0).count() as u64;
    if count as u64 > left && needed() > left {
        return Err(Stop::Budget);
    }
    let mut rates = vec![0.0; count];
    match meter.evaluate_sites(site, &mut rates).await {
        Err(RenderError::Time { .. }) => Err(Stop::Budget),
        Err(error) => Err(Stop::Failed(error)),
        Ok(()) => Ok(rates),
    }
}

#[cfg(test)]
mod tests;
