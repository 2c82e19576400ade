//! `[build]`: the box and the options of a tree; and trees as emissions.

use super::document::Node;
use super::error::SceneError;
use super::source::Place;
use super::table::Table;
use super::{EmissionSource, is_option};
use crate::tree_file::TreeFile;
use emitree::cell::CellIndex;
use emitree::world_tree::{WorldBox, WorldTreeOptions};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What `emitree build` makes of a scene: the table `[build]`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BuildSettings {
    /// The box, in the scene's length unit.
    pub bounds: WorldBox,
    /// Details below this fraction of the largest rate are dropped.
    pub tolerance: f64,
    /// The base grid has 2^`base_level` cells along each edge.
    pub base_level: u8,
    /// The order of the prediction.
    pub order: usize,
    /// Cells of this level are not split.
    pub finest_level: Option<u8>,
    /// The largest number of evaluations; the library's default if it is not given.
    pub max_evaluations: Option<u64>,
}

const BASE_LEVELS: RangeInclusive<u8> = 3..=10;

pub(super) fn read_build(mut table: Table) -> Result<BuildSettings, SceneError> {
    const CORNER: &str = "three numbers [x, y, z] in `length_unit`";
    let defaults = WorldTreeOptions::default();
    let (min, max) = (table.require("min", CORNER)?, table.require("max", CORNER)?);
    let tolerance = table.take("tolerance");
    let base_level = table.take("base_level");
    let order = table.take("order");
    let finest_level = table.take("finest_level");
    let max_evaluations = table.take("max_evaluations");
    table.finish()?;

    let bounds = WorldBox::new(min.vector(CORNER)?, max.vector(CORNER)?)
        .map_err(|error| SceneError::at(&max.place, format!("`[build]`: {error}")))?;
    let base_level = base_level.map(|node| level(&node, BASE_LEVELS)).transpose()?;
    let base_level = base_level.unwrap_or(defaults.base_level);
    let deeper = base_level + 1..=CellIndex::<3>::MAX_LEVEL;
    Ok(BuildSettings {
        bounds,
        tolerance: tolerance.map_or(Ok(defaults.tolerance), |node| fraction(&node))?,
        base_level,
        order: order.map_or(Ok(defaults.order), |node| read_order(&node))?,
        finest_level: finest_level.map(|node| level(&node, deeper)).transpose()?,
        max_evaluations: max_evaluations.map(|node| evaluations(&node)).transpose()?,
    })
}

fn fraction(node: &Node) -> Result<f64, SceneError> {
    let value = node.number()?;
    if value > 0.0 && value < 1.0 {
        return Ok(value);
    }
    Err(node.refuse(&value.to_string(), "a fraction above 0 and below 1, as in 0.001"))
}

fn read_order(node: &Node) -> Result<usize, SceneError> {
    const EXPECTED: &str = "3, 5 or 7";
    match node.count(EXPECTED)? {
        order @ (3 | 5 | 7) => Ok(order),
        other => Err(node.refuse(&other.to_string(), EXPECTED)),
    }
}

fn level(node: &Node, levels: RangeInclusive<u8>) -> Result<u8, SceneError> {
    let expected = format!("a level from {} to {}", levels.start(), levels.end());
    match node.count(&expected)? {
        level if levels.contains(&level) => Ok(level),
        other => Err(node.refuse(&other.to_string(), &expected)),
    }
}

fn evaluations(node: &Node) -> Result<u64, SceneError> {
    const EXPECTED: &str = "a number of evaluations, 1 or more";
    match node.count(EXPECTED)? {
        0 => Err(node.refuse("0", EXPECTED)),
        count => Ok(count),
    }
}

/// The emission of `tree = "…"`: a file named from the folder of the scene, or from the current one
/// if an option of the command line names it.
pub(super) fn read_emission((name, place): &(String, Place)) -> Result<EmissionSource, SceneError> {
    let folder = if is_option(&place.source) {
        PathBuf::new()
    } else {
        Path::new(&place.source.name).parent().map(Path::to_owned).unwrap_or_default()
    };
    let file = TreeFile::open(folder.join(name)).map_err(|error| {
        SceneError::at(place, error.to_string()).label("expected a file of `emitree build`")
    })?;
    Ok(EmissionSource::Tree(Arc::new(file)))
}

#[cfg(test)]
mod tests {
    use crate::{EmissionSource, Override, Scene, SceneError, TreeFile};
    use emitree::FromFn;
    use emitree::world_tree::{WorldBox, WorldTreeOptions, build_world_tree};

    const SCENE: &str = r#"
[emission]
expression = "x"

[projection]
type = "canonical"

[image]
width = 5
height = 4

[build]
min = [-1, -2.0, -3.0]
max = [1.0, 2.0, 3.0]
tolerance = 0.01
base_level = 5
order = 7
finest_level = 9
max_evaluations = 1_000_000
"#;

    fn error(from: &str, to: &str) -> (usize, String, String) {
        assert!(SCENE.contains(from), "{from}");
        let error = Scene::parse("scene.toml", &SCENE.replacen(from, to, 1), &[]).unwrap_err();
        let (_, line) = error.line().unwrap();
        (line, error.message().to_owned(), error.expected().to_owned())
    }

