//! Building a tree, top down: the one loop that evaluates the function (the paper's section 2.1).

use super::SparseTree;
use super::level::{LEAF, Level};
use super::points::PointPredictor;
use crate::cell::{CellIndex, to_u32};
use crate::parallel::prelude::*;
use crate::polling::at_once;
use crate::prediction::{OrderError, Predictor};
use crate::quadrature::{AsyncIntegrand, Averager, CellRule, Immediate, Integrand};
use crate::refinement::{Threshold, detail_size};

/// How a tree is built: the options of method [`Paper`](crate::Method::Paper).
///
/// ```
/// use emitree::refinement::Threshold;
/// use emitree::tree::BuildOptions;
///
/// let options = BuildOptions::new(Threshold::Relative(1e-4)).with_order(5).with_finest_level(7);
/// assert_eq!((options.order, options.base_level, options.finest_level), (5, 3, Some(7)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BuildOptions {
    /// The order p of the prediction: 1, 3, 5, 7 or 9.
    pub order: usize,
    /// The base grid has 2^`base_level` cells along each axis.
    pub base_level: u8,
    /// How cell averages are made from evaluations.
    pub rule: CellRule,
    /// Details below this are dropped.
    pub threshold: Threshold,
    /// Cells of this level are not split, however large their details: where g jumps, refinement
    /// would not end by itself.
    pub finest_level: Option<u8>,
}

impl Default for BuildOptions {
    /// The paper's choices: quadratic prediction on 8^D cells, midpoint rule; threshold 1 %.
    fn default() -> Self {
        Self {
            order: 3,
            base_level: 3,
            rule: CellRule::Midpoint,
            threshold: Threshold::Relative(0.01),
            finest_level: None,
        }
    }
}

/// A tree, and why its build ended.
#[derive(Clone, Debug)]
pub struct Built<const D: usize> {
    /// The tree.
    pub tree: SparseTree<D>,
    /// The tree without its last generation: without the families that have no children.
    ///
    /// The change by the last generation estimates that by the next one.
    pub previous: SparseTree<D>,
    /// The threshold that the last step used, in the units of the function.
    pub threshold: f64,
    /// Why the build ended.
    pub ending: StopReason,
}

/// Why a build, or a rendering, ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StopReason {
    /// The stopping criterion was met.
    Complete,
    /// The limit on evaluations, or on memory, was reached.
    Budget,
    /// The time limit was reached.
    Time,
    /// A cell of the maximum level would have had to be split.
    MaxLevel,
    /// The functions of a mesh do not suffice, and none may be added.
    FixedMesh,
    /// It has not ended yet.
    Unfinished,
}

/// A tree that can't be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError<E> {
    /// The order of the prediction does not exist.
    #[error(transparent)]
    Order(#[from] OrderError),
    /// The base level is out of range.
    #[error("`base_level` is {level}: expected 1 to {deepest}")]
    BaseLevel {
        /// The level given.
        level: u8,
        /// The deepest base level that this dimension can have.
        deepest: u8,
    },
    /// The finest level is not finer than the base level, or finer than the deepest one.
    #[error("`finest_level` is {level}: expected {} to {deepest}", .base_level + 1)]
    FinestLevel {
        /// The level given.
        level: u8,
        /// The base level: each of its cells is split.
        base_level: u8,
        /// The deepest level that this dimension can have.
        deepest: u8,
    },
    /// The threshold is not a size.
    #[error("`threshold` is {0}: expected a number above 0")]
    Threshold(f64),
    /// The evaluations allowed do not even fill the base grid.
    #[error("{left} evaluations are allowed, but the base grid of level {level} needs {needed}")]
    BudgetBelowBase {
        /// The number that the base grid needs.
        needed: u64,
        /// The number that is allowed.
        left: u64,
        /// The base level.
        level: u8,
    },
    /// The function could not be evaluated.
    #[error(transparent)]
    Integrand(E),
}

