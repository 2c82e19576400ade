//! `HEALPix` maps: a binary table with a row for each pixel of the sphere.
//!
//! The keywords are those that healpy and the `HEALPix` Fortran and C++ libraries read and write
//! (<https://healpix.sourceforge.io/data/examples/healpix_fits_specs.pdf>).

use super::card::{ascii, set};
use super::provenance::Provenance;
use super::{Card, FitsEncodeError, energies};
use crate::energies::Energies;
use fits_well::FitsWriter;
use fits_well::header::Header;
use fits_well::table::{Builder, ColumnData, WriteColumn};
use std::time::SystemTime;

/// One quantity of a `HEALPix` map: its value in each pixel of the sphere.
#[derive(Clone, Copy, Debug)]
pub struct HealpixColumn<'a> {
    /// The name of the column (`TTYPE`): `RADIANCE`, `ERROR`.
    pub name: &'a str,
    /// The unit of the values (`TUNIT`) in the grammar of FITS; none for pure numbers.
    pub unit: Option<&'a str>,
    /// The values in nested order: 12 · nside², nside a power of two.
    pub values: &'a [f64],
}

/// A map of the whole sphere as a file; [`encode`](Self::encode) turns it into bytes.
///
/// The primary HDU has no image, but the provenance; the map is the table in HDU 1, where
/// `healpy.read_map(path, nest=True)` expects it.
///
/// ```
/// use emitree_io::{Card, HealpixColumn, HealpixFile};
///
/// let radiance: Vec<f64> = (0..48).map(f64::from).collect();
/// let file = HealpixFile {
///     columns: vec![HealpixColumn { name: "RADIANCE", unit: Some("R"), values: &radiance }],
///     coordinates: None,
///     energies: None,
///     provenance: vec![Card::new("NEVAL", 4066, "evaluations of the emission rate")],
///     history: String::new(),
///     date: None,
/// };
/// let bytes = file.encode()?;
/// assert_eq!(bytes.len() % 2880, 0);
/// # Ok::<(), emitree_io::FitsEncodeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct HealpixFile<'a> {
    /// The quantities, all of them on the same pixels.
    pub columns: Vec<HealpixColumn<'a>>,
    /// The system of the longitudes and latitudes (`COORDSYS`): `G` galactic, `E` ecliptic, `C`
    /// equatorial; none for directions in a scene.
    pub coordinates: Option<&'a str>,
    /// The bins, if columns are energy bands: they become the table `ENERGIES` in HDU 2, with the
    /// ends of each bin.
    pub energies: Option<&'a Energies>,
    /// As of [`FitsFile`](super::FitsFile).
    pub provenance: Vec<Card>,
    /// As of [`FitsFile`](super::FitsFile).
    pub history: String,
    /// When the file was made (`DATE`, in UTC).
    pub date: Option<SystemTime>,
}

impl HealpixFile<'_> {
    /// The most columns that a table of FITS may have (standard 4.0, section 7.3.1).
    pub const MOST_COLUMNS: usize = 999;

    /// The bytes of the file: 64-bit floats in nested order, with `DATASUM` and `CHECKSUM`.
    ///
    /// # Errors
    ///
    /// [`FitsEncodeError`] if the columns have not 12 · nside² values each with nside a power of
    /// two, there are more than 999, or a keyword of the provenance is not valid in FITS, comes twice, or is written by this
    /// function itself.
    pub fn encode(&self) -> Result<Vec<u8>, FitsEncodeError> {
        if self.columns.len() > Self::MOST_COLUMNS {
            return Err(FitsEncodeError::Columns(self.columns.len()));
        }
        let nside = self.nside()?;
        let pixels = 12 * nside * nside;
        let mut primary = Header::new();
        let Self { provenance: cards, history, date, .. } = self;
        Provenance { cards, history, date: *date }.write(&mut primary)?;

        let mut header = Header::new();
        let mut add = |keyword: &str, value: super::CardValue, comment: &str| {
            set(&mut header, &Card::new(keyword, value, comment))
        };
        add("EXTNAME", "HEALPIX".into(), "what the table is")?;
        add("PIXTYPE", "HEALPIX".into(), "pixelisation")?;
        add("ORDERING", "NESTED".into(), "numbering of the pixels")?;
        add("NSIDE", nside.into(), "pixels along an edge of a face")?;
        add("FIRSTPIX", 0.into(), "first pixel, counted from 0")?;
        add("LASTPIX", (pixels - 1).into(), "last pixel")?;
        add("INDXSCHM", "IMPLICIT".into(), "a row for each pixel, in order")?;
        add("OBJECT", "FULLSKY".into(), "all pixels are there")?;
        if let Some(system) = self.coordinates {
            add("COORDSYS", system.into(), "system of longitude and latitude")?;
            if system == "C" {
                add("RADESYS", "ICRS".into(), "reference frame")?;
            }
        }

        let mut table = Builder::with_rows(pixels);
        for column in &self.columns {
            let data = ColumnData::F64(column.values.to_vec());
            let written = WriteColumn::scalar(ascii(column.name), data);
            table.push(match column.unit {
                Some(unit) => written.with_unit(ascii(unit)),
                None => written,
            })?;
        }
        let mut writer = FitsWriter::new(Vec::new()).with_checksums();
        writer.write_empty_primary(Some(&primary))?;
        writer.write_table(&table, Some(&header))?;
        if let Some(energies) = self.energies {
            energies::write_table(&mut writer, energies)?;
        }
        Ok(writer.into_inner())
    }

    /// The number of pixels along an edge of a face, the same for all columns.
    fn nside(&self) -> Result<usize, FitsEncodeError> {
        let wrong = |column: &str, values, expected: &str| FitsEncodeError::Pixels {
            column: column.to_owned(),
            values,
            expected: expected.to_owned(),
        };
        let Some(first) = self.columns.first() else {
            return Err(wrong("", 0, "at least one column"));
        };
        let pixels = first.values.len();
        let Some(nside) = nside_of(pixels) else {
            return Err(wrong(first.name, pixels, "12 nside^2 for nside = 1, 2, 4, 8 and so on"));
        };
        match self.columns.iter().find(|column| column.values.len() != pixels) {
            Some(other) => {
                let as_many = format!("as many as `{}` has, {pixels}", first.name);
                Err(wrong(other.name, other.values.len(), &as_many))
            }
            None => Ok(nside),
        }
    }
}

