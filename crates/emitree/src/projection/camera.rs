//! Cameras: an image plane at a viewpoint, with depths, bounds, edges and opaque bodies.

use super::bounds::Bounds;
use super::charts::chart::Chart;
use super::edge::Edge;
use super::ellipsoid::Ellipsoid;
use super::frame::{Frame, GeometryError, Viewpoint};
use super::plane::{
    DiscMapping, DiscPlane, EquirectangularPlane, ImagePlane, ParallelPlane, PolarPlane,
    TangentPlane,
};
use super::region::Region;
use super::singularity::Singularity;
use super::span::Depth;
use super::surroundings::{Observer, SightLine, Surroundings};
use super::vector::{along, difference, dot, norm};
use super::{MappedPoint, Projection, ViewGeometry};

/// A camera with the image plane `P`.
///
/// Lines of sight reach from `near` to `far`, distances along each line, `far` possibly infinite;
/// they are clipped to the [bounds](Self::with_bounds), and end at
/// [opaque bodies](Self::with_occulters).
#[derive(Clone, Debug, PartialEq)]
pub struct Camera<P> {
    frame: Frame,
    plane: P,
    surroundings: Surroundings,
}

/// Parallel lines of sight in any direction. FITS: linear axes.
///
/// ```
/// use emitree::{Orthographic, Projection, Viewpoint};
///
/// let viewpoint =
///     Viewpoint { position: [0.0, 0.0, 9.0], target: [0.0; 3], up: [0.0, 1.0, 0.0] };
/// let everything = [f64::NEG_INFINITY, f64::INFINITY];
/// let camera = Orthographic::new(viewpoint, [4.0, 2.0], everything)?;
/// let corner = camera.world_from_canonical([0.0, 0.0, 0.5]);
/// assert_eq!(corner.position, [-2.0, -1.0, 0.0]);
/// # Ok::<(), emitree::projection::GeometryError>(())
/// ```
pub type Orthographic = Camera<ParallelPlane>;

/// A pinhole camera. FITS: TAN.
///
/// ```
/// use emitree::{Perspective, Projection, Viewpoint};
///
/// let viewpoint =
///     Viewpoint { position: [0.0, 0.0, 9.0], target: [0.0; 3], up: [0.0, 1.0, 0.0] };
/// let camera = Perspective::new(viewpoint, [1.0, 1.0], [0.0, 20.0])?;
/// let centre = camera.world_from_canonical([0.5, 0.5, 0.45]);
/// assert!(centre.position[2].abs() < 1e-12);
/// # Ok::<(), emitree::projection::GeometryError>(())
/// ```
pub type Perspective = Camera<TangentPlane>;

/// A camera whose columns and rows are uniform in longitude and latitude about the pointing.
/// FITS: CAR.
///
/// ```
/// use emitree::{Equirectangular, Projection, Viewpoint};
///
/// let viewpoint =
///     Viewpoint { position: [0.0; 3], target: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0] };
/// let camera = Equirectangular::new(viewpoint, [0.2, 0.1], [0.0, 10.0])?;
/// let centre = camera.world_from_canonical([0.5, 0.5, 0.5]);
/// assert_eq!(centre.position, [5.0, 0.0, 0.0]);
/// assert_eq!(centre.path_per_depth, 10.0);
/// # Ok::<(), emitree::projection::GeometryError>(())
/// ```
pub type Equirectangular = Camera<EquirectangularPlane>;

/// The paper's polar view: azimuth along the columns, the angle from the pointing along the rows.
///
/// ```
/// use emitree::{Polar, Projection, Viewpoint};
/// use std::f64::consts::{PI, TAU};
///
/// let viewpoint =
///     Viewpoint { position: [0.0; 3], target: [0.0, 0.0, 1.0], up: [0.0, 1.0, 0.0] };
/// let whole_sky = Polar::new(viewpoint, TAU, [0.0, 10.0])?;
/// assert!((whole_sky.solid_angle([0.0; 2], [1.0; 2]) - 4.0 * PI).abs() < 1e-12);
/// # Ok::<(), emitree::projection::GeometryError>(())
/// ```
pub type Polar = Camera<PolarPlane>;

/// The sky as a disc. FITS: ARC or ZEA.
///
/// ```
/// use emitree::projection::{DiscMapping, Region, ViewGeometry};
/// use emitree::{Fisheye, Projection, Viewpoint};
/// use std::f64::consts::PI;
///
/// let viewpoint =
///     Viewpoint { position: [0.0; 3], target: [0.0, 0.0, 1.0], up: [0.0, 1.0, 0.0] };
/// let camera = Fisheye::new(viewpoint, PI, DiscMapping::Equidistant, [0.0, 10.0])?;
/// assert_eq!(camera.region([0.01, 0.01]), Region::Outside);
/// assert!((camera.solid_angle([0.0; 2], [1.0; 2]) - 2.0 * PI).abs() < 1e-10);
/// # Ok::<(), emitree::projection::GeometryError>(())
/// ```
pub type Fisheye = Camera<DiscPlane>;

