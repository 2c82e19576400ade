//! The formats of output files: one row each, and one file each; chosen by the ending of a name.

mod fits;
mod npy;
mod png;

pub use png::PictureStyle;

use crate::fits::FitsEncodeError;
use crate::npy::NpyError;
use crate::png::PictureError;
use crate::product::Product;
use crate::words::alternatives;
use std::path::{Path, PathBuf};

/// A format that images can be written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// FITS: the image, its error and other maps, with units, coordinates and provenance.
    Fits,
    /// The array file of `numpy`: the bare numbers of one image.
    Npy,
    /// PNG: a picture for display, without the numbers.
    Png,
}

/// What there is to say of a format: its names, and what it makes of an image, a cube and a sky.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct FormatDescription {
    /// The name, as people write it.
    pub name: &'static str,
    /// The endings of names that choose it, lower case and without the dot; new files get the first.
    pub endings: &'static [&'static str],
    /// Whether a rendering has a file of it if no output is named.
    pub is_default: bool,
    /// Whether it is a picture, so that [`PictureStyle`] decides how it looks.
    pub is_picture: bool,
    /// What it makes of an image.
    pub image: &'static str,
    /// What it makes of a cube.
    pub cube: &'static str,
    /// What it makes of a whole sky.
    pub sky: &'static str,
    /// The most maps, or bands of maps, that a file of a sky has room for; `None` for any number.
    pub most_maps_of_sky: Option<usize>,
    encode: fn(&Product<'_>, PictureStyle) -> Result<Vec<u8>, EncodeError>,
}

impl Format {
    /// All formats, in the order of messages and of the files that a rendering has by default.
    pub const ALL: [Self; 3] = [Self::Fits, Self::Npy, Self::Png];

    /// What there is to say of it.
    ///
    /// ```
    /// use emitree_io::Format;
    ///
    /// for format in Format::ALL {
    ///     let found = format.description();
    ///     println!("{} (.{}): {}", found.name, found.endings.join(", ."), found.image);
    /// }
    /// ```
    pub fn description(self) -> &'static FormatDescription {
        match self {
            Self::Fits => &fits::FITS,
            Self::Npy => &npy::NPY,
            Self::Png => &png::PNG,
        }
    }

    /// The format that the ending of `path` stands for, upper or lower case.
    ///
    /// # Errors
    ///
    /// [`UnknownEnding`] with the endings that there are.
    ///
    /// ```
    /// use emitree_io::Format;
    ///
    /// assert_eq!(Format::from_path("run/image.fits"), Ok(Format::Fits));
    /// let error = Format::from_path("image.jpeg").unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "`image.jpeg`: no format for this ending: expected .fits, .fit, .npy or .png"
    /// );
    /// ```
    pub fn from_path(path: impl AsRef<Path>) -> Result<Self, UnknownEnding> {
        let path = path.as_ref();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let has_ending = |format: &Self| {
            format.description().endings.iter().any(|name| name.eq_ignore_ascii_case(ending))
        };
        let found = Self::ALL.into_iter().find(has_ending);
        found.ok_or_else(|| UnknownEnding { path: path.to_owned(), expected: endings() })
    }

    /// The bytes of a file with a product; pictures look as `style` says.
    ///
    /// ```
    /// use emitree::{Cube, Image};
    /// use emitree_io::{Bands, Format, PictureStyle, Product, ProductMap, Scene};
    ///
    /// let text = r#"
    ///     emission.expression = "x"
    ///     projection.type = "canonical"
    ///     image = { width = 8, height = 4 }
    /// "#;
    /// let scene = Scene::parse("example", text, &[])?;
    /// let map = Cube::from_bands(vec![Image::zeros(4, 8)]);
    /// let map = ProductMap { name: "RADIANCE", map: &map, unit: "", bands: Bands::Image };
    /// let product = Product::new(&scene, map);
    /// let bytes = Format::Npy.encode(&product, PictureStyle::default())?;
    /// assert!(bytes.starts_with(b"\x93NUMPY"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`EncodeError`]: what the format can't hold.
    pub fn encode(
        self,
        product: &Product<'_>,
        style: PictureStyle,
    ) -> Result<Vec<u8>, EncodeError> {
        (self.description().encode)(product, style)
    }
}

/// A file name whose ending stands for no format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}`: no format for this ending: expected {expected}", path.display())]
pub struct UnknownEnding {
    /// The path given.
    pub path: PathBuf,
    /// The endings that there are.
    pub expected: String,
}

/// The endings of all formats, for messages.
fn endings() -> String {
    let endings = Format::ALL.into_iter().flat_map(|format| format.description().endings);
    alternatives(endings.map(|ending| format!(".{ending}")))
}

/// A product that a format can't hold.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// FITS can't.
    #[error(transparent)]
    Fits(#[from] FitsEncodeError),
    /// An array file can't.
    #[error(transparent)]
    Npy(#[from] NpyError),
    /// A picture can't.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// An archive of arrays can't.
    #[error("can't make the archive: {reason}")]
    Archive {
        /// What is wrong with it.
        reason: String,
    },
    /// An annotated picture can't.
    #[cfg(feature = "figure")]
    #[error(transparent)]
    Figure(#[from] crate::figure::FigureError),
}

#[cfg(test)]
mod tests;
