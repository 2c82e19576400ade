//! Scenes of media that absorb.

use crate::support::{Folder, pixels};

/// A uniform cube with sides of 1 km and an optical depth of 2 through it.
const FOG: &str = r#"
[emission]
expression = "3"

[absorption]
expression = "k"
constants = { k = 2e-3 }
unit = "m-1"

[projection]
type = "canonical"
length_unit = "km"

[image]
width = 4
height = 3
"#;

#[test]
fn a_scene_absorbs_and_says_how_often_its_coefficient_was_evaluated() {
    for method in ["vol", "paper", "los"] {
        let folder = Folder::with_scene(FOG);
        let run = folder.emitree(&format!(
            "render scene.toml --method {method} -o a.npy -o a.fits --report report.json"
        ));
        run.succeeds();
        let exact = 1.5 * -(-2.0_f64).exp_m1();
        let image = pixels(&folder.bytes("a.npy"));
        assert!(image.iter().all(|pixel| (pixel / exact - 1.0).abs() < 0.01), "{method} {image:?}");
        let report = folder.json("report.json");
        let evaluations = report["absorption_evaluations"].as_u64().unwrap();
        assert!(evaluations > 0);
        let grouped = emitree_io::grouped(evaluations);
        let line = format!("\n  absorption   {grouped} evaluations of its coefficient\n");
        assert!(run.stdout.contains(&line), "{}", run.stdout);
        let header = String::from_utf8_lossy(&folder.bytes("a.fits")).into_owned();
        assert!(header.contains("NABSORB = "), "{method}");
    }
}

#[test]
fn a_transparent_scene_says_nothing_of_absorption() {
    let (before, rest) = FOG.split_once("[absorption]").unwrap_or_default();
    let (_, after) = rest.split_once("[projection]").unwrap_or_default();
    let folder = Folder::with_scene(&format!("{before}[projection]{after}"));
    let run = folder.emitree("render scene.toml -o a.fits --report report.json");
    run.succeeds();
    assert!(!run.stdout.contains("absorption"), "{}", run.stdout);
    assert!(folder.json("report.json").get("absorption_evaluations").is_none());
    assert!(!String::from_utf8_lossy(&folder.bytes("a.fits")).contains("NABSORB"));
}

#[test]
fn a_coefficient_that_can_not_be_evaluated_is_an_error_of_its_table() {
    let folder = Folder::with_scene(&FOG.replace("\"k\"", "\"k / x / 0\""));
    let run = folder.emitree("render scene.toml -o a.npy");
    run.fails_with(3);
    assert!(run.stderr.contains("the absorption coefficient is "), "{}", run.stderr);
    folder.holds(&["scene.toml"]);
    let folder = Folder::with_scene(&FOG.replace("m-1", "m"));
    let run = folder.emitree("render scene.toml -o a.npy");
    run.fails_with(2);
    assert!(run.stderr.contains("`absorption.unit`"), "{}", run.stderr);
}