impl BuildOptions {
    /// Details below `threshold` are dropped; all else as by [default](Self::default).
    pub fn new(threshold: Threshold) -> Self {
        Self { threshold, ..Self::default() }
    }

    /// Sets the order p of the predictions: 1, 3, 5, 7 or 9.
    #[must_use]
    pub fn with_order(mut self, order: usize) -> Self {
        self.order = order;
        self
    }

    /// Sets the level of the base grid, which has 2^`base_level` cells along each axis; 1 to
    /// [`deepest_base_level`](Self::deepest_base_level).
    #[must_use]
    pub fn with_base_level(mut self, base_level: u8) -> Self {
        self.base_level = base_level;
        self
    }

    /// Sets the rule for the averages of cells.
    #[must_use]
    pub fn with_rule(mut self, rule: CellRule) -> Self {
        self.rule = rule;
        self
    }

    /// Sets the level, above the base level, whose cells are not split; `None` for no such level.
    #[must_use]
    pub fn with_finest_level(mut self, level: impl Into<Option<u8>>) -> Self {
        self.finest_level = level.into();
        self
    }

    /// The number of cells of the base grid in D dimensions, saturating.
    pub fn base_cells<const D: usize>(&self) -> u64 {
        let doublings = D * usize::from(self.base_level);
        if doublings < 64 { 1 << doublings } else { u64::MAX }
    }

    /// The deepest base level in D dimensions: cells of one level are counted in 32 bits.
    pub fn deepest_base_level<const D: usize>() -> u8 {
        let fits = |level: &u8| usize::from(*level) * D <= 31;
        (1..=CellIndex::<D>::MAX_LEVEL).rev().find(fits).unwrap_or(1)
    }

    fn check<const D: usize, E>(&self) -> Result<Predictor, BuildError<E>> {
        let predictor = Predictor::new(self.order)?;
        let deepest = Self::deepest_base_level::<D>();
        if !(1..=deepest).contains(&self.base_level) {
            return Err(BuildError::BaseLevel { level: self.base_level, deepest });
        }
        if let Some(level) = self.finest_level
            && !(self.base_level + 1..=CellIndex::<D>::MAX_LEVEL).contains(&level)
        {
            let (base_level, deepest) = (self.base_level, CellIndex::<D>::MAX_LEVEL);
            return Err(BuildError::FinestLevel { level, base_level, deepest });
        }
        let (Threshold::Absolute(threshold) | Threshold::Relative(threshold)) = self.threshold;
        if !(threshold > 0.0 && threshold.is_finite()) {
            return Err(BuildError::Threshold(threshold));
        }
        Ok(predictor)
    }
}

/// Builds the tree of `integrand` on the unit cube, level by level.
///
/// Every base cell is split. A family whose details (actual minus predicted averages) are all below
/// the threshold stays as it is; otherwise each of its cells is split in turn. Each level is one
/// batch. Where the evaluations left do not suffice for a level, the cells with the largest details
/// are split and the build ends.
///
/// ```
/// use emitree::quadrature::Pointwise;
/// use emitree::tree::{BuildOptions, build};
///
/// let plane = Pointwise(|[x, y]: [f64; 2]| x + y);
/// let built = build(&plane, [false; 2], &BuildOptions::default())?;
/// // Prediction is exact for a plane: the base cells are split once, and no further.
/// assert_eq!(built.tree.leaves_per_level(), [0, 0, 0, 0, 256]);
/// assert!((built.tree.integral() - 1.0).abs() < 1e-14);
/// # Ok::<(), emitree::tree::BuildError<std::convert::Infallible>>(())
/// ```
///
/// # Errors
///
/// [`BuildError`] for options out of range, a budget below the base grid, or an evaluation that
/// failed.
pub fn build<const D: usize, I: Integrand<D>>(
    integrand: &I,
    periodic: [bool; D],
    options: &BuildOptions,
) -> Result<Built<D>, BuildError<I::Error>> {
    at_once(build_async(&Immediate(integrand), periodic, options))
}

