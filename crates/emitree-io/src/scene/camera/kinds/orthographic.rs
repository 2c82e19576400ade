//! `orthographic`: parallel lines of sight through a rectangle.

use crate::fits::{Wcs, WcsAxis};
use crate::scene::camera::description::{
    CameraDescription, CameraKey, FitsCoordinates, ImageCoordinates, KeyDefault, KeyUnit, Optics,
    PixelLayout, PlotAxis, PlotFrame, PlotScale,
};
use crate::scene::camera::pointing::{FAR, Keys, LENGTH_UNIT, NEAR, POSITION, TARGET, UP};
use crate::scene::camera::shapes::Shapes;
use crate::scene::error::SceneError;
use crate::scene::source::Place;
use crate::scene::table::Table;
use crate::units::Unit;
use emitree::Orthographic;

pub(super) const ORTHOGRAPHIC: CameraDescription = CameraDescription {
    name: "orthographic",
    summary: "Parallel lines of sight through a rectangle about `position`.",
    python_class: "Orthographic",
    keys: &[POSITION, TARGET, UP, NEAR, FAR, LENGTH_UNIT, EXTENT],
    pixels: PixelLayout::Rectangle,
    has_solid_angles: false,
    has_plane: true,
    fits: FitsCoordinates::Axes(&[["X", "Y"]]),
    read,
};

const EXTENT: CameraKey = CameraKey {
    name: "extent",
    value: "[width, height], length",
    unit: KeyUnit::Length,
    default: KeyDefault::Required,
    meaning: "width and height of the image, each above 0",
    example: "[8.0, 6.0]",
    expected: "two lengths [width, height] in `length_unit`",
};

fn read(table: &mut Table, shapes: Shapes, _: &Place) -> Result<Optics, SceneError> {
    let keys = Keys::read(table, &EXTENT, shapes.bounds.is_some(), true)?;
    let extent = keys.field.vector(EXTENT.expected)?;
    let camera = Orthographic::new(keys.viewpoint()?, extent, keys.depth()?);
    keys.camera(Screen { extent }, camera, shapes)
}

/// The image plane, of this width and height in the length unit of the scene.
#[derive(Debug)]
struct Screen {
    extent: [f64; 2],
}

impl ImageCoordinates for Screen {
    fn wcs(&self, [height, width]: [usize; 2], unit: &Unit) -> Option<Wcs> {
        Some(Wcs::orthographic(height, width, self.extent, unit))
    }

    fn frame(&self) -> PlotFrame {
        let axis = |label, extent| PlotAxis::centred(label, extent, PlotScale::Lengths);
        let [width, height] = self.extent;
        PlotFrame::Axes { x: axis("to the right", width), y: axis("up", height) }
    }
}

impl Wcs {
    /// Lengths on the image plane of parallel rays, linear and about the middle, for an image of
    /// `extent` = \[width, height\] in `unit`.
    ///
    /// At the canonical point (x, y) they are ((x − ½) · width, (y − ½) · height): x to the right, y
    /// up. A unit that FITS lacks, the radius of a planet, becomes kilometres; pure numbers have
    /// none.
    ///
    /// ```
    /// use emitree_io::{Wcs, units::Unit};
    ///
    /// let wcs = Wcs::orthographic(100, 50, [50.0, 100.0], &Unit::parse("R_E")?);
    /// assert_eq!((wcs.axes[0].cunit.as_deref(), wcs.axes[0].cdelt), (Some("km"), 6371.0));
    /// # Ok::<(), emitree_io::units::UnitError>(())
    /// ```
    pub fn orthographic(height: usize, width: usize, extent: [f64; 2], unit: &Unit) -> Self {
        let (cunit, factor) = unit.fits();
        let axis = |ctype: &str, name: &str, pixels, extent: f64| {
            WcsAxis::about_the_middle(ctype, name, pixels, extent * factor, cunit.as_deref())
        };
        Self {
            name: "orthographic".to_owned(),
            axes: vec![
                axis("X", "x on the image plane", width, extent[0]),
                axis("Y", "y on the image plane", height, extent[1]),
            ],
            pole_deg: None,
            celestial: None,
        }
    }
}
