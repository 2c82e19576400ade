//! [`GridAxes`]: the three axes of a grid, and the cell of each that a position lies in.

use super::arrange::Arrangement;
use super::axis::{Axis, Location, check_nodes};
use super::coordinates::{ANGLE_ROUNDING, Coordinates, in_turn_from, of_all};
use super::error::{GridError, OutsideGrid};
use core::f64::consts::PI;
use emitree::projection::{Bounds, Edge, Ellipsoid};

/// The axes of a grid: its coordinates, and the nodes along each.
///
/// Nodes increase or decrease strictly, at any distances. An axis of φ that goes all round is closed, whether
/// or not its last node repeats the first: it does so if the gap that it leaves is at most 1.5 of its
/// largest spacings. One node of φ is enough for data that are the same all round.
///
/// With a closed φ, all azimuths meet at the poles, or on the z axis of cylindrical coordinates, and so do
/// the values there: each of those rows of values is replaced by its mean over φ. Nodes that end before
/// a pole, at a distance of one of their spacings or less, are continued to it with the mean
/// over φ of their last row, so that cells around the pole are filled: the error is of
/// second order in the spacing, and the interpolant is continuous there.
///
/// ```
/// use core::f64::consts::PI;
/// use emitree_models::grid::{Coordinates, Grid, GridAxes};
///
/// let degrees = |nodes: &[f64]| nodes.iter().map(|node| node.to_radians()).collect::<Vec<_>>();
/// let nodes = [vec![1.0, 2.0, 5.0], degrees(&[45.0, 135.0]), degrees(&[0.0, 120.0, 240.0])];
/// let axes = GridAxes::new(Coordinates::Spherical, nodes)?;
/// assert_eq!(axes.shape(), [3, 2, 3]); // as the values are given
/// assert_eq!((axes.nodes()[1][0], axes.nodes()[1][3]), (0.0, PI)); // with the poles
/// let grid = Grid::on(axes, vec![7.0; 18])?;
/// # Ok::<(), emitree_models::GridError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GridAxes {
    coordinates: Coordinates,
    axes: [Axis; 3],
    arrangement: Arrangement,
}

impl GridAxes {
    /// Axes with these nodes, lengths in the length unit of the scene and angles in radians.
    ///
    /// # Errors
    ///
    /// [`GridError`] names the axis, the node, its value, and what was expected.
    pub fn new(coordinates: Coordinates, nodes: [Vec<f64>; 3]) -> Result<Self, GridError> {
        for (axis, nodes) in coordinates.names().into_iter().zip(&nodes) {
            let least = if axis == "phi" { 1 } else { 2 };
            if nodes.len() < least {
                return Err(GridError::TooFewNodes { axis, count: nodes.len() });
            }
            check_nodes(axis, nodes)?;
            check_range(axis, nodes)?;
        }
        let (arrangement, axes) = Arrangement::new(coordinates, nodes);
        Ok(Self { coordinates, axes, arrangement })
    }

    /// The same axes with that of this number, from 0, interpolated in the logarithm of its coordinate, a length.
    /// Its nodes are not continued to the z axis, which has no logarithm.
    ///
    /// ```
    /// use emitree_models::grid::{Coordinates, GridAxes};
    ///
    /// let nodes = [vec![0.0, 1.0], vec![1.0, 2.0], vec![0.0]];
    /// let axes = GridAxes::new(Coordinates::Spherical, nodes)?;
    /// let error = axes.with_logarithmic(0).unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "node 0 of the r axis is 0: expected a length above 0 and apart from the node before, \
    ///      which has a logarithm"
    /// );
    /// # Ok::<(), emitree_models::GridError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`GridError::LogarithmOfAngle`], or [`GridError::OutOfRange`] for nodes that have no logarithms.
    pub fn with_logarithmic(mut self, number: usize) -> Result<Self, GridError> {
        const EXPECTED: &str =
            "a length above 0 and apart from the node before, which has a logarithm";
        let names = self.coordinates.names();
        let (Some(&axis), Some(place)) = (names.get(number), self.axes.get_mut(number)) else {
            return Ok(self);
        };
        if self.coordinates.are_angles()[number] {
            return Err(GridError::LogarithmOfAngle { axis });
        }
        let lengths = self.arrangement.without_added(number, place.clone());
        *place = lengths.logarithmic().map_err(|(index, value)| GridError::OutOfRange {
            axis,
            index,
            value,
            expected: EXPECTED,
        })?;
        Ok(self)
    }

    /// The coordinates.
    pub fn coordinates(&self) -> Coordinates {
        self.coordinates
    }

    /// The number of nodes along the axes, as they were given.
    pub fn shape(&self) -> [usize; 3] {
        self.arrangement.given
    }

    /// The coordinates of the nodes that are interpolated between: increasing, angles in radians, with the nodes
    /// that close a turn and those at poles.
    pub fn nodes(&self) -> [&[f64]; 3] {
        self.axes.each_ref().map(Axis::nodes)
    }

