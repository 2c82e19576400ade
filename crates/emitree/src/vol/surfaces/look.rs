//! Whether G jumps in a view of several tiles, by a few samples: products, whose search would show it, are not
//! searched for there.

use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::projection::vector::along;
use crate::site::Site;
use crate::tile::Tile;
use crate::vol::VolOptions;
use crate::vol::lattice;
use crate::vol::lowrank::WeightedView;
use crate::vol::lowrank::jump::Steep;
use crate::vol::sampling::{Stop, are_one, evaluate};
use crate::vol::surfaces::render::is_possible;
use crate::vol::surfaces::sky::{Sky, known_rates};
use crate::vol::tuning::TUNING;
use crate::vol::view::part::Parts;
use crate::vol::view::scattered::KnownParts;

/// The samples of a view, divided among its tiles.
const SAMPLES: usize = 288;
/// The smallest share of the budget of which they are taken.
const LEAST_BUDGET: u64 = 50;
/// Pairs of neighbouring samples between which a jump is searched for, those with the largest differences.
const PAIRS: usize = 8;
/// The samples of a view that has the same g at all of them are doubled, up to so many of a tile and this share of the
/// budget: a small shape may be its only structure.
const MOST_OF_TILE: usize = 4096;
const MOST_BUDGET_SHARE: u64 = 4;
/// The fewest points for which the scattered lattice is even, and the most for which pairs are looked for.
const FEWEST_OF_LATTICE: usize = 128;
const MOST_PAIRED: usize = 2048;
/// The smallest difference, as a share of the largest |rate|.
const LEAST_DIFFERENCE: f64 = 0.05;

/// Looks for a jump. Returns whether there is one, and the samples, which serve the trees, too.
pub(crate) async fn look(
    meter: &Meter,
    tiles: &[Tile<'_>],
    parts: &Parts<'_>,
    vol: &VolOptions,
) -> Result<(bool, KnownParts), MethodError> {
    let mut known = KnownParts::none(parts.parts.len());
    let of_tile = SAMPLES / tiles.len();
    if !is_possible(vol) || meter.evaluations_left() / LEAST_BUDGET < SAMPLES as u64 {
        return Ok((false, known));
    }
    match find(meter, tiles, parts, of_tile, &mut known).await {
        Ok(found) => Ok((found, known)),
        Err(Stop::Budget) => Ok((false, known)),
        Err(Stop::Failed(error)) => Err(error),
    }
}

async fn find(
    meter: &Meter,
    tiles: &[Tile<'_>],
    parts: &Parts<'_>,
    of_tile: usize,
    known: &mut KnownParts,
) -> Result<bool, Stop> {
    let mut of_tile = of_tile;
    sample_tiles(meter, parts, [0, of_tile], known).await?;
    while of_tile < MOST_OF_TILE && has_one_rate(parts, known) {
        let next = (2 * of_tile).max(FEWEST_OF_LATTICE);
        let needed = ((next - of_tile) * parts.parts.len()) as u64;
        if meter.evaluations_left() / MOST_BUDGET_SHARE < needed {
            break;
        }
        sample_tiles(meter, parts, [of_tile, next], known).await?;
        of_tile = next;
    }
    let count = of_tile * parts.parts.len();
    let chart = |i: usize| &*parts.parts[i / of_tile].chart;
    let place = |i: usize| lattice::point(i % of_tile);
    let rates: Vec<f64> = known.samples.iter().flat_map(|of| of.rates.iter().copied()).collect();
    let Some(sky) = Sky::new(tiles, &known_rates(parts, &known.samples)) else { return Ok(false) };
    let part = sky.part(tiles);
    let view = WeightedView::new(meter, &part, tiles.len());
    let places: Vec<[f64; 3]> = (0..count)
        .map(|i| {
            let position = chart(i).world_from_chart(place(i)).position;
            part.chart.chart_from_world(position).unwrap_or([0.5; 3])
        })
        .collect();
    let largest = rates.iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
    let mut steep: Vec<([[f64; 3]; 2], Steep)> = pairs(&places, &rates)
        .into_iter()
        .filter(|[a, b]| (rates[*a] - rates[*b]).abs() > LEAST_DIFFERENCE * largest)
        .map(|[a, b]| ([places[a], places[b]], Steep::between([0.0, 1.0], [rates[a], rates[b]])))
        .collect();
    for _ in 0..=TUNING.lowrank.steep_steps {
        if steep.is_empty() {
            return Ok(false);
        }
        let of_pair = |([from, to], steep): &([[f64; 3]; 2], Steep)| {
            let at = |t: f64| core::array::from_fn(|k| from[k] + t * (to[k] - from[k]));
            steep.inside().into_iter().map(at).collect::<Vec<[f64; 3]>>()
        };
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

/// Samples the points of the lattice between two numbers in each tile.
async fn sample_tiles(
    meter: &Meter,
    parts: &Parts<'_>,
    [from, to]: [usize; 2],
    known: &mut KnownParts,
) -> Result<(), Stop> {
    let (new, tiles) = (to - from, parts.parts.len());
    let site = |i: usize| {
        let u @ [x, y, _] = lattice::point(from + i % new);
        let point = parts.parts[i / new].chart.world_from_chart(u);
        Site { xy: [x, y], point, energy: None, tile: (i / new, tiles) }
    };
    let rates = evaluate(meter, new * tiles, &site).await?;
    for (samples, rates) in known.samples.iter_mut().zip(rates.chunks(new)) {
        samples.number = to;
        samples.points.extend((from..to).map(lattice::point));
        samples.rates.extend(rates);
    }
    Ok(())
}

/// Whether g is the same at all samples.
fn has_one_rate(parts: &Parts<'_>, known: &KnownParts) -> bool {
    let of_parts = parts.parts.iter().zip(&known.samples);
    are_one(of_parts.flat_map(|(part, samples)| {
        let both = samples.points.iter().zip(&samples.rates);
        both.map(|(point, rate)| rate / part.chart.world_from_chart(*point).path_per_depth)
    }))
}

/// The pairs of a point and one of the nearest points to it, with the largest differences of rates.
fn pairs(places: &[[f64; 3]], rates: &[f64]) -> Vec<[usize; 2]> {
    let square = |a: usize, b: usize| {
        along(places[a], -1.0, places[b]).into_iter().map(|along| along * along).sum::<f64>()
    };
    let pair = |a: usize| {
        let others = (0..places.len()).filter(|b| rates[*b].to_bits() != rates[a].to_bits());
        let b = others.min_by(|b, c| square(a, *b).total_cmp(&square(a, *c)))?;
        Some([a.min(b), a.max(b)])
    };
    // Among many points, few differ from the others: more are taken only where all before were equal.
    let is_first = |a: &usize| rates[*a].to_bits() == rates[0].to_bits();
    let is_few = places.len() <= MOST_PAIRED;
    let from = (0..places.len()).filter(|a| is_few || !is_first(a));
    let mut pairs: Vec<[usize; 2]> = from.take(MOST_PAIRED).filter_map(pair).collect();
    pairs.sort_unstable();
    pairs.dedup();
    // The differences over the distances, so that neighbours are preferred.
    let slope = |[a, b]: &[usize; 2]| (rates[*a] - rates[*b]).abs() / square(*a, *b).sqrt();
    pairs.sort_by(|a, b| slope(b).total_cmp(&slope(a)));
    pairs.truncate(PAIRS);
    pairs
}
