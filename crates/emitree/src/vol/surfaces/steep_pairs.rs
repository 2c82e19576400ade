//! Whether G jumps between neighbouring samples with much different values.

use crate::projection::vector::along;
use crate::vol::lowrank::WeightedView;
use crate::vol::lowrank::jump::Steep;
use crate::vol::sampling::Stop;
use crate::vol::surfaces::hits::Known;
use crate::vol::tuning::TUNING;

/// Pairs of neighbouring samples between which a jump is searched for, those with the largest differences.
const PAIRS: usize = 8;
/// The most samples for which all pairs are looked for.
const MOST_PAIRED: usize = 2048;
/// The smallest difference, as a share of the largest |rate|.
const LEAST_DIFFERENCE: f64 = 0.05;

/// Divides the intervals between neighbouring samples, until a jump remains in one, or in none. With some samples in
/// `few`, the intervals are those between one of them and the nearest one that is not.
pub(super) async fn jumps_between(
    view: &WeightedView<'_>,
    samples: &[Known],
    few: &[usize],
) -> Result<bool, Stop> {
    let places: Vec<[f64; 3]> = samples.iter().map(|of| of.at).collect();
    let rates: Vec<f64> = samples.iter().map(|of| of.of_path).collect();
    let largest = rates.iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
    let mut steep: Vec<([[f64; 3]; 2], Steep)> = pairs(&places, &rates, few)
        .into_iter()
        .filter(|[a, b]| (rates[*a] - rates[*b]).abs() > LEAST_DIFFERENCE * largest)
        .map(|[a, b]| ([places[a], places[b]], Steep::between([0.0, 1.0], [rates[a], rates[b]])))
        .collect();
    for _ in 0..=TUNING.lowrank.steep_steps {
        let of_pair = |([from, to], steep): &([[f64; 3]; 2], Steep)| {
            let at = |t: f64| core::array::from_fn(|k| from[k] + t * (to[k] - from[k]));
            steep.inside().into_iter().map(at).collect::<Vec<[f64; 3]>>()
        };
        // G has no value behind a body and beyond bounds.
        let is_seen = |[x, y, z]: &[f64; 3]| {
            let [from, to] = view.part.chart.visible_ends([*x, *y]);
            (from..=to).contains(z)
        };
        steep.retain(|pair| of_pair(pair).iter().all(is_seen));
        if steep.is_empty() {
            return Ok(false);
        }
        let points: Vec<Vec<[f64; 3]>> = steep.iter().map(of_pair).collect();
        let rates = view.rates(&points.concat()).await?;
        let of_pairs = rates.chunks(points[0].len());
        let steepest = |((ends, steep), rates): (([[f64; 3]; 2], Steep), &[f64])| {
            Some((ends, steep.steepest_part(rates)?))
        };
        steep = steep.into_iter().zip(of_pairs).filter_map(steepest).collect();
    }
    Ok(!steep.is_empty())
}

/// The pairs of a point and one of the nearest points to it, with the largest differences of rates.
fn pairs(places: &[[f64; 3]], rates: &[f64], few: &[usize]) -> Vec<[usize; 2]> {
    let square = |a: usize, b: usize| {
        along(places[a], -1.0, places[b]).into_iter().map(|along| along * along).sum::<f64>()
    };
    let pair = |a: usize| {
        let differs = |b: &usize| match few {
            [] => rates[*b].to_bits() != rates[a].to_bits(),
            _ => few.binary_search(b).is_err(),
        };
        let others = (0..places.len()).filter(differs);
        let b = others.min_by(|b, c| square(a, *b).total_cmp(&square(a, *c)))?;
        Some([a.min(b), a.max(b)])
    };
    // Among many points, few differ from the others: more are taken only where all before were equal.
    let is_first = |a: &usize| rates[*a].to_bits() == rates[0].to_bits();
    let is_few = places.len() <= MOST_PAIRED;
    let from: Vec<usize> = match few {
        [] => (0..places.len()).filter(|a| is_few || !is_first(a)).take(MOST_PAIRED).collect(),
        _ => few.to_vec(),
    };
    let mut pairs: Vec<[usize; 2]> = from.into_iter().filter_map(pair).collect();
    pairs.sort_unstable();
    pairs.dedup();
    // The differences over the distances, so that neighbours are preferred.
    let slope = |[a, b]: &[usize; 2]| (rates[*a] - rates[*b]).abs() / square(*a, *b).sqrt();
    pairs.sort_by(|a, b| slope(b).total_cmp(&slope(a)));
    pairs.truncate(PAIRS);
    pairs
}
