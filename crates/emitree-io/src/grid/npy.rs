//! Arrays of `numpy`: the .npy file, versions 1 to 3, described in `numpy.lib.format`.
//!
//! After a magic string and the version comes the length of the header, then the header, a Python
//! dictionary with the type of the numbers, their order and the shape, then the numbers.

use super::array::{Array, Container, Described, Nodes};
use super::budget::Budget;
use super::error::GridReadError;
use super::request::GridFormat;
use std::io::{ErrorKind, Read};

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// The longest header that is read: some ten thousand times what an array of numbers needs.
const LONGEST_HEADER: usize = 1 << 20;
/// Bytes that are turned into numbers at once; a multiple of the size of each type.
const BLOCK: usize = 1 << 16;

/// A file of one array.
#[derive(Debug)]
pub(super) struct NpyCube<R> {
    source: R,
    header: Header,
    budget: Budget,
}

impl<R: Read> NpyCube<R> {
    /// The array in a source of `length` bytes.
    pub(super) fn open(mut source: R, length: u64, budget: Budget) -> Result<Self, GridReadError> {
        let header = Header::read(&mut source, length)?;
        Ok(Self { source, header, budget })
    }
}

impl<R: Read> Container for NpyCube<R> {
    fn describe(&mut self, name: Option<&str>) -> Result<Described, GridReadError> {
        match name {
            None => Ok(self.header.described()),
            Some(name) => Err(nameless(name)),
        }
    }

    /// Read once: the source is at its end then.
    fn values(
        &mut self,
        name: Option<&str>,
        selection: &[Option<usize>],
    ) -> Result<Array, GridReadError> {
        match name {
            None => self.header.array(&mut self.source, selection, self.budget),
            Some(name) => Err(nameless(name)),
        }
    }

    fn array(&mut self, name: &str) -> Result<Array, GridReadError> {
        Err(nameless(name))
    }

