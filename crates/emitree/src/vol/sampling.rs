//! Samples of the radiance per depth along lines of sight, evaluated in batches.

use crate::error::RenderError;
use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::projection::Chart;
use crate::projection::charts::chart::AcrossGap;
use crate::site::{Site, Sites};
use crate::vol::dyadic::{Place, unit};
use std::collections::HashMap;

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
    pub(crate) chart: &'a dyn Chart,
    /// The number of tiles of the image.
    pub(crate) tiles: usize,
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
        let mut point = self.chart.world_from_chart(u);
        if let Some(energy) = energy {
            point.path_per_depth *= energy.density;
        }
        let energy = energy.map(|sample| sample.energy);
        let (tile, xy) = self.chart.image_place([u[0], u[1]]);
        Site { xy, point, energy, tile: (tile, self.tiles) }
    }

    /// What makes G at a point, as [`terms`].
    pub(crate) fn terms(&self, [x, y]: Place, depth: u32) -> Vec<(Site, f64)> {
        let site = self.site([x, y, depth], self.energy);
        terms(self.chart, [x, y, depth].map(unit), site)
    }

    /// G at the energy of the view, in one batch.
    pub(crate) async fn rates(&self, points: &[(Place, u32)]) -> Result<Vec<f64>, Stop> {
        let at = |i: usize| {
            let ([x, y], depth) = points[i];
            [x, y, depth].map(unit)
        };
        let site = |i: usize| {
            let ([x, y], depth) = points[i];
            self.site([x, y, depth], self.energy)
        };
        evaluate_across_gaps(self.meter, self.chart, points.len(), &at, &site).await
    }
}

/// The sites whose weighted values make the value at a point of a chart, given its coordinates and its
/// own site: that one alone, unless the point is inside an opaque body.
pub(crate) fn terms(chart: &dyn Chart, u: [f64; 3], own: Site) -> Vec<(Site, f64)> {
    let Some(gap) = chart.has_gaps().then(|| across_gap(chart, u, &own)).flatten() else {
        return vec![(own, 1.0)];
    };
    let around = gap.around.into_iter().map(|point| Site { point, ..own });
    around.zip(gap.weights).collect()
}

/// The points around a body that replace one inside it, whose own site is given.
fn across_gap(chart: &dyn Chart, u: [f64; 3], own: &Site) -> Option<AcrossGap> {
    let mut gap = chart.across_gap(u)?;
    let plain = chart.world_from_chart(u).path_per_depth;
    // What an energy axis adds to the path.
    let density = if plain == 0.0 { 0.0 } else { own.point.path_per_depth / plain };
    gap.weights.iter_mut().for_each(|weight| *weight *= density);
    Some(gap)
}

/// The values at points of a chart, given their coordinates and their sites: a point inside an opaque
/// body has the sum of the values at those around the body that replace it.
pub(crate) async fn evaluate_across_gaps(
    meter: &Meter,
    chart: &dyn Chart,
    count: usize,
    at: &(dyn Fn(usize) -> [f64; 3] + Sync),
    site: &Sites<'_>,
) -> Result<Vec<f64>, Stop> {
    if !chart.has_gaps() {
        return evaluate(meter, count, site).await;
    }
    let mut sites: Vec<Site> = Vec::with_capacity(count);
    // The first site of each point.
    let mut first: Vec<(usize, Option<AcrossGap>)> = Vec::with_capacity(count);
    // Points in one gap of a line of sight have the same sites: the first of those of each gap.
    let mut lines: HashMap<[u64; 3], Vec<usize>> = HashMap::new();
    for i in 0..count {
        let (own, u) = (site(i), at(i));
        let Some(gap) = across_gap(chart, u, &own) else {
            first.push((sites.len(), None));
            sites.push(own);
            continue;
        };
        let line = [u[0], u[1], own.energy.unwrap_or(0.0)].map(f64::to_bits);
        let gaps = lines.entry(line).or_default();
        let is_same = |first: &usize| {
            gap.around.iter().zip(&sites[*first..]).all(|(point, site)| *point == site.point)
        };
        let at_first = gaps.iter().copied().find(is_same).unwrap_or(sites.len());
        if at_first == sites.len() {
            gaps.push(at_first);
            sites.extend(gap.around.map(|point| Site { point, ..own }));
        }
        first.push((at_first, Some(gap)));
    }
    let rates = evaluate(meter, sites.len(), &|k: usize| sites[k]).await?;
    let value = |(at, gap): (usize, Option<AcrossGap>)| {
        gap.map_or_else(|| rates[at], |gap| gap.value(&rates[at..]))
    };
    Ok(first.into_iter().map(value).collect())
}

/// Whether there are rates, and all are the same up to rounding.
pub(crate) fn are_one(mut rates: impl Iterator<Item = f64>) -> bool {
    let Some(first) = rates.next() else { return false };
    rates.all(|rate| are_same(rate, first))
}

/// Whether a rate is another one up to rounding.
fn are_same(rate: f64, other: f64) -> bool {
    const ROUNDING: f64 = 1e-9;
    (rate - other).abs() <= ROUNDING * other.abs()
}

/// The numbers of the rates that are not the median, up to rounding, in ascending order.
pub(crate) fn unlike_most(rates: &[f64]) -> Vec<usize> {
    let mut sorted = rates.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(&median) = sorted.get(sorted.len() / 2) else { return Vec::new() };
    (0..rates.len()).filter(|&number| !are_same(rates[number], median)).collect()
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
