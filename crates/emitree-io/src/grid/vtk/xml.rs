//! XML of VTK: `ImageData` (.vti) and `RectilinearGrid` (.vtr), as
//! [VTK File Formats](https://docs.vtk.org/en/latest/vtk_file_formats/index.html) has them.
//!
//! Numbers are text, base64 in the elements, or bytes appended after all elements, which are no XML.

use super::super::budget::Budget;
use super::super::error::GridReadError;
use super::super::npy::number;
use super::blocks::{Bytes, Storage};
use super::{Content, Data, Source, malformed};
use roxmltree::{Document, Node};
use std::ops::Range;

const APPENDED: &[u8] = b"<AppendedData";
/// The most bytes that one byte of zlib stands for is 1032.
const MOST_COMPRESSION: usize = 1100;

/// Whether these bytes begin as XML does.
pub(super) fn is_xml(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    text.trim_ascii_start().starts_with(b"<")
}

/// The numbers of all arrays of a file.
struct Xml {
    bytes: Vec<u8>,
    storage: Storage,
    arrays: Vec<Numbers>,
    budget: Budget,
}

/// Where the numbers of an array are, and what.
#[derive(Clone, Debug)]
struct Numbers {
    /// As `numpy` calls it: f4, u1 and others.
    kind: &'static str,
    format: Format,
    /// Their bytes in the file; of appended ones the first, and the end of the file.
    place: Range<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Text,
    Base64,
    Plain,
}

/// What is in the bytes of a file.
pub(super) fn open(bytes: Vec<u8>, budget: Budget) -> Result<Content, GridReadError> {
    let (elements, appended) = parts(&bytes)?;
    let document =
        Document::parse(&elements).map_err(|error| malformed(format!("its XML: {error}")))?;
    let file = document.root_element();
    if file.tag_name().name() != "VTKFile" {
        let name = file.tag_name().name();
        return Err(malformed(format!("it is XML with <{name}>: expected <VTKFile>")));
    }
    let storage = storage(file)?;
    let kind = file.attribute("type").unwrap_or_default();
    if !matches!(kind, "ImageData" | "RectilinearGrid") {
        return Err(malformed(format!(
            "its dataset is {kind}: expected ImageData or RectilinearGrid (in Python \
             `emitree.from_pyvista` takes others)"
        )));
    }
    let grid = child(file, kind)?;
    let pieces: Vec<Node<'_, '_>> = children(grid, "Piece").collect();
    let &[piece] = pieces.as_slice() else {
        let count = pieces.len();
        return Err(malformed(format!(
            "it has {count} pieces: expected one (in Python `emitree.from_pyvista` takes several)"
        )));
    };
    let extent: [i64; 6] = numbers(piece, "Extent")?;
    let mut counts = [0; 3];
    for (axis, count) in counts.iter_mut().enumerate() {
        let [first, last] = [extent[2 * axis], extent[2 * axis + 1]];
        let cells = last.checked_sub(first).and_then(|cells| usize::try_from(cells).ok());
        let refuse = || malformed(format!("its extent is {extent:?}: expected ascending pairs"));
        *count = cells.and_then(|cells| cells.checked_add(1)).ok_or_else(refuse)?;
        // An extent that no array confirms must not take memory.
        if *count / MOST_COMPRESSION > bytes.len() {
            return Err(malformed(format!("its extent is {extent:?}: expected a smaller one")));
        }
    }
    let is_in_base64 =
        children(file, "AppendedData").any(|data| data.attribute("encoding") != Some("raw"));
    let reader = Reader { appended, is_in_base64, end: bytes.len() };
    let mut arrays = Vec::new();
    let mut found = Vec::new();
    for (place, is_of_cells) in [("PointData", false), ("CellData", true)] {
        let of_place = children(piece, place).flat_map(|node| children(node, "DataArray"));
        for array in of_place {
            let name = array.attribute("Name").unwrap_or_default().to_owned();
            let components = match array.attribute("NumberOfComponents") {
                None => 1,
                Some(_) => numbers::<usize, 1>(array, "NumberOfComponents")?[0].max(1),
            };
            // Texts and bits are no numbers.
            if let Some(numbers) = reader.numbers(array)? {
                arrays.push(Data { name, components, is_of_cells });
                found.push(numbers);
            }
        }
    }
    let axes = if kind == "ImageData" { None } else { Some(reader.coordinates(piece)?) };
    let [origin, spacing] = if axes.is_none() { lattice(grid)? } else { [[0.0; 3], [1.0; 3]] };
    drop(document);
    drop(elements);
    let source = Xml { bytes, storage, arrays: found, budget };
    let mut points = [const { Vec::new() }; 3];
    for (axis, points) in points.iter_mut().enumerate() {
        *points = budget.reserve(&[counts[axis]], source.bytes.len() as u64)?;
        match &axes {
            Some(axes) => {
                source.each_of(&axes[axis], counts[axis], &mut |_, value| points.push(value))?;
            }
            None => {
                let first = extent[2 * axis] as f64;
                let place = |i: usize| origin[axis] + (first + i as f64) * spacing[axis];
                points.extend((0..counts[axis]).map(place));
            }
        }
        let (found, expected) = (points.len(), counts[axis]);
        if found != expected {
            let reason = format!("it has {found} coordinates of an axis: expected {expected}");
            return Err(malformed(reason));
        }
    }
    Ok(Content { points, arrays, source: Box::new(source) })
}

