//! Jumps and kinks of G at the same azimuth on several fibers of a chart.
//!
//! On a plane through the axis of shells G may have a jump, a kink or a cusp, which makes a chart
//! costly, while its two sides are smooth. If the search fails, the samples of the newest fiber
//! along the azimuth show where the slope changes most. These intervals are halved repeatedly: the
//! change of a smooth slope is soon distributed over the parts, that of a kink stays in one place.
//! The place is accepted if other fibers have it, too. It only decides where charts end, and the
//! image is correct for any place.

use crate::vol::lowrank::search::{Search, along};
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;

/// The axis of the azimuth.
const AZIMUTH: usize = 1;
/// Where fibers are compared with the first one, on the other two axes.
const OTHERS: [[f64; 2]; 3] = [[0.37, 0.58], [0.71, 0.33], [0.18, 0.79]];
/// The places on both sides of a kink, in units of `same_kink`.
const BESIDE: [f64; 6] = [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5];

/// G along the azimuth: its coordinates on the other axes, places and rates.
#[derive(Clone, Debug)]
pub(super) struct Fiber {
    pub(super) at: [f64; 2],
    pub(super) places: Vec<f64>,
    pub(super) rates: Vec<f64>,
}

/// Three successive intervals, with most of the change of the slope at or in the middle one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bend {
    places: [f64; 4],
    rates: [f64; 4],
}

impl Search<'_> {
    /// The newest fiber along the azimuth.
    pub(super) fn azimuth_fiber(&self) -> Option<Fiber> {
        let fibers = &self.interpolant.axes[AZIMUTH];
        let (&at, rates) = fibers.at.last().zip(fibers.rates.last())?;
        Some(Fiber { at, places: fibers.places().to_vec(), rates: rates.clone() })
    }

    /// The places on the azimuth, from 0 to 1, at which G has a kink or a jump on several fibers.
    pub(super) async fn kinks(&self, fiber: &Fiber) -> Result<Vec<f64>, Stop> {
        let mut kinks: Vec<f64> = Vec::new();
        for bend in bends_of(&fiber.places, &fiber.rates) {
            // A plane is seen at opposite azimuths.
            let opposite = kinks.iter().map(|kink| (kink + 0.5) % 1.0).find(|v| bend.contains(*v));
            let found = match opposite {
                Some(opposite) if self.is_kink(fiber.at, opposite).await? => Some(opposite),
                _ => self.located(fiber.at, bend).await?,
            };
            if let Some(place) = found
                && self.is_on_others(place).await?
            {
                kinks.push(place);
            }
        }
        Ok(kinks)
    }

    /// The place of a kink or a jump, if the change of the slope is one.
    async fn located(&self, at: [f64; 2], mut bend: Bend) -> Result<Option<f64>, Stop> {
        for _ in 0..TUNING.lowrank.kink_halvings {
            let rates = self.view.rates(&along(AZIMUTH, at, &bend.middles())).await?;
            match bend.halved(&rates) {
                Some(half) => bend = half,
                None => return Ok(None),
            }
        }
        Ok(Some(bend.middle()))
    }

    /// Whether other fibers have a kink at a place.
    async fn is_on_others(&self, place: f64) -> Result<bool, Stop> {
        let mut agreeing = 0;
        for at in OTHERS {
            agreeing += usize::from(self.is_kink(at, place).await?);
            if agreeing == TUNING.lowrank.kink_fibers {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether a fiber has a kink at a place.
    async fn is_kink(&self, at: [f64; 2], place: f64) -> Result<bool, Stop> {
        let places = BESIDE.map(|beside| place + beside * TUNING.lowrank.same_kink);
        if places.iter().any(|place| !(0.0..=1.0).contains(place)) {
            return Ok(false);
        }
        let rates = self.view.rates(&along(AZIMUTH, at, &places)).await?;
        Ok(has_kink(&places, &rates))
    }
}

/// Whether the slope changes mainly between the two middle ones of an even number of places.
fn has_kink(places: &[f64], rates: &[f64]) -> bool {
    let changes = changes_of_slope(places, rates);
    let Some((first, most)) = largest_pair(&changes) else { return false };
    let largest = rates.iter().fold(0.0, |largest: f64, rate| largest.max(rate.abs()));
    2 * (first + 1) == changes.len()
        && most > TUNING.lowrank.least_kink * largest
        && most > TUNING.lowrank.kink_share * changes.iter().sum::<f64>()
}

impl Bend {
    /// Three intervals from place `first` on.
    fn of_parts(places: &[f64], rates: &[f64], first: usize) -> Self {
        let of = |all: &[f64]| core::array::from_fn(|i| all[first + i]);
        Self { places: of(places), rates: of(rates) }
    }

    fn contains(&self, place: f64) -> bool {
        self.places[0] < place && place < self.places[3]
    }

    fn middle(&self) -> f64 {
        0.5 * (self.places[1] + self.places[2])
    }

    /// The places in the middle of each interval.
    fn middles(&self) -> [f64; 3] {
        core::array::from_fn(|i| 0.5 * (self.places[i] + self.places[i + 1]))
    }

    /// The halves of intervals with nearly all of the change of the slope, if there are such, given
    /// the rates in their middles.
    fn halved(&self, middles: &[f64]) -> Option<Self> {
        let places = alternating(&self.places, &self.middles());
        let rates = alternating(&self.rates, middles);
        let changes = changes_of_slope(&places, &rates);
        let (first, most) = largest_pair(&changes)?;
        let is_one = most > TUNING.lowrank.kink_share * changes.iter().sum::<f64>();
        is_one.then(|| Self::of_parts(&places, &rates, first))
    }
}

/// The elements of a list with those of another one between them.
fn alternating(ends: &[f64], middles: &[f64]) -> Vec<f64> {
    let element = |i: usize| if i.is_multiple_of(2) { ends[i / 2] } else { middles[i / 2] };
    (0..ends.len() + middles.len()).map(element).collect()
}

/// The |change| of the slope at each place but the first and the last.
fn changes_of_slope(places: &[f64], rates: &[f64]) -> Vec<f64> {
    let both = places.windows(2).zip(rates.windows(2));
    let slopes: Vec<f64> =
        both.map(|(place, rate)| (rate[1] - rate[0]) / (place[1] - place[0])).collect();
    slopes.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect()
}

/// The first of the two successive numbers with the largest sum, and the sum.
fn largest_pair(changes: &[f64]) -> Option<(usize, f64)> {
    let pairs = changes.windows(2).map(|pair| pair[0] + pair[1]).enumerate();
    pairs.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The intervals of a fiber in which the slope changes more than around them, the largest changes
/// first.
fn bends_of(places: &[f64], rates: &[f64]) -> Vec<Bend> {
    let changes = changes_of_slope(places, rates);
    let pairs: Vec<f64> = changes.windows(2).map(|pair| pair[0] + pair[1]).collect();
    let around = |i: usize| &pairs[i.saturating_sub(2)..(i + 3).min(pairs.len())];
    let is_largest = |i: &usize| around(*i).iter().all(|other| *other <= pairs[*i]);
    let mut order: Vec<usize> = (0..pairs.len()).filter(is_largest).collect();
    order.sort_by(|&a, &b| pairs[b].total_cmp(&pairs[a]));
    let Some(&most) = order.first() else { return Vec::new() };
    let least = TUNING.lowrank.least_bend_share * pairs[most];
    order.retain(|&i| pairs[i] > 0.0 && pairs[i] >= least);
    order.truncate(TUNING.lowrank.most_bends);
    order.into_iter().map(|i| Bend::of_parts(places, rates, i)).collect()
}

#[cfg(test)]
mod tests;
