//! Images larger than the memory, written to FITS files block by block.

use crate::account::Account;
use crate::fits::{FitsEncodeError, FitsFile, FitsImage};
use crate::output::{OutputError, OutputFile};
use crate::product::scene_history;
use crate::scene::{Quantity, Scene};
use emitree::large::{LargeImage, refused, render_large};
use emitree::{Emission, Image, RenderError, RenderOptions};
use fits_well::FitsWriter;
use fits_well::header::Header;
use fits_well::image::{Bitpix, Metadata, Scaling, View};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;
use std::time::SystemTime;

/// The bytes of a pixel: its value and its error.
const BYTES_PER_PIXEL: u64 = 16;
/// A compressed file takes at least the thousandth of the other.
const BEST_RATIO: u64 = 1000;

/// A large image that can't be rendered or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LargeError<E> {
    /// It can't be rendered.
    #[error(transparent)]
    Render(#[from] RenderError<E>),
    /// It can't be encoded, or not all of it stored.
    #[error(transparent)]
    Fits(#[from] FitsEncodeError),
    /// The file can't be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// What was written.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LargeOutput {
    /// What was rendered and what it cost.
    pub account: Account,
    /// The smallest and the largest radiance.
    pub range: [f64; 2],
}

/// Renders an image of a scene from a low-rank approximation and writes it to a FITS file block by block: the
/// values, and the extension `ERROR`. Memory does not grow with the number of pixels. A name that ends in `.gz`
/// has the whole file compressed (gzip), without `CHECKSUM`.
///
/// ```
/// use emitree_io::{OutputFile, Scene, write_large};
///
/// let text = r#"
///     emission.expression = "exp(-x^2 - y^2 - z^2)"
///     projection.type = "canonical"
///     image = { width = 300, height = 200 }
/// "#;
/// let scene = Scene::parse("example", text, &[])?;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("image.fits");
/// let options = scene.render_options();
/// let made = write_large(&scene, &scene.emission, &options, OutputFile::create(&path)?)?;
/// assert!(made.account.converged());
/// assert!(std::fs::metadata(&path)?.len() > 16 * 300 * 200);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`LargeError`]: as [`render_large`], for a cube too; a disk without room for the file, before anything is
/// evaluated. No file is left then.
pub fn write_large<E: Emission>(
    scene: &Scene,
    emission: &E,
    options: &RenderOptions<'_>,
    output: OutputFile,
) -> Result<LargeOutput, LargeError<E::Error>> {
    let shape @ [height, width] = [scene.height, scene.width];
    if scene.axis().is_some() {
        return Err(refused("it is a cube", shape, options).into());
    }
    let is_compressed = is_compressed(output.path());
    let whole = BYTES_PER_PIXEL.saturating_mul(height as u64).saturating_mul(width as u64);
    output.check_room(if is_compressed { whole / BEST_RATIO } else { whole })?;
    let image = render_large(emission, scene.camera.projection(), shape, options)?;
    let account = Account::of(scene, image.stats(), None, Some(image.estimated_error()));
    let writing = Writing { scene, image: &image, account: &account, options };
    output.commit_with(|file| -> Result<(), LargeError<E::Error>> {
        let file = BufWriter::with_capacity(1 << 20, file);
        if is_compressed {
            let gzip = GzEncoder::new(file, Compression::fast());
            let writer = FitsWriter::new(Counted { gzip, position: 0 });
            let Counted { gzip, .. } = writing.write(writer)?;
            gzip.finish().and_then(|mut file| file.flush()).map_err(stored)?;
        } else {
            let writer = FitsWriter::new(file).with_checksums();
            writing.write(writer)?.flush().map_err(stored)?;
        }
        Ok(())
    })?;
    Ok(LargeOutput { account, range: image.range() })
}

/// Whether the ending of a name asks for a compressed file.
fn is_compressed(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz"))
}

/// The error of bytes that can't be stored.
fn stored(error: io::Error) -> FitsEncodeError {
    FitsEncodeError::Encode(error.into())
}

/// A file while it is written.
struct Writing<'a> {
    scene: &'a Scene,
    image: &'a LargeImage<'a>,
    account: &'a Account,
    options: &'a RenderOptions<'a>,
}

impl Writing<'_> {
    fn write<W: Write + Seek, E>(&self, mut writer: FitsWriter<W>) -> Result<W, LargeError<E>> {
        let [primary, error] = self.headers()?;
        self.map(&mut writer, &primary, |rows| self.image.values(rows))?;
        self.map(&mut writer, &error, |rows| self.image.errors(rows))?;
        Ok(writer.into_inner())
    }

    /// Writes one HDU, block by block.
    fn map<W: Write + Seek, E>(
        &self,
        writer: &mut FitsWriter<W>,
        header: &Header,
        make: impl Fn(std::ops::Range<usize>) -> Image,
    ) -> Result<(), LargeError<E>> {
        let [height, width] = self.image.shape();
        let shape = [width, height];
        let layout = Metadata { shape: &shape, bitpix: Bitpix::F64, scaling: Scaling::IDENTITY };
        let mut stream =
            writer.stream_image(layout, Some(header)).map_err(FitsEncodeError::from)?;
        for rows in self.image.blocks() {
            let evaluations = self.image.stats().evaluations;
            if self.options.progress.is_some_and(|progress| progress(evaluations).is_break()) {
                return Err(RenderError::Interrupted.into());
            }
            let mut block = make(rows.clone());
            if self.scene.quantity == Quantity::Irradiance {
                let angles = self.image.solid_angles(rows);
                let pixels = block.pixels_mut().iter_mut().zip(angles.pixels());
                pixels.for_each(|(pixel, angle)| *pixel *= angle);
            }
            stream.write_chunk(View::F64(block.pixels())).map_err(FitsEncodeError::from)?;
        }
        stream.finish().map_err(FitsEncodeError::from)?;
        Ok(())
    }

    /// The headers of the values and of their errors.
    fn headers(&self) -> Result<[Header; 2], FitsEncodeError> {
        let pixel = Image::zeros(1, 1);
        let unit = Some(self.account.unit.as_str()).filter(|unit| !unit.is_empty());
        let name = self.account.quantity.to_uppercase();
        let error = FitsImage::new("ERROR", &pixel, unit);
        let file = FitsFile {
            primary: FitsImage::new(&name, &pixel, unit),
            extensions: Vec::new(),
            wcs: self.scene.celestial_wcs(),
            energies: None,
            provenance: self.account.cards(),
            history: scene_history(&self.scene.text, &self.scene.overrides),
            date: Some(SystemTime::now()),
        };
        Ok([file.primary_header()?, file.header(&error)?])
    }
}

/// A compressed file that tells how many bytes went into it.
struct Counted<'f> {
    gzip: GzEncoder<BufWriter<&'f mut File>>,
    position: u64,
}

impl Write for Counted<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.gzip.write(bytes)?;
        self.position += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.gzip.flush()
    }
}

impl Seek for Counted<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.position),
            _ => Err(io::Error::new(
                io::ErrorKind::Unsupported,
                "a compressed file has one direction",
            )),
        }
    }
}
