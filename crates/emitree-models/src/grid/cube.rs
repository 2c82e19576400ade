//! [`Grid`]: values at the nodes of three axes, and what is between them.

use super::axis::{Axis, Location};
use super::cubic::Stencil;
use super::error::{AXES, GridError, OutsideGrid};
use core::array::from_fn;
use core::fmt;
use emitree::{Emission, Samples};
use std::sync::Arc;

/// How a grid is interpolated between its nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Interpolation {
    /// Trilinear: linear along each axis. The error is of second order in the spacing.
    #[default]
    Linear,
    /// A product of monotone cubics (Steffen 1990, Astronomy and Astrophysics 239, 443), along x,
    /// then y, then z: of third order where the data are smooth and monotone, never outside the
    /// range of the eight nodes around, so never negative where the data are not. The limits on
    /// slopes are not linear, so that another order of the axes would give slightly other values.
    MonotoneCubic,
}

/// What a grid is outside its outermost nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Outside {
    /// The rate is 0 there.
    #[default]
    Zero,
    /// A position outside is an error, [`OutsideGrid`].
    Error,
}

/// An emission rate from values at the nodes of a rectilinear grid, uniform or not.
///
/// Cells of an even axis are found by a product, of an uneven one by bisection; both give the same
/// bits for the same nodes. A clone shares the values.
///
/// ```
/// use emitree::{Emission, Samples};
/// use emitree_models::grid::{Grid, Interpolation, Outside};
///
/// // g = x + 10 y + 100 z on 3 x 2 x 2 nodes, x varying fastest.
/// let axes = [vec![0.0, 1.0, 4.0], vec![0.0, 1.0], vec![0.0, 1.0]];
/// let values = [0.0, 100.0].map(|z| [0.0, 10.0].map(|y| [0.0, 1.0, 4.0].map(|x| x + y + z)));
/// let values = values.into_iter().flatten().flatten().collect();
/// let grid = Grid::new(axes, values)?.with_interpolation(Interpolation::Linear);
///
/// let positions = [[2.5, 0.25, 0.5], [5.0, 0.0, 0.0]];
/// let samples = Samples::new(&positions, &[[0.0, 0.0, 1.0]; 2]);
/// let mut rates = [0.0; 2];
/// grid.emission_rates(&samples, &mut rates)?;
/// assert_eq!(rates, [2.5 + 2.5 + 50.0, 0.0]);
///
/// let strict = grid.with_outside(Outside::Error);
/// let error = strict.emission_rates(&samples, &mut rates).unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "the position [5.0, 0.0, 0.0] is outside the grid: its x is 5, expected 0 to 4"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, PartialEq)]
pub struct Grid {
    axes: [Axis; 3],
    /// One for each node, x fastest.
    values: Arc<Vec<f64>>,
    interpolation: Interpolation,
    outside: Outside,
}

impl Grid {
    /// A grid of `values` at the `nodes` of x, y and z, in the length unit of the scene.
    ///
    /// `values` has one finite number for each node, that of the node (i, j, k) at
    /// i + nx (j + ny k): see the [module](super) on the order of the axes. The nodes of each axis
    /// increase strictly; there are at least 2. Interpolation is linear, and outside is 0, until
    /// set otherwise.
    ///
    /// # Errors
    ///
    /// [`GridError`] names the axis or the node, the value, and what was expected.
    pub fn new(nodes: [Vec<f64>; 3], values: Vec<f64>) -> Result<Self, GridError> {
        let [x, y, z] = nodes;
        let axes = [Axis::new('x', x)?, Axis::new('y', y)?, Axis::new('z', z)?];
        let shape = axes.each_ref().map(|axis| axis.nodes().len());
        let count = shape.iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
        if count != Some(values.len()) {
            return Err(GridError::Length { shape, found: values.len() });
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let row = at / shape[0];
            let index = (at % shape[0], row % shape[1], row / shape[1]);
            return Err(GridError::ValueNotFinite { index, value: values[at] });
        }
        let (interpolation, outside) = (Interpolation::default(), Outside::default());
        Ok(Self { axes, values: Arc::new(values), interpolation, outside })
    }

