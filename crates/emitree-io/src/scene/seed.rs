//! `[[seed]]`: where the emission has a structure that a coarse grid would miss.

use super::error::SceneError;
use super::table::Table;
use emitree::vol::Seed;

pub(super) fn read(tables: Vec<Table>) -> Result<Vec<Seed>, SceneError> {
    tables.into_iter().map(read_one).collect()
}

fn read_one(mut table: Table) -> Result<Seed, SceneError> {
    const POINT: &str = "three numbers [x, y, z]";
    const RADIUS: &str = "a length above 0";
    let position = table.require("position", POINT)?;
    let node = table.require("radius", RADIUS)?;
    table.finish()?;
    let radius = node.number()?;
    if radius <= 0.0 {
        return Err(node.refuse(&radius.to_string(), RADIUS));
    }
    Ok(Seed { position: position.vector(POINT)?, radius })
}