/// [`build()`] for a function that has to be waited for.
pub(crate) async fn build_async<const D: usize, I: AsyncIntegrand<D>>(
    integrand: &I,
    periodic: [bool; D],
    options: &BuildOptions,
) -> Result<Built<D>, BuildError<I::Error>> {
    let Grown { mut tree, threshold, ending } = grow(integrand, periodic, options, None).await?;
    let previous = tree.without_last_generation();
    tree.restrict();
    tree.update_details();
    Ok(Built { tree, previous, threshold, ending })
}

/// A tree as the loop leaves it: every number is the one that was evaluated.
pub(super) struct Grown<const D: usize> {
    pub(super) tree: SparseTree<D>,
    /// The threshold that the last step used.
    pub(super) threshold: f64,
    pub(super) ending: StopReason,
}

/// The loop of [`build()`]; the numbers are cell averages, or values at the centres of the cells if
/// there is a prediction of `points`.
pub(super) async fn grow<const D: usize, I: AsyncIntegrand<D>>(
    integrand: &I,
    periodic: [bool; D],
    options: &BuildOptions,
    points: Option<PointPredictor>,
) -> Result<Grown<D>, BuildError<I::Error>> {
    let predictor = options.check::<D, I::Error>()?;
    let mut averager = Averager::new(options.rule, periodic);

    let mut base = Level::base(options.base_level);
    let Level { level, families, averages, .. } = &mut base;
    let (needed, left) = (averager.cost(*level, families), integrand.evaluations_left());
    if needed > left {
        return Err(BuildError::BudgetBelowBase { needed, left, level: *level });
    }
    averager.average(*level, families, averages, integrand).await.map_err(BuildError::Integrand)?;
    let mut largest = detail_size(averages);

    let mut split: Vec<u32> = (0..to_u32(base.own_cells())).collect();
    let mut tree = SparseTree { predictor, points, periodic, levels: vec![base] };
    let mut ending = StopReason::Complete;
    while !split.is_empty() {
        let parents = &tree.levels[tree.levels.len() - 1];
        if Some(parents.level) == options.finest_level {
            break;
        }
        if parents.level == CellIndex::<D>::MAX_LEVEL {
            ending = StopReason::MaxLevel;
            break;
        }
        let mut families = parents.positions(&split);
        if averager.cost(parents.level + 1, &families) > integrand.evaluations_left() {
            ending = StopReason::Budget;
            let affordable = integrand.evaluations_left() / averager.family_cost();
            parents.keep_largest(&mut split, usize::try_from(affordable).unwrap_or(usize::MAX));
            if split.is_empty() {
                break;
            }
            families = parents.positions(&split);
        }
        tree.add_level(core::mem::take(&mut split), families);
        let last = tree.levels.len() - 1;
        let Level { level, families, averages, own, .. } = &mut tree.levels[last];
        match averager.average(*level, &families[..*own], averages, integrand).await {
            Err(error) if I::is_out_of_time(&error) => {
                ending = StopReason::Time;
                tree.drop_finest_level();
                break;
            }
            result => result.map_err(BuildError::Integrand)?,
        }
        largest = largest.max(detail_size(averages));
        tree.set_details(last);
        if ending == StopReason::Complete {
            split = tree.levels[last].cells_to_split(options.threshold.absolute(largest));
        }
    }
    Ok(Grown { tree, threshold: options.threshold.absolute(largest), ending })
}

impl<const D: usize> Level<D> {
    /// The positions of cells.
    fn positions(&self, cells: &[u32]) -> Vec<[u32; D]> {
        cells.par_iter().map(|&cell| self.cell_position(cell as usize)).collect()
    }