    #[test]
    fn a_box_and_its_options() {
        let build = Scene::parse("scene.toml", SCENE, &[]).unwrap().build.unwrap();
        assert_eq!((build.bounds.min(), build.bounds.max()), ([-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]));
        assert_eq!((build.tolerance, build.base_level, build.order), (0.01, 5, 7));
        assert_eq!((build.finest_level, build.max_evaluations), (Some(9), Some(1_000_000)));
        let (head, _) = SCENE.split_once("tolerance").unwrap();
        let build = Scene::parse("scene.toml", head, &[]).unwrap().build.unwrap();
        assert_eq!((build.tolerance, build.base_level, build.order), (1e-3, 4, 5));
        assert_eq!((build.finest_level, build.max_evaluations), (None, None));
        let (head, _) = SCENE.split_once("[build]").unwrap();
        assert_eq!(Scene::parse("scene.toml", head, &[]).unwrap().build, None);
    }

    #[test]
    fn wrong_values_are_marked() {
        let is = |line, message: &str, expected: &str| (line, message.into(), expected.into());
        assert_eq!(
            error("tolerance = 0.01", "tolerance = 1"),
            is(
                15,
                "`build.tolerance` is 1",
                "expected a fraction above 0 and below 1, as in 0.001"
            )
        );
        assert_eq!(
            error("base_level = 5", "base_level = 2"),
            is(16, "`build.base_level` is 2", "expected a level from 3 to 10")
        );
        assert_eq!(
            error("order = 7", "order = 9"),
            is(17, "`build.order` is 9", "expected 3, 5 or 7")
        );
        assert_eq!(
            error("finest_level = 9", "finest_level = 5"),
            is(18, "`build.finest_level` is 5", "expected a level from 6 to 19")
        );
        assert_eq!(
            error("1_000_000", "0"),
            is(19, "`build.max_evaluations` is 0", "expected a number of evaluations, 1 or more")
        );
        let (line, message, _) = error("[1.0, 2.0, 3.0]", "[1.0, -2.0, 3.0]");
        let expected = "`[build]`: the box reaches from -2 to -2 along y: expected finite numbers, \
                        the first below the second";
        assert_eq!((line, &*message), (14, expected));
        assert_eq!(error("max = [1.0, 2.0, 3.0]\n", "").1, "`build.max` is missing");
        let (line, message, label) = error("order", "ordre");
        assert_eq!(
            (line, &*message, &*label),
            (17, "unknown key `build.ordre`", "did you mean `order`?")
        );
    }

    /// A folder with `model.fits`, a tree in kpc.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let g = FromFn(|[x, _, _]: [f64; 3], _: [f64; 3]| x);
        let options = WorldTreeOptions::default().with_base_level(3);
        let bounds = WorldBox::new([0.0; 3], [1.0; 3]).unwrap();
        let built = build_world_tree(&g, bounds, &options).unwrap();
        let file = TreeFile::new(built, 1e-3).with_units(Some("kpc"), "erg cm-2 s-1 sr-1");
        std::fs::write(folder.path().join("model.fits"), file.encode().unwrap()).unwrap();
        folder
    }

    fn scene(folder: &tempfile::TempDir, from: &str, to: &str) -> Result<Scene, SceneError> {
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, SCENE.replacen(from, to, 1)).unwrap();
        Scene::open(&path, &[])
    }

    #[test]
    fn a_tree_is_found_beside_the_scene() {
        let folder = folder();
        let scene = scene(&folder, "expression = \"x\"", "tree = \"model.fits\"").unwrap();
        assert!(matches!(scene.emission.source, EmissionSource::Tree(_)));
        assert_eq!(scene.length_unit.as_deref(), Some("kpc"));
        assert_eq!(scene.image_unit(), "erg cm-2 s-1 sr-1");
        // From the command line it is found from where the command runs.
        let text =
            "projection.type = \"canonical\"\nimage = { width = 1, height = 1 }\nemission = {}";
        let named = |value| Override { key: "emission.tree".into(), value, option: "set".into() };
        let path = folder.path().join("model.fits").display().to_string();
        assert!(Scene::parse("elsewhere/scene.toml", text, &[named(path)]).is_ok());
    }

    #[test]
    fn a_tree_that_does_not_fit_is_marked() {
        let folder = folder();
        let error = scene(&folder, "expression = \"x\"", "tree = \"modle.fits\"").unwrap_err();
        assert!(error.message().contains("modle.fits can't be read: "), "{error}");
        assert_eq!(error.expected(), "expected a file of `emitree build`");
        assert_eq!(error.line().unwrap().1, 3);
        let unit = "type = \"canonical\"\nlength_unit = \"s\"";
        std::fs::write(
            folder.path().join("seconds.toml"),
            SCENE.replacen("expression = \"x\"", "tree = \"model.fits\"", 1).replacen(
                "type = \"canonical\"",
                unit,
                1,
            ),
        )
        .unwrap();
        let error = Scene::open(&folder.path().join("seconds.toml"), &[]).unwrap_err();
        assert!(error.message().starts_with("`length_unit` is \"s\": "), "{error}");
        assert!(error.expected().starts_with("expected \"kpc\", "), "{}", error.expected());
        let both = "expression = \"x\"\ntree = \"model.fits\"";
        let error = scene(&folder, "expression = \"x\"", both).unwrap_err();
        assert_eq!(error.message(), "the scene has two emissions");
    }
}
