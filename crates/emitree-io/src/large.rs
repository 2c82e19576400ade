//! Images and cubes larger than the memory, written to FITS files block by block.

use crate::account::Account;
use crate::fits::{FitsEncodeError, FitsFile, FitsImage, energies};
use crate::output::{OutputError, OutputFile};
use crate::product::scene_history;
use crate::report::Report;
use crate::scene::{Quantity, Scene};
use emitree::large::{LargeCube, LargeImage, render_large_cube};
use emitree::{Cube, Emission, EnergyAxis, Image, RenderError, RenderOptions};
use fits_well::FitsWriter;
use fits_well::header::Header;
use fits_well::image::{Bitpix, Metadata, Scaling, View};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::ops::{ControlFlow, Range};
use std::path::Path;
use std::time::SystemTime;

/// The bytes of a voxel: its value and its error.
const BYTES_PER_VOXEL: u64 = 16;
/// A compressed file takes at least the thousandth of the other.
const BEST_RATIO: u64 = 1000;

/// A large image or cube that can't be rendered or written.
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
    /// The smallest and the largest value.
    pub range: [f64; 2],
    /// Height and width in pixels.
    pub shape: [usize; 2],
}

impl LargeOutput {
    /// The report of the rendering.
    pub fn report(&self) -> Report<'_> {
        Report::new(&self.account, self.shape, self.range, None, None)
    }
}

/// Renders an image or a cube of a scene from low-rank approximations and writes it to a FITS file block by block: the
/// values, the extension `ERROR`, and of a cube the table `ENERGIES`. Memory does not grow with the number of pixels. A
/// name that ends in `.gz` has the whole file compressed (gzip), without `CHECKSUM`.
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
/// [`LargeError`]: as [`render_large_cube`]; a disk without room for the file, before anything is
/// evaluated. No file is left then.
pub fn write_large<E: Emission>(
    scene: &Scene,
    emission: &E,
    options: &RenderOptions<'_>,
    output: OutputFile,
) -> Result<LargeOutput, LargeError<E::Error>> {
    let shape = [scene.height, scene.width];
    let axis = scene.axis();
    let is_compressed = is_compressed(output.path());
    let bins = axis.map_or(1, EnergyAxis::bins);
    let [bins, height, width] = [bins, shape[0], shape[1]].map(|number| number as u64);
    let voxels = bins.saturating_mul(height).saturating_mul(width);
    let whole = BYTES_PER_VOXEL.saturating_mul(voxels);
    output.check_room(if is_compressed { whole / BEST_RATIO } else { whole })?;
    let cube = render_large_cube(emission, scene.camera.projection(), shape, axis, options)?;
    let error = match scene.quantity {
        Quantity::Irradiance => error_of_irradiances(&cube, options)?,
        Quantity::Radiance => cube.estimated_error(),
    };
    let account = Account::of(scene, cube.stats(), None, Some(error));
    let writing = Writing { scene, cube: &cube, account: &account, options };
    let mut range = [f64::NAN; 2];
    output.commit_with(|file| -> Result<(), LargeError<E::Error>> {
        let file = BufWriter::with_capacity(1 << 20, file);
        if is_compressed {
            let gzip = GzEncoder::new(file, Compression::fast());
            let writer = FitsWriter::new(Counted { gzip, position: 0 });
            let Counted { gzip, .. } = writing.write(writer, &mut range)?;
            gzip.finish().and_then(|mut file| file.flush()).map_err(stored)?;
        } else {
            let writer = FitsWriter::new(file).with_checksums();
            writing.write(writer, &mut range)?.flush().map_err(stored)?;
        }
        Ok(())
    })?;
    Ok(LargeOutput { account, range, shape })
}

/// Makes radiances of some rows, or their errors, irradiances.
fn to_irradiances(block: &mut Image, band: &LargeImage<'_>, rows: Range<usize>) {
    let angles = band.solid_angles(rows);
    let pixels = block.pixels_mut().iter_mut().zip(angles.pixels());
    pixels.for_each(|(pixel, angle)| *pixel *= angle);
}

