//! The attempt: surfaces, pieces and the image, with a verification.

use crate::found_surfaces::FoundSurfaces;
use crate::image::Image;
use crate::line_values::LineValues;
use crate::projection::vector::{difference, norm};
use crate::vol::lattice;
use crate::vol::lowrank::WeightedView;
use crate::vol::sampling::Stop;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::found::found_surfaces;
use crate::vol::surfaces::model::Model;
use crate::vol::surfaces::octree::{Cell, Grid, HIDDEN};
use crate::vol::surfaces::pixel::KnownLines;
use crate::vol::surfaces::raster::Maps;
use crate::vol::surfaces::samples::Samples;
use crate::vol::surfaces::search::{Failure, Reason, Search, of_tolerance};
use crate::vol::surfaces::start::{Request, Start};
use crate::vol::surfaces::visible::Visible;
use crate::vol::tuning::TUNING;

/// The most corners of a lattice that is refined, which has eight times as many then.
const MOST_REFINED: usize = 1024;

/// The image of surfaces and the pieces beside them.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) image: Image,
    pub(crate) error: Image,
    /// The number of scattered samples.
    pub(crate) samples: usize,
    pub(crate) surfaces: FoundSurfaces,
    /// The radiances of the lines that the request names.
    pub(crate) lines: Option<LineValues>,
}

/// Searches for surfaces. Returns the image if it is within the tolerance, and all scattered samples.
pub(crate) async fn attempt(request: &Request<'_>) -> Result<(Option<Found>, Vec<f64>), Stop> {
    let mut rates = request.known.to_vec();
    match find(request, &mut rates).await {
        Ok(found) => Ok((found, rates)),
        Err(failure) => failure.given_up().map(|()| (None, rates)),
    }
}

async fn find(request: &Request<'_>, rates: &mut Vec<f64>) -> Result<Option<Found>, Failure> {
    let Some(Located { mut search, model, maps }) = locate(request, rates).await? else {
        return Ok(None);
    };
    let Maps { image, error } = maps;
    let chart = &*request.view.part.chart;
    let surfaces = found_surfaces(chart, &model, &search.aim);
    let lines = match request.lines {
        Some(places) => Some(search.lines(&model, places).await?),
        None => None,
    };
    Ok(Some(Found { image, error, samples: rates.len(), surfaces, lines }))
}

/// The surfaces of a view, with the search that has found them and the image within the tolerance.
pub(super) struct Located<'a> {
    pub(super) search: Search<'a>,
    pub(super) model: Model,
    pub(super) maps: Maps,
}

/// Searches for surfaces, until the image of them and the pieces beside them is verified to the tolerance;
/// `None` if that fails. All scattered samples are in `rates` then. If a search has too many regions, or one in which G
/// jumps, it is repeated from a finer lattice: corners that are further apart than a shell is thick meet it at places that
/// nothing connects, and none may be in a small cavity.
pub(super) async fn locate<'a>(
    request: &Request<'a>,
    rates: &mut Vec<f64>,
) -> Result<Option<Located<'a>>, Failure> {
    let tolerance = request.tolerance;
    let mut grid = grid(request.view, tolerance);
    let mut left = of_tolerance(TUNING.surfaces.most_evaluations, tolerance).min(request.most);
    let levels = grid.finest;
    let visible = request.limbs.map(|parts| Visible::new(&*request.view.part.chart, parts));
    let (scale, sky, plane) = (request.scale, request.sky, request.plane);
    let mut aim = Aim { target: 0.0, scale, visible, sky, plane };
    let mut start = Start::sample(request, &grid, &aim, left, rates).await?;
    if !(start.largest > 0.0 && start.largest.is_finite()) {
        return Err(Failure::TooComplex);
    }
    loop {
        left -= start.evaluations;
        aim.target = tolerance * start.largest;
        // Beside a small shape cells become as small, relative to it, as beside one that fills the view.
        grid.finest = levels + start.base.cells.level;
        let negligible = TUNING.surfaces.negligible * aim.target / request.scale.largest();
        let samples = Samples::new(0.25 * grid.cell_size(0), negligible);
        let mut search = Search::new(request.view, grid, aim, tolerance, samples, left);
        let can_be_finer = start.base.corners() <= MOST_REFINED;
        search.can_be_finer = can_be_finer;
        match search.converge(&start).await {
            Ok(found) => {
                return Ok(found.map(|(model, maps)| Located { search, model, maps }));
            }
            Err(Failure::TooManyRegions | Failure::JumpInRegion) if can_be_finer => {
                Search { aim, left, .. } = search;
                start.refine(request, &grid, &aim, left).await?;
            }
            Err(failure) => return Err(failure),
        }
    }
}

