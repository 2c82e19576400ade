//! Scenes whose emission is an expression of fields and of a table.

use crate::support::{Folder, pixels};
use emitree_io::encode_npy;
use std::fmt::Write as _;

const CORE: f64 = 0.4;
const NODES: usize = 64;

/// A beta model n = 1/(1 + r²/CORE²) in a cube from -1 to 1, in a file beside the scene, and n² Λ(n) as the rate.
const SCENE: &str = r#"
[emission]
expression = "a*n^2*Lambda(T)"
constants = { a = 2.0 }
fields = { n = { scale = 1 }, T = { interpolation = "monotone" } }

[emission.grid]
file = "n.npy"
x = { min = -1, max = 1 }
y = { min = -1, max = 1 }
z = { min = -1, max = 1 }

[emission.table.Lambda]
file = "cooling.csv"
logarithmic = ["T", "Lambda"]

[projection]
type = "orthographic"
position = [0, -9, 0]
target = [0, 0, 0]
extent = [1.2, 1.2]

[image]
width = 20
height = 20

[render]
tolerance = 0.01
"#;

/// The folder of the scene and its files, and what the command writes.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn folder(scene: &str, table: &str) -> Folder {
    let folder = Folder::with_scene(scene);
    let place = |index: usize| -1.0 + 2.0 * index as f64 / (NODES - 1) as f64;
    let mut values = Vec::new();
    for at in 0..NODES.pow(3) {
        let parts = [at % NODES, at / NODES % NODES, at / NODES.pow(2)].map(place);
        let square: f64 = parts.iter().map(|part| part * part).sum();
        values.push(1.0 / (1.0 + square / (CORE * CORE)));
    }
    let bytes = encode_npy(&[NODES; 3], &values).unwrap();
    std::fs::write(folder.path("n.npy"), bytes).unwrap();
    std::fs::write(folder.path("cooling.csv"), table).unwrap();
    folder
}

/// Λ = 3 T at 20 temperatures, which a power law has exactly.
#[expect(clippy::unwrap_used, reason = "a text can be written to")]
fn table() -> String {
    let mut text = "# a model\nT,Lambda\n".to_owned();
    for number in 0..20 {
        let t = 10_f64.powf(-2.0 + 2.0 * f64::from(number) / 19.0);
        writeln!(text, "{t},{}", 3.0 * t).unwrap();
    }
    text
}

/// The integral of (CORE² + b² + s²)⁻³ over s from -1 to 1, for a = CORE² + b².
fn column(a: f64) -> f64 {
    let first = 2.0 * (1.0 / a.sqrt()).atan() / a.sqrt();
    let second = 1.0 / (a * (a + 1.0)) + first / (2.0 * a);
    1.0 / (2.0 * a * (a + 1.0).powi(2)) + 3.0 / (4.0 * a) * second
}

/// The closed form's mean over a pixel, by Simpson's rule; its error is below 1e-4.
fn exact(row: usize, column_number: usize) -> f64 {
    let width = 1.2 / 20.0;
    let points = |index: usize| {
        let start = -0.6 + width * index as f64;
        [(start, 1.0), (start + width / 2.0, 4.0), (start + width, 1.0)]
    };
    let mut sum = 0.0;
    for (x, of_x) in points(column_number) {
        for (z, of_z) in points(row) {
            sum += of_x * of_z * column(CORE * CORE + x * x + z * z);
        }
    }
    2.0 * 3.0 * CORE.powi(6) * sum / 36.0
}

#[test]
fn a_cooling_cluster_has_its_closed_form() {
    let folder = folder(SCENE, &table());
    folder.emitree("render scene.toml -o image.npy --report report.json").succeeds();
    let found = pixels(&folder.bytes("image.npy"));
    let expected: Vec<f64> = (0..400).map(|at| exact(at / 20, at % 20)).collect();
    let largest = expected.iter().copied().fold(0.0, f64::max);
    let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst / largest < 0.01, "{}", worst / largest);
}

#[test]
fn messages_name_the_file_the_line_and_the_value() {
    let broken = table().replace("0.01,0.03", "0.01,-");
    let run = folder(SCENE, &broken).emitree("render scene.toml -o image.npy");
    run.fails_with(2);
    for text in [
        "`emission.table.Lambda`: the table ",
        "cooling.csv: line 3: the column `Lambda` is `-`: expected",
        "file = \"cooling.csv\"",
    ] {
        assert!(run.stderr.contains(text), "{text}\n{}", run.stderr);
    }
    let hot = "T,Lambda\n0.5,1\n1,2\n";
    let run = folder(SCENE, hot).emitree("render scene.toml -o image.npy");
    run.fails_with(3);
    for text in
        ["the argument `T` of `Lambda` is 0.", "expected 0.5 to 1", "emission.table.Lambda.outside"]
    {
        assert!(run.stderr.contains(text), "{text}\n{}", run.stderr);
    }
}
