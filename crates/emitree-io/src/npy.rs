//! The .npy file of `numpy`: one array of numbers, nothing else.
//!
//! Version 1.0 of the format, described in `numpy.lib.format`: a magic string, a header that is a
//! Python dictionary, padded so that the data start at a multiple of 64 bytes, and the data.

use emitree::{Cube, Image};

/// The limit of `numpy` itself on the number of axes.
const MAX_AXES: usize = 64;

const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// An array that does not fit a .npy file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NpyError {
    /// The numbers are not as many as the shape has room for.
    #[error("{found} numbers for an array of shape {shape:?}: expected the product of the lengths")]
    Length {
        /// The shape given.
        shape: Vec<usize>,
        /// How many numbers came with it.
        found: usize,
    },
    /// `numpy` could not read it.
    #[error("an array of {axes} axes: expected at most 64, the limit of numpy")]
    Axes {
        /// How many axes were given.
        axes: usize,
    },
}

/// The bytes of a .npy file with the array of `shape`, its last axis varying fastest, as
/// little-endian f64.
///
/// # Errors
///
/// [`NpyError`] if `values` does not have one number for each element, or there are more than 64
/// axes.
///
/// ```
/// let bytes = emitree_io::encode_npy(&[2, 1], &[1.0, 2.0])?;
/// assert_eq!(bytes.len(), 128 + 16);
/// # Ok::<(), emitree_io::NpyError>(())
/// ```
pub fn encode_npy(shape: &[usize], values: &[f64]) -> Result<Vec<u8>, NpyError> {
    if shape.len() > MAX_AXES {
        return Err(NpyError::Axes { axes: shape.len() });
    }
    let elements = shape.iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
    if elements != Some(values.len()) {
        return Err(NpyError::Length { shape: shape.to_vec(), found: values.len() });
    }
    Ok(encode(shape, values.iter().copied()))
}

/// The bytes of a .npy file with `image` as an array of shape (height, width), row 0 the lowest y.
///
/// ```
/// use emitree::Image;
///
/// let bytes = emitree_io::encode_npy_image(&Image::zeros(2, 3));
/// assert!(bytes.starts_with(b"\x93NUMPY"));
/// ```
pub fn encode_npy_image(image: &Image) -> Vec<u8> {
    encode(&[image.height(), image.width()], image.pixels().iter().copied())
}

/// The bytes of a .npy file with `cube` as an array of shape (bins, height, width), the lowest
/// energies first and row 0 the lowest y.
///
/// ```
/// use emitree::{Cube, Image};
///
/// let cube = Cube::from_bands(vec![Image::zeros(2, 3); 4]);
/// let bytes = emitree_io::encode_npy_cube(&cube);
/// assert_eq!(bytes.len(), 128 + 4 * 2 * 3 * 8);
/// ```
pub fn encode_npy_cube(cube: &Cube) -> Vec<u8> {
    encode(&cube.shape(), cube.voxels())
}

/// The bytes of a .npy file with the numbers of `shape`, as many as it has room for.
pub(crate) fn encode(shape: &[usize], values: impl Iterator<Item = f64>) -> Vec<u8> {
    encode_numbers("<f8", shape, values.map(f64::to_le_bytes))
}

/// The bytes of a .npy file with the whole numbers of `shape`, its last axis varying fastest.
pub(crate) fn encode_npy_integers(shape: &[usize], values: impl Iterator<Item = i64>) -> Vec<u8> {
    encode_numbers("<i8", shape, values.map(i64::to_le_bytes))
}

/// The bytes of a .npy file with a text: an array without axes.
pub(crate) fn encode_npy_text(text: &str) -> Vec<u8> {
    let letters = text.chars().map(|letter| u32::from(letter).to_le_bytes());
    // A type of no letters is none.
    let filled = text.is_empty().then_some([0; 4]);
    let descr = format!("<U{}", text.chars().count().max(1));
    encode_numbers(&descr, &[], letters.chain(filled))
}

