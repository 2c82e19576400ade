//! The picture of an image: one 8-bit colour for each pixel, for display only.

use crate::colour::{ColourMap, ValueRange};
use emitree::Image;

/// How numbers become a picture; [`Default`] is viridis over [`ValueRange::of`] the image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureOptions {
    /// The colour map.
    pub colour_map: ColourMap,
    /// The values at the ends of the colour map, in the unit of the pixels.
    pub range: Option<ValueRange>,
    /// The title, kept in the file's text: the name of the scene, for example.
    pub title: Option<String>,
    /// The unit of the pixels, kept in the file's text beside the range.
    pub unit: Option<String>,
    /// Whether pixels that are not numbers are left blank, transparent, and not grey: for a disc or
    /// an ellipse, outside of which there is nothing.
    pub blank_outside: bool,
}

/// An image that no picture can be made of.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// PNG has room for 1 to 2³¹ − 1 pixels along each edge.
    #[error("an image of {width} x {height} pixels: expected 1 to 2147483647 along each edge")]
    Size {
        /// The number of columns.
        width: usize,
        /// The number of rows.
        height: usize,
    },
    /// The range has no length, no order or no end.
    #[error("a range of colours from {} to {}: expected two finite values in order", .0.low, .0.high)]
    Range(ValueRange),
    /// The encoder failed.
    #[error("cannot encode the picture: {0}")]
    Encode(#[from] png::EncodingError),
}

/// The bytes of a PNG file, width × height pixels, y up: the last row of `image` is the first on
/// the screen.
///
/// Colours are linear in the value. Pixels that are not numbers are grey, or blank if the options
/// say so: the file then has an alpha channel. The file's text names the software, the title, the
/// range and the unit.
///
/// # Errors
///
/// [`PictureError`] if the image has no pixels or the range is not in order.
///
/// ```
/// use emitree::Image;
/// use emitree_io::{PictureOptions, encode_png};
///
/// let image = Image::from_pixels(2, 2, vec![0.0, 1.0, 2.0, 3.0]);
/// let bytes = encode_png(&image, &PictureOptions::default())?;
/// assert!(bytes.starts_with(b"\x89PNG\r\n"));
/// # Ok::<(), emitree_io::PictureError>(())
/// ```
pub fn encode_png(image: &Image, options: &PictureOptions) -> Result<Vec<u8>, PictureError> {
    let (width, height) = (image.width(), image.height());
    let length = |pixels| u32::try_from(pixels).ok().filter(|n| (1..=i32::MAX as u32).contains(n));
    let (Some(columns), Some(rows)) = (length(width), length(height)) else {
        return Err(PictureError::Size { width, height });
    };
    let range = options.range.unwrap_or_else(|| ValueRange::of(&[image]));
    let ValueRange { low, high } = range;
    if !(low < high && low.is_finite() && high.is_finite()) {
        return Err(PictureError::Range(range));
    }

    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, columns, rows);
    let blank = options.blank_outside;
    encoder.set_color(if blank { png::ColorType::Rgba } else { png::ColorType::Rgb });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let unit = options.unit.as_deref().map(|unit| format!(" {unit}")).unwrap_or_default();
    let software = concat!("emitree ", env!("CARGO_PKG_VERSION")).to_owned();
    add_text(&mut encoder, "Software", software)?;
    if let Some(title) = &options.title {
        add_text(&mut encoder, "Title", title.clone())?;
    }
    add_text(&mut encoder, "Description", format!("Colours from {low:e} to {high:e}{unit}"))?;

    let mut writer = encoder.write_header()?;
    let map = options.colour_map;
    let rows = if blank { rgba_rows(image, map, range) } else { rgb_rows(image, map, range) };
    writer.write_image_data(&rows)?;
    writer.finish()?;
    Ok(bytes)
}

/// Three bytes for each pixel, the highest row first.
fn rgb_rows(image: &Image, map: ColourMap, range: ValueRange) -> Vec<u8> {
    let pixels = image.rows().rev().flatten();
    pixels.flat_map(|&pixel| map.rgb(range.fraction(pixel))).collect()
}

