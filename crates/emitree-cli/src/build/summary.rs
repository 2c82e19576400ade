//! The summary of a tree that was built, for people.

use crate::failure::Failure;
use crate::numbers::{percent, seconds};
use emitree_io::grouped;

use emitree::StopReason;
use emitree::world_tree::BuiltWorldTree;
use emitree_io::{BuildSettings, Scene};
use std::io::Write;
use std::path::Path;

pub(super) fn print(text: &str) -> Result<(), Failure> {
    Ok(std::io::stdout().lock().write_all(text.as_bytes())?)
}

pub(super) fn text(
    scene: &Scene,
    settings: &BuildSettings,
    built: &BuiltWorldTree,
    written: &Path,
) -> String {
    let tree = &built.tree;
    let [min, max] = [settings.bounds.min(), settings.bounds.max()];
    let unit = scene.length_unit.as_deref().unwrap_or_default();
    let relative = |size: f64| if size > 0.0 { size / built.largest_rate } else { 0.0 };
    let [total, emission] = [built.total_time, built.emission_time].map(seconds);
    let mut lines = vec![
        format!("{}: a tree of the box {min:?} to {max:?} {unit}", scene.name),
        format!(
            "  tree         order {}, base grid {}^3, to {} of the largest rate",
            settings.order,
            1_u32 << settings.base_level,
            percent(settings.tolerance)
        ),
        format!("  evaluations  {} in {} batches", grouped(built.evaluations), built.batches),
        format!(
            "  cells        {}, the finest 1/{} of the box",
            grouped(tree.cells() as u64),
            1_u32 << tree.finest_level()
        ),
        format!(
            "  error        {:.2e} of the largest rate at the last centres (no bound between them)",
            relative(built.largest_dropped)
        ),
        format!("  time         {total}, of which the emission {emission}"),
        format!("  written      {}", written.display()),
    ];
    let cells = grouped(built.unresolved_cells);
    match built.ending {
        StopReason::Complete if built.unresolved_cells > 0 => {
            lines.push(format!("  unresolved   {cells} cells of the finest level"));
        }
        StopReason::Complete => {}
        StopReason::MaxLevel => lines.push(format!(
            "  NOT CONVERGED: stopped at the deepest level with {cells} cells unresolved; a \
             finest_level would end it earlier"
        )),
        _ => lines.push(format!(
            "  NOT CONVERGED: stopped by its budget after {} evaluations with {cells} cells \
             unresolved",
            grouped(built.evaluations)
        )),
    }
    lines.iter().map(|line| format!("{}\n", line.trim_end())).collect()
}
