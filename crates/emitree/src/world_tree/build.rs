//! Building a tree in the world, and the cost of the build.

use super::{WorldBox, WorldTree, WorldTreeError};
use crate::calls::Calls;
use crate::emission::Emission;
use crate::erased::{Erased, typed};
use crate::error::{OptionError, RenderError};
use crate::exchange::MethodError;
use crate::meter::{Limits, Meter};
use crate::options::{DEFAULT_MAX_EVALUATIONS, DEFAULT_MAX_MEMORY_BYTES};
use crate::progress::Progress;
use crate::projection::MappedPoint;
use crate::quadrature::{AsyncIntegrand, Points};
use crate::refinement::Threshold;
use crate::site::Mapping;
use crate::tree::{BuildOptions, GrownPoints, PointTree, StopReason};
use core::future::Future;
use core::pin::Pin;
use core::time::Duration;
use std::time::Instant;

/// Options of a tree in the world.
///
/// ```
/// use emitree::world_tree::WorldTreeOptions;
///
/// let options = WorldTreeOptions::new(1e-4).with_base_level(5).with_max_evaluations(1_000_000);
/// assert_eq!((options.tolerance, options.order), (1e-4, 5));
/// ```
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct WorldTreeOptions<'a> {
    /// The order p of prediction: 3, 5 or 7.
    pub order: usize,
    /// The base grid has 2^`base_level` cells along each edge of the box: 3 to 10. A structure that
    /// falls between the centres of cells half as wide is missed.
    pub base_level: u8,
    /// Details below this fraction of the largest |rate| are dropped: above 0 and below 1.
    pub tolerance: f64,
    /// Cells of this level are not split: where g jumps, refinement would not end by itself.
    pub finest_level: Option<u8>,
    /// The largest number of evaluations of g.
    pub max_evaluations: u64,
    /// The largest number of evaluations in one batch: a larger one is made in parts.
    pub batch_size: u64,
    /// The memory that the tree may take while it is built \[bytes\].
    pub max_memory_bytes: u64,
    /// Called after each call of g, from any thread, with the evaluations so far; may break.
    pub progress: Option<&'a Progress<'a>>,
}

impl Default for WorldTreeOptions<'_> {
    /// Order 5 on 16³ cells to 10⁻³, and no more evaluations than a rendering may make.
    fn default() -> Self {
        Self {
            order: 5,
            base_level: 4,
            tolerance: 1e-3,
            finest_level: None,
            max_evaluations: DEFAULT_MAX_EVALUATIONS,
            batch_size: u64::MAX,
            max_memory_bytes: DEFAULT_MAX_MEMORY_BYTES,
            progress: None,
        }
    }
}

impl<'a> WorldTreeOptions<'a> {
    /// Details below `tolerance` times the largest |rate| are dropped, above 0 and below 1; all else as
    /// by [default](Self::default).
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, ..Self::default() }
    }

    /// Sets the order p of the predictions: 3, 5 or 7.
    #[must_use]
    pub fn with_order(mut self, order: usize) -> Self {
        self.order = order;
        self
    }

    /// Sets the level of the base grid, which has 2^`base_level` cells along each edge of the box; 3
    /// to 10.
    #[must_use]
    pub fn with_base_level(mut self, base_level: u8) -> Self {
        self.base_level = base_level;
        self
    }

    /// Sets the level, above the base level, whose cells are not split; `None` for no such level.
    #[must_use]
    pub fn with_finest_level(mut self, level: impl Into<Option<u8>>) -> Self {
        self.finest_level = level.into();
        self
    }

    /// Sets the largest number of evaluations.
    #[must_use]
    pub fn with_max_evaluations(mut self, max_evaluations: u64) -> Self {
        self.max_evaluations = max_evaluations;
        self
    }

    /// Sets the largest number of evaluations in one batch, 1 or more.
    #[must_use]
    pub fn with_batch_size(mut self, batch_size: u64) -> Self {
        self.batch_size = batch_size;
        self
    }

    /// Sets the memory that the tree may take while it is built \[bytes\].
    #[must_use]
    pub fn with_max_memory_bytes(mut self, max_memory_bytes: u64) -> Self {
        self.max_memory_bytes = max_memory_bytes;
        self
    }

    /// Sets the callback after each call of g.
    #[must_use]
    pub fn with_progress(mut self, progress: &'a Progress<'a>) -> Self {
        self.progress = Some(progress);
        self
    }
}

impl core::fmt::Debug for WorldTreeOptions<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("WorldTreeOptions")
            .field("order", &self.order)
            .field("base_level", &self.base_level)
            .field("tolerance", &self.tolerance)
            .field("finest_level", &self.finest_level)
            .field("max_evaluations", &self.max_evaluations)
            .field("batch_size", &self.batch_size)
            .field("max_memory_bytes", &self.max_memory_bytes)
            .finish_non_exhaustive()
    }
}

