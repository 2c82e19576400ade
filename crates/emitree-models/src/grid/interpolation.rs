//! The value in a cell, from those at the nodes around it.

use super::axis::{Axis, Location};
use super::cubic::Stencil;
use core::array::from_fn;

/// How a grid is interpolated between its nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Interpolation {
    /// Trilinear: linear along each axis. The error is of second order in the spacing.
    #[default]
    Linear,
    /// Piecewise constant: the value of the nearest node, along each axis. The error is of first order, and
    /// the interpolant jumps half-way between nodes.
    Nearest,
    /// A product of monotone cubics (Steffen 1990, Astronomy and Astrophysics 239, 443), along the first
    /// axis, then the second, then the third: of third order where the data are smooth and monotone, never outside the
    /// range of the eight nodes around, so never negative where the data are not. The limits on
    /// slopes are not linear, so that another order of the axes would give slightly other values.
    MonotoneCubic,
    /// A product of cubics whose slopes at a node are those of the parabola through it and its neighbours (on even nodes
    /// those of Catmull and Rom): of third order where the data are smooth, with continuous derivatives, so that an image costs
    /// no more evaluations than that of a smooth function. Beside a jump of the data it overshoots by up to a tenth of it;
    /// data of which none is negative stay so.
    Cubic,
}

/// The value of the nearest node.
#[inline(always)]
pub(super) fn nearest([x, y, z]: &[Axis; 3], values: &[f64], at: [Location; 3]) -> f64 {
    let [nx, ny] = [x, y].map(|axis| axis.nodes().len());
    values[x.nearest(at[0]) + nx * (y.nearest(at[1]) + ny * z.nearest(at[2]))]
}

/// Linear along each axis.
#[inline(always)]
pub(super) fn linear(axes: &[Axis; 3], values: &[f64], [x, y, z]: [Location; 3]) -> f64 {
    let [nx, ny] = [&axes[0], &axes[1]].map(|axis| axis.nodes().len());
    let between = |from: f64, to: f64, t: f64| (1.0 - t) * from + t * to;
    let along_x = |row: usize| {
        let start = nx * row + x.cell;
        let pair = &values[start..start + 2];
        between(pair[0], pair[1], x.fraction)
    };
    let along_y = |plane: usize| {
        let row = ny * plane + y.cell;
        between(along_x(row), along_x(row + 1), y.fraction)
    };
    between(along_y(z.cell), along_y(z.cell + 1), z.fraction)
}

/// Cubics along each axis, monotone ones or smooth ones.
pub(super) fn cubic<const MONOTONE: bool>(
    axes: &[Axis; 3],
    values: &[f64],
    at: [Location; 3],
) -> f64 {
    let [nx, ny] = [&axes[0], &axes[1]].map(|axis| axis.nodes().len());
    let [x, y, z]: [Stencil; 3] = from_fn(|i| Stencil::new(&axes[i], at[i]));
    // Four planes at once: rows of one y in all of them along x, then the four along y.
    let along_x = |y_node: usize| {
        let rows: [&[f64]; 4] = z.nodes.map(|z_node| {
            let row = y_node + ny * z_node;
            &values[nx * row..nx * (row + 1)]
        });
        x.interpolate::<4, MONOTONE>(x.nodes.map(|x_node| rows.map(|row| row[x_node])))
    };
    let planes = y.interpolate::<4, MONOTONE>(y.nodes.map(along_x));
    let [rate] = z.interpolate::<1, MONOTONE>(planes.map(|value| [value]));
    rate
}
