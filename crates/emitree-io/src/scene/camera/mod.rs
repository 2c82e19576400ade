//! `[projection]`: the camera, and what files and pictures say of its images.

mod description;
mod kinds;
mod pointing;
mod shapes;

pub use description::{
    CameraDescription, CameraKey, FitsCoordinates, KeyDefault, KeyUnit, PixelLayout, PlotAxis,
    PlotFrame, PlotScale,
};
pub use kinds::cameras;
pub(super) use shapes::{Shape, ShapeOfScene, ShapeTables};

use super::emission::EmissionSource;
use super::error::SceneError;
use super::radiometry::length_factor;
use super::sky::SkyView;
use super::source::Place;
use super::table::Table;
use crate::fits::Wcs;
use crate::sky::Pointing;
use crate::units::Unit;
use crate::words::alternatives;
use description::{ImageCoordinates, Optics};
use emitree::Projection;
use pointing::{LENGTH_UNIT, UP};
use std::sync::Arc;

/// The camera of a scene.
#[derive(Clone, Debug)]
pub struct Camera {
    description: &'static CameraDescription,
    coordinates: Arc<dyn ImageCoordinates>,
    projection: Arc<dyn Projection + Send>,
    pointing: Option<Pointing>,
    has_shapes: bool,
}

impl Camera {
    /// The projection.
    pub fn projection(&self) -> &(dyn Projection + 'static) {
        &*self.projection
    }

    /// Whether lines of sight end at bounds or opaque bodies somewhere, and not only at the depths of the camera.
    pub fn has_shapes(&self) -> bool {
        self.has_shapes
    }

    /// The kind of camera.
    pub fn description(&self) -> &'static CameraDescription {
        self.description
    }

    /// The coordinates of an image of `height` × `width` pixels in a FITS header, lengths in `unit`;
    /// none where [`FitsCoordinates::None`] says why.
    pub fn wcs(&self, height: usize, width: usize, unit: &Unit) -> Option<Wcs> {
        self.coordinates.wcs([height, width], unit)
    }

    /// Where it is and how it looks; none of the unit cube.
    pub fn pointing(&self) -> Option<&Pointing> {
        self.pointing.as_ref()
    }

    /// What the sky of its images has to fit to, for a scene of this length unit.
    pub(super) fn sky_view<'a>(&self, length_unit: Option<&'a str>) -> SkyView<'a> {
        SkyView {
            camera: self.description.name,
            is_celestial: self.description.is_celestial(),
            is_healpix: self.description.is_sky(),
            pointing: self.pointing,
            length_unit,
        }
    }

    /// What surrounds its image in an annotated picture.
    pub fn frame(&self) -> PlotFrame {
        self.coordinates.frame()
    }
}

/// The direction that is up in the image: that of the camera, or z.
pub(super) fn up(projection: Option<&Table>) -> Result<[f64; 3], SceneError> {
    let up = projection.and_then(|table| table.peek(UP.name));
    up.map_or(Ok([0.0, 0.0, 1.0]), |up| up.vector(UP.expected))
}

/// A camera, the length unit with its place, and the shapes of the scene.
pub(super) type CameraOfScene = (Camera, Option<(String, Place)>, Vec<ShapeOfScene>);

/// The camera with its length unit and the shapes; singular points, bounds and edges are
/// those of the scene and, if the camera does not move, of its emission.
pub(super) fn read(
    projection: Option<Table>,
    shapes: ShapeTables,
    emission: &EmissionSource,
    moves: bool,
    whole: &Place,
) -> Result<CameraOfScene, SceneError> {
    let names = || alternatives(cameras().iter().map(|camera| format!("`{}`", camera.name)));
    let Some(mut table) = projection else {
        return Err(SceneError::at(whole, "the scene has no `[projection]`")
            .label(format!("expected a table `[projection]` with `type` = {}", names())));
    };
    let mut shapes = shapes::read(shapes)?;
    let listed = shapes.listed();
    let (name, place) = table.require("type", &names())?.text()?;
    let length_unit = table.text(LENGTH_UNIT.name)?;
    // A length unit that can't be converted is refused with the other units.
    if let (Ok(factor), false) =
        (length_factor(emission.length_unit(), length_unit.as_ref()), moves)
    {
        shapes.add_singular_points(emission.singular_points(), factor);
        shapes.add_edges(emission.edges(), factor);
    }
    let Some(description) = cameras().iter().find(|camera| camera.name == name) else {
        let message = format!("unknown projection `{name}`");
        return Err(SceneError::at(&place, message).label(format!("expected {}", names())));
    };
    // The unit cube is a volume of its own, which data in it usually fill.
    if description.name != "canonical" && !moves {
        emission.data_axes().into_iter().for_each(|axes| shapes.add_ends_of(axes));
    }
    let has_shapes = shapes.bounds.is_some() || !shapes.bodies.is_empty();
    let Optics { coordinates, projection, pointing } =
        (description.read)(&mut table, shapes, &place)?;
    table.finish()?;
    let camera = Camera { description, coordinates, projection, pointing, has_shapes };
    Ok((camera, length_unit, listed))
}

#[cfg(test)]
mod tests;
