//! What the methods need of a view beyond its map: edges, layers, tiles, and many points in one call.
//!
//! Users implement [`Projection`]; cameras with bodies, discs and skies implement [`ViewGeometry`] too. The
//! methods use any projection through the functions of `dyn Projection` here, which have defaults for
//! projections without a [`ViewGeometry`].

use super::charts::chart::{Chart, Whole};
use super::region::Region;
use super::surroundings::{SightLine, Surroundings};
use super::{MappedPoint, Projection};

/// The edges, layers and tiles of a view, and the points of a line or the solid angles of a row in one
/// call; see [`Projection::view_geometry`].
///
/// Every method has a default, for a view that is smooth and in one piece.
///
/// ```
/// use emitree::projection::{Ellipsoid, Region, ViewGeometry};
/// use emitree::{Orthographic, Projection};
///
/// let ball = Ellipsoid::sphere([0.5; 3], 0.2)?;
/// let camera = Orthographic::of_unit_cube().with_occulters(vec![ball])?;
/// let projection: &dyn Projection = &camera;
/// let geometry = projection.view_geometry().ok_or("smooth")?;
/// assert_eq!(geometry.region([0.5, 0.5]), Region::Body(0));
/// assert_eq!(geometry.region([0.1, 0.1]), Region::Sky);
/// assert!(geometry.line([0.5, 0.5]).is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait ViewGeometry: Projection {
    /// The region at (x, y): the map is smooth where this does not change.
    fn region(&self, _xy: [f64; 2]) -> Region {
        Region::Sky
    }

    /// Whether [`region`](Self::region) may be anything but [`Region::Sky`].
    fn has_regions(&self) -> bool {
        self.has_rim() || self.surroundings().is_some_and(|around| !around.bodies.is_empty())
    }

    /// Whether some points of the image plane belong to no image, as the corners around a disc.
    fn has_rim(&self) -> bool {
        false
    }

    /// What the lines of sight meet, from which charts are made; `None` if all lines belong to the
    /// [chart](Self::chart) of the image plane.
    fn surroundings(&self) -> Option<&Surroundings> {
        None
    }

    /// The line of sight at (x, y), beyond the rim of a disc too; `None` if there are no
    /// [surroundings](Self::surroundings).
    fn line(&self, _xy: [f64; 2]) -> Option<SightLine> {
        None
    }

    /// The canonical (x, y) at which a line of sight is seen, beyond the square if it is not in view;
    /// `None` if it is nowhere on the image plane.
    fn place_of_line(&self, _line: &SightLine) -> Option<[f64; 2]> {
        None
    }

    /// The image plane as a chart of whole lines of sight, as number `tile` of the tiles of an image.
    fn chart(&self, tile: usize) -> Box<dyn Chart + '_> {
        Box::new(Whole { projection: self, tile })
    }

    /// The parts of an image that is several squares, from the lowest rows up, all of one shape;
    /// none if the image is one piece.
    fn tiles(&self) -> Vec<&dyn Projection> {
        Vec::new()
    }

    /// The points at each of `depths` on the line of sight at (x, y): the values of
    /// [`world_from_canonical`](Projection::world_from_canonical), for one line at once.
    ///
    /// # Panics
    ///
    /// May panic if there are not as many points as depths.
    fn points_of_line(&self, xy: [f64; 2], depths: &[f64], points: &mut [MappedPoint]) {
        points_one_by_one(self, xy, depths, points);
    }

    /// Solid angle \[sr\] of each of the equal parts, as many as there are numbers, of the row from
    /// `y[0]` to `y[1]` of the canonical image plane: the values of
    /// [`solid_angle`](Projection::solid_angle), for all pixels of a row at once.
    fn solid_angles_of_row(&self, y: [f64; 2], solid_angles: &mut [f64]) {
        solid_angles_one_by_one(self, y, solid_angles);
    }
}

/// What the methods need of any projection.
impl dyn Projection + '_ {
    /// As [`ViewGeometry::region`].
    pub(crate) fn region(&self, xy: [f64; 2]) -> Region {
        self.view_geometry().map_or(Region::Sky, |geometry| geometry.region(xy))
    }

    /// As [`ViewGeometry::chart`].
    pub(crate) fn chart(&self, tile: usize) -> Box<dyn Chart + '_> {
        match self.view_geometry() {
            Some(geometry) => geometry.chart(tile),
            None => Box::new(Whole { projection: self, tile }),
        }
    }

    /// As [`ViewGeometry::tiles`].
    pub(crate) fn tiles(&self) -> Vec<&dyn Projection> {
        self.view_geometry().map_or_else(Vec::new, ViewGeometry::tiles)
    }

    /// As [`ViewGeometry::points_of_line`].
    pub(crate) fn points_of_line(&self, xy: [f64; 2], depths: &[f64], points: &mut [MappedPoint]) {
        match self.view_geometry() {
            Some(geometry) => geometry.points_of_line(xy, depths, points),
            None => points_one_by_one(self, xy, depths, points),
        }
    }

    /// As [`ViewGeometry::solid_angles_of_row`].
    pub(crate) fn solid_angles_of_row(&self, y: [f64; 2], solid_angles: &mut [f64]) {
        match self.view_geometry() {
            Some(geometry) => geometry.solid_angles_of_row(y, solid_angles),
            None => solid_angles_one_by_one(self, y, solid_angles),
        }
    }
}

/// The points of a line, each by the map.
fn points_one_by_one<P: Projection + ?Sized>(
    projection: &P,
    [x, y]: [f64; 2],
    depths: &[f64],
    points: &mut [MappedPoint],
) {
    for (point, &z) in points.iter_mut().zip(depths) {
        *point = projection.world_from_canonical([x, y, z]);
    }
}

/// The solid angles of a row, each by its own integral.
fn solid_angles_one_by_one<P: Projection + ?Sized>(
    projection: &P,
    y: [f64; 2],
    solid_angles: &mut [f64],
) {
    let columns = solid_angles.len() as f64;
    for (column, solid_angle) in solid_angles.iter_mut().enumerate() {
        // Borders as quotients, so that neighbours share them to the last bit.
        let x = [column, column + 1].map(|c| c as f64 / columns);
        *solid_angle = projection.solid_angle([x[0], y[0]], [x[1], y[1]]);
    }
}
