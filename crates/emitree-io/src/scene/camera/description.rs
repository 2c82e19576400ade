//! What there is to say of a kind of camera: a row of the table in `kinds`.

use super::shapes::Shapes;
use crate::fits::Wcs;
use crate::scene::error::SceneError;
use crate::scene::source::Place;
use crate::scene::table::Table;
use crate::sky::Pointing;
use crate::units::Unit;
use core::fmt;
use emitree::Projection;
use std::sync::Arc;

/// A kind of camera: its name, its keys, and what files and pictures say of its images.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct CameraDescription {
    /// The name, as `projection.type` has it.
    pub name: &'static str,
    /// What it is, in one sentence.
    pub summary: &'static str,
    /// The name of its class in Python.
    pub python_class: &'static str,
    /// The keys of `[projection]` that it has beside `type`: first those it shares with others.
    pub keys: &'static [CameraKey],
    /// How its pixels are arranged.
    pub pixels: PixelLayout,
    /// Whether there is a point observer, so that pixels have solid angles.
    pub has_solid_angles: bool,
    /// Whether pixels lie on a plane with uniform steps along x and y about the middle, so that a
    /// point-spread function in pixels has a meaning.
    pub has_plane: bool,
    /// The coordinates of its images in FITS.
    pub fits: FitsCoordinates,
    pub(super) read: ReadCamera,
}

impl CameraDescription {
    /// Whether an image is a whole sky, and no rectangle of pixels.
    ///
    /// ```
    /// use emitree_io::cameras;
    ///
    /// let skies = cameras().iter().filter(|camera| camera.is_sky());
    /// assert!(skies.map(|camera| camera.name).eq(["healpix"]));
    /// ```
    pub fn is_sky(&self) -> bool {
        match self.pixels {
            PixelLayout::Rectangle => false,
            PixelLayout::Healpix => true,
        }
    }

    /// Whether its images have longitudes and latitudes about the pointing, which `[sky]` replaces by those of
    /// the sky.
    ///
    /// ```
    /// use emitree_io::cameras;
    ///
    /// let celestial = cameras().iter().filter(|camera| camera.is_celestial());
    /// assert!(celestial.map(|of| of.name).eq(["perspective", "equirectangular", "fisheye"]));
    /// ```
    pub fn is_celestial(&self) -> bool {
        match self.fits {
            FitsCoordinates::Axes(axes) => axes.iter().all(|[x, _]| x.starts_with("XLON-")),
            FitsCoordinates::None(_) => false,
        }
    }
}

/// How the pixels of a camera are arranged, and which keys of `[image]` count them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelLayout {
    /// `width` columns and `height` rows.
    Rectangle,
    /// Twelve faces of `nside` × `nside` pixels of equal solid angle, in nested order: the whole sky.
    Healpix,
}

/// The coordinates of a camera's images in FITS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitsCoordinates {
    /// Keywords, with one of these types of axes (`CTYPE1`, `CTYPE2`): x first.
    Axes(&'static [[&'static str; 2]]),
    /// No keywords, for this reason.
    None(&'static str),
}

/// A key of `[projection]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct CameraKey {
    /// The name.
    pub name: &'static str,
    /// The type of its value and its unit, as the guide has them: `[width, height], degrees`.
    pub value: &'static str,
    /// The unit that its numbers are in.
    pub unit: KeyUnit,
    /// Whether it may be left out, and what that means.
    pub default: KeyDefault,
    /// What it says, and which values it may have, in a line.
    pub meaning: &'static str,
    /// A value, as TOML writes it; those of all keys of a camera go together.
    pub example: &'static str,
    /// What error messages say was expected.
    pub(super) expected: &'static str,
}

/// The unit of the numbers of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyUnit {
    /// The length unit of the scene.
    Length,
    /// Degrees.
    Degrees,
    /// None: a direction or a word.
    None,
}

/// Whether a key may be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyDefault {
    /// It must be given.
    Required,
    /// It may be left out where the scene has `[bounds]`, and is this there.
    InBounds(&'static str),
    /// It may be left out, and is this.
    Value(&'static str),
}

/// What surrounds an image in an annotated picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlotFrame {
    /// Axes; the image has their proportions.
    Axes {
        /// To the right.
        x: PlotAxis,
        /// Upwards.
        y: PlotAxis,
    },
    /// Axes that have nothing in common; the image keeps its own proportions.
    UnlikeAxes {
        /// To the right.
        x: PlotAxis,
        /// Upwards.
        y: PlotAxis,
    },
    /// A line about the ellipse that fills the image, for a disc or a map of the sphere.
    Ellipse,
}

/// An axis of an annotated picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlotAxis {
    /// What it measures, without the unit.
    pub label: &'static str,
    /// The coordinates at the edges of the image, the left or the lower one first: in the length
    /// unit of the scene, or in degrees.
    pub ends: [f64; 2],
    /// Their unit, and which steps are equal.
    pub scale: PlotScale,
}

impl PlotAxis {
    /// An axis with 0 in the middle of the image, which is `extent` across.
    pub(super) fn centred(label: &'static str, extent: f64, scale: PlotScale) -> Self {
        let end = 0.5 * extent;
        Self { label, ends: [-end, end], scale }
    }
}

/// The scale of an axis of an annotated picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlotScale {
    /// Lengths, with uniform steps, in the length unit of the scene.
    Lengths,
    /// Angles with uniform steps \[deg\].
    Angles,
    /// Angles whose tangents have uniform steps, as on a flat screen \[deg\].
    Tangents,
}

/// The image of a camera in the numbers of its scene: which coordinates are where.
pub(super) trait ImageCoordinates: fmt::Debug + Send + Sync {
    /// The coordinates of an image of \[height, width\] pixels in FITS, lengths in `unit`; none if
    /// the row of the camera says why.
    fn wcs(&self, shape: [usize; 2], unit: &Unit) -> Option<Wcs>;

    /// What surrounds the image in an annotated picture.
    fn frame(&self) -> PlotFrame;
}

/// A camera that was read.
pub(super) struct Optics {
    pub(super) coordinates: Arc<dyn ImageCoordinates>,
    pub(super) projection: Arc<dyn Projection + Send>,
    pub(super) pointing: Option<Pointing>,
}

/// Takes the keys of a camera from `[projection]`, which names it at the given place, and makes it
/// with the shapes of the scene.
pub(super) type ReadCamera = fn(&mut Table, Shapes, &Place) -> Result<Optics, SceneError>;
