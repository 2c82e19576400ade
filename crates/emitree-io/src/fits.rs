//! FITS: images and cubes with units, coordinates and provenance, for numbers.
//!
//! The first axis is x and row 0 comes first, as FITS has it: the pixels are stored in the order
//! that [`Image`] and [`Cube`] keep them, without a flip.

mod card;
mod celestial;
mod channels;
pub(crate) mod energies;
mod healpix;
mod on_sky;
mod provenance;
mod wcs;

pub use card::{Card, CardValue};
pub use celestial::Celestial;
pub use healpix::{HealpixColumn, HealpixFile};
pub use wcs::{Wcs, WcsAxis};

use crate::energies::Energies;
pub(crate) use card::set;
use emitree::{Cube, Image};
use emitree_instrument::Channel;
use fits_well::header::Header;
use fits_well::image::{Borrowed, Scaling, View};
use fits_well::{FitsError, FitsWriter};
pub(crate) use healpix::nside_of;
pub(crate) use provenance::Provenance;
use std::borrow::Cow;
use std::time::SystemTime;
pub(crate) use wcs::{AT_THE_POLE, count};

/// One image of a FITS file, or one cube: the primary one or an extension.
#[derive(Clone, Copy, Debug)]
pub struct FitsImage<'a> {
    name: &'a str,
    bands: &'a [Image],
    third: Third<'a>,
    unit: Option<&'a str>,
}

/// What the third axis of an image is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Third<'a> {
    /// There is none.
    None,
    /// The energy, in the bins of the file.
    Energy,
    /// The channel of a detector.
    Channel(&'a [Channel]),
}

impl<'a> FitsImage<'a> {
    /// An image with the name of its HDU (`EXTNAME`), such as `ERROR`, and the unit of its pixels
    /// (`BUNIT`) in the grammar of FITS, `m-2 sr-1 s-1` for example; none for pure numbers.
    pub fn new(name: &'a str, image: &'a Image, unit: Option<&'a str>) -> Self {
        Self { name, bands: core::slice::from_ref(image), third: Third::None, unit }
    }

    /// A cube, likewise: three axes, the third of which is the energy.
    pub fn cube(name: &'a str, cube: &'a Cube, unit: Option<&'a str>) -> Self {
        Self { name, bands: cube.bands(), third: Third::Energy, unit }
    }

    /// A cube whose third axis is the channel of a detector. As the primary one it brings the table
    /// `EBOUNDS` as the last extension, with the number and the nominal energies of each channel.
    pub fn channels(
        name: &'a str,
        cube: &'a Cube,
        channels: &'a [Channel],
        unit: Option<&'a str>,
    ) -> Self {
        Self { name, bands: cube.bands(), third: Third::Channel(channels), unit }
    }

    /// The shape of one band.
    fn shape(&self) -> Option<[usize; 2]> {
        self.bands.first().map(|band| [band.width(), band.height()])
    }

    /// Writes the pixels with this header.
    fn write(
        &self,
        writer: &mut FitsWriter<Vec<u8>>,
        header: &Header,
    ) -> Result<(), FitsEncodeError> {
        let [width, height] = self.shape().unwrap_or_default();
        let shape = [width, height, self.bands.len()];
        let shape = if self.third == Third::None { &shape[..2] } else { &shape[..] };
        let pixels: Cow<'_, [f64]> = match self.bands {
            [image] => Cow::Borrowed(image.pixels()),
            bands => bands.iter().flat_map(Image::pixels).copied().collect(),
        };
        let pixels = Borrowed::new(shape, View::F64(&pixels), Scaling::IDENTITY)?;
        Ok(writer.write_image(pixels, Some(header))?)
    }
}

/// The contents of a FITS file; [`encode`](Self::encode) turns them into bytes.
///
/// Text may be any Unicode. FITS allows only ASCII, so that other characters are written as
/// `\u00e9`, the escape of TOML strings.
///
/// ```
/// use emitree::Image;
/// use emitree_io::{Card, FitsFile, FitsImage, Wcs};
///
/// let image = Image::zeros(4, 8);
/// let file = FitsFile {
///     primary: FitsImage::new("RADIANCE", &image, Some("m-2 sr-1 s-1")),
///     extensions: vec![FitsImage::new("ERROR", &image, Some("m-2 sr-1 s-1"))],
///     wcs: Some(Wcs::canonical(4, 8)),
///     energies: None,
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
    /// More images or cubes, each in an extension; those of the primary's height and width get its
    /// coordinates.
    pub extensions: Vec<FitsImage<'a>>,
    /// The coordinates of the pixels of an image.
    pub wcs: Option<Wcs>,
    /// The bins of the cubes, if there are any: their third axis, and the table `ENERGIES` as the
    /// last extension, with the ends of each bin.
    pub energies: Option<&'a Energies>,
    /// Keywords of the primary header with the provenance of the image.
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
        /// The message of the encoder.
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
        /// What was expected.
        expected: String,
    },
    /// More columns than a table may have.
    #[error("{0} columns: expected at most 999, as many as FITS allows")]
    Columns(usize),
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
        let header = self.primary_header()?;
        let mut writer = FitsWriter::new(Vec::new()).with_checksums();
        self.primary.write(&mut writer, &header)?;
        for extension in &self.extensions {
            extension.write(&mut writer, &self.header(extension)?)?;
        }
        if let Some(energies) = self.energies {
            energies::write_table(&mut writer, energies)?;
        }
        if let Third::Channel(channels) = self.primary.third {
            channels::write_table(&mut writer, channels)?;
        }
        Ok(writer.into_inner())
    }

    /// Name, unit and coordinates of the primary image, with the provenance.
    pub(crate) fn primary_header(&self) -> Result<Header, FitsEncodeError> {
        let mut header = self.header(&self.primary)?;
        let Self { provenance: cards, history, date, .. } = self;
        Provenance { cards, history, date: *date }.write(&mut header)?;
        Ok(header)
    }

    /// Name, unit and coordinates of one image.
    pub(crate) fn header(&self, of: &FitsImage<'_>) -> Result<Header, FitsEncodeError> {
        let mut header = Header::new();
        set(&mut header, &Card::new("EXTNAME", of.name, "what the pixels are"))?;
        if let Some(unit) = of.unit {
            set(&mut header, &Card::new("BUNIT", unit, "unit of the pixels"))?;
        }
        let Some(wcs) = &self.wcs else { return Ok(header) };
        if of.shape() == self.primary.shape() {
            let wcs = match (of.third, self.energies) {
                (Third::Energy, Some(energies)) => wcs.clone().with_energies(energies),
                (Third::Channel(channels), _) => wcs.clone().with_channels(channels),
                _ => wcs.clone(),
            };
            for card in wcs.cards() {
                set(&mut header, &card)?;
            }
        }
        Ok(header)
    }
}

#[cfg(test)]
mod tests;
