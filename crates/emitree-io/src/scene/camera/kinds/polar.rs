//! `polar`: the azimuth about the pointing along x, the angle from it along y.

use crate::fits::{Wcs, WcsAxis};
use crate::scene::camera::description::{
    CameraDescription, FitsCoordinates, ImageCoordinates, Optics, PixelLayout, PlotAxis, PlotFrame,
    PlotScale,
};
use crate::scene::camera::pointing::{CONE, FAR, Keys, LENGTH_UNIT, NEAR, POSITION, TARGET, UP};
use crate::scene::camera::shapes::Shapes;
use crate::scene::error::SceneError;
use crate::scene::source::Place;
use crate::scene::table::Table;
use crate::units::Unit;
use emitree::Polar;

pub(super) const POLAR: CameraDescription = CameraDescription {
    name: "polar",
    summary: "An unrolled cone about the pointing: the azimuth to the right, the angle from the \
              pointing upwards.",
    python_class: "Polar",
    keys: &[POSITION, TARGET, UP, NEAR, FAR, LENGTH_UNIT, CONE],
    pixels: PixelLayout::Rectangle,
    has_solid_angles: true,
    // Its lower edge is a single direction, so that neighbours in the image are none on the sky.
    has_plane: false,
    fits: FitsCoordinates::Axes(&[["AZIMUTH", "ANGLE"]]),
    read,
};

fn read(table: &mut Table, shapes: Shapes, _: &Place) -> Result<Optics, SceneError> {
    let keys = Keys::read(table, &CONE, shapes.bounds.is_some(), false)?;
    let fov_deg = keys.cone_deg()?;
    let camera = Polar::new(keys.viewpoint()?, fov_deg.to_radians(), keys.depth()?);
    keys.camera(UnrolledCone { fov_deg }, camera, shapes)
}

/// The image of a cone with this full angle \[deg\].
#[derive(Debug)]
struct UnrolledCone {
    fov_deg: f64,
}

impl ImageCoordinates for UnrolledCone {
    fn wcs(&self, [height, width]: [usize; 2], _: &Unit) -> Option<Wcs> {
        Some(Wcs::polar(height, width, self.fov_deg))
    }

    fn frame(&self) -> PlotFrame {
        let axis = |label, end| PlotAxis { label, ends: [0.0, end], scale: PlotScale::Angles };
        let y = axis("angle from the pointing", 0.5 * self.fov_deg);
        PlotFrame::UnlikeAxes { x: axis("azimuth", 360.0), y }
    }
}

impl Wcs {
    /// Azimuth about the pointing and angle from it, linear, for a field of view of `fov_deg` across
    /// \[deg\], up to 360.
    ///
    /// At the canonical point (x, y) the azimuth is x · 360° and the angle y · fov/2. Linear axes and
    /// no spherical ones: FITS has no latitude that falls from 90° at the lower edge, and a reader
    /// would take it for one of the sky.
    pub fn polar(height: usize, width: usize, fov_deg: f64) -> Self {
        let axis = |ctype: &str, name: &str, pixels, extent_deg: f64| WcsAxis {
            crpix: 0.5,
            ..WcsAxis::about_the_middle(ctype, name, pixels, extent_deg, Some("deg"))
        };
        Self {
            name: "polar".to_owned(),
            axes: vec![
                axis("AZIMUTH", "azimuth about the pointing", width, 360.0),
                axis("ANGLE", "angle from the pointing", height, 0.5 * fov_deg),
            ],
            pole_deg: None,
            celestial: None,
        }
    }
}
