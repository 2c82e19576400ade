//! Scenes whose emission is a grid of data.

use crate::support::{Folder, Run, pixels};
use emitree_io::encode_npy;

const CAMERA: &str = r#"
[projection]
type = "canonical"

[image]
width = 6
height = 5

[render]
method = "los"
steps = 20
"#;

/// Renders a grid that is 1 + x + 2 y z, in a file beside the scene and not beside the user.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn render(far: f64, keys: &str) -> (Folder, Run) {
    let scene = format!(
        "[emission.grid]\nfile = \"cube.npy\"\nx = {{ min = 0, max = {far} }}\ny = [0, 0.25, 1]\n\
         z = [0, 1]\n{keys}\n{CAMERA}"
    );
    let folder = Folder::with_scene("");
    std::fs::create_dir(folder.path("scenes")).unwrap();
    std::fs::write(folder.path("scenes/grid.toml"), scene).unwrap();
    let mut values = Vec::new();
    for z in [0.0, 1.0] {
        for y in [0.0, 0.25, 1.0] {
            values.extend([0.0, 0.5, 1.0].map(|x| 1.0 + x * far + 2.0 * y * z));
        }
    }
    let bytes = encode_npy(&[2, 3, 3], &values).unwrap();
    std::fs::write(folder.path("scenes/cube.npy"), bytes).unwrap();
    let run = folder.emitree("render scenes/grid.toml -o image.npy");
    (folder, run)
}

#[test]
fn the_image_of_a_grid_is_that_of_its_function() {
    let scene = format!("emission.expression = \"1 + x + 2*y*z\"\n{CAMERA}");
    let by_expression = Folder::with_scene(&scene);
    by_expression.emitree("render scene.toml -o image.npy").succeeds();
    let expected = pixels(&by_expression.bytes("image.npy"));
    // Trilinear functions are exact, and so are lines by the cubics.
    for interpolation in ["linear", "monotone", "cubic"] {
        let (folder, run) = render(1.0, &format!("interpolation = \"{interpolation}\""));
        run.succeeds();
        let found = pixels(&folder.bytes("image.npy"));
        assert_eq!(found.len(), 30);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-14, "{interpolation}: {found} {expected}");
        }
    }
}

#[test]
fn a_point_outside_is_an_error_where_the_scene_says_so() {
    let (folder, run) = render(0.75, "");
    run.succeeds();
    // The middle of the last column is at x = 11/12, beyond the last node.
    assert_eq!(pixels(&folder.bytes("image.npy"))[5].to_bits(), 0);
    let (folder, run) = render(0.75, "outside = \"error\"");
    run.fails_with(3);
    for text in
        ["the emission model failed: the position [0.91666", "its x is 0.91666", "0 to 0.75"]
    {
        assert!(run.stderr.contains(text), "{}", run.stderr);
    }
    folder.holds(&["scene.toml", "scenes"]);
}

#[test]
fn a_grid_that_does_not_fit_is_refused_at_its_key() {
    let (folder, run) = render(-1.0, "");
    run.fails_with(2);
    assert!(run.stderr.contains("`emission.grid.x.max` is -1"), "{}", run.stderr);
    let (_, run) = render(1.0, "order = \"xyz\"");
    run.fails_with(2);
    for text in ["scenes/cube.npy: the z axis: it has 2 nodes: expected 3", "grid.toml:5:5"] {
        assert!(run.stderr.contains(text), "{}", run.stderr);
    }
    folder.holds(&["scene.toml", "scenes"]);
}
