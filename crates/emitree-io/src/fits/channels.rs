//! The channels of a detector: the third axis of a cube of counts, and a table of them.
//!
//! The table has the name and the columns that the files of missions have (George et al. 1998, OGIP
//! memo CAL/GEN/92-002).

use super::card::{Card, ascii, set};
use super::{FitsEncodeError, WcsAxis};
use emitree_instrument::Channel;
use fits_well::FitsWriter;
use fits_well::header::Header;
use fits_well::table::{Builder, ColumnData, WriteColumn};

/// The coordinate of the channels: their number, or their place where the numbers are not uniform.
pub(super) fn axis(channels: &[Channel]) -> WcsAxis {
    let (ctype, cname, crval, cdelt) = match even_numbers(channels) {
        Some([first, step]) => ("CHANNEL", "channel of the detector", first, step),
        None => ("ROW", "row of the channel in EBOUNDS, from 1", 1.0, 1.0),
    };
    WcsAxis {
        ctype: ctype.to_owned(),
        cunit: None,
        cname: cname.to_owned(),
        crpix: 1.0,
        crval,
        cdelt,
    }
}

/// The first number and the step to the next, if all steps are the same and not 0.
#[expect(clippy::cast_precision_loss, reason = "channels have numbers of a few digits")]
fn even_numbers(channels: &[Channel]) -> Option<[f64; 2]> {
    let steps = channels.windows(2).map(|pair| pair[1].number.wrapping_sub(pair[0].number));
    let step = steps.clone().next().unwrap_or(1);
    let even = step != 0 && steps.clone().all(|other| other == step);
    even.then_some([channels.first()?.number as f64, step as f64])
}

/// Adds the table `EBOUNDS`: a row for each channel, with its number `CHANNEL` and its nominal energies
/// `E_MIN` and `E_MAX` \[keV\].
pub(super) fn write_table(
    writer: &mut FitsWriter<Vec<u8>>,
    channels: &[Channel],
) -> Result<(), FitsEncodeError> {
    let mut header = Header::new();
    for (keyword, value, comment) in [
        ("EXTNAME", "EBOUNDS", "nominal energies of the channels"),
        ("HDUCLASS", "OGIP", "the format is that of CAL/GEN/92-002"),
        ("HDUCLAS1", "RESPONSE", "of a detector"),
        ("HDUCLAS2", "EBOUNDS", "nominal energies of the channels"),
    ] {
        set(&mut header, &Card::new(keyword, value, comment))?;
    }
    let numbers = channels.iter().map(|channel| channel.number).collect();
    let ends = |which: usize| {
        ColumnData::F64(channels.iter().map(|channel| channel.range_kev[which]).collect())
    };
    let mut table = Builder::with_rows(channels.len());
    table.push(WriteColumn::scalar(ascii("CHANNEL"), ColumnData::I64(numbers)))?;
    for (name, which) in [("E_MIN", 0), ("E_MAX", 1)] {
        table.push(WriteColumn::scalar(ascii(name), ends(which)).with_unit(ascii("keV")))?;
    }
    Ok(writer.write_table(&table, Some(&header))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FitsFile, FitsImage, Wcs};
    use emitree::{Cube, Image};
    use fits_well::FitsReader;

    fn channels<const N: usize>(numbers: [i64; N]) -> Vec<Channel> {
        let low = (0..).map(|n| 0.25 * f64::from(n));
        numbers
            .into_iter()
            .zip(low)
            .map(|(number, low)| Channel { number, range_kev: [low, low + 0.25] })
            .collect()
    }

    #[test]
    fn numbers_are_the_coordinate_where_their_steps_are_equal() {
        let of = |axis: WcsAxis| (axis.ctype, axis.crval, axis.cdelt);
        assert_eq!(of(axis(&channels([30, 31, 32]))), ("CHANNEL".into(), 30.0, 1.0));
        assert_eq!(of(axis(&channels([9, 7, 5]))), ("CHANNEL".into(), 9.0, -2.0));
        assert_eq!(of(axis(&channels([7]))), ("CHANNEL".into(), 7.0, 1.0));
        for uneven in [channels([1, 2, 4]), channels([1, 1, 1])] {
            assert_eq!(of(axis(&uneven)), ("ROW".into(), 1.0, 1.0));
        }
    }

    #[test]
    fn a_cube_of_channels_has_its_axis_and_its_table() {
        let (channels, image) = (channels([4, 5]), Image::zeros(2, 3));
        let cube = Cube::from_bands(vec![image; 2]);
        let file = FitsFile {
            primary: FitsImage::channels("COUNTS", &cube, &channels, Some("count")),
            extensions: Vec::new(),
            wcs: Some(Wcs::canonical(2, 3)),
            energies: None,
            provenance: Vec::new(),
            history: String::new(),
            date: None,
        };
        let bytes = file.encode().unwrap();
        let mut reader = FitsReader::open(std::io::Cursor::new(bytes)).unwrap();
        assert_eq!(reader.image(0).unwrap().metadata().shape, [3, 2, 2]);
        let text = |hdu: usize, key: &str| {
            reader.hdus()[hdu].header.get_text(key).unwrap().map(str::to_owned)
        };
        assert_eq!(text(0, "CTYPE3").as_deref(), Some("CHANNEL"));
        assert_eq!(text(0, "BUNIT").as_deref(), Some("count"));
        assert_eq!(text(1, "EXTNAME").as_deref(), Some("EBOUNDS"));
        assert_eq!(text(1, "HDUCLAS2").as_deref(), Some("EBOUNDS"));
        let columns = ["TTYPE1", "TTYPE2", "TTYPE3", "TUNIT3"].map(|key| text(1, key).unwrap());
        assert_eq!(columns, ["CHANNEL", "E_MIN", "E_MAX", "keV"]);
    }
}