/// A tree and the cost of its build.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct BuiltWorldTree {
    /// The tree.
    pub tree: WorldTree,
    /// How often g was evaluated, the check of directions included.
    pub evaluations: u64,
    /// The number of batches in which that was done: two for the check of directions, one for each
    /// level.
    pub batches: u64,
    /// What ended the build.
    pub ending: StopReason,
    /// The largest |rate| that was evaluated, in the unit of g.
    pub largest_rate: f64,
    /// The size below which details were dropped, in the unit of g.
    pub threshold: f64,
    /// The largest |detail| of cells that were not split, in the unit of g: what the last generation
    /// of cells has changed at their centres. Below the threshold, unless
    /// [`unresolved_cells`](Self::unresolved_cells) is above 0.
    pub largest_dropped: f64,
    /// The number of cells that should have been split, but for the finest level or the budget.
    pub unresolved_cells: u64,
    /// Time spent in g, for one of the threads.
    pub emission_time: Duration,
    /// Time spent altogether.
    pub total_time: Duration,
}

/// Unit vectors at no special angle to each other nor to the axes: g is evaluated towards the first.
const DIRECTIONS: [[f64; 3]; 2] = [[0.48, 0.6, 0.64], [-0.8, -0.36, 0.48]];
/// The check of directions is made at the centres of a grid of 8³ cells.
const CHECKED_LEVEL: u32 = 3;
const CHECKED_POINTS: u64 = 1 << (3 * CHECKED_LEVEL);
/// Rates that differ by less are taken for the same: sums in another order.
const ROUNDING: f64 = 1e-9;

/// Memory that one cell takes while a tree is built, at the most, with its share of the ghosts:
/// measured 47 to 78 bytes on trees of 10⁶ to 4·10⁶ cells, and rounded up.
const BYTES_PER_CELL: u64 = 128;

/// Builds the tree of `emission` in the box `bounds`, level by level, each level one batch.
///
/// First g is evaluated at 512 points towards two directions, since a tree can't hold a rate that
/// depends on the direction. Then each cell of the base grid is split, and each family whose details
/// reach the tolerance; see [the guarantees](super).
///
/// ```
/// use emitree::FromFn;
/// use emitree::world_tree::{WorldBox, WorldTreeError, WorldTreeOptions, build_world_tree};
///
/// let bounds = WorldBox::new([-1.0; 3], [1.0; 3])?;
/// let options = WorldTreeOptions::new(1e-4);
/// let ball = FromFn(|[x, y, z]: [f64; 3], _| (-9.0 * (x * x + y * y + z * z)).exp());
/// let built = build_world_tree(&ball, bounds, &options)?;
/// assert!(built.largest_dropped < 1e-4 * built.largest_rate);
///
/// let beam = FromFn(|_, [dx, _, _]: [f64; 3]| dx.max(0.0));
/// let refused = build_world_tree(&beam, bounds, &options);
/// assert!(matches!(refused, Err(WorldTreeError::Directional { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`WorldTreeError`]: options out of range, a budget below the base grid, an emission that failed,
/// is not finite somewhere or depends on the direction, a progress callback that broke off.
pub fn build_world_tree<E: Emission>(
    emission: &E,
    bounds: WorldBox,
    options: &WorldTreeOptions<'_>,
) -> Result<BuiltWorldTree, WorldTreeError<E::Error>> {
    let start = Instant::now();
    check(options)?;
    let affordable = options.max_memory_bytes / BYTES_PER_CELL;
    let max_evaluations = options.max_evaluations.min(affordable);
    let limits = Limits {
        max_evaluations,
        max_kept: u64::MAX,
        batch_size: options.batch_size,
        deadline: None,
        whole_batches: emission.takes_whole_batches(),
    };
    // There are no pixels that evaluations could be counted for.
    let meter = Meter::new([0, 0], limits, None, false);
    let build_options = BuildOptions {
        order: options.order,
        base_level: options.base_level,
        threshold: Threshold::Relative(options.tolerance),
        finest_level: options.finest_level,
        ..BuildOptions::default()
    };
    let mut method = grow(&meter, bounds, &build_options);
    let grown = Calls::new(&Erased(emission), &meter, options.progress)
        .drive(method.as_mut())
        .map_err(typed)?;
    let grown = grown.map_err(|Directional { position, rates }| WorldTreeError::Directional {
        position,
        directions: DIRECTIONS,
        rates,
    })?;
    let GrownPoints { tree: points, threshold, ending, .. } = grown;
    Ok(BuiltWorldTree {
        tree: WorldTree { bounds, points },
        evaluations: meter.evaluations(),
        batches: meter.batches(),
        ending,
        largest_rate: grown.largest,
        threshold,
        largest_dropped: grown.largest_dropped,
        unresolved_cells: grown.unresolved_cells,
        emission_time: meter.emission_time(),
        total_time: start.elapsed(),
    })
}

