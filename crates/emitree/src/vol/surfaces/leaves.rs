//! Leaves: what becomes of a cell whose patches are known.

use crate::vol::surfaces::octree::{Facet, Label, Leaf};
use crate::vol::surfaces::search::{OpenCell, Search};
use crate::vol::tuning::TUNING;

impl Search<'_> {
    /// The leaf that a cell becomes; `None` if it is to be divided.
    pub(super) fn leaf(&self, level: u8, cell: &OpenCell) -> Option<Leaf> {
        if let Some(facets) = cell.facets.as_ref().filter(|_| cell.is_done) {
            return Some(Leaf::Cut(facets.clone()));
        }
        let labels = self.labels(cell);
        let is_guessed = cell.facets.is_some() || cell.guess.facets.is_some();
        if let ([only], false) = (&labels[..], is_guessed) {
            // Its regions have become one.
            return Some(Leaf::Uncut(*only));
        }
        let rates = self.measured_samples(cell).map(|&i| self.samples.get(i).rate);
        let [low, high] = rates.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], rate| {
            [low.min(rate), high.max(rate)]
        });
        // A surface may pass between samples of one region.
        let facets =
            cell.facets.iter().flatten().chain(cell.guess.facets.iter().flat_map(|of| of.iter()));
        let jump = facets.map(|of| of.jump).fold((high - low).max(0.0), f64::max);
        if self.matters(cell, jump) && level < self.grid.finest {
            return None;
        }
        if let Some(facets) = self.near_enough(cell, &labels) {
            return Some(Leaf::Cut(facets.to_vec()));
        }
        Some(Leaf::Unresolved(self.main_label(cell, &labels), jump))
    }

    /// The label of most samples in a cell.
    fn main_label(&self, cell: &OpenCell, labels: &[Label]) -> Label {
        let is = |label: Label| move |&&i: &&usize| self.samples.label(i) == label;
        let count = |label: Label| self.seen_samples(cell).filter(is(label)).count();
        let most = labels.iter().max_by_key(|label| (count(**label), Label::MAX - **label));
        most.copied().unwrap_or(0)
    }

    /// Whether a jump between unknown parts of a cell changes pixels by too much.
    fn matters(&self, cell: &OpenCell, jump: f64) -> bool {
        let edges = self.grid.cell_edges(cell.cell.0);
        let canonical = self.grid.canonical(self.grid.centre(cell.cell));
        let [across, along] = self.aim.pixels_across();
        let share = (edges[0] / self.grid.edges[0] * across).min(1.0)
            * (edges[1] / self.grid.edges[1] * along).min(1.0);
        let effect = 0.25 * jump * share * edges[2] / self.grid.edges[2];
        let allowed =
            TUNING.surfaces.unresolved_share * self.aim.of_line([canonical[0], canonical[1]]);
        effect > cell.guess.share * allowed
    }

    /// The leaf of a cell with several regions between which the jump has faded out: the regions predict
    /// nearly the same values.
    pub(super) fn faded(&self, cell: &OpenCell) -> Option<Leaf> {
        let labels = self.labels(cell);
        if labels.len() < 2 {
            return None;
        }
        let [jump, error] = self.samples.largest_jump(self.grid.centre(cell.cell), &labels)?;
        let is_faded = !self.matters(cell, TUNING.surfaces.faded_cells * (jump + error));
        is_faded.then(|| Leaf::Unresolved(self.main_label(cell, &labels), jump))
    }

    /// The patches of a cell that need not be divided: with their errors they are nearer to the surfaces
    /// than no patches would be.
    fn near_enough<'b>(&self, cell: &'b OpenCell, labels: &[Label]) -> Option<&'b [Facet]> {
        let facets = cell.facets.as_deref()?;
        let most = TUNING.surfaces.guess_error * self.grid.cell_size(cell.cell.0);
        let is_beside = |label: &Label| {
            let sides = facets.iter().flat_map(|of| [of.below, of.above]);
            sides.into_iter().any(|side| self.samples.current(side) == *label)
        };
        let is_near = facets.iter().all(|of| of.error < most) && labels.iter().all(is_beside);
        (is_near && !self.has_ambiguous_places(cell.cell, facets)).then_some(facets)
    }
}
