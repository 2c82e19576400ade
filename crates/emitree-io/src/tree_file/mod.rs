//! Tree files: an emission rate in a box of the world, kept for any camera.
//!
//! A tree file is FITS with one binary table, `TREE`. A row is a family of eight cells: the level of
//! the cells (`LEVEL`), the position of the cell that they fill, one level up (`FAMILY`, three
//! integers), and the rates at the centres of the eight (`RATES`), where cell n is the upper half
//! along axis a if bit a of n is set. The rows of the base grid come first, x fastest, then one level
//! after the other. Ghosts and all that prediction needs are made anew when a file is read, from the
//! same numbers by the same code: a tree that was read is the tree that was written, bit for bit.

mod decode;
mod encode;
mod error;

pub use error::TreeFileError;

use emitree::StopReason;
use emitree::world_tree::{BuiltWorldTree, WorldTree};

/// A tree with the other contents of its file.
///
/// ```
/// use emitree::world_tree::{WorldBox, WorldTreeOptions, build_world_tree};
/// use emitree::FromFn;
/// use emitree_io::TreeFile;
///
/// let corona = FromFn(|[x, y, z]: [f64; 3], _| (-(x * x + y * y + z * z)).exp());
/// let bounds = WorldBox::new([-4.0; 3], [4.0; 3])?;
/// let options = WorldTreeOptions::default();
/// let built = build_world_tree(&corona, bounds, &options)?;
/// let file = TreeFile::new(built, options.tolerance).with_units(Some("R_E"), "");
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("corona.fits");
/// std::fs::write(&path, file.encode()?)?;
/// let read = TreeFile::open(&path)?;
/// assert_eq!(read.length_unit.as_deref(), Some("R_E"));
/// assert!(read.tree.families().eq(file.tree.families()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TreeFile {
    /// The tree.
    pub tree: WorldTree,
    /// The unit of the box, if the scene had one.
    pub length_unit: Option<String>,
    /// The unit of images of the tree, FITS grammar; empty if the scene had none.
    pub image_unit: String,
    /// How often the emission was evaluated for the tree.
    pub evaluations: u64,
    /// The tolerance, a fraction of the largest rate.
    pub tolerance: f64,
    /// The size below which details were dropped, in the unit of the rate.
    pub threshold: f64,
    /// The largest detail of cells that were not split, in the unit of the rate.
    pub largest_dropped: f64,
    /// The largest |rate| that was evaluated.
    pub largest_rate: f64,
    /// Whether the tolerance was met everywhere: no budget and no finest level came before.
    pub converged: bool,
    /// The scene that the tree was built from. Characters beyond ASCII come back escaped as in TOML,
    /// `\u00e9`, tabs as two spaces, and lines without spaces at their ends.
    pub scene: String,
}

impl TreeFile {
    /// The file of a tree that was built to `tolerance`, without units and scene.
    pub fn new(built: BuiltWorldTree, tolerance: f64) -> Self {
        let converged = built.ending == StopReason::Complete && built.unresolved_cells == 0;
        Self {
            tree: built.tree,
            length_unit: None,
            image_unit: String::new(),
            evaluations: built.evaluations,
            tolerance,
            threshold: built.threshold,
            largest_dropped: built.largest_dropped,
            largest_rate: built.largest_rate,
            converged,
            scene: String::new(),
        }
    }

    /// The same with the unit of the box, and that of images.
    #[must_use]
    pub fn with_units(mut self, length_unit: Option<&str>, image_unit: &str) -> Self {
        self.length_unit = length_unit.map(str::to_owned);
        image_unit.clone_into(&mut self.image_unit);
        self
    }

    /// The same with the text of the scene.
    #[must_use]
    pub fn with_scene(mut self, scene: &str) -> Self {
        scene.clone_into(&mut self.scene);
        self
    }
}

/// The name of the table.
const TABLE: &str = "TREE";
/// The version of the layout of the table and its keywords.
const LAYOUT: i64 = 1;
/// The columns, and how many numbers a row has in each.
const LEVEL: (&str, usize) = ("LEVEL", 1);
const FAMILY: (&str, usize) = ("FAMILY", 3);
const RATES: (&str, usize) = ("RATES", 8);

#[cfg(test)]
mod tests;
