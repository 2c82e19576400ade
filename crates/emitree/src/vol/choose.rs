//! The choice between the low-rank approximation, surfaces and the image tree.

mod checks;
mod cube;

use crate::cube::Cube;
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
use crate::vol::VolOptions;
use crate::vol::engine::first_energy::{EnergySearch, FirstEnergy};
use crate::vol::engine::{
    BeforeTrees, COARSEST_LEVEL, Trees, affordable_base_level, base_evaluations_of,
};
use crate::vol::error_weights::ErrorWeights;
use crate::vol::lowrank::attempted::Attempted;
use crate::vol::lowrank::channel::CubeView;
use crate::vol::lowrank::start::Start;
use crate::vol::lowrank::{self, ImageOf};
use crate::vol::pixel_lines::PixelLines;
use crate::vol::sampling::Stop;
use crate::vol::seeds::check_seeds;
use crate::vol::surfaces::{self, FirstImage};
use crate::vol::tuning::TUNING;
use crate::vol::view::division::{Division, atlas, atlas_of_box};
use crate::vol::view::edges::{cost_of_edges, find_edges};
use crate::vol::view::faces::reaches_faces_at;
use crate::vol::view::part::{Part, Parts, SeenCharts, layered_parts, parts};
use crate::vol::view::scattered::KnownParts;
use std::sync::Arc;

