//! Cubic interpolation in one dimension: Hermite cubics, monotone ones, whose slopes are limited, and smooth ones.
//!
//! The slope at a node is that of the parabola through the node and its two neighbours, limited so
//! that the cubic is monotone wherever the data are: M. Steffen, "A simple method for monotonic
//! interpolation in one dimension", Astronomy and Astrophysics 239, 443–450 (1990), with his rule
//! for the ends of an axis. The limits lie within the region that F. N. Fritsch and R. E. Carlson
//! (1980, doi:10.1137/0717021) found sufficient.
//!
//! Between two nodes the interpolant never leaves the range of their two values: data that are not
//! negative stay so. Where the data are monotone and smooth, its error is of third order in the
//! spacing; at an extremum the slope is set to 0, and the error is of second order.
//!
//! Without the limits the interpolant is linear in the values, its derivative is continuous, and its error is of third
//! order everywhere. It may leave the range of the two values. On even nodes it is the cubic convolution of R. G. Keys
//! (1981, doi:10.1109/TASSP.1981.1163711) and the spline of E. Catmull and R. Rom (1974,
//! doi:10.1016/B978-0-12-079050-0.50020-5).

use super::axis::{Axis, Location};
use core::array::from_fn;

/// The nodes before, at the start, at the end and after a cell, and the weights of interpolation
/// at one coordinate of it. What it needs of the axis is in here, so that many rows of values that
/// share the coordinate share the work.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stencil {
    /// The indices of the four nodes. At an end of the axis the node that is not there is replaced
    /// by the end itself, and its value is not used.
    pub(super) nodes: [usize; 4],
    start: Side,
    end: Side,
    /// The Hermite weights: of the two values, and of the two slopes times the width of the cell.
    weights: [f64; 4],
}

/// What the slope at one end of a cell needs of the axis.
#[derive(Clone, Copy, Debug)]
enum Side {
    /// A cell follows beyond the node.
    Inner {
        /// The width of the cell over that of the cell beyond.
        ratio: f64,
        /// The weight of the secant beyond in the slope of the parabola: the width of the cell over
        /// the sum of both widths.
        weight: f64,
    },
    /// The axis ends at the node; the parabola goes through the cell at the other side.
    Edge {
        /// The ratio of the other side.
        ratio: f64,
        /// The weight of the other side; 0 where the axis has no other cell, for a line.
        weight: f64,
    },
}

impl Stencil {
    pub(super) fn new(axis: &Axis, at: Location) -> Self {
        let nodes = axis.places();
        let (cell, last) = (at.cell, nodes.len() - 1);
        let width = nodes[cell + 1] - nodes[cell];
        let beyond = |width_beyond: f64| (width / width_beyond, width / (width + width_beyond));
        let below = (cell > 0).then(|| beyond(nodes[cell] - nodes[cell - 1]));
        let above = (cell + 2 <= last).then(|| beyond(nodes[cell + 2] - nodes[cell + 1]));
        Self {
            nodes: [cell.saturating_sub(1), cell, cell + 1, (cell + 2).min(last)],
            start: Side::new(below, above),
            end: Side::new(above, below),
            weights: hermite_weights(at.fraction),
        }
    }

    /// The interpolants of `N` rows at once, from the values at the four nodes: `values[i]` are
    /// those at node i, one for each row. `MONOTONE` ones have limited slopes.
    pub(super) fn interpolate<const N: usize, const MONOTONE: bool>(
        &self,
        [before, start, end, after]: [[f64; N]; 4],
    ) -> [f64; N] {
        let secants: [f64; N] = from_fn(|row| end[row] - start[row]);
        let below = from_fn(|row| start[row] - before[row]);
        let above = from_fn(|row| after[row] - end[row]);
        let slopes_start = self.start.slopes::<N, MONOTONE>(secants, below, above);
        let slopes_end = self.end.slopes::<N, MONOTONE>(secants, above, below);
        let [of_start, of_end, of_slope_start, of_slope_end] = self.weights;
        from_fn(|row| {
            // From one end, so that equal values stay as they are.
            let value = if MONOTONE {
                of_start * start[row] + of_end * end[row]
            } else {
                start[row] + of_end * secants[row]
            };
            let value = value + of_slope_start * slopes_start[row] + of_slope_end * slopes_end[row];
            if !MONOTONE {
                return value;
            }
            // The cubic lies between its ends: rounding shall not take it out.
            larger(smaller(value, larger(start[row], end[row])), smaller(start[row], end[row]))
        })
    }
}

impl Side {
    fn new(beyond: Option<(f64, f64)>, opposite: Option<(f64, f64)>) -> Self {
        match (beyond, opposite) {
            (Some((ratio, weight)), _) => Self::Inner { ratio, weight },
            (None, Some((ratio, weight))) => Self::Edge { ratio, weight },
            (None, None) => Self::Edge { ratio: 0.0, weight: 0.0 },
        }
    }

    /// The slopes at this end of the cell, times the width of the cell. `secants`, `beyond` and
    /// `opposite` are the differences of values over the cell, over the one beyond this end and
    /// over the one beyond the other end.
    fn slopes<const N: usize, const MONOTONE: bool>(
        &self,
        secants: [f64; N],
        beyond: [f64; N],
        opposite: [f64; N],
    ) -> [f64; N] {
        match *self {
            Self::Inner { ratio, weight } => from_fn(|row| {
                let (secant, other) = (secants[row], ratio * beyond[row]);
                let parabola = weight * (other - secant) + secant;
                if MONOTONE { limited(parabola, secant, other) } else { parabola }
            }),
            Self::Edge { ratio, weight } => from_fn(|row| {
                let secant = secants[row];
                let parabola = secant + weight * (secant - ratio * opposite[row]);
                // One secant alone limits it, and its sign has to be that of the parabola.
                let limit = secant.copysign(parabola);
                if MONOTONE { limited(parabola, secant, limit) } else { parabola }
            }),
        }
    }
}

/// Steffen's limits: 0 where the two secants have different signs, and never more than twice
/// the smaller one.
fn limited(slope: f64, secant: f64, other: f64) -> f64 {
    let signs = 1.0_f64.copysign(secant) + 1.0_f64.copysign(other);
    signs * smaller(smaller(secant.abs(), other.abs()), 0.5 * slope.abs())
}

/// The smaller number; one instruction, where `f64::min` has to mind NaN.
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger number.
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The cubic Hermite basis at `t` from 0 to 1, exact at both.
fn hermite_weights(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    [(1.0 + 2.0 * t) * u * u, t * t * (3.0 - 2.0 * t), t * u * u, -t * t * u]
}