impl Orthographic {
    /// Parallel lines of sight through a rectangle of `extent` = \[width, height\] in the length unit
    /// around `viewpoint`, at depths \[near, far\] counted from its plane; −∞ and ∞ are depths.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the viewpoint has no rotation, the extent is not positive, or not
    /// near < far.
    pub fn new(
        viewpoint: Viewpoint,
        extent: [f64; 2],
        depth: [f64; 2],
    ) -> Result<Self, GeometryError> {
        Self::at(&viewpoint, ParallelPlane::new(extent)?, depth)
    }

    /// The view of [`Canonical`](super::Canonical), the unit cube along +z, as a camera that can have
    /// bounds and opaque bodies.
    pub fn of_unit_cube() -> Self {
        let plane = ParallelPlane::unit_square();
        Self::of_frame(Frame::of_world([0.0; 3]), plane, Depth::of_unit_cube())
    }
}

impl Perspective {
    /// A pinhole camera at `viewpoint` with fields of view `fov_rad` = \[width, height\] \[rad\].
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the viewpoint has no rotation, a field of view is not in (0, π), or not
    /// 0 ≤ near < far ≤ ∞.
    pub fn new(
        viewpoint: Viewpoint,
        fov_rad: [f64; 2],
        depth: [f64; 2],
    ) -> Result<Self, GeometryError> {
        Self::at(&viewpoint, TangentPlane::new(fov_rad)?, depth)
    }

    /// The same camera with the pointing at the canonical (x, y) instead of the middle of the image, \[0.5, 0.5\];
    /// it may be beside the image. The image has the same size on the tangent plane: tan(w/2) is half of its
    /// width there.
    ///
    /// ```
    /// use emitree::{Perspective, Projection, Viewpoint};
    ///
    /// let viewpoint = Viewpoint { position: [10.0, 0.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    /// let camera = Perspective::new(viewpoint, [0.1, 0.1], [0.0, 20.0])?;
    /// let camera = camera.with_principal_point([0.25, 0.5])?;
    /// // There the emission towards the observer is along x.
    /// let point = camera.world_from_canonical([0.25, 0.5, 0.1]);
    /// assert!((point.direction[0] - 1.0).abs() < 1e-15);
    /// # Ok::<(), emitree::projection::GeometryError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if a part of the image is more than 89 degrees from the pointing along right or up.
    pub fn with_principal_point(self, principal_point: [f64; 2]) -> Result<Self, GeometryError> {
        Ok(Self { plane: self.plane.with_principal_point(principal_point)?, ..self })
    }
}

impl Equirectangular {
    /// A camera at `viewpoint` with fields of view `fov_rad` = \[width, height\] \[rad\].
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the viewpoint has no rotation, the width is not in (0, 2π], the height
    /// is not in (0, π], or not 0 ≤ near < far ≤ ∞.
    pub fn new(
        viewpoint: Viewpoint,
        fov_rad: [f64; 2],
        depth: [f64; 2],
    ) -> Result<Self, GeometryError> {
        Self::at(&viewpoint, EquirectangularPlane::new(fov_rad)?, depth)
    }
}

impl Polar {
    /// A cone of the full angle `fov_rad` \[rad\] about the pointing of `viewpoint`, at most 2π.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the viewpoint has no rotation, the angle is not in (0, 2π], or not
    /// 0 ≤ near < far ≤ ∞.
    pub fn new(viewpoint: Viewpoint, fov_rad: f64, depth: [f64; 2]) -> Result<Self, GeometryError> {
        Self::at(&viewpoint, PolarPlane::new(fov_rad)?, depth)
    }
}

impl Fisheye {
    /// A cone of the full angle `fov_rad` \[rad\] about the pointing of `viewpoint`, at most 2π, as a
    /// disc.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the viewpoint has no rotation, the angle is not in (0, 2π], or not
    /// 0 ≤ near < far ≤ ∞.
    pub fn new(
        viewpoint: Viewpoint,
        fov_rad: f64,
        mapping: DiscMapping,
        depth: [f64; 2],
    ) -> Result<Self, GeometryError> {
        Self::at(&viewpoint, DiscPlane::new(fov_rad, mapping)?, depth)
    }
}

