//! The keys of each kind of camera.

use super::super::document::{Node, Value};
use super::super::error::SceneError;
use super::super::source::Place;
use super::super::table::Table;
use super::shapes::Shapes;
use super::{Camera, CameraKind};
use emitree::projection::{Camera as AnyCamera, DiscMapping, GeometryError, ImagePlane};
use emitree::{
    Canonical, Equirectangular, Fisheye, Healpix, Orthographic, Perspective, Polar, Projection,
    Viewpoint,
};
use std::ops::RangeInclusive;
use std::sync::Arc;

const POINT: &str = "three numbers [x, y, z]";
const ANGLES: &str = "two angles [width, height] in degrees";
const CONE: &str = "the full angle of the cone in degrees";

pub(super) fn canonical(shapes: Shapes, place: &Place) -> Result<Camera, SceneError> {
    let projection: Arc<dyn Projection + Send> =
        if shapes.bounds.is_none() && shapes.bodies.is_empty() {
            Arc::new(Canonical)
        } else {
            Arc::new(with_shapes(Orthographic::of_unit_cube(), shapes, place)?)
        };
    Ok(Camera { kind: CameraKind::Canonical, projection })
}

pub(super) fn orthographic(table: &mut Table, shapes: Shapes) -> Result<Camera, SceneError> {
    const EXTENT: &str = "two lengths [width, height] in `length_unit`";
    let keys = Keys::read(table, ("extent", EXTENT), shapes.bounds.is_some(), true)?;
    let extent = keys.field.vector(EXTENT)?;
    let camera = Orthographic::new(keys.viewpoint()?, extent, keys.depth()?);
    keys.camera(CameraKind::Orthographic { extent }, camera, shapes)
}

pub(super) fn perspective(table: &mut Table, shapes: Shapes) -> Result<Camera, SceneError> {
    let keys = Keys::read(table, (FIELD, ANGLES), shapes.bounds.is_some(), false)?;
    let fov_deg: [f64; 2] = keys.field.vector(ANGLES)?;
    let fov_rad = fov_deg.map(f64::to_radians);
    let camera = Perspective::new(keys.viewpoint()?, fov_rad, keys.depth()?);
    keys.camera(CameraKind::Perspective { fov_deg }, camera, shapes)
}

pub(super) fn equirectangular(table: &mut Table, shapes: Shapes) -> Result<Camera, SceneError> {
    let keys = Keys::read(table, (FIELD, ANGLES), shapes.bounds.is_some(), false)?;
    let fov_deg: [f64; 2] = keys.field.vector(ANGLES)?;
    let fov_rad = fov_deg.map(f64::to_radians);
    let camera = Equirectangular::new(keys.viewpoint()?, fov_rad, keys.depth()?);
    keys.camera(CameraKind::Equirectangular { fov_deg }, camera, shapes)
}

pub(super) fn polar(table: &mut Table, shapes: Shapes) -> Result<Camera, SceneError> {
    let keys = Keys::read(table, (FIELD, CONE), shapes.bounds.is_some(), false)?;
    let fov_deg = cone(&keys.field)?;
    let camera = Polar::new(keys.viewpoint()?, fov_deg.to_radians(), keys.depth()?);
    keys.camera(CameraKind::Polar { fov_deg }, camera, shapes)
}

pub(super) fn fisheye(table: &mut Table, shapes: Shapes) -> Result<Camera, SceneError> {
    const MAPPINGS: &str = "`equidistant` (ARC) or `equal_area` (ZEA)";
    let mapping = match table.text("mapping")? {
        None => DiscMapping::Equidistant,
        Some((name, place)) => match name.as_str() {
            "equidistant" | "ARC" => DiscMapping::Equidistant,
            "equal_area" | "ZEA" => DiscMapping::EqualArea,
            _ => {
                let error = SceneError::at(&place, format!("unknown mapping `{name}`"));
                return Err(error.label(format!("expected {MAPPINGS}")));
            }
        },
    };
    let keys = Keys::read(table, (FIELD, CONE), shapes.bounds.is_some(), false)?;
    let fov_deg = cone(&keys.field)?;
    let camera = Fisheye::new(keys.viewpoint()?, fov_deg.to_radians(), mapping, keys.depth()?);
    let equal_area = mapping == DiscMapping::EqualArea;
    keys.camera(CameraKind::Fisheye { fov_deg, equal_area }, camera, shapes)
}

pub(super) fn healpix(table: &mut Table, shapes: Shapes) -> Result<Camera, SceneError> {
    let position = table.require("position", POINT)?;
    let near = table.take("near");
    let far = far(table, shapes.bounds.is_some())?;
    let depth = [number_or(near.as_ref(), 0.0)?, number_or(far.as_ref(), f64::INFINITY)?];
    let sky = Healpix::new(position.vector(POINT)?, depth).map_err(|error| {
        let is_near = matches!(&error, GeometryError::OutOfRange { name: "near", .. });
        let node = if is_near { near.as_ref() } else { far.as_ref() }.unwrap_or(&position);
        SceneError::at(&node.place, format!("`[projection]`: {error}"))
    })?;
    let sky = match shapes.bounds {
        Some(bounds) => sky.with_bounds(bounds),
        None => sky,
    };
    let places = shapes.places;
    let bodied = sky.with_occulters(shapes.bodies);
    let sky = bodied.map_err(|error| of_body(&error, &places, &position.place))?;
    Ok(Camera { kind: CameraKind::Healpix, projection: Arc::new(sky) })
}

