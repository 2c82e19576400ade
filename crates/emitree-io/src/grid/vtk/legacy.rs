//! The legacy format: a sequence of lines, each a keyword with its arguments, followed by numbers: text, or
//! big-endian numbers that start right after the line.

use super::super::error::GridReadError;
use super::super::npy::number;
use super::{Content, Data, malformed};

/// Where numbers are in a file.
#[derive(Clone, Copy, Debug)]
struct Numbers {
    start: usize,
    count: usize,
    /// As `numpy` calls it: f4, u1 and others.
    kind: &'static str,
}

/// The numbers of all arrays of a file.
pub(super) struct Legacy {
    bytes: Vec<u8>,
    is_binary: bool,
    numbers: Vec<Numbers>,
}

impl Legacy {
    /// What is in the bytes of a file.
    pub(super) fn open(bytes: Vec<u8>) -> Result<Content, GridReadError> {
        let mut cursor = Cursor { bytes: &bytes, at: 0, is_binary: false };
        let start = cursor.line().unwrap_or_default();
        if !start.starts_with("# vtk DataFile") {
            return Err(malformed(
                "expected `# vtk DataFile Version` at its start, or XML with <VTKFile>",
            ));
        }
        cursor.line(); // The title.
        let encoding = cursor.line().unwrap_or_default().trim().to_owned();
        let is_binary = match encoding.as_str() {
            "BINARY" => true,
            "ASCII" => false,
            _ => {
                let reason = format!("its third line is `{encoding}`: expected ASCII or BINARY");
                return Err(malformed(reason));
            }
        };
        cursor.is_binary = is_binary;
        let (points, arrays) = cursor.dataset()?;
        let (arrays, numbers) = arrays.into_iter().unzip();
        let source = Box::new(Self { bytes, is_binary, numbers });
        Ok(Content { points, arrays, source })
    }
}

impl super::Source for Legacy {
    fn bytes(&self) -> usize {
        self.bytes.len()
    }

    fn each(
        &self,
        number: usize,
        _: usize,
        take: &mut dyn FnMut(usize, f64),
    ) -> Result<(), GridReadError> {
        let cursor = Cursor { bytes: &self.bytes, at: 0, is_binary: self.is_binary };
        cursor.each(self.numbers[number], take).map(|_| ())
    }
}

/// What has been read of a file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    is_binary: bool,
}

/// The points along x, y and z, and the arrays with their numbers.
type Dataset = ([Vec<f64>; 3], Vec<(Data, Numbers)>);

