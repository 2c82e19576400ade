//! The guide names the keys that scenes may have: all of them, and no others.
//!
//! A table that refuses an unknown key names those that it has asked for: what reads a scene is compared with what the
//! guide says, without a list of its own.

use super::Scene;
use miette::Diagnostic;
use std::collections::BTreeSet;

const BASE: &str = "emission.expression = \"x\"\nprojection = { type = \"canonical\", length_unit = \"m\" }\n\
                    image = { width = 4, height = 4 }\n";
const UNKNOWN: &str = "qqqqqq";

/// The keys that are expected in the table of this path, by the refusal of another one.
fn expected_keys(scene: &str, path: &str) -> BTreeSet<String> {
    let text = scene.replace('?', &format!("{UNKNOWN} = 1"));
    let error = Scene::parse("scene.toml", &text, &[]).unwrap_err();
    assert!(
        error.to_string().ends_with(&format!(".{UNKNOWN}`")) || path.is_empty(),
        "{path}: {error}"
    );
    let labels: Vec<String> = error
        .labels()
        .into_iter()
        .flatten()
        .filter_map(|of| of.label().map(str::to_owned))
        .collect();
    let label = labels.concat();
    assert!(label.starts_with("expected one of `"), "{path}: {error}: {label}");
    label.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

fn guide() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/guide.md");
    std::fs::read_to_string(path).unwrap()
}

/// The rows of the tables below a heading, up to the next one, as what their first cell has in backticks.
fn rows(guide: &str, heading: &str) -> BTreeSet<String> {
    let below = guide.split_once(&format!("\n{heading}")).unwrap().1;
    let section = below.split("\n#").next().unwrap();
    let first_cells =
        section.lines().filter_map(|line| line.strip_prefix("| ")?.split(" |").next());
    let names = first_cells.flat_map(|cell| cell.split('`').skip(1).step_by(2));
    names.map(|name| name.trim_matches(['[', ']']).to_owned()).collect()
}

fn emission(keys: &str) -> String {
    BASE.replace("emission.expression = \"x\"", &format!("emission = {{ {keys}, ? }}"))
}

/// The base with another table.
fn with(table: &str) -> String {
    format!("{BASE}{table}\n")
}

#[test]
fn the_guide_names_the_keys_that_are_read() {
    let guide = guide();
    let energy = "energy = { min = 1, max = 2, bins = 3, ? }";
    let sphere = "type = \"sphere\", center = [0, 0, 0], radius = 1, ?";
    let ellipsoid = "type = \"ellipsoid\", center = [0, 0, 0], semi_axes = [1, 1, 1], ?";
    let healpix = BASE
        .replace("canonical\"", "healpix\", position = [0, 0, 0], far = 1")
        .replace("width = 4, height = 4", "nside = 1, ?");
    let camera =
        "perspective\", position = [0, 0, 0], target = [1, 0, 0], field_of_view = [9, 9], far = 1";
    let seen_from_earth = with("sky = { frame = \"ICRS\", ? }").replace("canonical\"", camera);
    let tables = [
        ("### `[emission]`", vec![emission("expression = \"x\""), emission("model = \"uniform\"")]),
        ("### `[image]`", vec![BASE.replace("height = 4", "height = 4, ?"), healpix]),
        ("### `[energy]`", vec![with(energy)]),
        (
            "### `[time]`",
            vec![
                with("time = { start = 0, stop = 1, ? }"),
                with("time = { start = 0, stop = 1, observer = { velocity = [1, 0, 0], ? } }"),
            ],
        ),
        (
            "### `[instrument]`",
            vec![with(&format!(
                "{}\ninstrument = {{ exposure = 1, effective_area = 1, ? }}",
                energy.replace(", ?", "")
            ))],
        ),
        (
            "### `[bounds]`",
            vec![
                with(&format!("bounds = {{ {sphere} }}")),
                with(&format!("bounds = {{ {ellipsoid} }}")),
                with("bounds = { type = \"box\", min = [0, 0, 0], max = [1, 1, 1], ? }"),
            ],
        ),
        (
            "### `[[occulter]]`",
            [sphere, ellipsoid].map(|body| with(&format!("occulter = [{{ {body} }}]"))).to_vec(),
        ),
        (
            "### `[[edge]]`",
            [sphere, ellipsoid, "type = \"plane\", position = [0, 0, 0], normal = [1, 0, 0], ?"]
                .map(|edge| with(&format!("edge = [{{ {edge} }}]")))
                .to_vec(),
        ),
        (
            "### `[[singularity]]`",
            [
                "type = \"point\", position = [0, 0, 0], ?",
                "type = \"axis\", position = [0, 0, 0], direction = [1, 0, 0], ?",
            ]
            .map(|of| with(&format!("singularity = [{{ {of} }}]")))
            .to_vec(),
        ),
        ("### `[render]`", vec![with("render = { ? }")]),
        ("### `[[seed]]`", vec![with("seed = [{ position = [0, 0, 0], radius = 1, ? }]")]),
        ("### `[build]`", vec![with("build = { min = [0, 0, 0], max = [1, 1, 1], ? }")]),
        ("### `[sky]`", vec![seen_from_earth]),
    ];
    for (heading, scenes) in tables {
        let mut read: BTreeSet<String> =
            scenes.iter().flat_map(|scene| expected_keys(scene, heading)).collect();
        // Python's alone: in the text.
        read.remove("function");
        assert_eq!(rows(&guide, heading), read, "{heading}");
    }
}

#[test]
fn the_guide_names_all_tables() {
    assert_eq!(rows(&guide(), "## A scene"), expected_keys(&format!("?\n{BASE}"), ""));
}