/// Renders an image, or a cube in the bins of `axis`, to the tolerance of `vol`.
pub(crate) async fn render(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<MethodOutput, MethodError> {
    checks::check(vol, tiles[0].shape_of_image(), axis)?;
    check_seeds(&vol.seeds)?;
    // From here on, the tolerance is that of the largest pixel.
    let vol = &VolOptions { tolerance: vol.of_largest(), ..vol.clone() };
    to_tolerance(meter, tiles, axis, vol).await
}

/// The same, or if the time ends before there is an image, the coarsest one, unless the mesh is fixed.
pub(crate) async fn render_in_time(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<MethodOutput, MethodError> {
    match render(meter, tiles, axis, vol).await {
        Err(RenderError::Time { seconds }) if !has_fixed_mesh(meter) => {
            let vol = &VolOptions { tolerance: vol.of_largest(), ..vol.clone() };
            coarsest(meter, tiles, axis, vol).await.map_err(|error| match error {
                RenderError::Budget { .. } => RenderError::Time { seconds },
                error => error,
            })
        }
        found => found,
    }
}

/// The evaluations that a point in a gap of a chart may take.
const MOST_FOR_A_POINT: u64 = 11;

/// The image of the smallest possible sampling of each part, after the time has ended. So few samples may miss
/// anything: the errors are those of all of the light at least.
async fn coarsest(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<MethodOutput, MethodError> {
    let atlas = atlas(tiles, &[]);
    let parts = parts(tiles, atlas.as_ref(), None);
    let needed = base_evaluations_of(&parts.parts, COARSEST_LEVEL);
    let has_gaps = parts.parts.iter().any(|part| part.chart.has_gaps());
    meter.allow_overtime(if has_gaps { MOST_FOR_A_POINT * needed } else { needed });
    let vol = &VolOptions { base_level: COARSEST_LEVEL, smallest_feature: None, ..vol.clone() };
    let known = KnownParts::none(parts.parts.len());
    let trees =
        Trees::begin(meter, tiles, &parts, axis, vol, known, BeforeTrees::default()).await?;
    let mut made = trees.finish().await?;
    made.ending = StopReason::Budget;
    let largest = made.cube.largest();
    let at_least = |band: &Image| {
        let mut band = band.clone();
        let errors = band.pixels_mut().iter_mut().filter(|error| !error.is_nan());
        errors.for_each(|error| *error = error.max(largest));
        band
    };
    made.error =
        made.error.map(|error| Cube::from_bands(error.bands().iter().map(at_least).collect()));
    Ok(with_share_of_allowed(made, vol))
}

/// The loop of [`render`], whose tolerance is that of the largest pixel.
async fn to_tolerance(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<MethodOutput, MethodError> {
    let mut lines = PixelLines::expected(meter, tiles, axis, vol).await?;
    if let Some(lines) = lines.take_if(|lines| lines.precede_products)
        && let Some(made) = lines.render().await?
    {
        return Ok(with_share_of_allowed(made, vol));
    }
    let mut start = start(meter, tiles);
    let mut division = match start {
        Some(start) => start.division.clone(),
        None => division(meter, tiles, axis, vol).await?,
    };
    let mut seen: Option<SeenCharts> = None;
    let mut first: Option<FirstEnergy> = None;
    let mut probed = Vec::new();
    let mut has_tried_halves = false;
    let mut unfinished: Option<MethodOutput> = None;
    loop {
        let Division { cuts, is_halved, stretch, layered_from, .. } = &division;
        let atlas = division.atlas(tiles);
        let layered = layered_from.and_then(|from| layered_parts(tiles, *stretch, from));
        let mut parts = match (seen.take(), &atlas, layered) {
            (Some(seen), Some(atlas), _) => seen.parts(tiles, atlas),
            (_, None, Some(layered)) => layered,
            _ => parts(tiles, atlas.as_ref(), *stretch),
        };
        parts.division = division.clone();
        if let Some(wanted) = meter.rows_wanted() {
            checks::check_rows(&parts, axis.is_some(), wanted)?;
        }
        meter.check_time()?;
        start = serving(start, &division, parts.parts.len(), axis, meter)?;
        if let Some(axis) = axis.filter(|_| start.is_none() && first.is_none()) {
            let search = EnergySearch::new(meter, tiles, &parts.parts, axis, vol);
            let left = meter.evaluations_left();
            let base_level = affordable_base_level(&parts.parts, vol.base_level, left)?;
            first = Some(search.run(base_level).await?);
        }
        let of_probes = core::mem::take(&mut probed);
        let mut attempted = match axis {
            None => {
                let of = ImageOf::default();
                lowrank::attempt(meter, tiles, &parts, vol, start, of_probes, of).await?
            }
            Some(axis) => {
                let view = CubeView { meter, tiles, parts: &parts, vol };
                let first = first.as_ref();
                let first = first.filter(|first| first.is_of_lattice && first.hits.is_empty());
                cube::of_products(&view, axis, first, of_probes, start).await?
            }
        };
        if !attempted.functions_suffice {
            // From nothing, as without a mesh.
            start = None;
            division = self::division(meter, tiles, axis, vol).await?;
            continue;
        }
        if attempted.prefers_faces {
            division.is_by_faces = true;
            continue;
        }
        if !attempted.depths.is_empty() {
            seen = parts.seen_charts();
            probed = attempted.probed;
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
                kinks.filter_map(|kink| atlas.cut(kink.chart, &kink.window, kink.v)).collect();
            if !cuts.is_empty() {
                division.cuts = cuts;
                continue;
            }
        }
        if attempted.prefers_halves && !has_tried_halves {
            (division.is_halved, has_tried_halves) = (true, true);
            continue;
        }
        // The trees of whole charts need fewer evaluations than those of halves.
        if *is_halved && start.is_none() && !attempted.found.as_ref().is_some_and(is_complete) {
            division.is_halved = false;
            continue;
        }
        // Products of whole lines of sight need fewer evaluations than those of their layers.
        let is_first = layered_from.is_none() && start.is_none();
        if is_first && !attempted.found.as_ref().is_some_and(is_complete) {
            let jumps = attempted.has_jump;
            let from = if jumps { 0.0 } else { TUNING.view.least_cosine_of_kinks };
            if layered_parts(tiles, None, from).is_some() {
                division.layered_from = Some(from);
                // Its points were of other parts.
                first = first.filter(|first| first.hits.is_empty());
                unfinished = attempted.found.take();
                continue;
            }
        }
        if let Some(lines) = lines.take_if(|_| !attempted.found.as_ref().is_some_and(is_complete))
            && let Some(made) = lines.render().await?
        {
            return Ok(with_share_of_allowed(made, vol));
        }
        attempted.found = attempted.found.or(unfinished);
        if let Some(wanted) = meter.rows_wanted()
            && !attempted.found.as_ref().is_some_and(is_complete)
        {
            return Err(wanted.refused(
                "its emission rate has no low-rank approximation within the tolerance and the budget",
            ));
        }
        let functions = core::mem::take(&mut attempted.functions);
        let cube = attempted.cube_start.take();
        let trees = start.and_then(|start| start.trees.as_deref());
        let before = BeforeTrees { start: trees, first, is_searched: false };
        let mut made = finish(meter, tiles, &parts, axis, vol, attempted, before).await?;
        made.stretch = division.stretch;
        if let Some(frozen) = made.frozen.as_mut().and_then(Arc::get_mut) {
            let trees = frozen.structure.take().and_then(|of| of.of_method().map(Arc::clone));
            let start = Start { division, functions, trees, cube };
            let has_products = start.has_functions();
            frozen.structure = Some(Structure::new(start, has_products));
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

fn has_fixed_mesh(meter: &Meter) -> bool {
    meter.start().is_some_and(|start| start.is_fixed)
}

/// The start, if it serves a view of so many parts. A mesh that is fixed has to, within the budget; a budget
/// that does not suffice for the points of another one is spent without it.
fn serving<'a>(
    start: Option<&'a Start>,
    division: &Division,
    parts: usize,
    axis: Option<&EnergyAxis>,
    meter: &Meter,
) -> Result<Option<&'a Start>, MethodError> {
    let serves = |start: &&Start| start.division == *division && start.serves(parts, axis);
    let start = start.filter(serves);
    let allowed = meter.evaluations_left();
    if has_fixed_mesh(meter) {
        lowrank::check_budget(start.ok_or(OptionError::FixedMesh)?, allowed)?;
        return Ok(start);
    }
    let is_affordable =
        |start: &&Start| start.trees.is_none() || lowrank::check_budget(start, allowed).is_ok();
    Ok(start.filter(is_affordable))
}

/// How a view is divided before its search for products.
async fn division(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<Division, MethodError> {
    let energies = some_energies(axis);
    let edges = edges(meter, tiles, &energies, vol).await?;
    let may_be_by_faces = atlas(tiles, &edges).is_none() && atlas_of_box(tiles).is_some();
    let is_by_faces = may_be_by_faces
        && match (axis, tiles) {
            // The first samples of the search for products decide.
            (None, [_]) => false,
            (Some(_), [tile]) => {
                match reaches_faces_at(meter, tile, &energies, vol.tolerance).await {
                    Ok(reaches) => reaches,
                    Err(Stop::Budget) => false,
                    Err(Stop::Failed(error)) => return Err(error),
                }
            }
            // Tiles have no products, but charts may.
            _ => true,
        };
    Ok(Division { edges, is_by_faces, ..Division::default() })
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

fn is_complete(found: &MethodOutput) -> bool {
    matches!(found.ending, StopReason::Complete | StopReason::FixedMesh)
}

/// The image of products, of surfaces, or of trees of the parts that have none.
async fn finish(
    meter: &Meter,
    tiles: &[Tile<'_>],
    parts: &Parts<'_>,
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
    mut attempted: Attempted,
    mut before: BeforeTrees<'_>,
) -> Result<MethodOutput, MethodError> {
    let mut products = attempted.found.take();
    let has_image = products.as_ref().is_some_and(is_complete);
    // Where there are trees to begin with, no surfaces were found before.
    if before.start.is_none() && axis.is_none() {
        let known = &mut attempted.known;
        let has_jump = !has_image
            && (attempted.has_jump
                || surfaces::look_beside_few(meter, tiles, parts, vol, known).await?);
        if has_jump && let Some(found) = surfaces::render(meter, tiles, parts, vol, known).await? {
            return Ok(found);
        }
        if meter.start().is_none() && meter.rows_wanted().is_none() {
            // Points that no search has kept.
            [known.hits, known.beside] = surfaces::few_of_all(meter);
        }
        if !known.hits.is_empty()
            && surfaces::look_beside_few(meter, tiles, parts, vol, known).await?
        {
            if let Some(found) = surfaces::render(meter, tiles, parts, vol, known).await? {
                return Ok(found);
            }
            if has_image {
                // It has no jump.
                products = None;
                known.products.fill(None);
            }
        }
    }
    if let Some(products) = products.take_if(|products| is_complete(products)) {
        return Ok(products);
    }
    // The search for products has shown whether G jumps at the first energy.
    before.is_searched = attempted.of_first.is_some();
    if let (Some(axis), Some(first), Some(samples)) =
        (axis, &before.first, attempted.of_first.take())
        && attempted.has_jump
    {
        let (brightness, hits) = (Vec::new(), Vec::new());
        let first = FirstImage { energy: first.place, brightness, hits, samples };
        if let Some(found) = surfaces::render_cube(meter, tiles, parts, axis, &first, vol).await? {
            return Ok(found);
        }
    }
    let known = attempted.known;
    let tree = by_tree_or_surfaces(meter, tiles, parts, axis, vol, known, before);
    match (products, tree.await) {
        // The time limit was reached before lines gave an image. Products that have found nothing yet are none.
        (Some(products), Err(RenderError::Time { .. })) if products.cube.largest() > 0.0 => {
            Ok(products)
        }
        (products, tree) => {
            let tree = tree?;
            // If a limit ended both, the one with the smaller estimated error is used.
            let is_better =
                |products: &MethodOutput| products.estimated_error() < tree.estimated_error();
            Ok(products.filter(|p| !is_complete(&tree) && is_better(p)).unwrap_or(tree))
        }
    }
}

/// The image of trees; or of surfaces, if G jumps on the first lines of a view of several tiles or, for a cube, at the
/// first energy.
async fn by_tree_or_surfaces(
    meter: &Meter,
    tiles: &[Tile<'_>],
    parts: &Parts<'_>,
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
    known: KnownParts,
    before: BeforeTrees<'_>,
) -> Result<MethodOutput, MethodError> {
    let (start, is_searched) = (before.start, before.is_searched);
    let (mut known, mut is_tried) = (known, false);
    if axis.is_none() && start.is_none() && parts.parts.iter().any(Part::is_tile_of_several) {
        (is_tried, known) = surfaces::look(meter, tiles, parts, vol).await?;
        if is_tried
            && let Some(found) = surfaces::render(meter, tiles, parts, vol, &mut known).await?
        {
            return Ok(found);
        }
    }
    let mut trees = Trees::begin(meter, tiles, parts, axis, vol, known, before).await?;
    if let (Some(axis), Some(energy)) = (axis, trees.energy_of_jumps().filter(|_| !is_searched)) {
        let before = meter.evaluations();
        let (brightness, hits) = (trees.brightness(), trees.first_hits());
        let first = FirstImage { energy, brightness, hits, samples: Vec::new() };
        if let Some(found) = surfaces::render_cube(meter, tiles, parts, axis, &first, vol).await? {
            return Ok(found);
        }
        trees.leave_out(meter.evaluations() - before);
    }
    if axis.is_none() && tiles.len() > 1 && !is_tried && trees.have_jumps() {
        let before = meter.evaluations();
        let mut known = KnownParts::none(parts.parts.len());
        if let Some(found) = surfaces::render(meter, tiles, parts, vol, &mut known).await? {
            return Ok(found);
        }
        trees.leave_out(meter.evaluations() - before);
    }
    trees.finish().await
}

/// The places of the energy axis at which a view is sampled before it is divided: some of them have emission.
const FIRST_ENERGIES: [f64; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];

/// Energies at those places; one `None` without an axis.
fn some_energies(axis: Option<&EnergyAxis>) -> Vec<Option<f64>> {
    match axis {
        None => vec![None],
        Some(axis) => FIRST_ENERGIES.iter().map(|u| Some(axis.energy(*u))).collect(),
    }
}

/// The edges of the emission around the bodies in view; none if the budget is small.
async fn edges(
    meter: &Meter,
    tiles: &[Tile<'_>],
    energies: &[Option<f64>],
    vol: &VolOptions,
) -> Result<Vec<FoundEdge>, MethodError> {
    let Some(atlas) = atlas(tiles, &[]) else { return Ok(Vec::new()) };
    let most = energies.len() as u64 * cost_of_edges();
    if meter.evaluations_left() / TUNING.edges.least_budget < most {
        return Ok(Vec::new());
    }
    match find_edges(meter, &atlas, vol.tolerance, energies).await {
        Ok(found) => Ok(found),
        Err(Stop::Budget) => Ok(Vec::new()),
        Err(Stop::Failed(error)) => Err(error),
    }
}

#[cfg(test)]
mod tests;
