//! `equirectangular`: columns and rows uniform in longitude and latitude about the pointing.

use crate::fits::Wcs;
use crate::scene::camera::description::{
    CameraDescription, CameraKey, FitsCoordinates, ImageCoordinates, Optics, PixelLayout, PlotAxis,
    PlotFrame, PlotScale,
};
use crate::scene::camera::pointing::{ANGLES, FAR, Keys, LENGTH_UNIT, NEAR, POSITION, TARGET, UP};
use crate::scene::camera::shapes::Shapes;
use crate::scene::error::SceneError;
use crate::scene::source::Place;
use crate::scene::table::Table;
use crate::units::Unit;
use emitree::Equirectangular;

pub(super) const EQUIRECTANGULAR: CameraDescription = CameraDescription {
    name: "equirectangular",
    summary: "Lines of sight from a point, uniform in longitude and latitude about the pointing.",
    python_class: "Equirectangular",
    keys: &[POSITION, TARGET, UP, NEAR, FAR, LENGTH_UNIT, FIELD],
    pixels: PixelLayout::Rectangle,
    has_solid_angles: true,
    has_plane: true,
    fits: FitsCoordinates::Axes(&[["XLON-CAR", "XLAT-CAR"]]),
    read,
};

const FIELD: CameraKey = CameraKey {
    meaning: "full width and height of the image, above 0 and at most 360 and 180",
    example: "[16.0, 27.0]",
    ..ANGLES
};

fn read(table: &mut Table, shapes: Shapes, _: &Place) -> Result<Optics, SceneError> {
    let keys = Keys::read(table, &FIELD, shapes.bounds.is_some(), false)?;
    let fov_deg: [f64; 2] = keys.field.vector(FIELD.expected)?;
    let fov_rad = fov_deg.map(f64::to_radians);
    let camera = Equirectangular::new(keys.viewpoint()?, fov_rad, keys.depth()?);
    keys.camera(Angles { fov_deg }, camera, shapes)
}

/// The plane of longitude and latitude, for this field of view \[deg\].
#[derive(Debug)]
struct Angles {
    fov_deg: [f64; 2],
}

impl ImageCoordinates for Angles {
    fn wcs(&self, [height, width]: [usize; 2], _: &Unit) -> Option<Wcs> {
        Some(Wcs::equirectangular(height, width, self.fov_deg))
    }

    fn frame(&self) -> PlotFrame {
        let axis = |label, extent| PlotAxis::centred(label, extent, PlotScale::Angles);
        let [width, height] = self.fov_deg;
        let x = axis("longitude about the pointing", width);
        PlotFrame::Axes { x, y: axis("latitude", height) }
    }
}

impl Wcs {
    /// Longitude and latitude about the pointing in uniform steps, the projection CAR, for a field
    /// of view of `fov_deg` = \[width, height\] \[deg\].
    ///
    /// At the canonical point (x, y) they are ((x − ½) · width, (y − ½) · height), longitudes
    /// modulo 360°. The axes are called `XLON` and `XLAT`: FITS reserves the first letter for
    /// systems such as `G` (galactic), and `RA`/`DEC` would claim a place on the sky that an image
    /// about a pointing does not have. The native coordinates are the world coordinates, which
    /// `LONPOLE` = 0 and `LATPOLE` = 90 with a reference point on the equator say. `CDELT1` is
    /// positive because longitude grows to the right here, unlike right ascension.
    pub fn equirectangular(height: usize, width: usize, fov_deg: [f64; 2]) -> Self {
        Self::spherical("equirectangular", "CAR", [height, width], fov_deg, [0.0, 90.0])
    }
}