    /// Which axes are interpolated in the logarithm of their coordinate.
    pub fn are_logarithmic(&self) -> [bool; 3] {
        self.axes.each_ref().map(Axis::is_logarithmic)
    }

    /// A shape that contains all nodes, for the bounds of a scene: the box of a Cartesian grid, the sphere of the
    /// largest r, the box around the largest ρ.
    pub fn bounds(&self) -> Option<Bounds> {
        let [a, b, c] = &self.axes;
        match self.coordinates {
            Coordinates::Cartesian => {
                Bounds::cuboid([a.min(), b.min(), c.min()], [a.max(), b.max(), c.max()])
            }
            Coordinates::Cylindrical => {
                let rho = a.max();
                Bounds::cuboid([-rho, -rho, c.min()], [rho, rho, c.max()])
            }
            Coordinates::Spherical => Ellipsoid::sphere([0.0; 3], a.max()).map(Bounds::Ellipsoid),
        }
        .ok()
    }

    /// The surfaces at which the data end, and their interpolant jumps, that a camera can declare: the spheres of
    /// the least r, unless it is 0, and of the largest.
    pub fn edges(&self) -> Vec<Edge> {
        if self.coordinates != Coordinates::Spherical {
            return Vec::new();
        }
        let radii = [self.axes[0].min(), self.axes[0].max()];
        // A sphere without a radius is none.
        let sphere = |radius| Ellipsoid::sphere([0.0; 3], radius).map(Edge::Ellipsoid).ok();
        radii.into_iter().filter_map(sphere).collect()
    }

    pub(super) fn axes(&self) -> &[Axis; 3] {
        &self.axes
    }

    /// The values at all nodes that are interpolated between, from those that were given.
    pub(super) fn arranged(&self, values: Vec<f64>) -> Result<Vec<f64>, GridError> {
        let (shape, coordinates) = (self.shape(), self.coordinates);
        let count = shape.iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
        if count != Some(values.len()) {
            return Err(GridError::Length { shape, coordinates, found: values.len() });
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let row = at / shape[0];
            let index = (at % shape[0], row % shape[1], row / shape[1]);
            return Err(GridError::ValueNotFinite { index, coordinates, value: values[at] });
        }
        Ok(self.arrangement.apply(values))
    }

    /// The coordinates of a position, φ in the turn of its axis.
    #[inline(always)]
    pub(super) fn coordinates_of(&self, position: [f64; 3]) -> [f64; 3] {
        let mut along = self.coordinates.of(position);
        if let Some(phi) = self.coordinates.azimuth() {
            along[phi] = in_turn_from(self.arrangement.turn_start, along[phi]);
        }
        along
    }

    /// The cell around a position, along each axis.
    #[inline(always)]
    pub(super) fn locate(&self, position: [f64; 3]) -> Option<[Location; 3]> {
        let [a, b, c] = &self.axes;
        let along = self.coordinates_of(position);
        Some([a.locate(along[0])?, b.locate(along[1])?, c.locate(along[2])?])
    }

    /// The coordinates of many positions, in columns, φ in the turn of its axis.
    pub(super) fn coordinates_of_all(&self, positions: &[[f64; 3]], columns: [&mut [f64]; 3]) {
        of_all(self.coordinates, self.arrangement.turn_start, positions, columns);
    }

    /// Why a position is outside.
    pub(crate) fn outside(&self, position: [f64; 3]) -> OutsideGrid {
        let along = self.coordinates_of(position);
        let leaves = |&i: &usize| self.axes[i].locate(along[i]).is_none();
        let i = (0..3).find(leaves).unwrap_or_default();
        let (min, max) = (self.axes[i].min(), self.axes[i].max());
        OutsideGrid { position, axis: self.coordinates.names()[i], value: along[i], min, max }
    }
}

/// Refuses coordinates that their axis does not have.
fn check_range(axis: &'static str, nodes: &[f64]) -> Result<(), GridError> {
    let refuse = |is_wrong: fn(f64) -> bool, expected| match nodes
        .iter()
        .position(|&node| is_wrong(node))
    {
        Some(index) => Err(GridError::OutOfRange { axis, index, value: nodes[index], expected }),
        None => Ok(()),
    };
    match axis {
        "r" | "rho" => refuse(|node| node < 0.0, "a distance, 0 or more"),
        "theta" => refuse(
            |node| !(-ANGLE_ROUNDING..=PI + ANGLE_ROUNDING).contains(&node),
            "a colatitude from 0 to pi, in radians (degrees have to be converted)",
        ),
        "phi" => {
            let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
            let span = (last - first).abs();
            if span > 2.0 * PI + ANGLE_ROUNDING {
                return Err(GridError::MoreThanATurn { axis, span, first, last });
            }
            Ok(())
        }
        _ => Ok(()),
    }
}
