//! The extent of a structure that few samples meet: where G on lines through these samples, along the axes of the grid,
//! has the value of the background again.

use crate::vol::surfaces::focus::background;
use crate::vol::surfaces::octree::Grid;
use core::cmp::Ordering;

/// The most samples in a structure whose extent is looked for.
const FEW: usize = 16;
/// How often lines are followed.
pub(super) const ROUNDS: usize = 2;
/// Distances from a sample are base cells, halved up to so many times.
const HALVINGS: u32 = 5;
/// Both ends are moved outwards by this share of the extent, since lines along the axes may miss the widest places.
const MARGIN: f64 = 0.25;

/// The extent of what differs from the background.
#[derive(Clone, Debug)]
pub(super) struct Extent {
    background: u64,
    /// Points that differ from the background.
    inside: Vec<[f64; 3]>,
    /// The ends along each axis.
    ends: [[f64; 2]; 3],
}

impl Extent {
    /// Of the structure that few of these samples meet; `None` if none does, or if many do.
    pub(super) fn of_few(samples: &[([f64; 3], f64)]) -> Option<Self> {
        let background = background(samples)?;
        let others = samples.iter().filter(|(_, value)| value.to_bits() != background);
        let inside: Vec<[f64; 3]> = others.map(|(at, _)| *at).take(FEW + 1).collect();
        let is_few = (1..=FEW).contains(&inside.len());
        is_few.then_some(Self { background, inside, ends: [[f64::INFINITY, f64::NEG_INFINITY]; 3] })
    }

    /// The points from which lines are followed in a round: the outermost samples along each axis, then the middle.
    pub(super) fn starts(&self, round: usize) -> Vec<[f64; 3]> {
        let outermost = |k: usize| {
            let inside = || self.inside.iter().copied();
            let by_place = |a: &[f64; 3], b: &[f64; 3]| a[k].total_cmp(&b[k]);
            [inside().min_by(by_place), inside().max_by(by_place)].map(Option::unwrap_or_default)
        };
        let of_axes = [0, 1, 2].map(outermost);
        if round > 0 {
            return vec![core::array::from_fn(|k| 0.5 * (of_axes[k][0][k] + of_axes[k][1][k]))];
        }
        let mut starts = of_axes.concat();
        starts.sort_by(|a, b| {
            a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).fold(Ordering::Equal, Ordering::then)
        });
        starts.dedup();
        starts
    }

    /// Points on lines along the axes through a point, within the view: for each axis and side in order of their
    /// distance.
    pub(super) fn points(grid: &Grid, from: [f64; 3]) -> Vec<[f64; 3]> {
        let cell = grid.cell_edges(0);
        let sides = (0..3).flat_map(|k| [-1.0, 1.0].map(|sign| (k, sign)));
        let along_side = |(k, sign): (usize, f64)| {
            (0..=HALVINGS).rev().map(move |halvings| {
                let mut at = from;
                at[k] += sign * cell[k] / f64::from(1_u32 << halvings);
                at[k] = at[k].clamp(0.0, grid.edges[k]);
                at
            })
        };
        sides.flat_map(along_side).collect()
    }

    /// Adds the values at the points of one start.
    pub(super) fn add(&mut self, points: &[[f64; 3]], values: &[Option<f64>]) {
        let per_side = HALVINGS as usize + 1;
        let sides = points.chunks(per_side).zip(values.chunks(per_side));
        for (side, (points, values)) in sides.enumerate() {
            let (axis, is_upper) = (side / 2, side % 2 == 1);
            let differs =
                |value: &Option<f64>| value.is_some_and(|value| value.to_bits() != self.background);
            let inside = values.iter().rposition(differs);
            // The next point is in the background; beyond the last one, nothing is known.
            let first_outside = inside.map_or(0, |last| last + 1).min(per_side - 1);
            let end = points[first_outside][axis];
            let known = &mut self.ends[axis][usize::from(is_upper)];
            *known = if is_upper { known.max(end) } else { known.min(end) };
            self.inside.extend(inside.map(|last| points[last]));
        }
    }

    /// The ends with a margin, within the view.
    pub(super) fn with_margin(&self, grid: &Grid) -> [[f64; 2]; 3] {
        core::array::from_fn(|k| {
            let [low, high] = self.ends[k];
            let margin = MARGIN * (high - low);
            [(low - margin).max(0.0), (high + margin).min(grid.edges[k])]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::lattice;

    const GRID: Grid = Grid { edges: [1.0; 3], base: [8; 3], finest: 7 };

    /// The extent of a ball at (0.4, 0.4, 0.4), from a point in it and points of the background.
    fn ends(radius: f64, hit: [f64; 3]) -> [[f64; 2]; 3] {
        let square = |at: [f64; 3]| at.iter().map(|x| (x - 0.4).powi(2)).sum::<f64>();
        let value = |at: [f64; 3]| if square(at) < radius * radius { 1.0 + at[0] } else { 0.0 };
        let beyond = (0..500).map(lattice::point).filter(|at| value(*at) == 0.0);
        let mut samples: Vec<([f64; 3], f64)> = beyond.map(|at| (at, 0.0)).collect();
        samples.push((hit, value(hit)));
        let mut extent = Extent::of_few(&samples).unwrap_or_else(|| unreachable!());
        for round in 0..ROUNDS {
            for start in extent.starts(round) {
                let points = Extent::points(&GRID, start);
                let values: Vec<_> = points.iter().map(|at| Some(value(*at))).collect();
                extent.add(&points, &values);
            }
        }
        extent.with_margin(&GRID)
    }

    #[test]
    fn one_sample_suffices_for_the_extent_of_a_ball() {
        for radius in [0.01, 0.03, 0.06] {
            for hit in [[0.4; 3], [0.4 + 0.8 * radius, 0.4, 0.4 - 0.4 * radius]] {
                for [low, high] in ends(radius, hit) {
                    assert!(low <= 0.4 - radius && high >= 0.4 + radius, "{radius}: {low} {high}");
                    assert!(high - low < 8.0 * radius, "{radius}: {low} {high}");
                }
            }
        }
    }

    #[test]
    fn structures_that_many_samples_meet_have_none() {
        let value = |at: [f64; 3]| if at[0] < 0.1 { at[1] } else { 0.0 };
        let samples: Vec<_> = (0..500).map(lattice::point).map(|at| (at, value(at))).collect();
        assert!(Extent::of_few(&samples).is_none());
        // Nor do views without structure.
        let samples: Vec<_> = (0..500).map(lattice::point).map(|at| (at, 2.0)).collect();
        assert!(Extent::of_few(&samples).is_none());
    }
}