    fn nodes(&mut self, _: usize, _: &[&str], _: usize, _: &Array) -> Result<Nodes, GridReadError> {
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

/// What a .npy file says before its numbers.
#[derive(Debug)]
pub(super) struct Header {
    descr: String,
    shape: Vec<usize>,
    fortran: bool,
    /// The bytes of numbers.
    length: u64,
}

impl Header {
    /// The header at the start of a source of `length` bytes.
    pub(super) fn read(source: &mut impl Read, length: u64) -> Result<Self, GridReadError> {
        let (header, before) = read_header(source)?;
        let descr = field(&header, "descr")?.to_owned();
        let shape = shape(field(&header, "shape")?)?;
        let fortran = match field(&header, "fortran_order")? {
            order if order.starts_with("True") => true,
            order if order.starts_with("False") => false,
            order => {
                return Err(malformed(format!("`fortran_order` is {order}: expected a boolean")));
            }
        };
        Ok(Self { descr, shape, fortran, length: length.saturating_sub(before) })
    }

    /// The axes of the array.
    pub(super) fn described(&self) -> Described {
        Described { shape: self.shape.clone(), axis_names: Vec::new() }
    }

    /// The numbers after the header, which are read to their end. A step along the first axis, the slowest one,
    /// is read alone.
    pub(super) fn array(
        &self,
        source: &mut impl Read,
        selection: &[Option<usize>],
        budget: Budget,
    ) -> Result<Array, GridReadError> {
        let is_first = selection.iter().skip(1).all(Option::is_none);
        let step = match (selection.first(), self.shape.first()) {
            (Some(&Some(index)), Some(&count)) if is_first && !self.fortran => Some((index, count)),
            _ => None,
        };
        let Some((index, count)) = step else {
            let values = numbers(source, &self.descr, &self.shape, self.length, budget)?;
            let shape = self.shape.clone();
            let array = match self.fortran {
                true => Array::fortran_order(shape, values),
                false => Array::c_order(shape, values),
            };
            return Ok(array.selected(selection));
        };
        let bytes = self.length / (count.max(1) as u64);
        if bytes.saturating_mul(count as u64) != self.length {
            let (length, shape) = (self.length, &self.shape);
            return Err(malformed(format!(
                "it has {length} bytes of numbers: expected as many as its shape {shape:?} takes"
            )));
        }
        skip(source, bytes * index as u64)?;
        let inner = self.shape[1..].to_vec();
        let mut one = source.take(bytes);
        let values = numbers(&mut one, &self.descr, &inner, bytes, budget)?;
        skip(source, bytes * (count - 1 - index) as u64)?;
        Ok(Array::c_order(inner, values))
    }
}

/// Reads bytes that are not needed.
fn skip(source: &mut impl Read, count: u64) -> Result<(), GridReadError> {
    let skipped = std::io::copy(&mut source.take(count), &mut std::io::sink());
    match skipped.map_err(malformed)? {
        skipped if skipped == count => Ok(()),
        _ => Err(malformed("its numbers are cut off")),
    }
}

/// The array in a .npy file of `length` bytes, which is read to its end.
pub(super) fn decode(
    source: &mut impl Read,
    length: u64,
    selection: &[Option<usize>],
    budget: Budget,
) -> Result<Array, GridReadError> {
    Header::read(source, length)?.array(source, selection, budget)
}

/// The header as text, and the number of bytes up to its end.
fn read_header(source: &mut impl Read) -> Result<(String, u64), GridReadError> {
    const START: &str = "expected \\x93NUMPY and a version at its start";
    const CUT: &str = "its header is cut off";
    let mut start = [0; MAGIC.len() + 2];
    fill(source, &mut start, START)?;
    let major = match start.strip_prefix(MAGIC) {
        Some(&[major, _minor]) => major,
        _ => return Err(malformed(START)),
    };
    // The length has two bytes in version 1 and four since.
    let bytes_of_length = match major {
        1 => 2,
        2 | 3 => 4,
        _ => return Err(malformed(format!("its version is {major}: expected 1, 2 or 3"))),
    };
    let mut length = [0; 4];
    fill(source, &mut length[..bytes_of_length], CUT)?;
    let length = usize::try_from(u32::from_le_bytes(length)).map_err(malformed)?;
    if length > LONGEST_HEADER {
        let expected = format!("its header has {length} bytes: expected at most {LONGEST_HEADER}");
        return Err(malformed(expected));
    }
    let mut header = vec![0; length];
    fill(source, &mut header, CUT)?;
    let before = (start.len() + bytes_of_length + length) as u64;
    let header = String::from_utf8(header).map_err(|_| malformed("its header is no text"))?;
    Ok((header, before))
}

/// Fills `bytes` from the source, which is `cut` if it ends before.
fn fill(source: &mut impl Read, bytes: &mut [u8], cut: &str) -> Result<(), GridReadError> {
    source.read_exact(bytes).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => malformed(cut),
        _ => malformed(error),
    })
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

/// The `length` bytes that are left as numbers of the type that `descr` names, as many as the shape has
/// room for.
fn numbers(
    source: &mut impl Read,
    descr: &str,
    shape: &[usize],
    length: u64,
    budget: Budget,
) -> Result<Vec<f64>, GridReadError> {
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
    if expected.map(|bytes| bytes as u64) != Some(length) {
        return Err(malformed(format!(
            "it has {length} bytes of numbers: expected as many as its shape {shape:?} takes with {kind}"
        )));
    }
    let mut values = budget.reserve(shape, 0)?;
    let mut left = expected.unwrap_or_default();
    let mut block = vec![0; BLOCK.min(left)];
    while left > 0 {
        let block = &mut block[..BLOCK.min(left)];
        fill(source, block, "its numbers are cut off")?;
        let numbers = block.chunks_exact(bytes_each);
        values.extend(numbers.map(|bytes| number(kind, bytes, big_endian)));
        left -= block.len();
    }
    // An archive compares its checksum when it has been read to its end.
    match source.read(&mut [0]).map_err(malformed)? {
        0 => Ok(values),
        _ => {
            Err(malformed(format!("it has more bytes of numbers than the {length} of its header")))
        }
    }
}

/// One number of at most eight bytes.
pub(super) fn number(kind: &str, bytes: &[u8], big_endian: bool) -> f64 {
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
