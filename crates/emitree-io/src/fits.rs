//! FITS: images with units, coordinates and provenance, for numbers.
//!
//! The first axis is x and row 0 comes first, as FITS has it: the pixels are stored in the order
//! that [`Image`] keeps them, without a flip.

mod card;
mod healpix;
mod provenance;
mod wcs;

pub use card::{Card, CardValue};
pub use healpix::{HealpixColumn, HealpixFile};
pub use wcs::{Wcs, WcsAxis};

pub(crate) use card::set;
use emitree::Image;
use fits_well::header::Header;
use fits_well::image::{Borrowed, Scaling, View};
use fits_well::{FitsError, FitsWriter};
pub(crate) use provenance::Provenance;
use std::time::SystemTime;

/// One image of a FITS file: the primary one or an extension.
#[derive(Clone, Copy, Debug)]
pub struct FitsImage<'a> {
    /// The name of the extension (`EXTNAME`): `ERROR`, `EVALUATIONS`.
    pub name: &'a str,
    /// The pixels.
    pub image: &'a Image,
    /// The unit of the pixels (`BUNIT`) in the grammar of FITS, `m-2 sr-1 s-1` for example; none
    /// for pure numbers.
    pub unit: Option<&'a str>,
}

/// What a FITS file says; [`encode`](Self::encode) turns it into bytes.
///
/// Text may be any Unicode. FITS knows only ASCII, so that other characters are written as
/// `\u00e9`, the escape of TOML strings.
///
/// ```
/// use emitree::Image;
/// use emitree_io::{Card, FitsFile, FitsImage, Wcs};
///
/// let image = Image::zeros(4, 8);
/// let file = FitsFile {
///     primary: FitsImage { name: "RADIANCE", image: &image, unit: Some("m-2 sr-1 s-1") },
///     extensions: vec![FitsImage { name: "ERROR", image: &image, unit: Some("m-2 sr-1 s-1") }],
///     wcs: Some(Wcs::canonical(4, 8)),
///     provenance: vec![Card::new("NEVAL", 4066, "evaluations of the emission rate")],
///     history: "[projection]\ntype = \"canonical\"\n".to_owned(),
///     date: None,
/// };
/// let bytes = file.encode()?;
/// assert_eq!(bytes.len() % 2880, 0);
/// # Ok::<(), emitree_io::FitsEncodeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct FitsFile<'a> {
    /// The image of the primary HDU.
    pub primary: FitsImage<'a>,
    /// More images, each in an extension; those of the primary's shape get its coordinates.
    pub extensions: Vec<FitsImage<'a>>,
    /// Where the pixels lie.
    pub wcs: Option<Wcs>,
    /// Keywords of the primary header that say how the image came about.
    pub provenance: Vec<Card>,
    /// A text of any number of lines, the scene for example, kept as `HISTORY`. A line of over 72
    /// characters goes on in the next record, the first ending in a backslash in column 72.
    pub history: String,
    /// When the file was made (`DATE`, in UTC).
    pub date: Option<SystemTime>,
}

/// Contents that FITS has no room or no word for.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FitsEncodeError {
    /// A header record that FITS forbids.
    #[error(
        "FITS keyword `{keyword}`: {source}: expected 1 to 8 of A-Z, 0-9, - and _, each keyword \
         once, none of the file structure"
    )]
    Card {
        /// The keyword.
        keyword: String,
        /// What the encoder said.
        source: FitsError,
    },
    /// A keyword that would be dropped or would contradict what is written here already.
    #[error("FITS keyword `{keyword}` is written already: expected another one")]
    Taken {
        /// The keyword.
        keyword: String,
    },
    /// A number of values that is not that of any map of the whole sphere.
    #[error(
        "column `{column}` has {values} values: expected {expected}, in each column of a HEALPix map"
    )]
    Pixels {
        /// The column.
        column: String,
        /// Its values.
        values: usize,
        /// What would be accepted.
        expected: String,
    },
    /// The encoder failed.
    #[error("cannot encode the FITS file: {0}")]
    Encode(#[from] FitsError),
}

impl FitsFile<'_> {
    /// The bytes of the file: 64-bit floats, with `DATASUM` and `CHECKSUM` for each image.
    ///
    /// # Errors
    ///
    /// [`FitsEncodeError`] if a keyword of the provenance is not valid in FITS, comes twice, or is
    /// written by this function itself.
    pub fn encode(&self) -> Result<Vec<u8>, FitsEncodeError> {
        let mut header = self.header(&self.primary)?;
        let Self { provenance: cards, history, date, .. } = self;
        Provenance { cards, history, date: *date }.write(&mut header)?;

        let mut writer = FitsWriter::new(Vec::new()).with_checksums();
        write_image(&mut writer, self.primary.image, &header)?;
        for extension in &self.extensions {
            write_image(&mut writer, extension.image, &self.header(extension)?)?;
        }
        Ok(writer.into_inner())
    }

    /// Name, unit and coordinates of one image.
    fn header(&self, of: &FitsImage<'_>) -> Result<Header, FitsEncodeError> {
        let mut header = Header::new();
        set(&mut header, &Card::new("EXTNAME", of.name, "what the pixels are"))?;
        if let Some(unit) = of.unit {
            set(&mut header, &Card::new("BUNIT", unit, "unit of the pixels"))?;
        }
        let shape = |image: &Image| (image.height(), image.width());
        if let Some(wcs) = &self.wcs
            && shape(of.image) == shape(self.primary.image)
        {
            for card in wcs.cards() {
                set(&mut header, &card)?;
            }
        }
        Ok(header)
    }
}

fn write_image(
    writer: &mut FitsWriter<Vec<u8>>,
    image: &Image,
    header: &Header,
) -> Result<(), FitsError> {
    let shape = [image.width(), image.height()];
    let pixels = Borrowed::new(&shape, View::F64(image.pixels()), Scaling::IDENTITY)?;
    writer.write_image(pixels, Some(header))
}

#[cfg(test)]
mod tests;
