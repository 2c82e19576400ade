//! The search: samples, corners, points and patches of all cells, level by level.

use crate::parallel::prelude::*;
use crate::vol::lowrank::WeightedView;
use crate::vol::sampling::Stop;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::comparisons::Comparisons;
use crate::vol::surfaces::octree::{Cell, Facet, Grid, HIDDEN, Label, Leaf, region};
use crate::vol::surfaces::samples::Samples;
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Reasons for which surfaces are not found.
#[derive(Debug)]
pub(super) enum Failure {
    /// G has too much structure for regions with surfaces between them.
    TooComplex,
    /// The values of samples belong to more regions than a view has.
    TooManyRegions,
    /// G jumps between samples of one region.
    JumpInRegion,
    Stopped(Stop),
}

impl Failure {
    /// The reason for which the rendering ends, too; `Ok` if other methods follow.
    pub(super) fn given_up(self) -> Result<(), Stop> {
        match self {
            Self::TooComplex
            | Self::TooManyRegions
            | Self::JumpInRegion
            | Self::Stopped(Stop::Budget) => Ok(()),
            Self::Stopped(stop) => Err(stop),
        }
    }
}

impl From<Stop> for Failure {
    fn from(stop: Stop) -> Self {
        Self::Stopped(stop)
    }
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    pub(super) at: [f64; 3],
    /// The samples on both sides: at the lower end of the bracket, and at the higher one.
    pub(super) samples: [usize; 2],
    /// The axis along which it was found.
    pub(super) axis: usize,
}

/// A line of the lattice of the finest level: its axis, and its place on the other two.
pub(super) type LatticeLine = (usize, [u32; 2]);

/// Samples or points on these lines: their places, and their numbers.
pub(super) type OnLines = FxHashMap<LatticeLine, Vec<(f64, usize)>>;

/// What a cell has from its parent.
#[derive(Clone, Debug)]
pub(super) struct Guess {
    /// The patches of the parent.
    pub(super) facets: Option<Arc<[Facet]>>,
    /// The displacements allowed, in units of the usual ones.
    pub(super) share: f64,
    /// Whether an evaluation has contradicted these patches.
    pub(super) is_refuted: bool,
}

impl Guess {
    /// Nothing is known.
    pub(super) const NONE: Self = Self { facets: None, share: 1.0, is_refuted: false };
}

/// Why leaves are divided.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reason {
    /// An evaluation contradicts them.
    Wrong,
    /// Their patches need smaller errors, by this factor.
    Inaccurate(f64),
}

/// A cell that is not a leaf yet.
#[derive(Clone, Debug)]
pub(super) struct OpenCell {
    pub(super) cell: Cell,
    /// The samples at its corners, and others in it.
    pub(super) corners: [usize; 8],
    pub(super) inside: Vec<usize>,
    pub(super) guess: Guess,
    pub(super) facets: Option<Vec<Facet>>,
    /// Whether its patches are good enough, and whether an evaluation has contradicted them.
    pub(super) is_done: bool,
    pub(super) is_refuted: bool,
}