/// A tree in progress, which waits for rates.
type Growing<'a> =
    Pin<Box<dyn Future<Output = Result<Result<GrownPoints, Directional>, MethodError>> + 'a>>;

/// Boxed: compiled here, once, and not for each emission.
fn grow<'a>(meter: &'a Meter, bounds: WorldBox, options: &'a BuildOptions) -> Growing<'a> {
    Box::pin(async move {
        match directional(meter, bounds).await? {
            Some(directional) => Ok(Err(directional)),
            None => Ok(Ok(PointTree::grow(&Rates { meter, bounds }, options).await?)),
        }
    })
}

/// g alone on the unit cube of the box.
struct Rates<'a> {
    meter: &'a Meter,
    bounds: WorldBox,
}

/// g at points of the unit cube of a box, towards one of the two directions.
async fn evaluate(
    meter: &Meter,
    bounds: WorldBox,
    direction: [f64; 3],
    points: Points<'_, 3>,
    rates: &mut [f64],
) -> Result<(), MethodError> {
    let map = |u| {
        let position = bounds.world_from_unit(u);
        MappedPoint { position, direction, path_per_depth: 1.0 }
    };
    meter.evaluate(points, Mapping { map: &map, tile: (0, 1), energy: None }, rates).await
}

impl AsyncIntegrand<3> for Rates<'_> {
    type Error = MethodError;

    async fn evaluate(&self, points: Points<'_, 3>, values: &mut [f64]) -> Result<(), MethodError> {
        evaluate(self.meter, self.bounds, DIRECTIONS[0], points, values).await
    }

    fn evaluations_left(&self) -> u64 {
        self.meter.evaluations_left()
    }

    fn is_out_of_time(_: &MethodError) -> bool {
        false // There is no limit on the time.
    }
}

/// Refuses options out of range, and limits below the base grid.
fn check<E>(options: &WorldTreeOptions<'_>) -> Result<(), RenderError<E>> {
    let WorldTreeOptions { order, base_level, tolerance, batch_size, .. } = *options;
    if !PointTree::ORDERS.contains(&order) {
        return Err(OptionError::WorldTreeOrder(order).into());
    }
    let deepest = BuildOptions::deepest_base_level::<3>();
    if !(PointTree::LEAST_BASE_LEVEL..=deepest).contains(&base_level) {
        return Err(OptionError::WorldTreeBaseLevel(base_level).into());
    }
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(OptionError::Tolerance(tolerance).into());
    }
    if batch_size == 0 {
        return Err(OptionError::BatchSize(0).into());
    }
    let base_cells = 1_u64 << (3 * base_level);
    let memory = base_cells * BYTES_PER_CELL;
    if memory > options.max_memory_bytes {
        return Err(RenderError::TooLarge {
            what: format!("a base grid of level {base_level}"),
            needed: memory,
            allowed: options.max_memory_bytes,
        });
    }
    let needed = base_cells + 2 * CHECKED_POINTS;
    let allowed = options.max_evaluations.min(options.max_memory_bytes / BYTES_PER_CELL);
    if needed > allowed {
        let what = format!("the base grid of level {base_level} with the check of directions");
        return Err(RenderError::Budget { what, needed, allowed });
    }
    Ok(())
}

/// A point at which the rates towards the two directions differ.
struct Directional {
    position: [f64; 3],
    rates: [f64; 2],
}

/// Evaluates g towards both directions at a few points: the first at which it differs, if there is one.
async fn directional(meter: &Meter, bounds: WorldBox) -> Result<Option<Directional>, MethodError> {
    let cells = 1 << CHECKED_LEVEL;
    let centre = |i: usize| {
        let cell = [i % cells, i / cells % cells, i / (cells * cells)];
        cell.map(|p| (p as f64 + 0.5) / cells as f64)
    };
    let points = Points::new(cells * cells * cells, &centre);
    let mut rates = [vec![0.0; points.len()], vec![0.0; points.len()]];
    for (direction, rates) in DIRECTIONS.into_iter().zip(&mut rates) {
        evaluate(meter, bounds, direction, points, rates).await?;
    }
    let [ours, theirs] = rates;
    let mut both = ours.iter().copied().zip(theirs.iter().copied());
    let differ = both.position(|(a, b)| (a - b).abs() > ROUNDING * a.abs().max(b.abs()));
    Ok(differ.map(|i| Directional {
        position: bounds.world_from_unit(centre(i)),
        rates: [ours[i], theirs[i]],
    }))
}