impl<P: ImagePlane> Camera<P> {
    /// A camera of any image plane at `viewpoint`, with depths \[near, far\] along each line.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if the viewpoint has no rotation, or not near < far.
    pub fn at(viewpoint: &Viewpoint, plane: P, depth: [f64; 2]) -> Result<Self, GeometryError> {
        let frame = Frame::new(viewpoint)?;
        let scale = norm(difference(viewpoint.target, viewpoint.position));
        let depth = Depth::new(depth, scale, plane.is_parallel())?;
        Ok(Self::of_frame(frame, plane, depth))
    }

    /// A camera in the surroundings of another one.
    pub(super) fn within(frame: Frame, plane: P, surroundings: Surroundings) -> Self {
        Self { frame, plane, surroundings }
    }

    /// The image plane.
    pub(super) fn plane(&self) -> &P {
        &self.plane
    }

    fn of_frame(frame: Frame, plane: P, depth: Depth) -> Self {
        let forward = frame.world_from_camera([0.0, 0.0, 1.0]);
        let observer = match plane.is_parallel() {
            true => Observer::Parallel { plane_point: frame.origin, direction: forward },
            false => Observer::Point(frame.origin),
        };
        Self { frame, plane, surroundings: Surroundings::new(observer, depth) }
    }

    /// A camera of an image plane whose (right, up, forward) are the world's (x, y, z); an infinite
    /// depth is resolved over the distance from the origin, or 1 there.
    #[cfg(feature = "healpix")]
    pub(super) fn of_world(
        position: [f64; 3],
        plane: P,
        depth: [f64; 2],
    ) -> Result<Self, GeometryError> {
        let distance = norm(position);
        let scale = if distance > 0.0 { distance } else { 1.0 };
        let depth = Depth::new(depth, scale, plane.is_parallel())?;
        Ok(Self::of_frame(Frame::of_world(position), plane, depth))
    }

    /// The same camera for an emission inside of `bounds` only: each line of sight is clipped to them.
    #[must_use]
    pub fn with_bounds(mut self, bounds: Bounds) -> Self {
        self.surroundings.bounds = Some(bounds);
        self
    }

    /// The same camera with opaque bodies, at whose surfaces lines of sight end.
    ///
    /// # Errors
    ///
    /// [`GeometryError::InsideOcculter`] if the observer is inside one of them.
    pub fn with_occulters(mut self, bodies: Vec<Ellipsoid>) -> Result<Self, GeometryError> {
        let position = self.frame.origin;
        if !self.plane.is_parallel()
            && let Some(inside) = bodies.iter().position(|body| body.contains(position))
        {
            return Err(GeometryError::InsideOcculter { number: inside + 1, position });
        }
        self.surroundings.bodies = bodies;
        Ok(self)
    }

    /// The same camera with the surfaces on which the emission jumps or has a kink.
    ///
    /// ```
    /// use emitree::Orthographic;
    /// use emitree::projection::{Edge, Ellipsoid};
    ///
    /// let shell = Edge::Ellipsoid(Ellipsoid::sphere([0.5; 3], 0.2)?);
    /// let wall = Edge::plane([0.5; 3], [1.0, 0.0, 1.0])?;
    /// let camera = Orthographic::of_unit_cube().with_edges(vec![shell, wall]);
    /// # Ok::<(), emitree::projection::GeometryError>(())
    /// ```
    #[must_use]
    pub fn with_edges(mut self, edges: Vec<Edge>) -> Self {
        self.surroundings.edges = edges;
        self
    }

    /// The same camera with the points and axes at which the emission is singular, or has a peak far smaller
    /// than a pixel.
    ///
    /// ```
    /// use emitree::Orthographic;
    /// use emitree::projection::Singularity;
    ///
    /// let cusp = Singularity::point([0.5; 3])?;
    /// let camera = Orthographic::of_unit_cube().with_singularities(vec![cusp]);
    /// # Ok::<(), emitree::projection::GeometryError>(())
    /// ```
    #[must_use]
    pub fn with_singularities(mut self, singularities: Vec<Singularity>) -> Self {
        self.surroundings.singularities = singularities;
        self
    }

    /// The line of sight at (x, y) in the world, and the part of it inside the bounds.
    fn line(&self, xy: [f64; 2]) -> SightLine {
        let sight = self.plane.sight(xy);
        let offset = self.frame.world_from_camera(sight.origin);
        let origin = along(self.frame.origin, 1.0, offset);
        self.surroundings.line(origin, self.frame.world_from_camera(sight.direction))
    }

