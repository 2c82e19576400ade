//! From the bytes of a file to its tree: everything is checked.

use super::{FAMILY, LAYOUT, LEVEL, RATES, TABLE, TreeFile, TreeFileError};
use emitree::tree::Family;
use emitree::world_tree::{WorldBox, WorldTree};
use fits_well::FitsReader;
use fits_well::header::{CommentaryName, Header};
use fits_well::table::{ColumnData, Table};
use std::path::Path;

impl TreeFile {
    /// Reads the tree file at `path`.
    ///
    /// # Errors
    ///
    /// [`TreeFileError`] names the file, and what in it is missing, wrong or out of place.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, TreeFileError> {
        let path = path.as_ref();
        let bytes = std::fs::read(path)
            .map_err(|source| TreeFileError::Read { path: path.to_owned(), source })?;
        Self::decode(path, &bytes)
    }

    /// Reads a tree from the bytes of a file; `path` is what errors call it.
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open).
    pub fn decode(path: &Path, bytes: &[u8]) -> Result<Self, TreeFileError> {
        let path = || path.to_owned();
        let fits = |source| TreeFileError::Fits { path: path(), source: Box::new(source) };
        let mut reader = FitsReader::from_bytes(bytes).map_err(fits)?;
        let no_table = |_| TreeFileError::NoTable { path: path() };
        let header = reader.hdu(TABLE).map_err(no_table)?.header.clone();
        if reader.verify_checksum(TABLE).map_err(fits)?.has_invalid() {
            return Err(TreeFileError::Checksum { path: path() });
        }
        let cards = Cards { path: &path(), header: &header };
        cards.check_layout()?;
        let axes = [1, 2, 3];
        let corner = |name: &str| -> Result<[f64; 3], TreeFileError> {
            let ends: Vec<f64> =
                axes.iter().map(|n| cards.real(&format!("{name}{n}"))).collect::<Result<_, _>>()?;
            Ok([ends[0], ends[1], ends[2]])
        };
        let bounds = WorldBox::new(corner("BOXMIN")?, corner("BOXMAX")?)
            .map_err(|source| TreeFileError::Box { path: path(), source })?;
        let order = cards.count("ORDER")?;
        let base_level = cards.count("BASELEVL")?;
        let table = reader.read_table(TABLE).map_err(fits)?;
        let families = families(&path(), &table)?;
        let tree = WorldTree::from_families(bounds, order, base_level, &families)
            .map_err(|source| TreeFileError::Families { path: path(), source })?;
        Ok(Self {
            tree,
            length_unit: cards.optional_text("LENUNIT")?,
            image_unit: cards.optional_text("IMGUNIT")?.unwrap_or_default(),
            evaluations: cards.count("NEVAL")?,
            tolerance: cards.real("TOLERANC")?,
            threshold: cards.real("THRESHLD")?,
            largest_dropped: cards.real("DROPPED")?,
            largest_rate: cards.real("MAXRATE")?,
            converged: cards.logical("CONVERGD")?,
            scene: joined(header.commentary(CommentaryName::HISTORY)),
        })
    }
}

/// The header records of the table, typed.
struct Cards<'a> {
    path: &'a Path,
    header: &'a Header,
}

impl Cards<'_> {
    fn check_layout(&self) -> Result<(), TreeFileError> {
        let version = self.integer("TREEVERS")?;
        if version == LAYOUT { Ok(()) } else { Err(self.wrong("TREEVERS", version, "1")) }
    }

    fn real(&self, keyword: &str) -> Result<f64, TreeFileError> {
        let found = self.header.require_real(keyword);
        // The reader takes an integer for a real number, but no record without a value.
        found.map_err(|source| self.unreadable(keyword, source, "a number"))
    }

    fn integer(&self, keyword: &str) -> Result<i64, TreeFileError> {
        let found = self.header.require_integer(keyword);
        found.map_err(|source| self.unreadable(keyword, source, "an integer"))
    }

    /// An integer that fits `T`.
    fn count<T: TryFrom<i64>>(&self, keyword: &str) -> Result<T, TreeFileError> {
        let found = self.integer(keyword)?;
        T::try_from(found).map_err(|_| self.wrong(keyword, found, "a number in its range"))
    }

    fn logical(&self, keyword: &str) -> Result<bool, TreeFileError> {
        let found = self.header.require_logical(keyword);
        found.map_err(|source| self.unreadable(keyword, source, "T or F"))
    }

    fn optional_text(&self, keyword: &str) -> Result<Option<String>, TreeFileError> {
        match self.header.get_text(keyword) {
            Ok(text) => Ok(text.map(str::to_owned)),
            Err(source) => Err(self.unreadable(keyword, source, "a text")),
        }
    }

    fn unreadable(
        &self,
        keyword: &str,
        source: fits_well::FitsError,
        expected: &'static str,
    ) -> TreeFileError {
        let (path, keyword) = (self.path.to_owned(), keyword.to_owned());
        TreeFileError::Card { path, keyword, source: Box::new(source), expected }
    }

    fn wrong(&self, keyword: &str, value: i64, expected: &'static str) -> TreeFileError {
        let (path, keyword) = (self.path.to_owned(), keyword.to_owned());
        TreeFileError::CardValue { path, keyword, value, expected }
    }
}

/// The families of the table, row after row.
fn families(path: &Path, table: &Table) -> Result<Vec<Family>, TreeFileError> {
    let wrong = |(column, count): (&'static str, usize), expected| {
        let path = path.to_owned();
        TreeFileError::Column { path, column, expected, count }
    };
    let rows = table.schema().row_count();
    let column = |named: (&'static str, usize), expected| {
        let mut data = ColumnData::U8(Vec::new());
        let read = table.column(named.0).and_then(|column| column.raw_into(&mut data));
        match read {
            Ok(()) if data.len() == rows * named.1 => Ok(data),
            _ => Err(wrong(named, expected)),
        }
    };
    const BYTES: &str = "bytes (B)";
    const INTEGERS: &str = "32-bit integers (J)";
    const REALS: &str = "64-bit floats (D)";
    let ColumnData::U8(levels) = column(LEVEL, BYTES)? else { return Err(wrong(LEVEL, BYTES)) };
    let ColumnData::I32(positions) = column(FAMILY, INTEGERS)? else {
        return Err(wrong(FAMILY, INTEGERS));
    };
    let ColumnData::F64(rates) = column(RATES, REALS)? else { return Err(wrong(RATES, REALS)) };
    let rows = levels.iter().zip(positions.as_chunks().0).zip(rates.as_chunks().0);
    Ok(rows
        .map(|((&level, position), &values)| Family {
            level,
            // A negative position becomes one beyond all levels, which the tree refuses.
            position: position.map(i32::cast_unsigned),
            values,
        })
        .collect())
}

/// The text of `HISTORY` records: one of 72 characters that ends in a backslash goes on in the next.
fn joined<'a>(records: impl Iterator<Item = &'a str>) -> String {
    const WHOLE: usize = 72;
    let mut text = String::new();
    for record in records {
        match record.strip_suffix('\\') {
            Some(piece) if record.len() == WHOLE => text.push_str(piece),
            _ => text.extend([record, "\n"]),
        }
    }
    text
}