/// The number of pixels along an edge of a face of a map with so many; none if no map in nested order has.
pub(crate) fn nside_of(pixels: usize) -> Option<usize> {
    let nside = (pixels / 12).isqrt();
    (nside.is_power_of_two() && 12 * nside * nside == pixels).then_some(nside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fits_well::FitsReader;

    fn file<'a>(columns: Vec<HealpixColumn<'a>>) -> HealpixFile<'a> {
        let history = "[projection]\ntype = \"healpix\"".to_owned();
        HealpixFile {
            columns,
            coordinates: None,
            energies: None,
            provenance: Vec::new(),
            history,
            date: None,
        }
    }

    fn column<'a>(name: &'a str, values: &'a [f64]) -> HealpixColumn<'a> {
        HealpixColumn { name, unit: None, values }
    }

    #[test]
    fn the_headers_have_the_keywords_of_readers() {
        let values = [0.5; 192];
        let mut file = file(vec![
            HealpixColumn { unit: Some("ph cm-2 s-1"), ..column("RADIANCE", &values) },
            column("N\u{e9}", &values),
        ]);
        file.coordinates = Some("G");
        file.provenance = vec![Card::new("METHOD", "vol", "")];
        let reader = FitsReader::open(std::io::Cursor::new(file.encode().unwrap())).unwrap();
        let [primary, table] = [0, 1].map(|hdu| &reader.hdus()[hdu].header);
        let text = |header: &Header, key: &str| header.get_text(key).unwrap().map(str::to_owned);
        assert_eq!(text(primary, "METHOD").as_deref(), Some("vol"));
        assert_eq!(text(primary, "CREATOR").as_deref(), Some("emitree"));
        for (key, expected) in [
            ("XTENSION", "BINTABLE"),
            ("PIXTYPE", "HEALPIX"),
            ("ORDERING", "NESTED"),
            ("INDXSCHM", "IMPLICIT"),
            ("OBJECT", "FULLSKY"),
            ("COORDSYS", "G"),
            ("TTYPE1", "RADIANCE"),
            ("TUNIT1", "ph cm-2 s-1"),
            ("TTYPE2", "N\\u00e9"),
        ] {
            assert_eq!(text(table, key).as_deref(), Some(expected), "{key}");
        }
        assert_eq!(text(table, "TUNIT2"), None);
    }

    #[test]
    fn numbers_of_pixels_that_are_no_map_are_refused() {
        let values = [0.0; 192];
        let message = |columns| file(columns).encode().unwrap_err().to_string();
        for wrong in [0, 1, 47, 108] {
            assert_eq!(
                message(vec![column("A", &values[..wrong])]),
                format!(
                    "column `A` has {wrong} values: expected 12 nside^2 for nside = 1, 2, 4, 8 and \
                     so on, in each column of a HEALPix map"
                )
            );
        }
        assert_eq!(
            message(vec![column("A", &values), column("B", &values[..48])]),
            "column `B` has 48 values: expected as many as `A` has, 192, in each column of a \
             HEALPix map"
        );
        assert!(message(Vec::new()).contains("expected at least one column"));
        let many = vec![column("A", &values[..12]); 1000];
        assert_eq!(message(many), "1000 columns: expected at most 999, as many as FITS allows");
    }

    #[test]
    fn keywords_of_the_provenance_are_checked() {
        let values = [0.0; 12];
        let mut file = file(vec![column("A", &values)]);
        file.provenance = vec![Card::new("CREATOR", "me", "")];
        assert!(
            matches!(file.encode(), Err(FitsEncodeError::Taken { keyword }) if keyword == "CREATOR")
        );
    }
}
