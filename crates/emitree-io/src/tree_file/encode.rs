//! From a tree to the bytes of its file.

use super::{FAMILY, LAYOUT, LEVEL, RATES, TABLE, TreeFile};
use crate::fits::{Card, FitsEncodeError, Provenance};
use fits_well::FitsWriter;
use fits_well::header::Header;
use fits_well::table::{Builder, ColumnData, WriteColumn};
use std::time::SystemTime;

impl TreeFile {
    /// The bytes of the file, with `DATASUM` and `CHECKSUM`, dated now.
    ///
    /// # Errors
    ///
    /// [`FitsEncodeError`] if FITS has no room for the table.
    pub fn encode(&self) -> Result<Vec<u8>, FitsEncodeError> {
        let mut header = Header::new();
        let (cards, date) = (&self.cards(), Some(SystemTime::now()));
        Provenance { cards, history: &self.scene, date }.write(&mut header)?;
        let mut writer = FitsWriter::new(Vec::new()).with_checksums();
        writer.write_table(&self.table()?, Some(&header))?;
        Ok(writer.into_inner())
    }

    fn cards(&self) -> Vec<Card> {
        let (tree, bounds) = (&self.tree, self.tree.bounds());
        let mut cards = vec![
            Card::new("EXTNAME", TABLE, "emission rates at the centres of cells"),
            Card::new("TREEVERS", LAYOUT, "version of this table"),
        ];
        let axes = ["x", "y", "z"];
        for (n, (axis, (min, max))) in
            (1..).zip(axes.into_iter().zip(bounds.min().into_iter().zip(bounds.max())))
        {
            cards.push(Card::new(format!("BOXMIN{n}"), min, format!("lower end along {axis}")));
            cards.push(Card::new(format!("BOXMAX{n}"), max, format!("upper end along {axis}")));
        }
        if let Some(unit) = &self.length_unit {
            cards.push(Card::new("LENUNIT", unit.as_str(), "unit of the box"));
        }
        cards.extend([
            Card::new("IMGUNIT", self.image_unit.as_str(), "unit of images of the tree"),
            Card::new("ORDER", tree.order(), "order of the prediction"),
            Card::new("BASELEVL", i32::from(tree.base_level()), "2^this base cells along an edge"),
            Card::new("NEVAL", self.evaluations, "evaluations of the emission rate"),
            Card::new("TOLERANC", self.tolerance, "tolerance / largest rate"),
            Card::new("THRESHLD", self.threshold, "details below it were dropped"),
            Card::new("DROPPED", self.largest_dropped, "largest detail of cells left whole"),
            Card::new("MAXRATE", self.largest_rate, "largest rate that was evaluated"),
            Card::new("CONVERGD", self.converged, "no detail above the threshold is left"),
        ]);
        cards
    }

    fn table(&self) -> Result<Builder, FitsEncodeError> {
        let rows = self.tree.cells() / RATES.1;
        let mut levels = Vec::with_capacity(rows);
        let mut positions = Vec::with_capacity(FAMILY.1 * rows);
        let mut rates = Vec::with_capacity(RATES.1 * rows);
        for family in self.tree.families() {
            levels.push(family.level);
            // Positions are below 2^19.
            positions.extend(family.position.map(u32::cast_signed));
            rates.extend(family.values);
        }
        let mut table = Builder::new();
        table
            .push(WriteColumn::fixed(LEVEL.0, ColumnData::U8(levels), LEVEL.1))?
            .push(WriteColumn::fixed(FAMILY.0, ColumnData::I32(positions), FAMILY.1))?
            .push(WriteColumn::fixed(RATES.0, ColumnData::F64(rates), RATES.1))?;
        Ok(table)
    }
}
