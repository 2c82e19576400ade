//! Cameras: an image plane at a viewpoint, with depths, bounds and opaque bodies.

use super::bounds::Bounds;
use super::ellipsoid::Ellipsoid;
use super::frame::{Frame, GeometryError, Viewpoint};
use super::layer::{Layer, Region};
use super::plane::{
    DiscMapping, DiscPlane, EquirectangularPlane, ImagePlane, ParallelPlane, PolarPlane,
    TangentPlane,
};
use super::section::{Piece, Section};
use super::span::{Depth, Span};
use super::vector::{along, difference, dot, norm};
use super::{MappedPoint, Projection, ViewGeometry};

/// Lines are clipped this part of their length inside of the bounds: a model that ends there is
/// evaluated inside, whatever rounding does.
const INSIDE_BOUNDS: f64 = 1e-9;

/// A camera with the image plane `P`.
///
/// Lines of sight reach from `near` to `far`, distances along each line, `far` possibly infinite;
/// they are clipped to the [bounds](Self::with_bounds), and end at
/// [opaque bodies](Self::with_occulters).
#[derive(Clone, Debug, PartialEq)]
pub struct Camera<P> {
    frame: Frame,
    plane: P,
    depth: Depth,
    bounds: Option<Bounds>,
    bodies: Vec<Ellipsoid>,
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
        Self {
            frame: Frame::of_world([0.0; 3]),
            plane: ParallelPlane::unit_square(),
            depth: Depth::of_unit_cube(),
            bounds: None,
            bodies: Vec::new(),
        }
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
        Ok(Self { frame, plane, depth, bounds: None, bodies: Vec::new() })
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
        let frame = Frame::of_world(position);
        Ok(Self { frame, plane, depth, bounds: None, bodies: Vec::new() })
    }

    /// The same camera for an emission inside of `bounds` only: each line of sight is clipped to them.
    #[must_use]
    pub fn with_bounds(mut self, bounds: Bounds) -> Self {
        self.bounds = Some(bounds);
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
        self.bodies = bodies;
        Ok(self)
    }

    pub(super) fn plane(&self) -> &P {
        &self.plane
    }

    pub(super) fn bodies(&self) -> &[Ellipsoid] {
        &self.bodies
    }

    /// The line of sight at (x, y) in the world, and the part of it inside the bounds.
    pub(super) fn line(&self, xy: [f64; 2]) -> Line {
        let sight = self.plane.sight(xy);
        let offset = self.frame.world_from_camera(sight.origin);
        let origin = along(self.frame.origin, 1.0, offset);
        let direction = self.frame.world_from_camera(sight.direction);
        let [near, far] = self.depth.ends();
        let ends = match self.bounds.map(|bounds| bounds.crossing(origin, direction)) {
            None => [near, far],
            Some(None) => [near.max(0.0); 2],
            Some(Some([enter, leave])) => {
                let inside = INSIDE_BOUNDS * (leave - enter);
                let from = near.max(enter + inside);
                [from, far.min(leave - inside).max(from)]
            }
        };
        Line { origin, direction, ends }
    }

    /// The region of a line, and the distance at which it ends.
    pub(super) fn end_of(&self, line: &Line) -> (Region, f64) {
        let [from, to] = line.ends;
        let mut seen = (Region::Sky, to);
        for (number, body) in self.bodies.iter().enumerate() {
            if let Some([enter, leave]) = body.crossing(line.origin, line.direction)
                && leave > from
                && enter < seen.1
            {
                seen = (Region::Body(number), enter.max(from));
            }
        }
        seen
    }

    /// The split distance of a body: inside of it if the line meets it, and at its limb if the line
    /// touches it.
    pub(super) fn split_distance(&self, line: &Line, body: &Ellipsoid) -> f64 {
        if self.plane.is_parallel() {
            body.closest_distance(line.origin, line.direction)
        } else {
            body.limb_distance(line.origin, line.direction)
        }
    }

    /// The point of a body's near side that stands for one of a line inside of it.
    pub(super) fn on_near_surface(
        &self,
        body: &Ellipsoid,
        line: &Line,
        position: [f64; 3],
    ) -> [f64; 3] {
        let is_parallel = self.plane.is_parallel();
        let towards = difference(body.centre(), self.frame.origin);
        body.on_near_surface(position, if is_parallel { line.direction } else { towards })
    }

    pub(super) fn span(&self, from: f64, to: f64) -> Span {
        self.depth.span(from, to)
    }

    /// The image plane's coordinates of a world point, and its line.
    pub(super) fn line_to(&self, position: [f64; 3]) -> Option<([f64; 2], Line, f64)> {
        let xy = self.plane.xy_of(self.frame.camera_from_world(position))?;
        let line = self.line(xy);
        let distance = dot(difference(position, line.origin), line.direction);
        Some((xy, line, distance))
    }
}

/// A line of sight in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) origin: [f64; 3],
    pub(super) direction: [f64; 3],
    /// The distances between which the emission may be above 0.
    pub(super) ends: [f64; 2],
}

impl Line {
    /// The point at `z` of a part of the line.
    pub(super) fn point(&self, span: &Span, z: f64) -> MappedPoint {
        let (distance, path_per_depth) = span.at(z);
        MappedPoint {
            position: along(self.origin, distance, self.direction),
            direction: self.direction.map(|component| -component),
            path_per_depth,
        }
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
        let (_, end) = self.end_of(&line);
        Some([x, y, self.span(line.ends[0], end).z_of(distance)])
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
        let (_, end) = self.end_of(&line);
        let span = self.span(line.ends[0], end);
        let is_in_image = self.plane.contains(xy);
        for (point, &z) in points.iter_mut().zip(depths) {
            *point = line.point(&span, z);
            for body in &self.bodies {
                point.position = body.outside(point.position);
            }
            if !is_in_image {
                point.path_per_depth = 0.0;
            }
        }
    }

    fn region(&self, xy: [f64; 2]) -> Region {
        if self.plane.contains(xy) { self.end_of(&self.line(xy)).0 } else { Region::Outside }
    }

    fn has_regions(&self) -> bool {
        !(self.plane.is_whole() && self.bodies.is_empty())
    }

    fn landmarks(&self) -> Vec<[f64; 2]> {
        let centre =
            |body: &Ellipsoid| self.plane.xy_of(self.frame.camera_from_world(body.centre()));
        self.bodies.iter().filter_map(centre).collect()
    }

    fn layers(&self) -> Vec<Box<dyn Layer + '_>> {
        let of_body = |number| [Piece::Front(number), Piece::Hidden(number)];
        let pieces = core::iter::once(Piece::Sky).chain((0..self.bodies.len()).flat_map(of_body));
        pieces.map(|piece| Box::new(Section::new(self, piece)) as Box<dyn Layer>).collect()
    }
}

#[cfg(test)]
mod tests;