/// The bytes of a .npy file with `values`, of the type `descr`.
fn encode_numbers<const LENGTH: usize>(
    descr: &str,
    shape: &[usize],
    values: impl Iterator<Item = [u8; LENGTH]>,
) -> Vec<u8> {
    let shape = match shape {
        // A tuple of one needs its comma in Python.
        [length] => format!("({length},)"),
        _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    };
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    // The magic string, two bytes of length, and the header with its newline fill 64-byte blocks.
    let unpadded = MAGIC.len() + 2 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(64) - unpadded));
    header.push('\n');
    #[expect(
        clippy::cast_possible_truncation,
        reason = "64 axes of at most 22 characters each stay far below 65,536"
    )]
    let length = header.len() as u16;

    let data = values.size_hint().0 * LENGTH;
    let mut bytes = Vec::with_capacity(MAGIC.len() + 2 + header.len() + data);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    bytes.extend(values.flatten());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_is_right_byte_for_byte() {
        let image = Image::from_pixels(1, 2, vec![1.0, -2.5]);
        let bytes = encode_npy_image(&image);
        let mut expected = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
        expected.extend(b"{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2), }");
        expected.resize(127, b' ');
        expected.push(b'\n');
        expected.extend([0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
        expected.extend([0, 0, 0, 0, 0, 0, 0x04, 0xc0]);
        assert_eq!(bytes, expected);
        assert_eq!(encode_npy(&[1, 2], &[1.0, -2.5]).unwrap(), expected);
        let bands = [1.0, -2.5].map(|pixel| Image::from_pixels(1, 1, vec![pixel]));
        let cube = encode_npy_cube(&Cube::from_bands(bands.into()));
        assert_eq!(cube, encode_npy(&[2, 1, 1], &[1.0, -2.5]).unwrap());
    }

    #[test]
    fn data_start_at_a_multiple_of_64_for_any_number_of_axes() {
        for axes in 0..=MAX_AXES {
            let bytes = encode_npy(&vec![1; axes], &[7.0]).unwrap();
            let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            assert_eq!((10 + length) % 64, 0, "{axes} axes");
            assert_eq!(bytes[10 + length..], 7.0_f64.to_le_bytes());
            assert_eq!(bytes[9 + length], b'\n');
        }
    }

    #[test]
    fn tuples_are_spelled_as_python_spells_them() {
        for (shape, spelled) in [(&[][..], "()"), (&[1], "(1,)"), (&[1, 1, 1], "(1, 1, 1)")] {
            let bytes = encode_npy(shape, &[0.0]).unwrap();
            let header = String::from_utf8_lossy(&bytes[10..128]);
            assert!(header.contains(&format!("'shape': {spelled}, }}")), "{header}");
        }
    }

    #[test]
    fn whole_numbers_and_texts_have_types_of_their_own() {
        let header = |bytes: &[u8]| String::from_utf8_lossy(&bytes[10..128]).into_owned();
        let numbers = encode_npy_integers(&[1, 2], [-1, 2].into_iter());
        assert!(header(&numbers).starts_with("{'descr': '<i8', "), "{}", header(&numbers));
        assert_eq!(numbers[128..136], (-1_i64).to_le_bytes());
        let text = encode_npy_text("R☉");
        assert!(header(&text).starts_with("{'descr': '<U2', "), "{}", header(&text));
        assert_eq!(text[128..], [0x52, 0, 0, 0, 0x09, 0x26, 0, 0]);
        assert_eq!(encode_npy_text("").len(), 128 + 4);
    }

    #[test]
    fn wrong_shapes_are_refused() {
        let error = encode_npy(&[2, 3], &[0.0; 5]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "5 numbers for an array of shape [2, 3]: expected the product of the lengths"
        );
        assert!(encode_npy(&[usize::MAX, 2], &[]).is_err());
        assert_eq!(encode_npy(&[1; 65], &[0.0]), Err(NpyError::Axes { axes: 65 }));
    }
}