/// The state of the search.
pub(super) struct Search<'a> {
    pub(super) view: &'a WeightedView<'a>,
    pub(super) grid: Grid,
    pub(super) aim: Aim<'a>,
    /// The error allowed, as a share of the largest pixel.
    pub(super) tolerance: f64,
    pub(super) samples: Samples,
    pub(super) corners: FxHashMap<[u32; 3], usize>,
    pub(super) points: Vec<SurfacePoint>,
    /// The points of surfaces on edges.
    pub(super) lines: OnLines,
    /// The samples at the last points of edges that lines of sight reach.
    pub(super) ends: OnLines,
    pub(super) leaves: BTreeMap<Cell, Leaf>,
    /// The last comparisons of leaves with those beside them.
    pub(super) comparisons: Comparisons,
    /// The evaluations that may be made.
    pub(super) left: u64,
    /// Whether a search from a finer lattice may follow.
    pub(super) can_be_finer: bool,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        view: &'a WeightedView<'a>,
        grid: Grid,
        aim: Aim<'a>,
        tolerance: f64,
        samples: Samples,
        left: u64,
    ) -> Self {
        let (corners, lines, ends) = (FxHashMap::default(), OnLines::default(), OnLines::default());
        let (points, leaves, comparisons) = (Vec::new(), BTreeMap::new(), Comparisons::default());
        Self {
            view,
            grid,
            aim,
            tolerance,
            samples,
            corners,
            points,
            lines,
            ends,
            leaves,
            comparisons,
            left,
            can_be_finer: false,
        }
    }

    /// G at points, in one batch.
    pub(super) async fn rates(&mut self, points: &[[f64; 3]]) -> Result<Vec<f64>, Failure> {
        let count = points.len() as u64 * self.view.evaluations_of_point();
        if count > self.left {
            return Err(Failure::TooComplex);
        }
        self.left -= count;
        let at: Vec<[f64; 3]> = points.iter().map(|point| self.grid.canonical(*point)).collect();
        Ok(self.view.rates(&at).await?)
    }

    /// Whether no line of sight reaches a point.
    pub(super) fn hides(&self, at: [f64; 3]) -> bool {
        self.aim.hides(&self.grid, at)
    }

    /// Samples G at points, as far as lines of sight reach them. Returns the numbers of the samples,
    /// whose regions follow from their values.
    pub(super) async fn sample(&mut self, points: &[[f64; 3]]) -> Result<Vec<usize>, Failure> {
        let is_seen: Vec<bool> = points.iter().map(|at| !self.hides(*at)).collect();
        let both = || points.iter().copied().zip(is_seen.iter().copied());
        let seen: Vec<[f64; 3]> =
            both().filter_map(|(at, is_seen)| is_seen.then_some(at)).collect();
        let mut rates = self.rates(&seen).await?.into_iter();
        let of_point = |(at, is_seen)| match is_seen {
            true => self.add(at, rates.next().unwrap_or(0.0)),
            false => Ok(self.samples.add_hidden(at)),
        };
        both().map(of_point).collect()
    }

    /// Adds a sample to the region that its value belongs to, or to a new one.
    pub(super) fn add(&mut self, at: [f64; 3], rate: f64) -> Result<usize, Failure> {
        let label = self.label_of(at, rate)?;
        Ok(self.samples.add(at, rate, label))
    }

    /// The region that a value belongs to, or a new one.
    pub(super) fn label_of(&mut self, at: [f64; 3], rate: f64) -> Result<Label, Failure> {
        let label = self.samples.classify(at, rate);
        let label = label.or_else(|| self.samples.constant(rate));
        let label = label.unwrap_or_else(|| self.samples.new_label());
        if self.samples.regions() > TUNING.surfaces.most_regions {
            return Err(Failure::TooManyRegions);
        }
        Ok(label)
    }

    /// Divides the view into leaves.
    pub(super) async fn run(&mut self) -> Result<(), Failure> {
        let [nx, ny, nz] = self.grid.base;
        let mut active: Vec<BTreeMap<[u32; 3], Guess>> =
            vec![BTreeMap::new(); usize::from(self.grid.finest) + 1];
        for x in 0..nx {
            for y in 0..ny {
                active[0].extend((0..nz).map(|z| ([x, y, z], Guess::NONE)));
            }
        }
        self.refine(active, true).await
    }

    /// Replaces leaves by their children, and refines these; patches with too large errors are fitted and checked again
    /// before their leaf is divided.
    pub(super) async fn divide(&mut self, cells: &[Cell], reason: Reason) -> Result<(), Failure> {
        let mut active = vec![BTreeMap::new(); usize::from(self.grid.finest) + 1];
        cells.iter().for_each(|cell| self.open(*cell, reason, &mut active));
        self.refine(active, false).await
    }

    /// Refines cells, and then those that disagree with their neighbours, until all agree. With all base cells, the
    /// error allowed becomes known from level to level.
    async fn refine(
        &mut self,
        mut active: Vec<BTreeMap<[u32; 3], Guess>>,
        mut is_first: bool,
    ) -> Result<(), Failure> {
        for _ in 0..TUNING.surfaces.rounds {
            self.levels(&mut active, is_first).await?;
            is_first = false;
            let disagreeing = self.disagreeing().await?;
            if disagreeing.is_empty() {
                return Ok(());
            }
            for cell in disagreeing {
                self.open(cell, Reason::Wrong, &mut active);
            }
        }
        Ok(())
    }

    /// Refines cells and their children, level by level. The first time, the error allowed is determined anew after each
    /// level, and goes on at the coarsest one with patches that are too far from their surface for that.
    async fn levels(
        &mut self,
        active: &mut [BTreeMap<[u32; 3], Guess>],
        is_first: bool,
    ) -> Result<(), Failure> {
        let (mut level, mut deepest) = (0, 0);
        while level <= self.grid.finest {
            let cells = core::mem::take(&mut active[usize::from(level)]);
            let below = level + 1;
            if cells.is_empty() {
                level = below;
                continue;
            }
            let children = self.level(level, cells).await?;
            let Some(next) = active.get_mut(usize::from(below)) else { return Ok(()) };
            next.extend(children);
            let has_new = is_first && level >= deepest && !next.is_empty();
            let mut following = below;
            if has_new {
                deepest = below;
                self.retarget(level, next);
                for ((loose, at), guess) in self.take_loose() {
                    following = following.min(loose);
                    active[usize::from(loose)].insert(at, guess);
                }
            }
            level = following;
        }
        Ok(())
    }

    /// Replaces a leaf by its children, which are refined next, or by itself.
    fn open(&mut self, cell: Cell, reason: Reason, active: &mut [BTreeMap<[u32; 3], Guess>]) {
        let (level, at) = cell;
        if let Reason::Inaccurate(share) = reason
            && let Some(guess) = self.take(cell, share)
        {
            active[usize::from(level)].insert(at, guess);
            return;
        }
        let Some(next) = active.get_mut(usize::from(level) + 1) else { return };
        if let Some(leaf) = self.leaves.remove(&cell) {
            let facets: Option<Arc<[Facet]>> = match leaf {
                Leaf::Cut(facets) => Some(facets.into()),
                _ => None,
            };
            let guess = match reason {
                Reason::Wrong => Guess { facets, share: 1.0, is_refuted: true },
                Reason::Inaccurate(share) => Guess { facets, share, is_refuted: false },
            };
            next.extend(children(at).map(|child| (child, guess.clone())));
        }
    }

    /// Makes leaves of the cells of a level as far as possible. Returns the children of the others.
    async fn level(
        &mut self,
        level: u8,
        cells: BTreeMap<[u32; 3], Guess>,
    ) -> Result<Vec<([u32; 3], Guess)>, Failure> {
        let is_hidden = |at: &[u32; 3]| self.aim.place_in_view(&self.grid, (level, *at)).is_none();
        let (hidden, cells): (BTreeMap<_, _>, BTreeMap<_, _>) =
            cells.into_iter().partition(|(at, _)| is_hidden(at));
        self.leaves.extend(hidden.into_keys().map(|at| ((level, at), Leaf::Hidden)));
        let cells = self.with_corners(level, cells).await?;
        self.test_borders(&cells).await?;
        let (mut cut, mut uncut, mut next) = (Vec::new(), Vec::new(), Vec::new());
        let faded: Vec<Option<Leaf>> = cells.par_iter().map(|cell| self.faded(cell)).collect();
        for (cell, faded) in cells.into_iter().zip(faded) {
            match faded {
                Some(leaf) => {
                    self.leaves.insert(cell.cell, leaf);
                }
                None if self.labels(&cell).len() < 2 => uncut.push(cell),
                None => cut.push(cell),
            }
        }
        for batch in 0..TUNING.surfaces.batches {
            self.find_points(&mut cut, batch).await?;
            self.fit_all(level, &mut cut);
        }
        self.fit_beside(level, &mut cut, &mut uncut);
        for cell in uncut {
            let label = self.own_label(&cell);
            self.leaves.insert(cell.cell, Leaf::Uncut(label));
        }
        self.check(&mut cut).await?;
        for cell in cut {
            let leaf = self.leaf(level, &cell);
            match leaf {
                Some(leaf) => {
                    self.leaves.insert(cell.cell, leaf);
                }
                None => {
                    let most = TUNING.surfaces.guess_error * self.grid.cell_size(level);
                    let is_guess = |facets: &Vec<Facet>| facets.iter().all(|of| of.error < most);
                    let facets = cell.facets.filter(is_guess).map(Into::into);
                    let guess =
                        Guess { facets, share: cell.guess.share, is_refuted: cell.is_refuted };
                    next.extend(children(cell.cell.1).map(|child| (child, guess.clone())));
                }
            }
        }
        Ok(next)
    }

    /// The points at the corners of a cell and in it that lines of sight reach.
    pub(super) fn seen_samples<'b>(
        &'b self,
        cell: &'b OpenCell,
    ) -> impl Iterator<Item = &'b usize> {
        cell.corners.iter().chain(&cell.inside).filter(|&&i| !self.samples.is_hidden(i))
    }

    /// Those of them at which G was evaluated.
    pub(super) fn measured_samples<'b>(
        &'b self,
        cell: &'b OpenCell,
    ) -> impl Iterator<Item = &'b usize> {
        self.seen_samples(cell).filter(|&&i| self.samples.is_measured(i))
    }

    /// The region of a cell with only one.
    pub(super) fn own_label(&self, cell: &OpenCell) -> Label {
        self.seen_samples(cell).next().map_or(HIDDEN, |&i| self.samples.label(i))
    }

    /// The regions of the samples in a cell, in ascending order.
    pub(super) fn labels(&self, cell: &OpenCell) -> Vec<Label> {
        let mut labels: Vec<Label> =
            self.seen_samples(cell).map(|&i| self.samples.label(i)).collect();
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    /// Evaluates G on both sides of each new patch, where it is furthest from the points it was fitted to.
    async fn check(&mut self, cells: &mut [OpenCell]) -> Result<(), Failure> {
        let places = self.places_of_checks(cells);
        let points: Vec<[f64; 3]> = places.iter().map(|(_, point)| *point).collect();
        let samples = self.sample(&points).await?;
        for ((cell, point), sample) in places.into_iter().zip(samples) {
            let cell = &mut cells[cell];
            let expected = cell.facets.as_deref().map(|facets| region(facets, point).0);
            let expected = expected.map(|label| self.samples.current(label));
            if expected != Some(self.samples.label(sample)) {
                (cell.is_done, cell.is_refuted) = (false, true);
                cell.inside.push(sample);
            }
        }
        Ok(())
    }
}

/// A limit at 1 % as one at another tolerance.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "far below 2⁶⁴")]
pub(super) fn of_tolerance(at_a_hundredth: f64, tolerance: f64) -> u64 {
    let allowed = 1e-2 / tolerance.max(1e-6);
    (at_a_hundredth * allowed.powf(TUNING.surfaces.growth)) as u64
}

/// Bit `k` of a corner's number.
pub(super) fn bit(corner: usize, k: usize) -> u32 {
    u32::from((corner >> k) & 1 == 1)
}

fn children(at: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..8).map(move |c| core::array::from_fn(|k| 2 * at[k] + bit(c, k)))
}
