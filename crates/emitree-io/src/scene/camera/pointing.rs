//! The keys that cameras share, and those of every camera with a pointing.

use super::description::{CameraKey, ImageCoordinates, KeyDefault, KeyUnit, Optics};
use super::shapes::Shapes;
use crate::scene::document::{Node, Value};
use crate::scene::error::SceneError;
use crate::scene::source::Place;
use crate::scene::table::Table;
use crate::sky::Pointing;
use emitree::projection::{Camera as AnyCamera, GeometryError, ImagePlane};
use emitree::{Projection as _, Viewpoint};
use std::ops::RangeInclusive;
use std::sync::Arc;

pub(super) const POSITION: CameraKey = CameraKey {
    name: "position",
    value: "[x, y, z], length",
    unit: KeyUnit::Length,
    default: KeyDefault::Required,
    meaning: "the observer; for parallel lines, the point in the middle of the image",
    example: "[10.0, 0.0, 1.0]",
    expected: "three numbers [x, y, z]",
};

pub(super) const TARGET: CameraKey = CameraKey {
    name: "target",
    meaning: "the point in the middle of the image (of a polar image: at its lower edge)",
    example: "[0.0, 0.0, 0.0]",
    ..POSITION
};

pub(super) const UP: CameraKey = CameraKey {
    name: "up",
    value: "[x, y, z]",
    unit: KeyUnit::None,
    default: KeyDefault::Value("[0, 0, 1]"),
    meaning: "its component perpendicular to the pointing is up in the image; not parallel to the \
              pointing",
    example: "[0.0, 1.0, 1.0]",
    expected: POSITION.expected,
};

pub(super) const NEAR: CameraKey = CameraKey {
    name: "near",
    value: "number, length",
    unit: KeyUnit::Length,
    default: KeyDefault::Value("0; `-inf` for parallel lines in bounds"),
    meaning: "the start of lines of sight",
    example: "1.0",
    expected: "a depth in `length_unit`",
};

pub(super) const FAR: CameraKey = CameraKey {
    name: "far",
    default: KeyDefault::InBounds("inf"),
    meaning: "their end",
    example: "20.0",
    expected: "a depth in `length_unit`, or inf (or a table `[bounds]`)",
    ..NEAR
};

pub(super) const LENGTH_UNIT: CameraKey = CameraKey {
    name: "length_unit",
    value: "string",
    unit: KeyUnit::None,
    default: KeyDefault::Value("the emission's"),
    meaning: "the unit of all lengths of the scene",
    example: "\"km\"",
    expected: "a unit of length",
};

/// A field of view of two angles.
pub(super) const ANGLES: CameraKey = CameraKey {
    name: "field_of_view",
    value: "[width, height], degrees",
    unit: KeyUnit::Degrees,
    default: KeyDefault::Required,
    meaning: "full width and height of the image",
    example: "[40.0, 30.0]",
    expected: "two angles [width, height] in degrees",
};

/// A field of view about the pointing.
pub(super) const CONE: CameraKey = CameraKey {
    value: "number, degrees",
    meaning: "the full angle of the cone, up to 360",
    example: "120.0",
    expected: "the full angle of the cone in degrees",
    ..ANGLES
};

/// Solid angles or areas of a whole image, of which each of 2^48 pixels has a part that double precision
/// has a normal number for, and so have their sums times a rate.
const IMAGES: RangeInclusive<f64> = 1e-290..=1e290;

/// The keys of cameras with a pointing.
pub(super) struct Keys {
    position: Node,
    target: Node,
    up: Option<Node>,
    /// The value of the key that says how large the image is.
    pub(super) field: Node,
    near: Option<Node>,
    far: Option<Node>,
    default_near: f64,
}

impl Keys {
    /// Takes the keys; `key` is the one that says how large the image is. Where the scene has
    /// bounds, depths may be left out: they are all of the line.
    pub(super) fn read(
        table: &mut Table,
        key: &CameraKey,
        has_bounds: bool,
        is_parallel: bool,
    ) -> Result<Self, SceneError> {
        let position = table.require(POSITION.name, POSITION.expected)?;
        let target = table.require(TARGET.name, TARGET.expected)?;
        let up = table.take(UP.name);
        let field = table.require(key.name, key.expected)?;
        let near = table.take(NEAR.name);
        let far = far(table, has_bounds)?;
        let default_near = if has_bounds && is_parallel { f64::NEG_INFINITY } else { 0.0 };
        Ok(Self { position, target, up, field, near, far, default_near })
    }

    pub(super) fn viewpoint(&self) -> Result<Viewpoint, SceneError> {
        Ok(Viewpoint {
            position: self.position.vector(POSITION.expected)?,
            target: self.target.vector(TARGET.expected)?,
            up: self.up.as_ref().map_or(Ok([0.0, 0.0, 1.0]), |up| up.vector(UP.expected))?,
        })
    }

    pub(super) fn depth(&self) -> Result<[f64; 2], SceneError> {
        let near = number_or(self.near.as_ref(), self.default_near)?;
        Ok([near, number_or(self.far.as_ref(), f64::INFINITY)?])
    }

    /// The angle of a cone \[deg\]: a number, or a list with one.
    pub(super) fn cone_deg(&self) -> Result<f64, SceneError> {
        match &self.field.value {
            Value::Array(_) => self.field.vector(CONE.expected).map(|[angle]: [f64; 1]| angle),
            _ => self.field.number(),
        }
    }

    /// The camera with the shapes of the scene, or the error at the key that it is about.
    pub(super) fn camera<P: ImagePlane + Send + 'static>(
        &self,
        coordinates: impl ImageCoordinates + 'static,
        camera: Result<AnyCamera<P>, GeometryError>,
        shapes: Shapes,
    ) -> Result<Optics, SceneError> {
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
        let projection = Arc::new(with_shapes(camera, shapes, &self.position.place)?);
        let Viewpoint { position, target, up } = self.viewpoint()?;
        let pointing = Some(Pointing::new(position, target, up));
        Ok(Optics { coordinates: Arc::new(coordinates), projection, pointing })
    }
}

/// The key `far`, which may be left out only where bounds end the lines.
pub(super) fn far(table: &mut Table, has_bounds: bool) -> Result<Option<Node>, SceneError> {
    if has_bounds {
        Ok(table.take(FAR.name))
    } else {
        table.require(FAR.name, FAR.expected).map(Some)
    }
}

pub(super) fn number_or(node: Option<&Node>, default: f64) -> Result<f64, SceneError> {
    node.map_or(Ok(default), Node::number_or_infinite)
}

/// The camera with the shapes of a scene; an error about none of the bodies is at `place`.
pub(super) fn with_shapes<P: ImagePlane>(
    camera: AnyCamera<P>,
    shapes: Shapes,
    place: &Place,
) -> Result<AnyCamera<P>, SceneError> {
    let camera = match shapes.bounds {
        Some(bounds) => camera.with_bounds(bounds),
        None => camera,
    };
    let camera = camera.with_edges(shapes.edges).with_singularities(shapes.singularities);
    camera.with_occulters(shapes.bodies).map_err(|error| of_body(&error, &shapes.places, place))
}

/// The error of a body among others, at its table.
pub(super) fn of_body(error: &GeometryError, places: &[Place], otherwise: &Place) -> SceneError {
    let place = match error {
        GeometryError::InsideOcculter { number, .. } => places.get(number - 1),
        _ => None,
    };
    SceneError::at(place.unwrap_or(otherwise), error.to_string())
}
