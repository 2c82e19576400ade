//! `healpix`: the whole sky in pixels of equal solid angle.

use crate::fits::Wcs;
use crate::scene::camera::description::{
    CameraDescription, FitsCoordinates, ImageCoordinates, Optics, PixelLayout, PlotFrame,
};
use crate::scene::camera::pointing::{FAR, LENGTH_UNIT, NEAR, POSITION, far, number_or, of_body};
use crate::scene::camera::shapes::Shapes;
use crate::scene::error::SceneError;
use crate::scene::source::Place;
use crate::scene::table::Table;
use crate::sky::Pointing;
use crate::units::Unit;
use emitree::Healpix;
use emitree::projection::GeometryError;
use std::sync::Arc;

pub(super) const HEALPIX: CameraDescription = CameraDescription {
    name: "healpix",
    summary: "The whole sky about `position` in HEALPix pixels: twelve faces of nside x nside.",
    python_class: "Healpix",
    keys: &[POSITION, NEAR, FAR, LENGTH_UNIT],
    pixels: PixelLayout::Healpix,
    has_solid_angles: true,
    // Faces meet at an angle, and rows of pixels are none of the sky.
    has_plane: false,
    fits: FitsCoordinates::None("a table of numbered pixels, whose numbers are the coordinates"),
    read,
};

fn read(table: &mut Table, shapes: Shapes, _: &Place) -> Result<Optics, SceneError> {
    let position = table.require(POSITION.name, POSITION.expected)?;
    let near = table.take(NEAR.name);
    let far = far(table, shapes.bounds.is_some())?;
    let depth = [number_or(near.as_ref(), 0.0)?, number_or(far.as_ref(), f64::INFINITY)?];
    let sky = Healpix::new(position.vector(POSITION.expected)?, depth).map_err(|error| {
        let is_near = matches!(&error, GeometryError::OutOfRange { name: "near", .. });
        let node = if is_near { near.as_ref() } else { far.as_ref() }.unwrap_or(&position);
        SceneError::at(&node.place, format!("`[projection]`: {error}"))
    })?;
    let sky = match shapes.bounds {
        Some(bounds) => sky.with_bounds(bounds),
        None => sky,
    };
    let places = shapes.places;
    let sky = sky.with_edges(shapes.edges).with_singularities(shapes.singularities);
    let bodied = sky.with_occulters(shapes.bodies);
    let sky = bodied.map_err(|error| of_body(&error, &places, &position.place))?;
    let pointing = Pointing::at(position.vector(POSITION.expected)?);
    Ok(Optics { coordinates: Arc::new(Sky), projection: Arc::new(sky), pointing: Some(pointing) })
}

/// The sky, which pictures show as an ellipse.
#[derive(Debug)]
struct Sky;

impl ImageCoordinates for Sky {
    fn wcs(&self, _: [usize; 2], _: &Unit) -> Option<Wcs> {
        None
    }

    fn frame(&self) -> PlotFrame {
        PlotFrame::Ellipse
    }
}
