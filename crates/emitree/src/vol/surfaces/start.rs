//! The first samples: a lattice in which regions are found, and scattered points.

use crate::image::Image;
use crate::projection::Chart;
use crate::vol::lattice;
use crate::vol::lowrank::WeightedView;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::extent::{Extent, ROUNDS};
use crate::vol::surfaces::focus::CellBox;
use crate::vol::surfaces::octree::Grid;
use crate::vol::surfaces::regions::BaseLattice;
use crate::vol::surfaces::search::Failure;
use crate::vol::surfaces::sky::Sky;
use crate::vol::tuning::TUNING;
use crate::vol::view::part::Parts;

/// What surfaces are searched for.
pub(crate) struct Request<'a> {
    pub(crate) view: &'a WeightedView<'a>,
    /// 1 in the pixels of the image, and 0 where the projection has none.
    pub(crate) scale: &'a Image,
    pub(crate) tolerance: f64,
    /// The evaluations that may be made.
    pub(crate) most: u64,
    /// The first points of the scattered lattice have been sampled.
    pub(crate) known: &'a [f64],
    /// Other points of the chart at which g differs from most of the view, with G there.
    pub(crate) hits: &'a [([f64; 3], f64)],
    /// The scattered samples that features of a size in the options require.
    pub(crate) least_samples: usize,
    /// The parts of the view, if lines of sight may end at opaque bodies, or if a rim crosses pixels.
    pub(crate) limbs: Option<&'a Parts<'a>>,
    /// Places on the image plane whose lines of sight have radiances of their own.
    pub(crate) lines: Option<&'a [[f64; 2]]>,
    /// The lines of pixels, if the chart of the view is not the image plane.
    pub(crate) sky: Option<&'a Sky<'a>>,
    /// The image plane with its density of solid angle; without one, that is 1.
    pub(crate) plane: Option<&'a dyn Chart>,
}

/// The first samples of a search.
pub(super) struct Start {
    /// The lattice in which regions are found.
    pub(super) base: BaseLattice,
    /// The base lattice of the whole view, if that is a part of it.
    pub(super) whole: Option<BaseLattice>,
    /// The scattered samples in view.
    pub(super) scattered: Vec<([f64; 3], f64)>,
    /// About the largest pixel.
    pub(super) largest: f64,
    /// The number of evaluations, of the last lattice alone if there are several.
    pub(super) evaluations: u64,
}

impl Start {
    /// Samples a view. The first scattered samples are those of the request; all are in `rates` then.
    pub(super) async fn sample(
        request: &Request<'_>,
        grid: &Grid,
        aim: &Aim<'_>,
        most: u64,
        rates: &mut Vec<f64>,
    ) -> Result<Self, Failure> {
        let mut view = SeenView { request, grid, aim, left: most };
        let count = TUNING.surfaces.scattered.max(request.least_samples).max(rates.len());
        let points: Vec<[f64; 3]> = (0..count).map(lattice::point).collect();
        let missing = view.rates(&points[rates.len()..]).await?;
        rates.extend(missing.into_iter().map(|rate| rate.unwrap_or(0.0)));
        let of_lattice = points.into_iter().zip(rates.iter().copied());
        let mut scattered: Vec<([f64; 3], f64)> = of_lattice
            .chain(request.hits.iter().copied())
            .map(|(u, rate)| (grid.at_canonical(u), rate))
            .filter(|(at, _)| !aim.hides(grid, *at))
            .collect();
        let base = view.lattice(CellBox::whole(grid)).await?;
        let largest = largest_pixel(&base, grid, aim);
        let mut known = scattered.clone();
        known.extend(base.samples(grid));
        let mut start = Self { base, whole: None, scattered: Vec::new(), largest, evaluations: 0 };
        let part = match Extent::of_few(&known) {
            Some(extent) => view.around(extent).await?,
            None => CellBox::around_structure(grid, &known),
        };
        if let Some(part) = part {
            let finer = view.lattice(part).await?;
            start.largest = start.largest.max(largest_pixel(&finer, grid, aim));
            start.whole = Some(core::mem::replace(&mut start.base, finer));
            let count = TUNING.surfaces.scattered / 2;
            let points: Vec<[f64; 3]> =
                (0..count).map(|k| part.at(grid, lattice::point(k))).collect();
            let canonical: Vec<[f64; 3]> = points.iter().map(|at| grid.canonical(*at)).collect();
            let rates = view.rates(&canonical).await?;
            let of_point = points.into_iter().zip(rates);
            scattered.extend(of_point.filter_map(|(at, rate)| Some((at, rate?))));
        }
        start.scattered = scattered;
        start.evaluations = most - view.left;
        Ok(start)
    }

