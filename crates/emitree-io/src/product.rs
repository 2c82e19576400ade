//! What a rendering makes and how it came about, for files of every format and every front end.

use crate::energies::Energies;
use crate::fits::{Card, FitsEncodeError, FitsFile, FitsImage, HealpixColumn, HealpixFile, Wcs};
use crate::scene::Scene;
use emitree::{Cube, Healpix};
use emitree_instrument::Channel;
use std::time::SystemTime;

/// A scene as FITS has it: its text, and a line for each value that was changed.
///
/// ```
/// let history = emitree_io::scene_history("x = 1\n", &["x = 2".to_owned()]);
/// assert_eq!(history, "x = 1\n# changed: x = 2\n");
/// ```
pub fn scene_history(text: &str, changes: &[String]) -> String {
    let mut history = text.trim_end().to_owned() + "\n";
    for change in changes {
        history.push_str(&format!("# changed: {change}\n"));
    }
    history
}

/// What the bands of a map are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bands<'a> {
    /// The only one, of an image.
    Image,
    /// Means over the energy bins of the file.
    Energies,
    /// Counts in channels.
    Counts {
        /// The channels.
        channels: &'a [Channel],
    },
}

/// One of the maps of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProductMap<'a> {
    /// The name of its HDU or column.
    pub name: &'a str,
    /// The values.
    pub map: &'a Cube,
    /// Their unit, in the grammar of FITS; empty if it is not known.
    pub unit: &'a str,
    /// What the bands are.
    pub bands: Bands<'a>,
}

impl ProductMap<'_> {
    /// Whether there is a third axis, be it of one band.
    pub fn is_cube(&self) -> bool {
        self.bands != Bands::Image
    }

    /// Whether the third axis is that of the energy bins.
    pub fn has_energies(&self) -> bool {
        self.bands == Bands::Energies
    }
}

/// One of the things that a rendering makes: what a [`Format`](crate::Format) writes.
#[derive(Clone, Debug)]
pub struct Product<'a> {
    /// The scene that was rendered.
    pub scene: &'a Scene,
    /// The main map.
    pub map: ProductMap<'a>,
    /// What its values are, for people: `radiance` for example.
    pub meaning: &'a str,
    /// The maps that go with it, in formats with room for several.
    pub others: Vec<ProductMap<'a>>,
    /// [`Account::cards`](crate::Account::cards), and what is true of this product only.
    pub provenance: Vec<Card>,
}

impl<'a> Product<'a> {
    /// A map of a scene, and nothing else.
    pub fn new(scene: &'a Scene, map: ProductMap<'a>) -> Self {
        let (meaning, others, provenance) = (scene.quantity.name(), Vec::new(), Vec::new());
        Self { scene, map, meaning, others, provenance }
    }

    /// The energies of the scene, if they are the third axis of the main map.
    pub(crate) fn energies(&self) -> Option<&'a Energies> {
        self.scene.energy.as_ref().filter(|_| self.map.has_energies())
    }
}

/// A FITS file of a rendering: an HDU for each map, or for a sky a table with a column for each band.
#[derive(Clone, Debug)]
pub struct FitsProduct<'a> {
    /// The main map, and those that go with it.
    pub maps: Vec<ProductMap<'a>>,
    /// Whether the pixels are those of `HEALPix`.
    pub is_sky: bool,
    /// The coordinates of the pixels, if they have some.
    pub wcs: Option<Wcs>,
    /// The system of the longitudes and latitudes of a `HEALPix` map (`COORDSYS`), if it is known.
    pub coordinates: Option<&'a str>,
    /// The energy bins, if there are some.
    pub energies: Option<&'a Energies>,
    /// [`Account::cards`](crate::Account::cards), and what is true of this file only.
    pub provenance: Vec<Card>,
    /// [`scene_history`].
    pub history: String,
}

impl FitsProduct<'_> {
    /// The bytes of the file, with the current time.
    ///
    /// # Errors
    ///
    /// [`FitsEncodeError`]: what FITS can't hold.
    pub fn encode(self) -> Result<Vec<u8>, FitsEncodeError> {
        let Self { maps, is_sky, wcs, coordinates, energies, provenance, history } = self;
        let date = Some(SystemTime::now());
        if is_sky {
            let columns: Vec<(String, &str, Vec<f64>)> = maps.iter().flat_map(columns).collect();
            let columns = columns
                .iter()
                .map(|(name, unit, values)| HealpixColumn { name, unit: known(unit), values })
                .collect();
            return HealpixFile { columns, coordinates, energies, provenance, history, date }
                .encode();
        }
        let mut images = maps.iter().map(image);
        let Some(primary) = images.next() else { return Ok(Vec::new()) };
        let extensions = images.collect();
        FitsFile { primary, extensions, wcs, energies, provenance, history, date }.encode()
    }
}

/// A unit, if it is given.
fn known(unit: &str) -> Option<&str> {
    Some(unit).filter(|unit| !unit.is_empty())
}

/// A map as an HDU.
fn image<'a>(&ProductMap { name, map, unit, bands }: &ProductMap<'a>) -> FitsImage<'a> {
    match (map.bands(), bands) {
        ([image], Bands::Image) => FitsImage::new(name, image, known(unit)),
        (_, Bands::Counts { channels }) => FitsImage::channels(name, map, channels, known(unit)),
        (_, Bands::Image | Bands::Energies) => FitsImage::cube(name, map, known(unit)),
    }
}

/// A column for each band: `RADIANCE`, or `RADIANCE_1`, `RADIANCE_2` and so on of a cube.
fn columns<'a>(
    product @ &ProductMap { name, map, unit, .. }: &ProductMap<'a>,
) -> Vec<(String, &'a str, Vec<f64>)> {
    let is_cube = product.is_cube();
    let number = |bin: usize| if is_cube { format!("_{}", bin + 1) } else { String::new() };
    let bands = map.bands().iter().enumerate();
    bands
        .map(|(bin, band)| (format!("{name}{}", number(bin)), unit, Healpix::nested(band)))
        .collect()
}
