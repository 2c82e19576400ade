//! Whether G jumps, by a few samples, where no search for products shows it: in a view of several tiles, and where few
//! samples meet a shape.

use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::site::Site;
use crate::tile::Tile;
use crate::vol::VolOptions;
use crate::vol::lattice;
use crate::vol::lowrank::WeightedView;
use crate::vol::sampling::{Stop, are_one, evaluate};
use crate::vol::surfaces::hits::{few, in_chart, known_in_chart};
use crate::vol::surfaces::lines_of_sight::{LinesOfSight, in_view};
use crate::vol::surfaces::render::is_possible;
use crate::vol::surfaces::sky::{Sky, known_rates};
use crate::vol::surfaces::steep_pairs::jumps_between;
use crate::vol::view::part::Parts;
use crate::vol::view::scattered::KnownParts;
use std::sync::Arc;

/// The samples of a view, divided among its tiles.
const SAMPLES: usize = 288;
/// The smallest share of the budget of which they are taken.
const LEAST_BUDGET: u64 = 50;
/// The samples of a view that has the same g at all of them are doubled, up to so many of a tile and this share of the
/// budget: a small shape may be its only structure.
const MOST_OF_TILE: usize = 4096;
const MOST_BUDGET_SHARE: u64 = 4;
/// The fewest points for which the scattered lattice is even.
const FEWEST_OF_LATTICE: usize = 128;

/// Looks for a jump beside those few of known samples at which g is not that of most.
pub(crate) async fn look_beside_few(
    meter: &Meter,
    tiles: &[Tile<'_>],
    parts: &Parts<'_>,
    vol: &VolOptions,
    known: &KnownParts,
) -> Result<bool, MethodError> {
    if !is_possible(vol) {
        return Ok(false);
    }
    let lines = LinesOfSight::new(tiles, parts, &known_rates(parts, &known.samples));
    let Some(lines) = lines else { return Ok(false) };
    let Some(part) = lines.part(tiles, parts) else { return Ok(false) };
    let samples = known_in_chart(&part, parts, known);
    let few = few(&samples);
    if few.is_empty() {
        return Ok(false);
    }
    let view = WeightedView::new(meter, &part, tiles.len());
    match jumps_between(&view, &samples, &few).await {
        Ok(found) => Ok(found),
        Err(Stop::Budget) => Ok(false),
        Err(Stop::Failed(error)) => Err(error),
    }
}

/// Looks for a jump in a view of several tiles. Returns whether there is one, and the samples, which serve the trees,
/// too.
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
    let Some(sky) = Sky::new(tiles, &known_rates(parts, &known.samples)) else { return Ok(false) };
    let part = sky.part(Arc::new(in_view(tiles)));
    let samples = in_chart(&part, parts, &known.samples);
    let view = WeightedView::new(meter, &part, tiles.len());
    jumps_between(&view, &samples, &[]).await
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
