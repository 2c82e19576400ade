//! [`Grid`]: an emission from values at the nodes of three axes.

use super::axes::GridAxes;
use super::coordinates::Coordinates;
use super::error::{GridError, OutsideGrid};
use super::interpolation::{Interpolation, cubic, linear, nearest};
use super::locations::Locations;
use core::fmt;
use emitree::{Emission, Samples};
use std::sync::Arc;

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

/// An emission rate from values at the nodes of a grid with Cartesian, cylindrical or spherical axes, uniform or
/// not.
///
/// Cells of an even axis are found by a product, of an uneven one by a table and bisection; both give the same
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
    axes: Arc<GridAxes>,
    /// One for each node that is interpolated between, the first axis fastest.
    values: Arc<Vec<f64>>,
    /// What smooth cubics do not fall below: 0 if no value is negative.
    least: f64,
    interpolation: Interpolation,
    outside: Outside,
}

impl Grid {
    /// A grid of `values` at the `nodes` of x, y and z, in the length unit of the scene.
    ///
    /// `values` has one finite number for each node, that of the node (i, j, k) at
    /// i + nx (j + ny k): see the [module](super) on the order of the axes. The nodes of each axis
    /// all increase or all decrease; there are at least 2. Interpolation is linear, and outside is 0, until
    /// set otherwise.
    ///
    /// # Errors
    ///
    /// [`GridError`] names the axis or the node, the value, and what was expected.
    pub fn new(nodes: [Vec<f64>; 3], values: Vec<f64>) -> Result<Self, GridError> {
        Self::on(GridAxes::new(Coordinates::Cartesian, nodes)?, values)
    }

    /// A grid of `values` on axes of any coordinates.
    ///
    /// ```
    /// use emitree::{Emission, Samples};
    /// use emitree_models::grid::{Coordinates, Grid, GridAxes};
    ///
    /// // g = r + theta, for all phi.
    /// let (r, theta) = ([1.0, 2.0], [0.0, 1.0, 3.0]);
    /// let values = theta.iter().flat_map(|theta| r.map(|r| r + theta)).collect();
    /// let axes = GridAxes::new(Coordinates::Spherical, [r.to_vec(), theta.to_vec(), vec![0.0]])?;
    /// let mut rates = [0.0];
    /// let samples = Samples::new(&[[0.0, -1.5, 0.0]], &[[0.0, 0.0, 1.0]]);
    /// Grid::on(axes, values)?.emission_rates(&samples, &mut rates)?;
    /// assert!((rates[0] - (1.5 + core::f64::consts::FRAC_PI_2)).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`GridError::Length`] and [`GridError::ValueNotFinite`].
    pub fn on(axes: GridAxes, values: Vec<f64>) -> Result<Self, GridError> {
        let values = Arc::new(axes.arranged(values)?);
        let (interpolation, outside) = (Interpolation::default(), Outside::default());
        let least = if values.iter().all(|&value| value >= 0.0) { 0.0 } else { f64::NEG_INFINITY };
        Ok(Self { axes: Arc::new(axes), values, least, interpolation, outside })
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

    /// The axes.
    pub fn axes(&self) -> &GridAxes {
        &self.axes
    }

    /// The number of nodes along the axes, as they were given.
    pub fn shape(&self) -> [usize; 3] {
        self.axes.shape()
    }

    /// The coordinates of the nodes along the axes: see [`GridAxes::nodes`].
    pub fn nodes(&self) -> [&[f64]; 3] {
        self.axes.nodes()
    }

    /// The values at these nodes, the first axis varying fastest.
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

    /// The value at a position, or `None` outside, whatever it [is](Self::outside) there.
    pub fn value(&self, position: [f64; 3]) -> Option<f64> {
        let at = self.axes.locate(position)?;
        let (axes, values) = (self.axes.axes(), self.values.as_slice());
        Some(match self.interpolation {
            Interpolation::Nearest => nearest(axes, values, at),
            Interpolation::Linear => linear(axes, values, at),
            Interpolation::MonotoneCubic => cubic::<true>(axes, values, at),
            Interpolation::Cubic => cubic::<false>(axes, values, at).max(self.least),
        })
    }

    /// The values at many positions, and `outside` where there is none, whatever it [is](Self::outside) there: the same
    /// bits as those of [`Self::value`], in less time.
    ///
    /// `values` has one place for each position.
    pub fn values_at(&self, positions: &[[f64; 3]], outside: f64, values: &mut [f64]) {
        let mut locations = Locations::default();
        let blocks = positions.chunks(Locations::BLOCK).zip(values.chunks_mut(Locations::BLOCK));
        for (positions, values) in blocks {
            locations.find(&self.axes, positions);
            self.values_in(&locations, outside, values);
        }
    }

    /// The values in these cells of the axes, and `outside` where there is none.
    pub(crate) fn values_in(&self, locations: &Locations, outside: f64, values: &mut [f64]) {
        let (axes, of_nodes) = (self.axes.axes(), self.values.as_slice());
        match self.interpolation {
            Interpolation::Nearest => {
                locations.fill(values, outside, |at| nearest(axes, of_nodes, at));
            }
            Interpolation::Linear => {
                locations.fill(values, outside, |at| linear(axes, of_nodes, at));
            }
            Interpolation::MonotoneCubic => {
                locations.fill(values, outside, |at| cubic::<true>(axes, of_nodes, at));
            }
            Interpolation::Cubic => {
                let value_in = |at| cubic::<false>(axes, of_nodes, at).max(self.least);
                locations.fill(values, outside, value_in);
            }
        }
    }
}

impl fmt::Debug for Grid {
    /// The shape and the range of the axes; the values are too many.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let range = self.nodes().map(|nodes| [nodes[0], nodes[nodes.len() - 1]]);
        f.debug_struct("Grid")
            .field("coordinates", &self.axes.coordinates())
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
        let mut locations = Locations::default();
        let positions = samples.positions().chunks(Locations::BLOCK);
        for (positions, rates) in positions.zip(rates.chunks_mut(Locations::BLOCK)) {
            locations.find(&self.axes, positions);
            if self.outside == Outside::Error
                && let Some(at) = locations.are_inside().iter().position(|is_inside| !is_inside)
            {
                return Err(self.axes.outside(positions[at]));
            }
            self.values_in(&locations, 0.0, rates);
        }
        Ok(())
    }
}
