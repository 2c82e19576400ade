//! `[projection]`: the camera, and what a FITS header says of it.

use super::document::Node;
use super::error::SceneError;
use super::source::Place;
use super::table::Table;
use crate::fits::Wcs;
use emitree::{Canonical, Equirectangular, GeometryError, Projection, Viewpoint};

/// The camera of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Camera {
    /// The unit cube itself.
    Canonical(Canonical),
    /// Equal angles about the pointing, and the fields of view in degrees as the scene has them.
    Equirectangular(Equirectangular, [f64; 2]),
}

impl Camera {
    /// The projection.
    pub fn projection(&self) -> &dyn Projection {
        match self {
            Self::Canonical(projection) => projection,
            Self::Equirectangular(projection, _) => projection,
        }
    }

    /// The coordinates of an image of `height` × `width` pixels in a FITS header.
    pub fn wcs(&self, height: usize, width: usize) -> Wcs {
        match self {
            Self::Canonical(_) => Wcs::canonical(height, width),
            Self::Equirectangular(_, fov_deg) => Wcs::equirectangular(height, width, *fov_deg),
        }
    }
}

const KINDS: &str = "`canonical` or `equirectangular`";

/// Kinds that the scene format knows and this version does not have.
const PLANNED: [&str; 5] = ["orthographic", "perspective", "polar", "fisheye", "healpix"];

/// The camera, and the length unit with its place.
pub(super) fn read(
    table: Option<Table>,
    whole: &Place,
) -> Result<(Camera, Option<(String, Place)>), SceneError> {
    let Some(mut table) = table else {
        return Err(SceneError::at(whole, "the scene has no `[projection]`")
            .label(format!("expected a table `[projection]` with `type` = {KINDS}")));
    };
    let (kind, place) = table.require("type", KINDS)?.text()?;
    let length_unit = table.text("length_unit")?;
    let camera = match kind.as_str() {
        "canonical" => Camera::Canonical(Canonical),
        "equirectangular" => equirectangular(&mut table)?,
        planned if PLANNED.contains(&planned) => {
            let message = format!("the projection `{planned}` is not available in this version");
            return Err(SceneError::at(&place, message).label(format!("expected {KINDS}")));
        }
        unknown => {
            let message = format!("unknown projection `{unknown}`");
            return Err(SceneError::at(&place, message).label(format!("expected {KINDS}")));
        }
    };
    table.finish()?;
    Ok((camera, length_unit))
}

fn equirectangular(table: &mut Table) -> Result<Camera, SceneError> {
    const POINT: &str = "three numbers [x, y, z]";
    const ANGLES: &str = "two angles [width, height] in degrees";
    let position = table.require("position", POINT)?;
    let target = table.require("target", POINT)?;
    let up = table.take("up");
    let field_of_view = table.require("field_of_view", ANGLES)?;
    let near = table.take("near");
    let far = table.require("far", "a depth in `length_unit`")?;

    let viewpoint = Viewpoint {
        position: position.vector(POINT)?,
        target: target.vector(POINT)?,
        up: up.as_ref().map_or(Ok([0.0, 0.0, 1.0]), |up| up.vector(POINT))?,
    };
    let fov_deg: [f64; 2] = field_of_view.vector(ANGLES)?;
    let depth = [near.as_ref().map_or(Ok(0.0), Node::number)?, far.number()?];
    let camera = Equirectangular::new(viewpoint, fov_deg.map(f64::to_radians), depth);
    let camera = camera.map_err(|error| {
        let node = match &error {
            GeometryError::TargetIsPosition(_) => &target,
            GeometryError::UpAlongPointing { .. } => up.as_ref().unwrap_or(&target),
            GeometryError::OutOfRange { name: "field_of_view", .. } => &field_of_view,
            GeometryError::OutOfRange { name: "near", .. } => near.as_ref().unwrap_or(&far),
            _ => &far,
        };
        SceneError::at(&node.place, format!("`[projection]`: {error}"))
    })?;
    Ok(Camera::Equirectangular(camera, fov_deg))
}
