//! [`Locations`]: the cells of many positions, one step of the search for all of them after the other.
//!
//! Each step is a loop without branches, or nearly so, over numbers that lie together: the processor works on several
//! positions at once, in vector instructions where there are some, and waits for the values of several cells.

use super::axes::GridAxes;
use super::axis::Location;

/// The cells of positions, along each axis of a grid.
#[derive(Debug, Default)]
pub(crate) struct Locations {
    /// Whether positions are in the grid; others have any cell.
    is_inside: Vec<bool>,
    cells: [Vec<usize>; 3],
    fractions: [Vec<f64>; 3],
}

impl Locations {
    /// Positions to be located at once: their cells stay in the fastest cache.
    pub(super) const BLOCK: usize = 512;

    /// The cells of these positions, instead of those before: as [`GridAxes::locate`] has them.
    pub(crate) fn find(&mut self, axes: &GridAxes, positions: &[[f64; 3]]) {
        let count = positions.len();
        self.is_inside.clear();
        self.is_inside.resize(count, true);
        self.cells.iter_mut().for_each(|cells| cells.resize(count, 0));
        self.fractions.iter_mut().for_each(|fractions| fractions.resize(count, 0.0));
        axes.coordinates_of_all(positions, self.fractions.each_mut().map(Vec::as_mut_slice));
        let columns = self.fractions.iter_mut().zip(&mut self.cells);
        for (axis, (fractions, cells)) in axes.axes().iter().zip(columns) {
            axis.locate_all(fractions, cells, &mut self.is_inside);
        }
    }

    /// Whether each of the positions is in the grid.
    pub(crate) fn are_inside(&self) -> &[bool] {
        &self.is_inside
    }

    /// Writes the value in the cell of each position, and `outside` where there is none.
    #[inline(always)]
    pub(super) fn fill(
        &self,
        values: &mut [f64],
        outside: f64,
        value_in: impl Fn([Location; 3]) -> f64,
    ) {
        let [a, b, c] = [0, 1, 2].map(|axis| self.cells[axis].iter().zip(&self.fractions[axis]));
        let location = |(&cell, &fraction): (&usize, &f64)| Location { cell, fraction };
        let places = a.zip(b).zip(c).map(|((a, b), c)| [a, b, c].map(location));
        for ((value, &is_inside), at) in values.iter_mut().zip(&self.is_inside).zip(places) {
            *value = if is_inside { value_in(at) } else { outside };
        }
    }
}