    /// Samples the first lattice again, with half the step.
    pub(super) async fn refine(
        &mut self,
        request: &Request<'_>,
        grid: &Grid,
        aim: &Aim<'_>,
        most: u64,
    ) -> Result<(), Failure> {
        let mut view = SeenView { request, grid, aim, left: most };
        self.base = view.lattice(self.base.cells.halved()).await?;
        self.largest = self.largest.max(largest_pixel(&self.base, grid, aim));
        self.evaluations = most - view.left;
        Ok(())
    }
}

/// A view with the evaluations that may be made.
struct SeenView<'a> {
    request: &'a Request<'a>,
    grid: &'a Grid,
    aim: &'a Aim<'a>,
    left: u64,
}

impl SeenView<'_> {
    /// G at those of canonical points that a line of sight reaches.
    async fn rates(&mut self, points: &[[f64; 3]]) -> Result<Vec<Option<f64>>, Failure> {
        let is_seen = |u: &[f64; 3]| !self.aim.hides(self.grid, self.grid.at_canonical(*u));
        let seen: Vec<[f64; 3]> = points.iter().copied().filter(|u| is_seen(u)).collect();
        let count = seen.len() as u64;
        if count > self.left {
            return Err(Failure::TooComplex);
        }
        self.left -= count;
        let mut rates = self.request.view.rates(&seen).await?.into_iter();
        Ok(points.iter().map(|u| is_seen(u).then(|| rates.next()).flatten()).collect())
    }

    /// The cells around a structure that few samples meet.
    async fn around(&mut self, mut extent: Extent) -> Result<Option<CellBox>, Failure> {
        for round in 0..ROUNDS {
            let of_start = |at: [f64; 3]| Extent::points(self.grid, at);
            let points: Vec<Vec<[f64; 3]>> =
                extent.starts(round).into_iter().map(of_start).collect();
            let canonical: Vec<[f64; 3]> =
                points.iter().flatten().map(|at| self.grid.canonical(*at)).collect();
            let rates = self.rates(&canonical).await?;
            let mut rates = &rates[..];
            for points in points {
                let (own, rest) = rates.split_at(points.len());
                extent.add(&points, own);
                rates = rest;
            }
        }
        Ok(CellBox::between(self.grid, extent.with_margin(self.grid)))
    }

    /// G at the corners of cells.
    async fn lattice(&mut self, cells: CellBox) -> Result<BaseLattice, Failure> {
        let empty = BaseLattice::new(cells, Vec::new());
        let point = |number: usize| self.grid.canonical(empty.point(self.grid, number));
        let points: Vec<[f64; 3]> = (0..empty.corners()).map(point).collect();
        Ok(BaseLattice::new(cells, self.rates(&points).await?))
    }
}

/// About the largest pixel, from the columns of a lattice.
fn largest_pixel(base: &BaseLattice, grid: &Grid, aim: &Aim<'_>) -> f64 {
    let [nx, ny, nz] = base.cells.cells.map(|k| k as usize);
    let depth = grid.cell_edges(base.cells.level)[2];
    let mut largest: f64 = 0.0;
    for x in 0..=nx {
        for y in 0..=ny {
            let of = |z: usize| base.rates[base.number([x, y, z])].unwrap_or(0.0);
            let [from_x, from_y, from] = base.cells.point(grid, [x, y, 0]);
            let [low, high] =
                aim.ends_of_line(grid, [from_x, from_y]).map(|end| (end - from) / depth);
            let seen = |z: usize| {
                let z = z as f64;
                (high.min(z + 1.0) - low.max(z)).max(0.0)
            };
            let sum: f64 = (0..nz).map(|z| 0.5 * seen(z) * (of(z) + of(z + 1))).sum();
            let effect = aim.effect([from_x / grid.edges[0], from_y / grid.edges[1]]);
            largest = largest.max((sum * depth / grid.edges[2] * effect).abs());
        }
    }
    largest
}