    /// The image plane's coordinates of a world point, and its line.
    fn line_to(&self, position: [f64; 3]) -> Option<([f64; 2], SightLine, f64)> {
        let xy = self.plane.xy_of(self.frame.camera_from_world(position))?;
        let line = self.line(xy);
        let distance = dot(difference(position, line.origin), line.direction);
        Some((xy, line, distance))
    }
}

impl<P: ImagePlane> Projection for Camera<P> {
    fn world_from_canonical(&self, [x, y, z]: [f64; 3]) -> MappedPoint {
        let mut point = [MappedPoint::default()];
        self.points_of_line([x, y], &[z], &mut point);
        point[0]
    }

    fn canonical_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let ([x, y], line, distance) = self.line_to(position)?;
        let (_, end) = self.surroundings.end_of(&line);
        Some([x, y, self.surroundings.span(line.ends[0], end).z_of(distance)])
    }

    fn solid_angle_density(&self, xy: [f64; 2]) -> f64 {
        if self.plane.contains(xy) { self.plane.solid_angle_density(xy) } else { 0.0 }
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        self.plane.solid_angle(min, max)
    }

    fn periodic(&self) -> [bool; 3] {
        [self.plane.is_closed(), false, false]
    }

    fn view_geometry(&self) -> Option<&dyn ViewGeometry> {
        Some(self)
    }
}

impl<P: ImagePlane> ViewGeometry for Camera<P> {
    fn points_of_line(&self, xy: [f64; 2], depths: &[f64], points: &mut [MappedPoint]) {
        let line = self.line(xy);
        let (_, end) = self.surroundings.end_of(&line);
        let span = self.surroundings.span(line.ends[0], end);
        let is_in_image = self.plane.contains(xy);
        for (point, &z) in points.iter_mut().zip(depths) {
            *point = line.point(&span, z);
            point.position = self.surroundings.outside(point.position);
            if !is_in_image {
                point.path_per_depth = 0.0;
            }
        }
    }

    fn region(&self, xy: [f64; 2]) -> Region {
        if !self.plane.contains(xy) {
            return Region::Outside;
        }
        self.surroundings.end_of(&self.line(xy)).0
    }

    fn has_rim(&self) -> bool {
        !self.plane.is_whole()
    }

    fn surroundings(&self) -> Option<&Surroundings> {
        Some(&self.surroundings)
    }

    fn line(&self, xy: [f64; 2]) -> Option<SightLine> {
        Some(Self::line(self, xy))
    }

    fn place_of_line(&self, line: &SightLine) -> Option<[f64; 2]> {
        let distance = match self.surroundings.observer {
            Observer::Point(position) => 1.0 + norm(position),
            Observer::Parallel { .. } => 0.0,
        };
        self.plane.xy_of(self.frame.camera_from_world(line.at(distance)))
    }

    fn chart(&self, tile: usize) -> Box<dyn Chart + '_> {
        Box::new(PlaneChart { camera: self, tile })
    }
}

/// The image plane itself as a chart of whole lines of sight: it continues beyond the rim of a disc,
/// and behind opaque bodies.
#[derive(Debug)]
pub(super) struct PlaneChart<'a, P> {
    pub(super) camera: &'a Camera<P>,
    pub(super) tile: usize,
}

impl<P: ImagePlane> Chart for PlaneChart<'_, P> {
    fn world_from_chart(&self, [x, y, z]: [f64; 3]) -> MappedPoint {
        let line = self.camera.line([x, y]);
        let surroundings = &self.camera.surroundings;
        let [from, to] = line.ends;
        let mut point = line.point(&surroundings.span(from, to), z);
        point.position = surroundings.outside(point.position);
        point
    }

    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let ([x, y], line, distance) = self.camera.line_to(position)?;
        let [from, to] = line.ends;
        Some([x, y, self.camera.surroundings.span(from, to).z_of(distance)])
    }

    fn density(&self, uv: [f64; 2]) -> f64 {
        self.camera.plane.solid_angle_density(uv)
    }

    fn line(&self, uv: [f64; 2]) -> Option<SightLine> {
        Some(self.camera.line(uv))
    }

    fn depth_of(&self, line: &SightLine, distance: f64) -> f64 {
        let [from, to] = line.ends;
        self.camera.surroundings.span(from, to).z_of(distance).clamp(0.0, 1.0)
    }

    fn visible_end(&self, uv: [f64; 2]) -> Option<(usize, f64)> {
        let line = self.camera.line(uv);
        let surroundings = &self.camera.surroundings;
        let (Region::Body(body), end) = surroundings.end_of(&line) else { return None };
        let [from, to] = line.ends;
        Some((body, surroundings.span(from, to).z_of(end).clamp(0.0, 1.0)))
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        (self.tile, uv)
    }
}

#[cfg(test)]
mod tests;
