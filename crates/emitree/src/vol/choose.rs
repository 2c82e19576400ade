//! The choice between the low-rank approximation, surfaces and the image tree.

use crate::energy::EnergyAxis;
use crate::error::{OptionError, RenderError};
use crate::exchange::MethodError;
use crate::image::Image;
use crate::mesh::start::Structure;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::projection::charts::{FoundCut, FoundEdge};
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::engine::by_tree;
use crate::vol::error_weights::ErrorWeights;
use crate::vol::lowrank;
use crate::vol::lowrank::attempted::Attempted;
use crate::vol::lowrank::start::{Division, Start};
use crate::vol::sampling::Stop;
use crate::vol::seeds::check_seeds;
use crate::vol::surfaces;
use crate::vol::tuning::TUNING;
use crate::vol::view::edges::{cost_of_edges, find_edges};
use crate::vol::view::part::{Parts, SeenCharts, atlas, parts};
use crate::vol::{BASE_LEVELS, PixelTolerance, VolOptions};
use std::sync::Arc;

/// Renders an image, or a cube in the bins of `axis`, to the tolerance of `vol`.
pub(crate) async fn render(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<MethodOutput, MethodError> {
    check(vol, tiles[0].shape_of_image(), axis)?;
    check_seeds(&vol.seeds)?;
    // From here on, the tolerance is that of the largest pixel.
    let vol = &VolOptions { tolerance: vol.of_largest(), ..vol.clone() };
    let mut start = start(meter, tiles);
    let mut division = match start {
        Some(start) => start.division.clone(),
        None => Division { edges: edges(meter, tiles, axis, vol).await?, ..Division::default() },
    };
    let mut seen: Option<SeenCharts> = None;
    loop {
        let Division { edges, cuts, depths, stretch } = &division;
        let atlas = atlas(tiles, edges).map(|atlas| atlas.with_weights(depths).with_cuts(cuts));
        let parts = match (seen.take(), &atlas) {
            (Some(seen), Some(atlas)) => seen.parts(tiles, atlas),
            _ => parts(tiles, atlas.as_ref(), *stretch),
        };
        meter.check_time()?;
        let mut attempted = match axis {
            None => {
                let start = start.filter(|start| start.division == division);
                lowrank::attempt(meter, tiles, &parts, vol, start).await?
            }
            Some(_) => Attempted::none(&parts),
        };
        if !attempted.functions_suffice {
            // From nothing, as without a mesh.
            start = None;
            let edges = self::edges(meter, tiles, axis, vol).await?;
            division = Division { edges, ..Division::default() };
            continue;
        }
        if !attempted.depths.is_empty() {
            seen = parts.seen_charts();
            division.depths = attempted.depths;
            continue;
        }
        if attempted.stretch.is_some() {
            division.stretch = attempted.stretch;
            continue;
        }
        // Charts that end at the kinks found replace the first ones; once, which bounds the cost.
        if let Some(atlas) = atlas.as_ref().filter(|_| cuts.is_empty()) {
            let kinks = attempted.kinks.iter();
            let cuts: Vec<FoundCut> =
                kinks.map(|kink| atlas.cut(kink.chart, &kink.window, kink.v)).collect();
            if !cuts.is_empty() {
                division.cuts = cuts;
                continue;
            }
        }
        let functions = core::mem::take(&mut attempted.functions);
        let mut made = finish(meter, tiles, &parts, axis, vol, attempted).await?;
        made.stretch = division.stretch;
        if functions.iter().any(Option::is_some)
            && let Some(frozen) = made.frozen.as_mut().and_then(Arc::get_mut)
        {
            frozen.structure = Some(Structure::new(Start { division, functions }));
        }
        return Ok(with_share_of_allowed(made, vol));
    }
}

/// The division and the functions that the rendering begins with, if it begins with those of a view that has
/// the same surfaces.
fn start<'a>(meter: &'a Meter, tiles: &[Tile<'_>]) -> Option<&'a Start> {
    let start: &Start = meter.start()?.structure.as_ref()?.of_method()?;
    start.division.fits(atlas(tiles, &start.division.edges).as_ref()).then_some(start)
}

/// Adds the largest error in units of the error allowed. By pixel, that is the final check of the image of
/// all parts together.
fn with_share_of_allowed(mut made: MethodOutput, vol: &VolOptions) -> MethodOutput {
    if let Some(errors) = &made.error {
        let share = ErrorWeights::over_allowed(vol, &made.cube, errors);
        made.error_over_allowed = Some(share);
        if !vol.is_uniform() && share > 1.0 && made.ending == StopReason::Complete {
            made.ending = StopReason::MaxLevel;
        }
    }
    made
}

/// The image of products, of surfaces, or of trees of the parts that have none.
async fn finish(
    meter: &Meter,
    tiles: &[Tile<'_>],
    parts: &Parts<'_>,
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
    mut attempted: Attempted,
) -> Result<MethodOutput, MethodError> {
    let is_complete =
        |found: &MethodOutput| matches!(found.ending, StopReason::Complete | StopReason::FixedMesh);
    let products = match attempted.found.take() {
        Some(products) if is_complete(&products) => return Ok(products),
        products => products,
    };
    if let Some(found) = surfaces::render(meter, tiles, parts, axis, vol, &mut attempted).await? {
        return Ok(found);
    }
    match (products, by_tree(meter, tiles, parts, axis, vol, attempted.known).await) {
        // The time limit was reached before lines gave an image.
        (Some(products), Err(RenderError::Time { .. })) => Ok(products),
        (products, tree) => {
            let tree = tree?;
            // If a limit ended both, the one with the smaller estimated error is used.
            let is_better =
                |products: &MethodOutput| products.estimated_error() < tree.estimated_error();
            Ok(products.filter(|p| !is_complete(&tree) && is_better(p)).unwrap_or(tree))
        }
    }
}

/// The places of the energy axis at which edges are searched for: some of them have emission.
const EDGE_ENERGIES: [f64; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];

/// The edges of the emission around the bodies in view; none if the budget is small.
async fn edges(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<Vec<FoundEdge>, MethodError> {
    let Some(atlas) = atlas(tiles, &[]) else { return Ok(Vec::new()) };
    let energies: Vec<Option<f64>> = match axis {
        None => vec![None],
        Some(axis) => EDGE_ENERGIES.iter().map(|u| Some(axis.energy(*u))).collect(),
    };
    let most = energies.len() as u64 * cost_of_edges();
    if meter.evaluations_left() / TUNING.edges.least_budget < most {
        return Ok(Vec::new());
    }
    match find_edges(meter, &atlas, vol.tolerance, &energies).await {
        Ok(found) => Ok(found),
        Err(Stop::Budget) => Ok(Vec::new()),
        Err(Stop::Failed(error)) => Err(error),
    }
}

/// Returns an error if an option is out of range.
fn check(
    vol: &VolOptions,
    shape: [usize; 2],
    axis: Option<&EnergyAxis>,
) -> Result<(), MethodError> {
    // Where sums alone matter, the tolerance of pixels may be as loose as it can be.
    let is_below = vol.tolerance < 1.0 || (vol.tolerance <= 1.0 && !vol.sums.is_empty());
    if !(vol.tolerance > 0.0 && is_below) {
        return Err(OptionError::Tolerance(vol.tolerance).into());
    }
    if let Some(by_pixel) = &vol.by_pixel {
        check_by_pixel(by_pixel)?;
    }
    if let Some(weights) = &vol.weights {
        check_weights(weights, shape)?;
    }
    if vol.per_band && axis.is_none() {
        return Err(OptionError::PerBand.into());
    }
    if !BASE_LEVELS.contains(&vol.base_level) {
        let expected = [*BASE_LEVELS.start(), *BASE_LEVELS.end()];
        return Err(OptionError::BaseLevel { level: vol.base_level, expected }.into());
    }
    Ok(())
}

fn check_by_pixel(by_pixel: &PixelTolerance) -> Result<(), OptionError> {
    let PixelTolerance { rtol, atol, floor } = *by_pixel;
    if !(atol >= 0.0 && atol.is_finite()) {
        return Err(OptionError::AbsoluteTolerance(atol));
    }
    if !(0.0..1.0).contains(&rtol) || (rtol == 0.0 && atol == 0.0) {
        return Err(OptionError::RelativeTolerance(rtol));
    }
    if !(0.0..1.0).contains(&floor) {
        return Err(OptionError::Floor(floor));
    }
    Ok(())
}

fn check_weights(weights: &Image, shape: [usize; 2]) -> Result<(), OptionError> {
    let given = [weights.height(), weights.width()];
    if given != shape {
        return Err(OptionError::WeightsShape { given, expected: shape });
    }
    let is_weight = |weight: &f64| *weight >= 0.0 && weight.is_finite();
    if let Some(pixel) = weights.pixels().iter().position(|weight| !is_weight(weight)) {
        let [row, column] = [pixel / shape[1], pixel % shape[1]];
        return Err(OptionError::Weight { weight: weights.pixels()[pixel], row, column });
    }
    match weights.largest() > 0.0 {
        true => Ok(()),
        false => Err(OptionError::NoWeights),
    }
}

#[cfg(test)]
mod tests;