const FIELD: &str = "field_of_view";

/// Solid angles or areas of a whole image, of which each of 2^48 pixels has a part that double precision
/// has a normal number for, and so have their sums times a rate.
const IMAGES: RangeInclusive<f64> = 1e-290..=1e290;

/// The keys of cameras with a pointing.
struct Keys {
    position: Node,
    target: Node,
    up: Option<Node>,
    field: Node,
    near: Option<Node>,
    far: Option<Node>,
    default_near: f64,
}

impl Keys {
    /// Takes the keys; `key` is the one that says how large the image is. Where the scene has
    /// bounds, depths may be left out: they are all of the line.
    fn read(
        table: &mut Table,
        (key, expected): (&'static str, &str),
        has_bounds: bool,
        is_parallel: bool,
    ) -> Result<Self, SceneError> {
        let position = table.require("position", POINT)?;
        let target = table.require("target", POINT)?;
        let up = table.take("up");
        let field = table.require(key, expected)?;
        let near = table.take("near");
        let far = far(table, has_bounds)?;
        let default_near = if has_bounds && is_parallel { f64::NEG_INFINITY } else { 0.0 };
        Ok(Self { position, target, up, field, near, far, default_near })
    }

    fn viewpoint(&self) -> Result<Viewpoint, SceneError> {
        Ok(Viewpoint {
            position: self.position.vector(POINT)?,
            target: self.target.vector(POINT)?,
            up: self.up.as_ref().map_or(Ok([0.0, 0.0, 1.0]), |up| up.vector(POINT))?,
        })
    }

    fn depth(&self) -> Result<[f64; 2], SceneError> {
        let near = number_or(self.near.as_ref(), self.default_near)?;
        Ok([near, number_or(self.far.as_ref(), f64::INFINITY)?])
    }

    /// The camera with the shapes of the scene, or the error at the key that it is about.
    fn camera<P: ImagePlane + Send + 'static>(
        &self,
        kind: CameraKind,
        camera: Result<AnyCamera<P>, GeometryError>,
        shapes: Shapes,
    ) -> Result<Camera, SceneError> {
        let camera = camera.map_err(|error| {
            let field = &self.field;
            let depth = self.far.as_ref().or(self.near.as_ref()).unwrap_or(field);
            let node = match &error {
                GeometryError::TargetIsPosition(_) => &self.target,
                GeometryError::UpAlongPointing { .. } => self.up.as_ref().unwrap_or(&self.target),
                GeometryError::OutOfRange { name: "near", .. } => {
                    self.near.as_ref().unwrap_or(depth)
                }
                GeometryError::OutOfRange { name: "far", .. } => depth,
                _ => field,
            };
            SceneError::at(&node.place, format!("`[projection]`: {error}"))
        })?;
        let whole = camera.solid_angle([0.0; 2], [1.0; 2]);
        if !IMAGES.contains(&whole) {
            let Place { source, span } = &self.field.place;
            let given = source.text.get(span.clone()).unwrap_or_default();
            let expected = "an image whose solid angle, or area, is from 1e-290 to 1e290";
            return Err(self.field.refuse(given, expected));
        }
        Ok(Camera {
            kind,
            projection: Arc::new(with_shapes(camera, shapes, &self.position.place)?),
        })
    }
}

/// The key `far`, which may be left out only where bounds end the lines.
fn far(table: &mut Table, has_bounds: bool) -> Result<Option<Node>, SceneError> {
    const FAR: &str = "a depth in `length_unit`, or inf (or a table `[bounds]`)";
    if has_bounds { Ok(table.take("far")) } else { table.require("far", FAR).map(Some) }
}

fn number_or(node: Option<&Node>, default: f64) -> Result<f64, SceneError> {
    node.map_or(Ok(default), Node::number_or_infinite)
}

/// The angle of a cone: a number, or a list with one.
fn cone(node: &Node) -> Result<f64, SceneError> {
    match &node.value {
        Value::Array(_) => node.vector(CONE).map(|[angle]: [f64; 1]| angle),
        _ => node.number(),
    }
}

fn with_shapes<P: ImagePlane>(
    camera: AnyCamera<P>,
    shapes: Shapes,
    place: &Place,
) -> Result<AnyCamera<P>, SceneError> {
    let camera = match shapes.bounds {
        Some(bounds) => camera.with_bounds(bounds),
        None => camera,
    };
    camera.with_occulters(shapes.bodies).map_err(|error| of_body(&error, &shapes.places, place))
}

/// The error of a body among others, at its table.
fn of_body(error: &GeometryError, places: &[Place], otherwise: &Place) -> SceneError {
    let place = match error {
        GeometryError::InsideOcculter { number, .. } => places.get(number - 1),
        _ => None,
    };
    SceneError::at(place.unwrap_or(otherwise), error.to_string())
}
