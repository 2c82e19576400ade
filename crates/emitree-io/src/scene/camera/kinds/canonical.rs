//! `canonical`: the unit cube itself.

use crate::fits::{Wcs, WcsAxis, count};
use crate::scene::camera::description::{
    CameraDescription, FitsCoordinates, ImageCoordinates, Optics, PixelLayout, PlotAxis, PlotFrame,
    PlotScale,
};
use crate::scene::camera::pointing::{LENGTH_UNIT, with_shapes};
use crate::scene::camera::shapes::Shapes;
use crate::scene::error::SceneError;
use crate::scene::source::Place;
use crate::scene::table::Table;
use crate::units::Unit;
use emitree::{Canonical, Orthographic, Projection};
use std::sync::Arc;

pub(super) const CANONICAL: CameraDescription = CameraDescription {
    name: "canonical",
    summary: "The unit cube seen along z by parallel lines of sight.",
    python_class: "Canonical",
    keys: &[LENGTH_UNIT],
    pixels: PixelLayout::Rectangle,
    has_solid_angles: false,
    has_plane: true,
    fits: FitsCoordinates::Axes(&[["X", "Y"]]),
    read,
};

fn read(_: &mut Table, shapes: Shapes, place: &Place) -> Result<Optics, SceneError> {
    let projection: Arc<dyn Projection + Send> = if shapes.is_empty() {
        Arc::new(Canonical)
    } else {
        Arc::new(with_shapes(Orthographic::of_unit_cube(), shapes, place)?)
    };
    Ok(Optics { coordinates: Arc::new(Cube), projection, pointing: None })
}

/// The image of the cube: x and y from 0 to 1.
#[derive(Debug)]
struct Cube;

impl ImageCoordinates for Cube {
    fn wcs(&self, [height, width]: [usize; 2], _: &Unit) -> Option<Wcs> {
        Some(Wcs::canonical(height, width))
    }

    fn frame(&self) -> PlotFrame {
        let axis = |label| PlotAxis { label, ends: [0.0, 1.0], scale: PlotScale::Lengths };
        PlotFrame::Axes { x: axis("x"), y: axis("y") }
    }
}

impl Wcs {
    /// Canonical coordinates: x and y go linearly from 0 to 1 across the image.
    ///
    /// The lower left corner of pixel (row 0, column 0), FITS pixel (½, ½), is (0, 0).
    pub fn canonical(height: usize, width: usize) -> Self {
        let axis = |name: &str, pixels| WcsAxis {
            ctype: name.to_uppercase(),
            cunit: None,
            cname: format!("canonical {name}"),
            crpix: 0.5,
            crval: 0.0,
            cdelt: 1.0 / count(pixels),
        };
        Self {
            name: "canonical".to_owned(),
            axes: vec![axis("x", width), axis("y", height)],
            pole_deg: None,
            celestial: None,
        }
    }
}
