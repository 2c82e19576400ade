//! The corners of cells: sampled, or far from the patches of the parent, from which their regions follow.
//!
//! A cell is divided where its patches are not accurate enough, and most corners of its children are far
//! from all of its surfaces. G is evaluated at those corners only when a bracket of a surface ends there.

use crate::vol::surfaces::octree::{Cell, Label, region};
use crate::vol::surfaces::search::{Failure, Guess, OpenCell, Search, bit};
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::hash::Hash;

/// Points that are not known yet, in the order of the cells, each with its region if all cells infer the same one.
pub(super) struct NewPoints<K> {
    points: Vec<(K, [f64; 3], Option<Label>)>,
    numbers: FxHashMap<K, usize>,
}

impl<K> Default for NewPoints<K> {
    fn default() -> Self {
        Self { points: Vec::new(), numbers: FxHashMap::default() }
    }
}

impl<K: Eq + Hash + Copy> NewPoints<K> {
    /// Adds what a cell infers at a point.
    pub(super) fn add(&mut self, key: K, at: [f64; 3], inferred: Option<Label>) {
        let next = self.points.len();
        let number = *self.numbers.entry(key).or_insert(next);
        match self.points.get_mut(number) {
            Some((.., label)) => *label = label.filter(|_| *label == inferred),
            None => self.points.push((key, at, inferred)),
        }
    }

    /// The points, in their order.
    pub(super) fn keys(&self) -> impl Iterator<Item = &K> {
        self.points.iter().map(|(key, ..)| key)
    }
}

impl Search<'_> {
    /// The cells with their corners, which are sampled or inferred, and with the samples inside them.
    pub(super) async fn with_corners(
        &mut self,
        level: u8,
        cells: BTreeMap<[u32; 3], Guess>,
    ) -> Result<Vec<OpenCell>, Failure> {
        let new = self.new_corners(level, &cells);
        let corners: Vec<[u32; 3]> = new.keys().copied().collect();
        let samples = self.sample_or_infer(new).await?;
        self.corners.extend(corners.into_iter().zip(samples));
        self.sample_ends(level, &cells).await?;
        let mut inside: FxHashMap<[u32; 3], Vec<usize>> = FxHashMap::default();
        for i in 0..self.samples.len() {
            let place = self.grid.cell_at(level, self.samples.get(i).at);
            if cells.contains_key(&place) {
                inside.entry(place).or_default().push(i);
            }
        }
        let open = |(at, guess): ([u32; 3], Guess)| {
            let corners = self.corners_of((level, at));
            let corners = corners.map(|corner| self.corners.get(&corner).copied().unwrap_or(0));
            let inside = inside.remove(&at).unwrap_or_default();
            let cell = (level, at);
            let mut cell = OpenCell {
                cell,
                corners,
                inside,
                guess,
                facets: None,
                is_done: false,
                is_refuted: false,
            };
            self.add_ends(&mut cell);
            cell
        };
        let mut cells: Vec<OpenCell> = cells.into_iter().map(open).collect();
        self.sample_unseen(&mut cells).await?;
        Ok(cells)
    }

    /// Samples a point that a line of sight reaches in each cell of which no corner and no other sample is seen.
    async fn sample_unseen(&mut self, cells: &mut [OpenCell]) -> Result<(), Failure> {
        let is_unseen = |cell: &&mut OpenCell| self.seen_samples(cell).next().is_none();
        let unseen: Vec<&mut OpenCell> = cells.iter_mut().filter(is_unseen).collect();
        let place = |cell: &&mut OpenCell| self.aim.place_in_view(&self.grid, cell.cell);
        let points: Vec<[f64; 3]> = unseen.iter().filter_map(place).collect();
        let samples = self.sample(&points).await?;
        for (cell, sample) in unseen.into_iter().zip(samples) {
            cell.inside.push(sample);
        }
        Ok(())
    }

    /// The corners of cells that are not known yet.
    fn new_corners(&self, level: u8, cells: &BTreeMap<[u32; 3], Guess>) -> NewPoints<[u32; 3]> {
        let size = self.grid.cell_size(level);
        let mut new = NewPoints::default();
        for (at, guess) in cells {
            for corner in self.corners_of((level, *at)) {
                if !self.corners.contains_key(&corner) {
                    let point = self.grid.corner(corner);
                    new.add(corner, point, self.inferred(guess, point, size));
                }
            }
        }
        new
    }

    /// Samples at new points: inferred where all cells agree, otherwise measured.
    pub(super) async fn sample_or_infer<K: Eq + Hash + Copy>(
        &mut self,
        new: NewPoints<K>,
    ) -> Result<Vec<usize>, Failure> {
        let known = new
            .points
            .iter()
            .map(|(_, at, label)| label.map(|label| self.samples.add_inferred(*at, label)));
        let mut known: Vec<Option<usize>> = known.collect();
        let missing = new.points.iter().filter(|(.., label)| label.is_none());
        let missing: Vec<[f64; 3]> = missing.map(|(_, at, _)| *at).collect();
        let mut measured = self.sample(&missing).await?.into_iter();
        known.iter_mut().filter(|of| of.is_none()).for_each(|of| *of = measured.next());
        Ok(known.into_iter().flatten().collect())
    }

    /// The region of a point that is far from the patches of the parent of a cell of this size.
    pub(super) fn inferred(&self, guess: &Guess, at: [f64; 3], size: f64) -> Option<Label> {
        let facets = guess.facets.as_deref()?;
        if guess.is_refuted || self.hides(at) {
            return None;
        }
        let error = facets.iter().map(|of| of.error).fold(0.0, f64::max);
        let least = TUNING.surfaces.inferred_errors * error;
        let (label, distance) = region(facets, at);
        let is_far = distance > least.max(TUNING.surfaces.inferred_share * size);
        is_far.then(|| self.samples.current(label))
    }

    /// The corners of a cell on the finest lattice.
    pub(super) fn corners_of(&self, cell: Cell) -> [[u32; 3]; 8] {
        let (low, step) = self.grid.corners(cell);
        core::array::from_fn(|c| core::array::from_fn(|k| low[k] + step * bit(c, k)))
    }

    /// Evaluates G at those of some points at which a region was inferred.
    pub(super) async fn measure(
        &mut self,
        points: impl Iterator<Item = usize>,
    ) -> Result<(), Failure> {
        let is_inferred = |i: &usize| !self.samples.is_measured(*i) && !self.samples.is_hidden(*i);
        let mut inferred: Vec<usize> = points.filter(is_inferred).collect();
        inferred.sort_unstable();
        inferred.dedup();
        let places: Vec<[f64; 3]> = inferred.iter().map(|&i| self.samples.get(i).at).collect();
        let rates = self.rates(&places).await?;
        for ((number, at), rate) in inferred.into_iter().zip(places).zip(rates) {
            let label = self.label_of(at, rate)?;
            self.samples.measure(number, rate, label);
        }
        Ok(())
    }
}