impl<'a> Cursor<'a> {
    /// The next line, without its end.
    fn line(&mut self) -> Option<&'a str> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        Some(core::str::from_utf8(&rest[..length]).unwrap_or_default())
    }

    /// The words of the next line that has some.
    fn words(&mut self) -> Option<Vec<&'a str>> {
        loop {
            let words: Vec<&str> = self.line()?.split_whitespace().collect();
            if !words.is_empty() {
                return Some(words);
            }
        }
    }

    /// The points along x, y and z, and the arrays.
    fn dataset(&mut self) -> Result<Dataset, GridReadError> {
        let mut counts = [0; 3];
        let (mut origin, mut spacing) = ([0.0; 3], [1.0; 3]);
        let mut points = [const { Vec::new() }; 3];
        let mut arrays = Vec::new();
        let (mut is_of_cells, mut tuples) = (false, None);
        while let Some(words) = self.words() {
            let keyword = words[0].to_uppercase();
            match keyword.as_str() {
                "DATASET"
                    if matches!(
                        words.get(1),
                        Some(&("STRUCTURED_POINTS" | "RECTILINEAR_GRID"))
                    ) => {}
                "DATASET" => {
                    let kind = words.get(1).copied().unwrap_or_default();
                    return Err(malformed(format!(
                        "its dataset is {kind}: expected STRUCTURED_POINTS or RECTILINEAR_GRID (in \
                         Python `emitree.from_pyvista` takes others)"
                    )));
                }
                "DIMENSIONS" => counts = three(&words)?,
                "ORIGIN" => origin = three(&words)?,
                "SPACING" | "ASPECT_RATIO" => spacing = three(&words)?,
                "X_COORDINATES" | "Y_COORDINATES" | "Z_COORDINATES" => {
                    let axis = usize::from(keyword.as_bytes()[0] - b'X');
                    let numbers = self.numbers(word(&words, 1)?, word_of(&words, 2)?)?;
                    self.each(numbers, |_, value| points[axis].push(value))?;
                }
                "POINT_DATA" | "CELL_DATA" => {
                    (is_of_cells, tuples) = (keyword == "CELL_DATA", Some(word(&words, 1)?));
                }
                "METADATA" => while self.line().is_some_and(|line| !line.trim().is_empty()) {},
                "FIELD" => {
                    for _ in 0..word::<usize>(&words, 2)? {
                        let array = self.words().unwrap_or_default();
                        let [components, count] = [word(&array, 1)?, word::<usize>(&array, 2)?];
                        let size = count.saturating_mul(components);
                        let numbers = self.numbers(size, word_of(&array, 3)?)?;
                        // Fields of the dataset itself, such as the time, are not on its points.
                        if tuples == Some(count) {
                            let name = decoded(array[0]);
                            arrays.push((Data { name, components, is_of_cells }, numbers));
                        }
                        self.skip_metadata();
                    }
                }
                "SCALARS" | "VECTORS" | "NORMALS" | "TENSORS" => {
                    let (name, kind) = (word_of(&words, 1)?, word_of(&words, 2)?);
                    let components = match keyword.as_str() {
                        "SCALARS" => words.get(3).and_then(|word| word.parse().ok()).unwrap_or(1),
                        "TENSORS" => 9,
                        _ => 3,
                    };
                    if keyword == "SCALARS" {
                        let before = self.at;
                        let is_table = self.words().is_some_and(|words| words[0] == "LOOKUP_TABLE");
                        if !is_table {
                            self.at = before;
                        }
                    }
                    let count = tuples.unwrap_or(0_usize).saturating_mul(components);
                    let numbers = self.numbers(count, kind)?;
                    let data = Data { name: decoded(name), components, is_of_cells };
                    arrays.push((data, numbers));
                }
                "LOOKUP_TABLE" => {
                    let count = word::<usize>(&words, 2)?.saturating_mul(4);
                    self.numbers(count, if self.is_binary { "unsigned_char" } else { "float" })?;
                }
                _ => {
                    let shown: String = words[0].chars().take(40).collect();
                    return Err(malformed(format!(
                        "it has the keyword `{shown}`, which is not known"
                    )));
                }
            }
        }
        for (axis, points) in points.iter_mut().enumerate() {
            if points.is_empty() {
                // A count that no array confirms must not take memory.
                let most = self.bytes.len();
                if counts[axis] > most {
                    return Err(malformed(format!(
                        "its dimensions are {counts:?}: expected fewer"
                    )));
                }
                points.extend((0..counts[axis]).map(|i| origin[axis] + i as f64 * spacing[axis]));
            }
            if points.len() != counts[axis] {
                let (found, expected) = (points.len(), counts[axis]);
                let reason = format!("it has {found} coordinates of an axis: expected {expected}");
                return Err(malformed(reason));
            }
        }
        Ok((points, arrays))
    }

    /// A block of METADATA, if one follows.
    fn skip_metadata(&mut self) {
        let before = self.at;
        match self.words() {
            Some(words) if words[0] == "METADATA" => {
                while self.line().is_some_and(|line| !line.trim().is_empty()) {}
            }
            _ => self.at = before,
        }
    }

    /// So many numbers from here on, which are left behind.
    fn numbers(&mut self, count: usize, kind: &str) -> Result<Numbers, GridReadError> {
        let kind = match kind.to_lowercase().as_str() {
            "float" => "f4",
            "double" => "f8",
            "char" | "signed_char" => "i1",
            "unsigned_char" => "u1",
            "short" => "i2",
            "unsigned_short" => "u2",
            "int" => "i4",
            "unsigned_int" => "u4",
            "long" | "vtktypeint64" | "vtkidtype" => "i8",
            "unsigned_long" | "vtktypeuint64" => "u8",
            _ => {
                return Err(malformed(format!(
                    "its numbers are of type {kind}: expected a real one"
                )));
            }
        };
        let numbers = Numbers { start: self.at, count, kind };
        self.at = self.each(numbers, |_, _| {})?;
        Ok(numbers)
    }

    /// Calls `take` with the index and the value of each number; returns where they end.
    fn each(
        &self,
        numbers: Numbers,
        mut take: impl FnMut(usize, f64),
    ) -> Result<usize, GridReadError> {
        let cut = || malformed("its numbers are cut off");
        let Numbers { start, count, kind } = numbers;
        let rest = self.bytes.get(start..).ok_or_else(cut)?;
        if self.is_binary {
            let size = usize::from(kind.as_bytes()[1] - b'0');
            let length = count.checked_mul(size).ok_or_else(cut)?;
            let block = rest.get(..length).ok_or_else(cut)?;
            for (index, bytes) in block.chunks_exact(size).enumerate() {
                take(index, number(kind, bytes, true));
            }
            return Ok(start + length);
        }
        let mut at = start;
        for index in 0..count {
            let blanks =
                self.bytes[at..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            let word = &self.bytes[at + blanks..];
            let length = word.iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
            let text = core::str::from_utf8(&word[..length]).unwrap_or_default();
            if text.is_empty() {
                return Err(cut());
            }
            let value = text.parse();
            let refuse = |_| malformed(format!("`{text}` is in place of a number"));
            take(index, value.map_err(refuse)?);
            at += blanks + length;
        }
        Ok(at)
    }
}

/// The words after the first as three numbers.
fn three<T: std::str::FromStr>(words: &[&str]) -> Result<[T; 3], GridReadError> {
    Ok([word(words, 1)?, word(words, 2)?, word(words, 3)?])
}

fn word<T: std::str::FromStr>(words: &[&str], place: usize) -> Result<T, GridReadError> {
    let text = word_of(words, place)?;
    text.parse().map_err(|_| malformed(format!("`{text}` is in place of a number")))
}

fn word_of<'a>(words: &[&'a str], place: usize) -> Result<&'a str, GridReadError> {
    let keyword = words.first().copied().unwrap_or("the end of the file");
    words.get(place).copied().ok_or_else(|| malformed(format!("`{keyword}` lacks arguments")))
}

/// A name with its blanks, which are written as %20.
fn decoded(name: &str) -> String {
    name.replace("%20", " ").replace("%25", "%")
}