/// The elements of a file, closed where the appended bytes begin, and the place of these.
fn parts(bytes: &[u8]) -> Result<(std::borrow::Cow<'_, str>, Option<usize>), GridReadError> {
    let text =
        |bytes| core::str::from_utf8(bytes).map_err(|error| malformed(format!("its XML: {error}")));
    let Some(start) = bytes.windows(APPENDED.len()).position(|window| window == APPENDED) else {
        return Ok((text(bytes)?.into(), None));
    };
    let length = bytes[start..].iter().position(|&byte| byte == b'>');
    let length = length.ok_or_else(|| malformed("its XML ends in <AppendedData"))?;
    let end = start + length + 1;
    if bytes[end - 2] == b'/' {
        return Ok((text(bytes)?.into(), None));
    }
    let blanks = bytes[end..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
    if bytes.get(end + blanks) != Some(&b'_') {
        return Err(malformed("its appended data begin without `_`"));
    }
    let elements = format!("{}</AppendedData></VTKFile>", text(&bytes[..end])?);
    Ok((elements.into(), Some(end + blanks + 1)))
}

/// How arrays are stored in this file.
fn storage(file: Node<'_, '_>) -> Result<Storage, GridReadError> {
    let refuse = |name: &str, found: &str, expected: &str| {
        malformed(format!("its {name} is {found}: expected {expected}"))
    };
    let is_big_endian = match file.attribute("byte_order").unwrap_or("LittleEndian") {
        "LittleEndian" => false,
        "BigEndian" => true,
        other => return Err(refuse("byte_order", other, "LittleEndian or BigEndian")),
    };
    let bytes_of_length = match file.attribute("header_type").unwrap_or("UInt32") {
        "UInt32" => 4,
        "UInt64" => 8,
        other => return Err(refuse("header_type", other, "UInt32 or UInt64")),
    };
    let is_compressed = match file.attribute("compressor").unwrap_or_default() {
        "" => false,
        "vtkZLibDataCompressor" => true,
        other => {
            let expected =
                "vtkZLibDataCompressor or none (in Python `emitree.from_pyvista` takes others)";
            return Err(refuse("compressor", other, expected));
        }
    };
    Ok(Storage { is_big_endian, bytes_of_length, is_compressed })
}

/// The origin and the spacing of an image whose axes are x, y and z.
fn lattice(image: Node<'_, '_>) -> Result<[[f64; 3]; 2], GridReadError> {
    const UNTURNED: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    if image.has_attribute("Direction") {
        let direction: [f64; 9] = numbers(image, "Direction")?;
        if direction.iter().zip(UNTURNED).any(|(found, unturned)| (found - unturned).abs() > 0.0) {
            return Err(malformed(format!(
                "its Direction is {direction:?}: expected axes that are not turned (in Python \
                 `emitree.from_pyvista` takes others)"
            )));
        }
    }
    Ok([numbers(image, "Origin")?, numbers(image, "Spacing")?])
}

fn children<'a, 'input: 'a>(
    of: Node<'a, 'input>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    of.children().filter(move |node| node.has_tag_name(name))
}

fn child<'a, 'input>(of: Node<'a, 'input>, name: &str) -> Result<Node<'a, 'input>, GridReadError> {
    let found = of.children().find(|node| node.has_tag_name(name));
    found.ok_or_else(|| malformed(format!("<{}> has no <{name}>", of.tag_name().name())))
}

/// So many numbers of an attribute.
fn numbers<T: std::str::FromStr, const N: usize>(
    of: Node<'_, '_>,
    name: &str,
) -> Result<[T; N], GridReadError> {
    let text = of.attribute(name).unwrap_or_default();
    let found: Result<Vec<T>, _> = text.split_ascii_whitespace().map(str::parse).collect();
    found.ok().and_then(|found| found.try_into().ok()).ok_or_else(|| {
        let element = of.tag_name().name();
        malformed(format!("the {name} of <{element}> is `{text}`: expected {N} numbers"))
    })
}