    /// The same grid with another interpolation.
    #[must_use]
    pub fn with_interpolation(self, interpolation: Interpolation) -> Self {
        Self { interpolation, ..self }
    }

    /// The same grid with another answer outside.
    #[must_use]
    pub fn with_outside(self, outside: Outside) -> Self {
        Self { outside, ..self }
    }

    /// The number of nodes along x, y and z.
    pub fn shape(&self) -> [usize; 3] {
        self.axes.each_ref().map(|axis| axis.nodes().len())
    }

    /// The coordinates of the nodes along x, y and z.
    pub fn nodes(&self) -> [&[f64]; 3] {
        self.axes.each_ref().map(Axis::nodes)
    }

    /// The values, x varying fastest.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// How it is interpolated.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// What it is outside.
    pub fn outside(&self) -> Outside {
        self.outside
    }

    /// The cell around a position, along each axis.
    fn locate(&self, position: [f64; 3]) -> Option<[Location; 3]> {
        let [x, y, z] = &self.axes;
        Some([x.locate(position[0])?, y.locate(position[1])?, z.locate(position[2])?])
    }

    /// g outside the grid.
    fn outside_rate(&self, position: [f64; 3]) -> Result<f64, OutsideGrid> {
        if self.outside == Outside::Zero {
            return Ok(0.0);
        }
        let leaves = |&i: &usize| self.axes[i].locate(position[i]).is_none();
        let i = (0..3).find(leaves).unwrap_or_default();
        let axis = &self.axes[i];
        let (min, max) = (axis.min(), axis.max());
        Err(OutsideGrid { position, axis: AXES[i], value: position[i], min, max })
    }

    fn evaluate(
        &self,
        positions: &[[f64; 3]],
        rates: &mut [f64],
        rate_in: impl Fn([Location; 3]) -> f64,
    ) -> Result<(), OutsideGrid> {
        for (rate, &position) in rates.iter_mut().zip(positions) {
            *rate = match self.locate(position) {
                Some(location) => rate_in(location),
                None => self.outside_rate(position)?,
            };
        }
        Ok(())
    }

    fn linear(&self, [x, y, z]: [Location; 3]) -> f64 {
        let [nx, ny, _] = self.shape();
        let between = |from: f64, to: f64, t: f64| (1.0 - t) * from + t * to;
        let along_x = |row: usize| {
            let start = nx * row + x.cell;
            between(self.values[start], self.values[start + 1], x.fraction)
        };
        let along_y = |plane: usize| {
            let row = ny * plane + y.cell;
            between(along_x(row), along_x(row + 1), y.fraction)
        };
        between(along_y(z.cell), along_y(z.cell + 1), z.fraction)
    }

    fn cubic(&self, location: [Location; 3]) -> f64 {
        let [nx, ny, _] = self.shape();
        let [x, y, z]: [Stencil; 3] = from_fn(|i| Stencil::new(&self.axes[i], location[i]));
        // Four planes at once: rows of one y in all of them along x, then the four along y.
        let along_x = |y_node: usize| {
            let rows: [&[f64]; 4] = z.nodes.map(|z_node| {
                let row = y_node + ny * z_node;
                &self.values[nx * row..nx * (row + 1)]
            });
            x.interpolate(x.nodes.map(|x_node| rows.map(|row| row[x_node])))
        };
        let planes = y.interpolate(y.nodes.map(along_x));
        let [rate] = z.interpolate(planes.map(|value| [value]));
        rate
    }
}

impl fmt::Debug for Grid {
    /// The shape and the range of the axes; the values are too many.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let range: [_; 3] = from_fn(|i| [self.axes[i].min(), self.axes[i].max()]);
        f.debug_struct("Grid")
            .field("shape", &self.shape())
            .field("range", &range)
            .field("interpolation", &self.interpolation)
            .field("outside", &self.outside)
            .finish_non_exhaustive()
    }
}

impl Emission for Grid {
    type Error = OutsideGrid;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Self::Error> {
        let positions = samples.positions();
        match self.interpolation {
            Interpolation::Linear => self.evaluate(positions, rates, |at| self.linear(at)),
            Interpolation::MonotoneCubic => self.evaluate(positions, rates, |at| self.cubic(at)),
        }
    }
}