    /// Keeps, of the cells to be split, at most `count`, those of the families with the largest
    /// details; their order stays. The base grid has no details to choose by: none of it is kept.
    fn keep_largest(&self, split: &mut Vec<u32>, count: usize) {
        if self.is_base() {
            split.clear();
            return;
        }
        let size = |cell: u32| {
            let family = cell as usize / Self::SIBLINGS;
            detail_size(&self.details[family * Self::SIBLINGS..][..Self::SIBLINGS])
        };
        if count >= split.len() {
            return;
        }
        let mut sized: Vec<(f64, u32)> = split.par_iter().map(|&cell| (size(cell), cell)).collect();
        // Of equal sizes the first in the order of cells.
        sized.select_nth_unstable_by(count, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        split.clear();
        split.extend(sized[..count].iter().map(|&(_, cell)| cell));
        split.sort_unstable();
    }

    /// The cells of families that have a detail of `threshold` or more.
    fn cells_to_split(&self, threshold: f64) -> Vec<u32> {
        let significant = |family: &usize| {
            let details = &self.details[family * Self::SIBLINGS..][..Self::SIBLINGS];
            // Where all is dark the threshold is 0, and so is every detail.
            let size = detail_size(details);
            size > 0.0 && size >= threshold
        };
        let families: Vec<usize> = (0..self.own).into_par_iter().filter(significant).collect();
        let cells = |family: usize| family * Self::SIBLINGS..(family + 1) * Self::SIBLINGS;
        families.into_iter().flat_map(cells).map(to_u32).collect()
    }
}

impl<const D: usize> SparseTree<D> {
    /// Adds a level with the families of the cells `split` of the finest one, which are at these
    /// positions, averages still 0, and the ghosts that their prediction needs.
    pub(super) fn add_level(&mut self, split: Vec<u32>, families: Vec<[u32; D]>) {
        let depth = self.levels.len() - 1;
        let parents = &mut self.levels[depth];
        for (family, &cell) in split.iter().enumerate() {
            parents.children[cell as usize] = to_u32(family);
        }
        let level = parents.level + 1;
        self.complete(depth, &families);
        self.levels.push(Level::refined(level, families, split));
    }

    /// Takes back [`add_level`](Self::add_level), but for the ghosts.
    fn drop_finest_level(&mut self) {
        self.levels.pop();
        if let Some(parents) = self.levels.last_mut() {
            parents.children.fill(LEAF);
        }
    }

    /// The tree without the families that have no children, restricted, with details.
    fn without_last_generation(&self) -> Self {
        let mut base = self.levels[0].clone();
        base.children.fill(LEAF);
        let mut pruned = Self {
            predictor: self.predictor.clone(),
            points: None,
            periodic: self.periodic,
            levels: vec![base],
        };
        // Where each own cell of the level above has gone.
        let mut moved: Vec<u32> = (0..to_u32(self.levels[0].own_cells())).collect();
        for level in &self.levels[1..] {
            let siblings = Level::<D>::SIBLINGS;
            let has_children = |family: &usize| {
                level.children[family * siblings..][..siblings].iter().any(|&c| c != LEAF)
            };
            let kept: Vec<usize> = (0..level.own).filter(has_children).collect();
            if kept.is_empty() {
                break;
            }
            let split: Vec<u32> =
                kept.iter().map(|&family| moved[level.parents[family] as usize]).collect();
            let families = kept.iter().map(|&family| level.families[family]).collect();
            pruned.add_level(split, families);
            moved = vec![LEAF; level.own_cells()];
            let last = pruned.levels.len() - 1;
            for (new, &old) in kept.iter().enumerate() {
                let (to, from) = (new * siblings, old * siblings);
                pruned.levels[last].averages[to..to + siblings]
                    .copy_from_slice(level.family_averages(old));
                for child in 0..siblings {
                    moved[from + child] = to_u32(to + child);
                }
            }
        }
        pruned.restrict();
        pruned.update_details();
        pruned
    }
}
