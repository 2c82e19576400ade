//! `fisheye`: a cone about the pointing as a disc.

use crate::fits::{AT_THE_POLE, Wcs};
use crate::scene::camera::description::{
    CameraDescription, CameraKey, FitsCoordinates, ImageCoordinates, KeyDefault, KeyUnit, Optics,
    PixelLayout, PlotFrame,
};
use crate::scene::camera::pointing::{CONE, FAR, Keys, LENGTH_UNIT, NEAR, POSITION, TARGET, UP};
use crate::scene::camera::shapes::Shapes;
use crate::scene::error::SceneError;
use crate::scene::source::Place;
use crate::scene::table::Table;
use crate::units::Unit;
use emitree::Fisheye;
use emitree::projection::DiscMapping;

pub(super) const FISHEYE: CameraDescription = CameraDescription {
    name: "fisheye",
    summary: "The sky about the pointing as a disc; pixels outside of it are NaN.",
    python_class: "Fisheye",
    keys: &[POSITION, TARGET, UP, NEAR, FAR, LENGTH_UNIT, CONE, MAPPING],
    pixels: PixelLayout::Rectangle,
    has_solid_angles: true,
    has_plane: true,
    fits: FitsCoordinates::Axes(&[["XLON-ARC", "XLAT-ARC"], ["XLON-ZEA", "XLAT-ZEA"]]),
    read,
};

const MAPPING: CameraKey = CameraKey {
    name: "mapping",
    value: "string",
    unit: KeyUnit::None,
    default: KeyDefault::Value("`\"equidistant\"`"),
    meaning: "the radius is proportional to the angle θ from the pointing: \"equidistant\" or \
              \"ARC\"; or to sin(θ/2), so that areas are solid angles: \"equal_area\" or \"ZEA\"",
    example: "\"equal_area\"",
    expected: "`equidistant` (ARC) or `equal_area` (ZEA)",
};

fn read(table: &mut Table, shapes: Shapes, _: &Place) -> Result<Optics, SceneError> {
    let mapping = match table.text(MAPPING.name)? {
        None => DiscMapping::Equidistant,
        Some((name, place)) => match name.as_str() {
            "equidistant" | "ARC" => DiscMapping::Equidistant,
            "equal_area" | "ZEA" => DiscMapping::EqualArea,
            _ => {
                let error = SceneError::at(&place, format!("unknown mapping `{name}`"));
                return Err(error.label(format!("expected {}", MAPPING.expected)));
            }
        },
    };
    let keys = Keys::read(table, &CONE, shapes.bounds.is_some(), false)?;
    let fov_deg = keys.cone_deg()?;
    let camera = Fisheye::new(keys.viewpoint()?, fov_deg.to_radians(), mapping, keys.depth()?);
    let equal_area = mapping == DiscMapping::EqualArea;
    keys.camera(Disc { fov_deg, equal_area }, camera, shapes)
}

/// The disc of a cone with this full angle \[deg\].
#[derive(Debug)]
struct Disc {
    fov_deg: f64,
    /// Whether areas are equal, or else distances from the pointing.
    equal_area: bool,
}

impl ImageCoordinates for Disc {
    fn wcs(&self, [height, width]: [usize; 2], _: &Unit) -> Option<Wcs> {
        Some(Wcs::fisheye(height, width, self.fov_deg, self.equal_area))
    }

    fn frame(&self) -> PlotFrame {
        PlotFrame::Ellipse
    }
}

impl Wcs {
    /// Longitude and latitude about the pointing in a disc, for a field of view of `fov_deg` across
    /// \[deg\], up to 360.
    ///
    /// The disc's radius on the canonical image is ½. At the distance ϱ from its middle the sight is
    /// at the angle ϑ from the pointing: ϑ = ϱ · fov, the projection ARC, or with `equal_area`
    /// sin(ϑ/2) = 2ϱ sin(fov/4), the projection ZEA. World coordinates and signs are those of
    /// [`perspective`](Self::perspective).
    ///
    /// ```
    /// use emitree_io::Wcs;
    ///
    /// let wcs = Wcs::fisheye(100, 100, 180.0, false);
    /// assert_eq!((wcs.axes[0].ctype.as_str(), wcs.axes[0].cdelt), ("XLON-ARC", 1.8));
    /// ```
    pub fn fisheye(height: usize, width: usize, fov_deg: f64, equal_area: bool) -> Self {
        let (code, across_deg) = if equal_area {
            ("ZEA", 4.0 * (0.25 * fov_deg).to_radians().sin().to_degrees())
        } else {
            ("ARC", fov_deg)
        };
        Self::spherical("fisheye", code, [height, width], [across_deg; 2], AT_THE_POLE)
    }
}