impl Search<'_> {
    /// Divides the view into leaves, and improves these until the image is verified; `None` if that fails.
    async fn converge(&mut self, start: &Start) -> Result<Option<(Model, Maps)>, Failure> {
        let Start { base, whole, scattered, .. } = start;
        self.find_regions(base.clone(), whole.as_ref(), scattered).await?;
        self.run().await?;
        match self.improve_leaves().await {
            // What belongs to no region beside all the leaves is structure, which a finer lattice does not resolve.
            Err(Failure::TooManyRegions) => Err(Failure::TooComplex),
            found => found,
        }
    }

    /// Improves the leaves until the image is verified; `None` if that fails.
    async fn improve_leaves(&mut self) -> Result<Option<(Model, Maps)>, Failure> {
        let (mut rounds, mut improvements) = (0, 0);
        let mut lines = KnownLines::default();
        loop {
            let model = model(self).await?;
            let maps = model.maps(&self.aim, self.tolerance, &mut lines);
            self.aim.target = self.tolerance * maps.image.largest();
            if maps.error.largest() > TUNING.surfaces.accepted_share * self.aim.target {
                if improvements == TUNING.surfaces.improvements
                    || !improve(self, &model, &maps, improvements).await?
                {
                    return Ok(None);
                }
                improvements += 1;
                continue;
            }
            let verdict = self.verify(&model, &maps, rounds).await?;
            rounds += 1;
            if verdict.has_passed {
                return Ok(Some((model, maps)));
            }
            if rounds == TUNING.surfaces.verifications {
                return Ok(None);
            }
            self.divide(&verdict.wrong, Reason::Wrong).await?;
        }
    }
}

/// Refines the leaves on the lines of the pixels with the largest errors. Returns whether there are any.
async fn improve(
    search: &mut Search<'_>,
    model: &Model,
    maps: &Maps,
    number: usize,
) -> Result<bool, Failure> {
    let grid = search.grid;
    let finer = TUNING.surfaces.improved_step.powf(number as f64);
    let least = TUNING.surfaces.improved_first * finer;
    let leaves = model.leaves_to_improve(&search.aim, maps, least, number);
    let cells = leaves.iter().map(|leaf| model.tree.leaves[*leaf].0);
    let cells: Vec<Cell> = cells.filter(|(level, _)| *level < grid.finest).collect();
    let share = TUNING.surfaces.improved_share.powf((number + 1) as f64);
    search.divide(&cells, Reason::Inaccurate(share)).await?;
    Ok(!cells.is_empty())
}

/// The surfaces with the pieces beside them. Cells in which a piece finds values of other regions are divided.
async fn model(search: &mut Search<'_>) -> Result<Model, Failure> {
    for _ in 0..TUNING.surfaces.rounds {
        match pieces(search).await? {
            Ok(model) => return Ok(model),
            Err(wrong) => search.divide(&wrong, Reason::Wrong).await?,
        }
    }
    Err(Failure::TooComplex)
}

/// The pieces of all regions; or the cells that are wrong.
async fn pieces(search: &mut Search<'_>) -> Result<Result<Model, Vec<Cell>>, Failure> {
    let tree = search.octree();
    let mut labels: Vec<u16> = (0..search.samples.len()).map(|i| search.samples.label(i)).collect();
    labels.sort_unstable();
    labels.dedup();
    labels.retain(|label| *label != HIDDEN);
    let mut pieces = Vec::new();
    for label in labels {
        pieces.resize_with(usize::from(label), || None);
        match search.pieces(&tree, label).await? {
            Ok(of_label) => pieces.push(Some(of_label)),
            Err(wrong) => return Ok(Err(wrong)),
        }
    }
    Ok(Ok(Model { tree, pieces }))
}

/// Cells that are about cubes in the world.
fn grid(view: &WeightedView<'_>, tolerance: f64) -> Grid {
    const POINTS: usize = 64;
    const STEP: f64 = 1e-3;
    let mut lengths = [0.0; 3];
    let mut count = 0.0;
    for k in 0..POINTS {
        let u = lattice::point(k).map(|along| along.clamp(STEP, 1.0 - STEP));
        let along = |axis: usize| {
            let ends = [-STEP, STEP].map(|step| {
                let mut at = u;
                at[axis] += step;
                view.part.chart.world_from_chart(at).position
            });
            norm(difference(ends[1], ends[0])) / (2.0 * STEP)
        };
        let of_point = [0, 1, 2].map(along);
        if of_point.iter().all(|length| *length > 0.0 && length.is_finite()) {
            count += 1.0;
            for (length, of_point) in lengths.iter_mut().zip(of_point) {
                *length += of_point.ln();
            }
        }
    }
    let lengths = lengths.map(|sum: f64| (sum / f64::max(count, 1.0)).exp());
    let size = (lengths.iter().product::<f64>() / TUNING.surfaces.base_cells).cbrt();
    // Powers of two, so that places are exact.
    let base = lengths.map(|length| {
        let level = (length / size).log2().round().clamp(1.0, 6.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 6")]
        let level = level as u32;
        1_u32 << level
    });
    let longest = lengths.iter().fold(0.0_f64, |a, b| a.max(*b));
    let edges = lengths.map(|length| length / longest);
    let is_fine = tolerance < TUNING.surfaces.fine_below;
    let finest = if is_fine { TUNING.surfaces.fine_levels } else { TUNING.surfaces.levels };
    Grid { edges, base, finest }
}

#[cfg(test)]
mod tests;