/// Each band with each of its blocks of rows, until the progress ends it.
fn blocks<'c, E>(
    cube: &'c LargeCube<'c>,
    options: &RenderOptions<'_>,
) -> impl Iterator<Item = Result<(&'c LargeImage<'c>, Range<usize>), LargeError<E>>> {
    let evaluations = cube.stats().evaluations;
    let of_band = |band: &'c LargeImage<'c>| band.blocks().map(move |rows| (band, rows));
    let all = cube.bands().iter().flat_map(of_band);
    all.map(move |of| match options.progress.map(|progress| progress(evaluations)) {
        Some(ControlFlow::Break(())) => Err(RenderError::Interrupted.into()),
        _ => Ok(of),
    })
}

/// The largest estimated |error| of an irradiance over the largest |irradiance|.
fn error_of_irradiances<E>(
    cube: &LargeCube<'_>,
    options: &RenderOptions<'_>,
) -> Result<f64, LargeError<E>> {
    let [mut largest, mut largest_error] = [0.0_f64; 2];
    for of in blocks(cube, options) {
        let (band, rows) = of?;
        let [mut values, mut errors] = [band.values(rows.clone()), band.errors(rows.clone())];
        for map in [&mut values, &mut errors] {
            to_irradiances(map, band, rows.clone());
        }
        let (low, high) = values.min_max();
        largest = largest.max(high.abs().max(low.abs()));
        largest_error = largest_error.max(errors.min_max().1);
    }
    Ok(if largest_error > 0.0 { largest_error / largest } else { 0.0 })
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
    cube: &'a LargeCube<'a>,
    account: &'a Account,
    options: &'a RenderOptions<'a>,
}

impl<'a> Writing<'a> {
    /// Writes all HDUs, and finds the range of the values.
    fn write<W: Write + Seek, E>(
        &self,
        mut writer: FitsWriter<W>,
        range: &mut [f64; 2],
    ) -> Result<W, LargeError<E>> {
        let [primary, error] = self.headers()?;
        *range = self.map(&mut writer, &primary, LargeImage::values)?;
        self.map(&mut writer, &error, LargeImage::errors)?;
        if let Some(bins) = &self.scene.energy {
            energies::write_table(&mut writer, bins)?;
        }
        Ok(writer.into_inner())
    }

    /// Writes one HDU, band by band and block by block. Returns the range of its values.
    fn map<W: Write + Seek, E>(
        &self,
        writer: &mut FitsWriter<W>,
        header: &Header,
        make: impl Fn(&LargeImage<'a>, Range<usize>) -> Image,
    ) -> Result<[f64; 2], LargeError<E>> {
        let [bins, height, width] = self.cube.shape();
        let shape = [width, height, bins];
        let shape = if self.scene.energy.is_some() { &shape[..] } else { &shape[..2] };
        let layout = Metadata { shape, bitpix: Bitpix::F64, scaling: Scaling::IDENTITY };
        let mut stream =
            writer.stream_image(layout, Some(header)).map_err(FitsEncodeError::from)?;
        let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY];
        for of in blocks(self.cube, self.options) {
            let (band, rows) = of?;
            let mut block = make(band, rows.clone());
            if self.scene.quantity == Quantity::Irradiance {
                to_irradiances(&mut block, band, rows);
            }
            let (low, high) = block.min_max();
            (least, most) = (least.min(low), most.max(high));
            stream.write_chunk(View::F64(block.pixels())).map_err(FitsEncodeError::from)?;
        }
        stream.finish().map_err(FitsEncodeError::from)?;
        Ok([least, most])
    }

    /// The headers of the values and of their errors.
    fn headers(&self) -> Result<[Header; 2], FitsEncodeError> {
        let pixel = Cube::from_bands(vec![Image::zeros(1, 1)]);
        let unit = Some(self.account.unit.as_str()).filter(|unit| !unit.is_empty());
        let name = self.account.quantity.to_uppercase();
        let energies = self.scene.energy.as_ref();
        let map = |name| match energies {
            Some(_) => FitsImage::cube(name, &pixel, unit),
            None => FitsImage::new(name, &pixel.bands()[0], unit),
        };
        let error = map("ERROR");
        let file = FitsFile {
            primary: map(&name),
            extensions: Vec::new(),
            wcs: self.scene.celestial_wcs(),
            energies,
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
