//! The part of the view where G is not constant: where it is small, the base lattice is finer there.
//!
//! A shape that is much smaller than the view has few corners of the base lattice of the whole view, and
//! its regions could not be told from each other.

use crate::vol::surfaces::octree::Grid;
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;

/// The least share of all values that are equal to the background.
const BACKGROUND: f64 = 0.5;
/// The most levels by which the lattice is finer.
const MOST_LEVELS: u8 = 3;

/// The same where the ends of the structure are known.
const MOST_LEVELS_BETWEEN: u8 = 5;

/// The most frequent value, if most samples have it.
pub(super) fn background(samples: &[([f64; 3], f64)]) -> Option<u64> {
    let mut counts: FxHashMap<u64, usize> = FxHashMap::default();
    for (_, value) in samples {
        *counts.entry(value.to_bits()).or_default() += 1;
    }
    let most = counts.into_iter().max_by_key(|(bits, count)| (*count, *bits));
    let (background, count) = most?;
    (count as f64 >= BACKGROUND * samples.len() as f64).then_some(background)
}

/// A box of cells of one level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CellBox {
    pub(super) level: u8,
    /// The first cell along each axis, and the number of cells.
    pub(super) low: [u32; 3],
    pub(super) cells: [u32; 3],
}

impl CellBox {
    /// All cells of the base lattice.
    pub(super) fn whole(grid: &Grid) -> Self {
        Self { level: 0, low: [0; 3], cells: grid.base }
    }

    /// The box, with one base cell around it, of the samples that do not have the most frequent value, in
    /// finer cells; `None` if no value is frequent, or if the cells of the base lattice are fine enough.
    pub(super) fn around_structure(grid: &Grid, samples: &[([f64; 3], f64)]) -> Option<Self> {
        let background = background(samples)?;
        let others = samples.iter().filter(|(_, value)| value.to_bits() != background);
        let places: Vec<[u32; 3]> = others.map(|(at, _)| grid.cell_at(0, *at)).collect();
        if places.is_empty() {
            return None;
        }
        let ends = |k: usize| {
            let along = || places.iter().map(move |place| place[k]);
            let (low, high) = (along().min().unwrap_or(0), along().max().unwrap_or(0));
            [low.saturating_sub(1), (high + 2).min(grid.base[k])]
        };
        let ends = [0, 1, 2].map(ends);
        let cells = ends.map(|[low, high]| high - low);
        let count: f64 = cells.iter().map(|count| f64::from(*count)).product();
        let wanted = TUNING.surfaces.base_cells;
        let is_affordable = |level: &u8| count * 8_f64.powi(i32::from(*level)) <= 2.0 * wanted;
        let level = (0..=MOST_LEVELS).rev().find(is_affordable).unwrap_or(0);
        (level > 0).then(|| Self {
            level,
            low: ends.map(|[low, _]| low << level),
            cells: cells.map(|count| count << level),
        })
    }

    /// The cells with these ends along each axis, as fine as can be.
    pub(super) fn between(grid: &Grid, ends: [[f64; 2]; 3]) -> Option<Self> {
        let of_level = |level: u8| {
            let edges = grid.cell_edges(level);
            let low = grid.cell_at(level, ends.map(|[low, _]| low));
            let high = grid.cell_at(level, ends.map(|[_, high]| high));
            let cells = core::array::from_fn(|k| {
                let is_beyond = ends[k][1] > f64::from(high[k]) * edges[k];
                (high[k] - low[k] + u32::from(is_beyond)).max(1)
            });
            Self { level, low, cells }
        };
        let count = |of: &Self| of.cells.iter().map(|count| f64::from(*count)).product::<f64>();
        let finest = MOST_LEVELS_BETWEEN.min(grid.finest);
        let is_affordable = |of: &Self| count(of) <= 2.0 * TUNING.surfaces.base_cells;
        (1..=finest).rev().map(of_level).find(is_affordable)
    }

    /// The same part of the view in cells of half the size.
    pub(super) fn halved(&self) -> Self {
        Self {
            level: self.level + 1,
            low: self.low.map(|k| 2 * k),
            cells: self.cells.map(|k| 2 * k),
        }
    }

    /// The corner of a number of cells from the first one, in the coordinates of a grid.
    pub(super) fn point(&self, grid: &Grid, corner: [usize; 3]) -> [f64; 3] {
        grid.point(self.level, core::array::from_fn(|k| f64::from(self.low[k]) + corner[k] as f64))
    }

    /// The point at a share of each edge of the box.
    pub(super) fn at(&self, grid: &Grid, u: [f64; 3]) -> [f64; 3] {
        let along = |k: usize| f64::from(self.low[k]) + u[k] * f64::from(self.cells[k]);
        grid.point(self.level, core::array::from_fn(along))
    }

    /// The same on the lattice of the finest level.
    pub(super) fn finest(&self, grid: &Grid, corner: [usize; 3]) -> [u32; 3] {
        let step = 1_u32 << (grid.finest - self.level);
        core::array::from_fn(|k| (self.low[k] + u32::try_from(corner[k]).unwrap_or(0)) * step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::lattice;

    fn samples(value: impl Fn([f64; 3]) -> f64) -> Vec<([f64; 3], f64)> {
        (0..1000).map(lattice::point).map(|at| (at, value(at))).collect()
    }

    #[test]
    fn a_small_shape_has_finer_cells() {
        let grid = Grid { edges: [1.0; 3], base: [8; 3], finest: 7 };
        let ball = |at: [f64; 3]| at.iter().map(|x| (x - 0.3).powi(2)).sum::<f64>() < 0.01;
        let found =
            CellBox::around_structure(&grid, &samples(|at| if ball(at) { at[0] } else { 2.0 }));
        let found = found.expect("a box");
        assert_eq!(found.level, 1);
        let ends = |k: usize| {
            let [from, to] = [found.low[k], found.low[k] + found.cells[k]];
            [from, to].map(|place| f64::from(place) / 16.0)
        };
        for k in 0..3 {
            let [from, to] = ends(k);
            assert!(from <= 0.2 && to >= 0.4 && to - from <= 0.7, "{from} {to}");
        }
        assert_eq!(found.finest(&grid, [0; 3]), found.low.map(|k| k * 64));
        let halved = found.halved();
        for corner in [[0; 3], [1, 2, 3]] {
            let of_halved = corner.map(|k| 2 * k);
            assert_eq!(halved.finest(&grid, of_halved), found.finest(&grid, corner));
        }
    }

    #[test]
    fn a_shape_that_fills_the_view_and_a_smooth_rate_have_none() {
        let grid = Grid { edges: [1.0; 3], base: [8; 3], finest: 7 };
        let large = samples(|at| if at[0] < 0.4 { at[1] } else { 0.0 });
        assert_eq!(CellBox::around_structure(&grid, &large), None);
        assert_eq!(CellBox::around_structure(&grid, &samples(|at| at[0])), None);
    }
}
