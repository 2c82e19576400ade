//! `perspective`: a pinhole camera with a flat screen.

use crate::fits::{AT_THE_POLE, Wcs};
use crate::scene::camera::description::{
    CameraDescription, CameraKey, FitsCoordinates, ImageCoordinates, KeyDefault, KeyUnit, Optics,
    PixelLayout, PlotAxis, PlotFrame, PlotScale,
};
use crate::scene::camera::pointing::{ANGLES, FAR, Keys, LENGTH_UNIT, NEAR, POSITION, TARGET, UP};
use crate::scene::camera::shapes::Shapes;
use crate::scene::error::SceneError;
use crate::scene::source::Place;
use crate::scene::table::Table;
use crate::units::Unit;
use emitree::Perspective;

pub(super) const PERSPECTIVE: CameraDescription = CameraDescription {
    name: "perspective",
    summary: "A pinhole camera: lines of sight from a point through a flat screen.",
    python_class: "Perspective",
    keys: &[POSITION, TARGET, UP, NEAR, FAR, LENGTH_UNIT, FIELD, PRINCIPAL_POINT],
    pixels: PixelLayout::Rectangle,
    has_solid_angles: true,
    has_plane: true,
    fits: FitsCoordinates::Axes(&[["XLON-TAN", "XLAT-TAN"]]),
    read,
};

const FIELD: CameraKey = CameraKey {
    meaning: "full width and height of the image, each above 0 and at most 178",
    example: "[40.0, 30.0]",
    ..ANGLES
};

const PRINCIPAL_POINT: CameraKey = CameraKey {
    name: "principal_point",
    value: "[x, y]",
    unit: KeyUnit::None,
    default: KeyDefault::Value("[0.5, 0.5]"),
    meaning: "where the pointing is, as fractions of the width and the height of the image from its lower left corner; \
              it may be beside the image",
    example: "[0.45, 0.52]",
    expected: "two numbers [x, y]",
};

fn read(table: &mut Table, shapes: Shapes, _: &Place) -> Result<Optics, SceneError> {
    let keys = Keys::read(table, &FIELD, shapes.bounds.is_some(), false)?;
    let place = table.take(PRINCIPAL_POINT.name);
    let principal_point =
        place.as_ref().map_or(Ok([0.5; 2]), |node| node.vector(PRINCIPAL_POINT.expected))?;
    let fov_deg: [f64; 2] = keys.field.vector(FIELD.expected)?;
    let fov_rad = fov_deg.map(f64::to_radians);
    let camera = Perspective::new(keys.viewpoint()?, fov_rad, keys.depth()?);
    let camera = match camera.map(|camera| camera.with_principal_point(principal_point)) {
        Ok(Err(error)) => {
            let node = place.as_ref().unwrap_or(&keys.field);
            return Err(SceneError::at(&node.place, format!("`[projection]`: {error}")));
        }
        Ok(Ok(camera)) => Ok(camera),
        Err(error) => Err(error),
    };
    keys.camera(Screen { fov_deg, principal_point }, camera, shapes)
}

/// The flat screen, for this field of view \[deg\] and canonical place of the pointing.
#[derive(Debug)]
struct Screen {
    fov_deg: [f64; 2],
    principal_point: [f64; 2],
}

impl ImageCoordinates for Screen {
    fn wcs(&self, [height, width]: [usize; 2], _: &Unit) -> Option<Wcs> {
        let mut wcs = Wcs::perspective(height, width, self.fov_deg);
        let along = self.principal_point.into_iter().zip([width, height]);
        for (axis, (at, pixels)) in wcs.axes.iter_mut().zip(along) {
            // The edges of the image are at 0.5 and 0.5 more than the number of pixels.
            axis.crpix = at * pixels as f64 + 0.5;
        }
        Some(wcs)
    }

    fn frame(&self) -> PlotFrame {
        let axis = |label, number: usize| {
            let extent = 2.0 * (0.5 * self.fov_deg[number]).to_radians().tan();
            let end = |at: f64| (extent * (at - self.principal_point[number])).atan().to_degrees();
            PlotAxis { label, ends: [end(0.0), end(1.0)], scale: PlotScale::Tangents }
        };
        PlotFrame::Axes { x: axis("to the right", 0), y: axis("up", 1) }
    }
}

impl Wcs {
    /// Longitude and latitude about the pointing on a plane behind a pinhole, the projection TAN,
    /// for a field of view of `fov_deg` = \[width, height\] \[deg\], both below 180.
    ///
    /// The canonical point (x, y) is at ((2x − 1) tan(width/2), (2y − 1) tan(height/2)) on the
    /// plane at distance 1. As for all cameras with a pointing, the world coordinates of a sight
    /// with components (right, up, forward) are the longitude atan2(right, forward) and the
    /// latitude asin(up), \(0, 0\) in the middle. The middle is the native pole here (Calabretta &
    /// Greisen, section 5.1), and `LONPOLE` = 180 has latitude grow upwards and, with a positive
    /// `CDELT1`, longitude to the right (their eqs. 2, 12 and 13).
    ///
    /// ```
    /// use emitree_io::Wcs;
    ///
    /// let wcs = Wcs::perspective(100, 200, [90.0, 60.0]);
    /// assert_eq!(wcs.axes[0].ctype, "XLON-TAN");
    /// assert!((wcs.axes[0].cdelt - 1_f64.to_degrees() / 100.0).abs() < 1e-15); // tan 45° = 1
    /// ```
    pub fn perspective(height: usize, width: usize, fov_deg: [f64; 2]) -> Self {
        let on_plane = |fov_deg: f64| 2.0 * (0.5 * fov_deg).to_radians().tan().to_degrees();
        let extent_deg = fov_deg.map(on_plane);
        Self::spherical("perspective", "TAN", [height, width], extent_deg, AT_THE_POLE)
    }
}