/// Four bytes for each pixel, the highest row first: opaque, or transparent for what is no number.
fn rgba_rows(image: &Image, map: ColourMap, range: ValueRange) -> Vec<u8> {
    let rgba = |&pixel: &f64| {
        let [red, green, blue] = map.rgb(range.fraction(pixel));
        if pixel.is_nan() { [0; 4] } else { [red, green, blue, u8::MAX] }
    };
    image.rows().rev().flatten().flat_map(rgba).collect()
}

/// A text in the chunk that every reader supports if it is ASCII, else in the one for UTF-8.
fn add_text<W: std::io::Write>(
    encoder: &mut png::Encoder<'_, W>,
    keyword: &str,
    text: String,
) -> Result<(), png::EncodingError> {
    if text.is_ascii() {
        encoder.add_text_chunk(keyword.to_owned(), text)
    } else {
        encoder.add_itxt_chunk(keyword.to_owned(), text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(bytes: &[u8]) -> (png::Info<'static>, Vec<u8>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        (reader.info().clone(), pixels)
    }

    #[test]
    fn pixels_are_flipped_so_that_y_points_up() {
        let image = Image::from_pixels(2, 3, vec![0.0, 1.0, 2.0, 3.0, f64::NAN, 4.0]);
        let options = PictureOptions { colour_map: ColourMap::Inferno, ..Default::default() };
        let (info, pixels) = decode(&encode_png(&image, &options).unwrap());
        assert_eq!((info.width, info.height), (3, 2));
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        let upper_row_first = [3.0, f64::NAN, 4.0, 0.0, 1.0, 2.0];
        let expected: Vec<u8> =
            upper_row_first.iter().flat_map(|p| ColourMap::Inferno.rgb(p / 4.0)).collect();
        assert_eq!(pixels, expected);
    }

    #[test]
    fn pixels_that_are_no_numbers_can_be_left_blank() {
        let image = Image::from_pixels(2, 2, vec![0.0, f64::NAN, f64::INFINITY, 1.0]);
        let options = PictureOptions { blank_outside: true, ..Default::default() };
        let (info, pixels) = decode(&encode_png(&image, &options).unwrap());
        assert_eq!(info.color_type, png::ColorType::Rgba);
        let opaque = |fraction| {
            let [red, green, blue] = ColourMap::Viridis.rgb(fraction);
            [red, green, blue, 255]
        };
        assert_eq!(pixels, [opaque(1.0), opaque(1.0), opaque(0.0), [0; 4]].concat());
    }

    #[test]
    fn infinite_pixels_get_the_colours_of_the_ends() {
        let image = Image::from_pixels(1, 3, vec![f64::NEG_INFINITY, 2.0, f64::INFINITY]);
        let (_, pixels) = decode(&encode_png(&image, &PictureOptions::default()).unwrap());
        let [low, high] = [0.0, 1.0].map(|fraction| ColourMap::Viridis.rgb(fraction));
        assert_eq!(pixels, [low, high, high].concat());
    }

    #[test]
    fn texts_name_software_title_and_range() {
        let options = PictureOptions {
            range: Some(ValueRange { low: -1.0, high: 0.5 }),
            title: Some("magnetosheath, 30 R⊕".to_owned()),
            unit: Some("m-2 sr-1 s-1".to_owned()),
            ..Default::default()
        };
        let (info, _) = decode(&encode_png(&Image::zeros(1, 1), &options).unwrap());
        let latin: Vec<_> =
            info.uncompressed_latin1_text.iter().map(|t| (&*t.keyword, &*t.text)).collect();
        assert_eq!(latin[0].0, "Software");
        assert_eq!(latin[1], ("Description", "Colours from -1e0 to 5e-1 m-2 sr-1 s-1"));
        assert_eq!(info.utf8_text[0].keyword, "Title");
        assert_eq!(info.utf8_text[0].get_text().unwrap(), "magnetosheath, 30 R⊕");
    }

    #[test]
    fn images_without_pixels_and_ranges_without_order_are_refused() {
        let error = encode_png(&Image::zeros(0, 4), &PictureOptions::default()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "an image of 4 x 0 pixels: expected 1 to 2147483647 along each edge"
        );
        for (low, high) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
            let range = Some(ValueRange { low, high });
            let options = PictureOptions { range, ..Default::default() };
            let error = encode_png(&Image::zeros(1, 1), &options).unwrap_err();
            assert!(matches!(error, PictureError::Range(_)), "{error}");
        }
    }
}
