//! The corners of cells: sampled, or far from the patches of the parent, from which their regions follow.

use crate::vol::surfaces::inferred::NewPoints;
use crate::vol::surfaces::octree::Cell;
use crate::vol::surfaces::search::{Failure, Guess, OpenCell, Search, bit};
use std::collections::BTreeMap;

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
        let open = |(at, guess): ([u32; 3], Guess)| {
            let corners = self.corners_of((level, at));
            let corners = corners.map(|corner| self.corners.get(&corner).copied().unwrap_or(0));
            let (cell, inside, facets) = ((level, at), Vec::new(), None);
            OpenCell { cell, corners, inside, guess, facets, is_done: false, is_refuted: false }
        };
        let mut cells: Vec<OpenCell> = cells.into_iter().map(open).collect();
        self.sample_ends(level, &cells).await?;
        for i in 0..self.samples.len() {
            let place = self.grid.cell_at(level, self.samples.get(i).at);
            if let Ok(cell) = cells.binary_search_by_key(&place, |of| of.cell.1) {
                cells[cell].inside.push(i);
            }
        }
        cells.iter_mut().for_each(|cell| self.add_ends(cell));
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

    /// The corners of a cell on the finest lattice.
    pub(super) fn corners_of(&self, cell: Cell) -> [[u32; 3]; 8] {
        let (low, step) = self.grid.corners(cell);
        core::array::from_fn(|c| core::array::from_fn(|k| low[k] + step * bit(c, k)))
    }
}
