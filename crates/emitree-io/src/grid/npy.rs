//! Arrays of `numpy`: the .npy file, versions 1 to 3, described in `numpy.lib.format`.
//!
//! After a magic string and the version comes the length of the header, then the header, a Python
//! dictionary with the type of the numbers, their order and the shape, then the numbers.

use super::array::{Array, Container};
use super::error::GridReadError;
use super::request::GridFormat;

const MAGIC: &[u8] = b"\x93NUMPY";

/// A file of one array.
#[derive(Debug)]
pub(super) struct NpyCube(Option<Array>);

impl NpyCube {
    pub(super) fn open(bytes: &[u8]) -> Result<Self, GridReadError> {
        decode(bytes).map(Some).map(Self)
    }
}

impl Container for NpyCube {
    fn values(&mut self, name: Option<&str>) -> Result<Array, GridReadError> {
        match (name, self.0.take()) {
            (None, Some(array)) => Ok(array),
            (name, _) => Err(nameless(name.unwrap_or_default())),
        }
    }

    fn array(&mut self, name: &str) -> Result<Array, GridReadError> {
        Err(nameless(name))
    }

    fn nodes(&mut self, _: usize, _: usize, _: &Array) -> Result<Vec<f64>, GridReadError> {
        let expected = "their numbers or their range, since an NPY file has only one array";
        Err(GridReadError::NoNodes(expected.to_owned()))
    }
}

fn nameless(name: &str) -> GridReadError {
    malformed(format!("it has one array without a name, expected no name `{name}` for it"))
}

fn malformed(reason: impl ToString) -> GridReadError {
    GridReadError::malformed(GridFormat::Npy, reason)
}

/// The array in the bytes of a .npy file.
pub(super) fn decode(bytes: &[u8]) -> Result<Array, GridReadError> {
    let (header, data) = split_header(bytes)?;
    let descr = field(header, "descr")?;
    let shape = shape(field(header, "shape")?)?;
    let fortran = match field(header, "fortran_order")? {
        order if order.starts_with("True") => true,
        order if order.starts_with("False") => false,
        order => return Err(malformed(format!("`fortran_order` is {order}: expected a boolean"))),
    };
    let values = numbers(descr, data, &shape)?;
    Ok(if fortran { Array::fortran_order(shape, values) } else { Array::c_order(shape, values) })
}

/// The header as text, and the bytes after it.
fn split_header(bytes: &[u8]) -> Result<(&str, &[u8]), GridReadError> {
    let Some((&[major, _minor], rest)) =
        bytes.strip_prefix(MAGIC).and_then(<[u8]>::split_first_chunk)
    else {
        return Err(malformed("expected \\x93NUMPY and a version at its start"));
    };
    let cut = || malformed("its header is cut off");
    let (length, rest) = match major {
        1 => {
            let (length, rest) = rest.split_first_chunk().ok_or_else(cut)?;
            (usize::from(u16::from_le_bytes(*length)), rest)
        }
        2 | 3 => {
            let (length, rest) = rest.split_first_chunk().ok_or_else(cut)?;
            (usize::try_from(u32::from_le_bytes(*length)).map_err(malformed)?, rest)
        }
        _ => return Err(malformed(format!("its version is {major}: expected 1, 2 or 3"))),
    };
    let (header, data) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| malformed("its header is no text"))?;
    Ok((header, data))
}

/// What stands after `'name':` in the dictionary.
fn field<'a>(header: &'a str, name: &str) -> Result<&'a str, GridReadError> {
    let missing = || malformed(format!("its header {header:?} has no `{name}`"));
    let after_name = ['\'', '"'].into_iter().find_map(|quote| {
        let key = format!("{quote}{name}{quote}");
        header.split_once(&key).map(|(_, after)| after.trim_start())
    });
    after_name.and_then(|rest| rest.strip_prefix(':')).map(str::trim_start).ok_or_else(missing)
}

/// A tuple of lengths, as Python writes it.
fn shape(text: &str) -> Result<Vec<usize>, GridReadError> {
    let refuse = || malformed(format!("its shape is {text}: expected a tuple of lengths"));
    let tuple = text.strip_prefix('(').and_then(|rest| rest.split_once(')'));
    let (lengths, _) = tuple.ok_or_else(refuse)?;
    let lengths = lengths.split(',').map(str::trim).filter(|length| !length.is_empty());
    // Python 2 wrote its long integers with an L.
    lengths.map(|length| length.trim_end_matches('L').parse().map_err(|_| refuse())).collect()
}

/// The data as numbers of the type that `descr` names, as many as the shape has room for.
fn numbers(descr: &str, data: &[u8], shape: &[usize]) -> Result<Vec<f64>, GridReadError> {
    let refuse = || {
        let descr = descr.split_once(", '").map_or(descr, |(descr, _)| descr);
        malformed(format!("its numbers are {descr}: expected one of f4, f8, i1 to i8, u1 to u8"))
    };
    let kind = descr.strip_prefix(['\'', '"']).and_then(|rest| rest.split_once(['\'', '"']));
    let (kind, _) = kind.ok_or_else(refuse)?;
    let (big_endian, kind) = match kind.split_at_checked(1) {
        Some(("<" | "|", kind)) => (false, kind),
        Some((">", kind)) => (true, kind),
        Some(("=", kind)) => (cfg!(target_endian = "big"), kind),
        _ => return Err(refuse()),
    };
    let bytes_each = match kind {
        "i1" | "u1" => 1,
        "i2" | "u2" => 2,
        "i4" | "u4" | "f4" => 4,
        "i8" | "u8" | "f8" => 8,
        _ => return Err(refuse()),
    };
    let expected = shape.iter().try_fold(bytes_each, |product: usize, &n| product.checked_mul(n));
    if expected != Some(data.len()) {
        return Err(malformed(format!(
            "it has {} bytes of numbers: expected as many as its shape {shape:?} takes with {kind}",
            data.len()
        )));
    }
    Ok(data.chunks_exact(bytes_each).map(|bytes| number(kind, bytes, big_endian)).collect())
}

/// One number of at most eight bytes.
fn number(kind: &str, bytes: &[u8], big_endian: bool) -> f64 {
    // The bytes from the most significant one on, at the upper end of 64 bits.
    let mut upper = [0; 8];
    upper[..bytes.len()].copy_from_slice(bytes);
    if !big_endian {
        upper[..bytes.len()].reverse();
    }
    let unused_bits = 8 * (8 - bytes.len());
    let bits = u64::from_be_bytes(upper);
    #[expect(clippy::cast_precision_loss, reason = "a grid has values of 53 bits")]
    match kind {
        "f8" => f64::from_bits(bits),
        "f4" => f64::from(f32::from_bits((bits >> 32) as u32)),
        _ if kind.starts_with('i') => (bits.cast_signed() >> unused_bits) as f64,
        _ => (bits >> unused_bits) as f64,
    }
}
