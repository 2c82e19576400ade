//! `[projection]`: the camera, and what a FITS header says of it.

mod kinds;
mod shapes;

use super::error::SceneError;
use super::source::Place;
use super::table::Table;
use crate::fits::Wcs;
use crate::units::Unit;
use emitree::Projection;
use std::sync::Arc;

/// The camera of a scene.
#[derive(Clone, Debug)]
pub struct Camera {
    kind: CameraKind,
    projection: Arc<dyn Projection + Send>,
}

/// Which camera it is, in the numbers of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CameraKind {
    /// The unit cube itself.
    Canonical,
    /// Parallel lines of sight through a rectangle of this width and height, in the length unit.
    Orthographic {
        /// Width and height.
        extent: [f64; 2],
    },
    /// A pinhole camera.
    Perspective {
        /// Width and height \[deg\].
        fov_deg: [f64; 2],
    },
    /// Equal angles about the pointing.
    Equirectangular {
        /// Width and height \[deg\].
        fov_deg: [f64; 2],
    },
    /// Azimuth and angle from the pointing.
    Polar {
        /// The full angle of the cone \[deg\].
        fov_deg: f64,
    },
    /// The sky as a disc.
    Fisheye {
        /// The full angle of the cone \[deg\].
        fov_deg: f64,
        /// Whether areas are equal, or else distances from the pointing.
        equal_area: bool,
    },
    /// The whole sky in pixels of equal area.
    Healpix,
}

impl Camera {
    /// The projection.
    pub fn projection(&self) -> &(dyn Projection + 'static) {
        &*self.projection
    }

    /// Which camera it is.
    pub fn kind(&self) -> CameraKind {
        self.kind
    }

    /// Whether lines of sight come from an eye, so that pixels have solid angles.
    pub fn has_solid_angles(&self) -> bool {
        !matches!(self.kind, CameraKind::Canonical | CameraKind::Orthographic { .. })
    }

    /// The coordinates of an image of `height` × `width` pixels in a FITS header, lengths in `unit`;
    /// none for a `HEALPix` map, which has its own kind of file.
    pub fn wcs(&self, height: usize, width: usize, unit: &Unit) -> Option<Wcs> {
        match self.kind {
            CameraKind::Canonical => Some(Wcs::canonical(height, width)),
            CameraKind::Orthographic { extent } => {
                Some(Wcs::orthographic(height, width, extent, unit))
            }
            CameraKind::Perspective { fov_deg } => Some(Wcs::perspective(height, width, fov_deg)),
            CameraKind::Equirectangular { fov_deg } => {
                Some(Wcs::equirectangular(height, width, fov_deg))
            }
            CameraKind::Polar { fov_deg } => Some(Wcs::polar(height, width, fov_deg)),
            CameraKind::Fisheye { fov_deg, equal_area } => {
                Some(Wcs::fisheye(height, width, fov_deg, equal_area))
            }
            CameraKind::Healpix => None,
        }
    }
}

const KINDS: &str = "`canonical`, `orthographic`, `perspective`, `equirectangular`, `polar`, \
                     `fisheye` or `healpix`";

/// The camera, and the length unit with its place.
pub(super) fn read(
    projection: Option<Table>,
    bounds: Option<Table>,
    occulters: Vec<Table>,
    whole: &Place,
) -> Result<(Camera, Option<(String, Place)>), SceneError> {
    let Some(mut table) = projection else {
        return Err(SceneError::at(whole, "the scene has no `[projection]`")
            .label(format!("expected a table `[projection]` with `type` = {KINDS}")));
    };
    let shapes = shapes::read(bounds, occulters)?;
    let (kind, place) = table.require("type", KINDS)?.text()?;
    let length_unit = table.text("length_unit")?;
    let camera = match kind.as_str() {
        "canonical" => kinds::canonical(shapes, &place),
        "orthographic" => kinds::orthographic(&mut table, shapes),
        "perspective" => kinds::perspective(&mut table, shapes),
        "equirectangular" => kinds::equirectangular(&mut table, shapes),
        "polar" => kinds::polar(&mut table, shapes),
        "fisheye" => kinds::fisheye(&mut table, shapes),
        "healpix" => kinds::healpix(&mut table, shapes),
        unknown => {
            let message = format!("unknown projection `{unknown}`");
            return Err(SceneError::at(&place, message).label(format!("expected {KINDS}")));
        }
    }?;
    table.finish()?;
    Ok((camera, length_unit))
}

#[cfg(test)]
mod tests;