/// From elements to the places of their numbers.
#[derive(Clone, Copy)]
struct Reader {
    /// Where the appended data begin.
    appended: Option<usize>,
    /// Whether they are in base64.
    is_in_base64: bool,
    /// The end of the file.
    end: usize,
}

impl Reader {
    /// Where the numbers of an array are; `None` if it has none.
    fn numbers(&self, array: Node<'_, '_>) -> Result<Option<Numbers>, GridReadError> {
        let kind = match array.attribute("type").unwrap_or_default() {
            "Float32" => "f4",
            "Float64" => "f8",
            "Int8" => "i1",
            "UInt8" => "u1",
            "Int16" => "i2",
            "UInt16" => "u2",
            "Int32" => "i4",
            "UInt32" => "u4",
            "Int64" => "i8",
            "UInt64" => "u8",
            _ => return Ok(None),
        };
        let of_name = || array.attribute("Name").unwrap_or("without a name");
        let (format, place) = match array.attribute("format").unwrap_or("ascii") {
            "appended" => {
                let [offset] = numbers::<usize, 1>(array, "offset")?;
                let start = self.appended.and_then(|start| start.checked_add(offset));
                let start = start.filter(|&start| start <= self.end).ok_or_else(|| {
                    malformed(format!("the array {} is beyond the appended data", of_name()))
                })?;
                let format = if self.is_in_base64 { Format::Base64 } else { Format::Plain };
                (format, start..self.end)
            }
            inline @ ("ascii" | "binary") => {
                let is_of_numbers = |node: &Node<'_, '_>| {
                    node.is_text() && node.text().is_some_and(|text| !text.trim().is_empty())
                };
                // The elements are the start of the file.
                let place = array.children().find(is_of_numbers).map_or(0..0, |text| text.range());
                (if inline == "ascii" { Format::Text } else { Format::Base64 }, place)
            }
            other => {
                return Err(malformed(format!(
                    "the format of the array {} is {other}: expected ascii, binary or appended",
                    of_name()
                )));
            }
        };
        Ok(Some(Numbers { kind, format, place }))
    }

    /// Where the coordinates along x, y and z are.
    fn coordinates(&self, piece: Node<'_, '_>) -> Result<[Numbers; 3], GridReadError> {
        let arrays: Vec<Node<'_, '_>> =
            children(child(piece, "Coordinates")?, "DataArray").collect();
        let found = arrays.iter().map(|array| self.numbers(*array));
        let found: Vec<Numbers> =
            found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        found.try_into().map_err(|found: Vec<Numbers>| {
            let count = found.len();
            malformed(format!("it has {count} arrays of coordinates: expected three"))
        })
    }
}

impl Xml {
    /// Calls `take` with the index and the value of each of the numbers, of which `count` are expected.
    fn each_of(
        &self,
        numbers: &Numbers,
        count: usize,
        take: &mut dyn FnMut(usize, f64),
    ) -> Result<(), GridReadError> {
        let Numbers { kind, format, place } = numbers;
        let stored = &self.bytes[place.clone()];
        if *format == Format::Text {
            let text = core::str::from_utf8(stored).map_err(malformed)?;
            for (index, word) in text.split_ascii_whitespace().enumerate() {
                if index >= count {
                    return Err(malformed(format!("an array has more than {count} numbers")));
                }
                let refuse =
                    |_| malformed(format!("`{}` is in place of a number", word.escape_debug()));
                take(index, word.parse().map_err(refuse)?);
            }
            return Ok(());
        }
        let stored = match format {
            Format::Plain => Bytes::Plain(stored),
            _ => Bytes::Base64 { text: stored, left: Vec::new() },
        };
        let size = usize::from(kind.as_bytes()[1] - b'0');
        let bytes = stored.array(count.saturating_mul(size), self.storage, self.budget)?;
        for (index, bytes) in bytes.chunks_exact(size).enumerate() {
            take(index, number(kind, bytes, self.storage.is_big_endian));
        }
        Ok(())
    }
}

impl Source for Xml {
    fn bytes(&self) -> usize {
        self.bytes.len()
    }

    fn each(
        &self,
        number: usize,
        count: usize,
        take: &mut dyn FnMut(usize, f64),
    ) -> Result<(), GridReadError> {
        self.each_of(&self.arrays[number], count, take)
    }
}
